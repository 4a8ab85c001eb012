"""TA Instruments TRIOS as JSON: column headers with units, and one object for each point."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from springpot.errors import DataError

from .blocks import Block
from .dynamic import reader_of_blocks
from .header_facts import facts_of
from .text import head_text, text_of
from .titles import Heading, heading

_MARKS = ("TRIOSJSONExportSchema", '"ColumnHeaders"', '"ResultsSteps"', '"Experiment"', '"DataSet"', '"Procedure"')
_PATHS = {
    "InstrumentInertia": "instrument inertia",
    "StressConstant": "stress constant",
    "StrainConstant": "strain constant",
    "Compliance": "compliance",
    "Inertia": "geometry inertia",
    "BearingFriction": "friction",
    "Gap": "gap",
    "Diameter": "diameter",
}
"""Names of quantities in the file, and in other exports of TRIOS."""
_STEPS = ("Results Step Id", "Procedure Step Id", "Step")


def recognises(head: bytes) -> float:
    """High for JSON with the words of a TRIOS export."""
    text = head_text(head).lstrip("\ufeff \r\n\t")
    if not text.startswith("{"):
        return 0.0
    return 1.0 if _MARKS[0] in text else min(0.9, 0.3 * sum(mark in text for mark in _MARKS))


def _parsed(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The tables of results, and what the file says of instrument and sample."""
    try:
        data = json.loads(text_of(path).lstrip("\ufeff"))
    except (ValueError, RecursionError) as error:
        reason = getattr(error, "msg", "nested too deeply")
        raise DataError(f"no readable JSON: {reason}, line {getattr(error, 'lineno', '?')}") from None
    if not isinstance(data, dict):
        raise DataError("no TRIOS export: the JSON is no object")
    experiment = data.get("Experiment")
    root: dict[str, Any] = experiment if isinstance(experiment, dict) else data
    blocks = [block for number, found in enumerate(_sets(root), 1) for block in _blocks(found, number, root)]
    if not blocks:
        raise DataError("a TRIOS JSON export without rows of results")
    return blocks, facts_of(_pairs(root))


def _sets(root: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Tables of results: processed rather than original."""
    results = root.get("Results")
    if isinstance(results, dict):
        chosen = next((results[key] for key in ("Processed", "Original") if isinstance(results.get(key), dict)), None)
        results = [chosen or results]
    found: list[dict[str, Any]] = []
    for result in results if isinstance(results, list) else []:
        inner = result.get("DataSet", result) if isinstance(result, dict) else None
        properties = result.get("Properties") if isinstance(result, dict) else None
        for table in inner if isinstance(inner, list) else [inner]:
            if isinstance(table, dict):
                found.append({"Properties": properties, **table})
    return found


def _blocks(table: Mapping[str, Any], number: int, root: Mapping[str, Any]) -> Iterator[Block]:
    headings, rows = _by_headers(table) if "ColumnHeaders" in table else _by_columns(table)
    steps = _step_names(table, root)
    key = next((i for name in _STEPS for i, found in enumerate(headings) if found.title == name), None)
    runs: dict[str, list[list[str]]] = {}
    for row in rows:
        runs.setdefault("" if key is None else row[key], []).append(row)
    properties = table.get("Properties")
    called = str(properties.get("Name", "")) if isinstance(properties, dict) else ""
    for place, (step, chosen) in enumerate(runs.items(), 1):
        name = steps.get(step) or called or (f"step {place}" if len(runs) > 1 else f"results {number}")
        yield Block(name[:80], headings, chosen, range(1, len(chosen) + 1))


def _by_headers(table: Mapping[str, Any]) -> tuple[tuple[Heading, ...], list[list[str]]]:
    """Rows as objects, by the keys of the column headers."""
    headers, rows = table.get("ColumnHeaders"), table.get("Rows")
    if not isinstance(headers, dict) or not isinstance(rows, list):
        return (), []
    keys = list(islice(headers, 500))
    headings = tuple(_heading(headers[key], key) for key in keys)
    return headings, [[_cell(row.get(key)) for key in keys] for row in rows if isinstance(row, dict)]


def _by_columns(table: Mapping[str, Any]) -> tuple[tuple[Heading, ...], list[list[str]]]:
    """Rows as lists, below columns with name and unit."""
    data = table.get("Data")
    columns = data.get("columns") if isinstance(data, dict) else None
    values = data.get("values") if isinstance(data, dict) else None
    if not isinstance(columns, list) or not isinstance(values, list):
        return (), []
    headings = tuple(_heading(column, f"column {i}") for i, column in enumerate(columns[:500], 1))
    width = len(headings)
    rows = [[_cell(cell) for cell in row[:width]] for row in values if isinstance(row, list)]
    return headings, [[*row, *[""] * (width - len(row))] for row in rows]


def _heading(said: Any, key: str) -> Heading:
    said = said if isinstance(said, dict) else {}
    name = str(said.get("DisplayName") or said.get("name") or key)
    unit = said.get("Unit", said.get("unit"))
    unit = unit.get("Name") if isinstance(unit, dict) else unit
    return heading(name[:200], unit[:60] if isinstance(unit, str) else None)


def _cell(value: Any) -> str:
    if isinstance(value, float) and value == value:
        return repr(value)
    return "" if value is None or isinstance(value, (dict, list, bool, float)) else str(value)[:200]


def _step_names(table: Mapping[str, Any], root: Mapping[str, Any]) -> dict[str, str]:
    """Names of steps by their identifiers."""
    procedure = root.get("Procedure")
    lists = [table.get("ResultsSteps"), procedure.get("Steps") if isinstance(procedure, dict) else None]
    return {
        str(step.get("Id")): str(step.get("Name"))
        for steps in lists
        if isinstance(steps, list)
        for step in steps
        if isinstance(step, dict) and step.get("Name")
    }


def _pairs(root: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    """Quantities ``{Value, Unit: {Name}}`` and names, wherever they stand outside the results."""
    sample, procedure = root.get("Sample"), root.get("Procedure")
    if isinstance(sample, dict) and sample.get("Name"):
        yield "sample name", str(sample["Name"])
    if isinstance(root.get("StartTime"), str):
        yield "run date", root["StartTime"]
    waiting: list[tuple[str, Any, int]] = [("", procedure, 0), ("", root.get("Properties"), 0)]
    seen = 0
    while waiting and seen < 20_000:
        key, value, depth = waiting.pop()
        seen += 1
        if isinstance(value, list) and depth < 12:
            waiting += [(key, item, depth + 1) for item in value[:100]]
        elif isinstance(value, dict) and isinstance(value.get("Value"), int | float):
            unit = value.get("Unit")
            name = unit.get("Name", "") if isinstance(unit, dict) else ""
            if key in _PATHS:
                yield _PATHS[key], f"{value['Value']:.12g} {name}"
        elif isinstance(value, dict) and depth < 12:
            waiting += [(str(name), inner, depth + 1) for name, inner in value.items()]
            if key == "Geometry" and isinstance(value.get("Name"), str):
                yield "geometry name", value["Name"]
            if key == "InstrumentConfigurations" and isinstance(value.get("Type"), str):
                yield "instrument type", value["Type"]


READER = reader_of_blocks(
    "trios-json", "TA Instruments TRIOS, exported as JSON", recognises, _parsed, "TA TRIOS JSON"
)
