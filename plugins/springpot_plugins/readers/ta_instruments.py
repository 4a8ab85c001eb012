"""TA Instruments: TRIOS as CSV or text, "export to LIMS" and JSON; text of thermal analysis.

CSV and text have a header of keys and values, then steps of names, units and numbers. In an export
to LIMS every line begins with a word that says what it is; JSON has column headers with units, and
one object for each point. Thermal analysis (DMA Q800, RSA) lists its signals as ``Sig1 ...`` above
``StartOfData``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby, islice
from pathlib import Path
from typing import Any

from springpot.errors import DataError
from springpot.measurement import json_of

from .above import facts_of, pairs_in
from .blocks import WIDEST, Block, blocks_of
from .dynamic import reader_of_blocks
from .grid import grid_of, head_text, is_number, lines_of, shortest, text_of
from .titles import Heading, heading

_STEP = re.compile(r"^[ \t]{0,20}\"?\[step\]", re.IGNORECASE | re.MULTILINE)
_HEADER = re.compile(
    r"^\"?(?:Filename|proceduresegments|Trios version|\[File Parameters\])\b", re.I | re.M
)
_LIMS = re.compile(r"LIMS export|^Variables\t", re.MULTILINE)


def _is_text(head: bytes) -> float:
    """High for the sections of a TRIOS export."""
    text = head_text(head)
    if _LIMS.search(text):
        # The export to LIMS has a reader of its own.
        return 0.0
    return 0.5 * bool(_STEP.search(text)) + 0.48 * bool(_HEADER.search(text))


def _of_text(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The steps, and what stands above each of them."""
    blocks, _ = blocks_of(grid_of(text_of(path)))
    return blocks, facts_of(pairs_in(row for block in blocks for row in block.above))


TRIOS_TEXT = reader_of_blocks(
    "trios", "TA Instruments TRIOS, exported as CSV or text", _is_text, _of_text, "TA TRIOS"
)


def _is_lims(head: bytes) -> float:
    """High for the first line or the lines of a step."""
    text = head_text(head)
    if "LIMS export format" in text[:500]:
        return 1.0
    if "\nVariables\t" not in text or "\nUnits\t" not in text:
        return 0.0
    return 0.95


def _of_lims(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The steps and what the header says."""
    pairs: list[tuple[str, str]] = []
    steps: list[list[tuple[int, list[str]]]] = []
    for number, line in enumerate(lines_of(text_of(path)), 1):
        if line.startswith(("[Step]", "[step]")):
            steps.append([])
        elif steps and "\t" in line:
            steps[-1].append((number, line.split("\t")))
        elif "\t" in line:
            key, _, value = line.partition("\t")
            pairs.append((key, value))
    return [block for step in steps if (block := _block_of_lims(step)) is not None], facts_of(pairs)


def _block_of_lims(step: list[tuple[int, list[str]]]) -> Block | None:
    header = {
        cells[0]: cells[1:] for _, cells in step if cells[0] in ("Step name", "Variables", "Units")
    }
    titles = [title.strip() for title in header.get("Variables", [])]
    data = [(number, cells[1:]) for number, cells in step if cells[0] == "Data point"]
    if not titles or not data:
        return None
    # The line of units ends where the last columns have none.
    units = [*header.get("Units", []), *[""] * len(titles)]
    headings = tuple(heading(title, unit) for title, unit in zip(titles, units, strict=False))
    width = len(titles)
    rows = [[*cells[:width], *[""] * (width - len(cells))] for _, cells in data]
    return Block(
        " ".join(header.get("Step name", [])).strip(),
        headings,
        rows,
        [number for number, _ in data],
    )


TRIOS_LIMS = reader_of_blocks(
    "trios-lims", "TA Instruments TRIOS, exported to LIMS", _is_lims, _of_lims, "TA TRIOS LIMS"
)


_MARKS = (
    "TRIOSJSONExportSchema",
    '"ColumnHeaders"',
    '"ResultsSteps"',
    '"Experiment"',
    '"DataSet"',
    '"Procedure"',
)
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
_MOST_SEEN, _DEEPEST = 20_000, 12
"""Values outside the results that are looked at, and how far down.

A file may be nested as somebody likes.
"""
_STEPS = ("Results Step Id", "Procedure Step Id", "Step")


def _is_json(head: bytes) -> float:
    """High for JSON with the words of a TRIOS export."""
    text = head_text(head).lstrip("\ufeff \r\n\t")
    if not text.startswith("{"):
        return 0.0
    if _MARKS[0] in text:
        return 1.0
    # One such word stands in other JSON as well, several of them hardly.
    return min(0.9, 0.3 * sum(mark in text for mark in _MARKS))


def _object(value: Any) -> dict[str, Any]:
    """The object itself.

    An empty one for anything else, since a broken file may hold that in its place.
    """
    if isinstance(value, dict):
        return value
    return {}


def _of_json(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The tables of results, and what the file says of instrument and sample."""
    try:
        data = json_of(text_of(path).lstrip("\ufeff"))
    except ValueError as error:
        reason = getattr(error, "msg", error)
        raise DataError(
            f"no readable JSON: {reason}, line {getattr(error, 'lineno', '?')}"
        ) from None
    if not isinstance(data, dict):
        raise DataError("no TRIOS export: the JSON is no object")
    root: dict[str, Any] = data
    if isinstance(data.get("Experiment"), dict):
        root = data["Experiment"]
    blocks: list[Block] = []
    for number, table in enumerate(_sets(root), 1):
        blocks += _blocks(table, number, root)
    if not blocks:
        raise DataError("a TRIOS JSON export without rows of results")
    return blocks, facts_of(_pairs(root))


def _sets(root: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Tables of results: processed rather than original."""
    results = root.get("Results")
    if isinstance(results, dict):
        results = [_processed(results)]
    if not isinstance(results, list):
        return []
    tables: list[dict[str, Any]] = []
    for result in results:
        if not isinstance(result, dict):
            continue
        inner = result.get("DataSet", result)
        if not isinstance(inner, list):
            inner = [inner]
        for table in inner:
            if isinstance(table, dict):
                tables.append({"Properties": result.get("Properties"), **table})
    return tables


def _processed(results: dict[str, Any]) -> dict[str, Any]:
    """The processed results, else the original ones, else the object itself as the one result."""
    for key in ("Processed", "Original"):
        if isinstance(results.get(key), dict):
            return results[key] or results
    return results


def _blocks(table: Mapping[str, Any], number: int, root: Mapping[str, Any]) -> Iterator[Block]:
    if "ColumnHeaders" in table:
        headings, rows = _by_headers(table)
    else:
        headings, rows = _by_columns(table)
    steps = _step_names(table, root)
    runs = _by_step(headings, rows)
    own_name = str(_object(table.get("Properties")).get("Name", ""))
    for place, (step, points) in enumerate(runs.items(), 1):
        name = steps.get(step) or own_name
        if not name and len(runs) > 1:
            name = f"step {place}"
        elif not name:
            name = f"results {number}"
        yield Block(name[:80], headings, points, range(1, len(points) + 1))


def _by_step(headings: Sequence[Heading], rows: list[list[str]]) -> dict[str, list[list[str]]]:
    """Rows by what the column of steps says.

    All of them under nothing where there is no such column.
    """
    titles = [each.title for each in headings]
    named = [titles.index(name) for name in _STEPS if name in titles]
    runs: dict[str, list[list[str]]] = {}
    for row in rows:
        step = ""
        if named:
            step = row[named[0]]
        runs.setdefault(step, []).append(row)
    return runs


def _by_headers(table: Mapping[str, Any]) -> tuple[tuple[Heading, ...], list[list[str]]]:
    """Rows as objects, by the keys of the column headers."""
    headers, rows = table.get("ColumnHeaders"), table.get("Rows")
    if not isinstance(headers, dict) or not isinstance(rows, list):
        return (), []
    keys = list(islice(headers, WIDEST))
    headings = tuple(_heading(headers[key], key) for key in keys)
    return headings, [
        [_cell(row.get(key)) for key in keys] for row in rows if isinstance(row, dict)
    ]


def _by_columns(table: Mapping[str, Any]) -> tuple[tuple[Heading, ...], list[list[str]]]:
    """Rows as lists, below columns with name and unit."""
    data = _object(table.get("Data"))
    columns, values = data.get("columns"), data.get("values")
    if not isinstance(columns, list) or not isinstance(values, list):
        return (), []
    headings = tuple(
        _heading(column, f"column {i}") for i, column in enumerate(columns[:WIDEST], 1)
    )
    width = len(headings)
    rows = [[_cell(cell) for cell in row[:width]] for row in values if isinstance(row, list)]
    return headings, [[*row, *[""] * (width - len(row))] for row in rows]


def _heading(header: Any, key: str) -> Heading:
    header = _object(header)
    name = str(header.get("DisplayName") or header.get("name") or key)
    unit = header.get("Unit", header.get("unit"))
    if isinstance(unit, dict):
        unit = unit.get("Name")
    # Cut short: a file may hold anything here, and what follows searches it by patterns.
    if isinstance(unit, str):
        return heading(name[:200], unit[:60])
    return heading(name[:200], None)


def _cell(value: Any) -> str:
    if value is None or isinstance(value, (dict, list, bool)):
        return ""
    if isinstance(value, float):
        return shortest(value)
    return str(value)[:200]


def _step_names(table: Mapping[str, Any], root: Mapping[str, Any]) -> dict[str, str]:
    """Names of steps by their identifiers."""
    names: dict[str, str] = {}
    for steps in (table.get("ResultsSteps"), _object(root.get("Procedure")).get("Steps")):
        if not isinstance(steps, list):
            continue
        for step in map(_object, steps):
            if step.get("Name"):
                names[str(step.get("Id"))] = str(step["Name"])
    return names


def _pairs(root: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    """Quantities ``{Value, Unit: {Name}}`` and names, wherever they stand outside the results."""
    sample, procedure = root.get("Sample"), root.get("Procedure")
    if isinstance(sample, dict) and sample.get("Name"):
        yield "sample name", str(sample["Name"])
    if isinstance(root.get("StartTime"), str):
        yield "run date", root["StartTime"]
    waiting: list[tuple[str, Any, int]] = [("", procedure, 0), ("", root.get("Properties"), 0)]
    seen = 0
    # A stack with a limit, no recursion, which such a file could exhaust.
    while waiting and seen < _MOST_SEEN:
        key, value, depth = waiting.pop()
        seen += 1
        if isinstance(value, list) and depth < _DEEPEST:
            waiting += [(key, item, depth + 1) for item in value[:100]]
        elif isinstance(value, dict) and isinstance(value.get("Value"), int | float):
            unit = _object(value.get("Unit")).get("Name", "")
            if key in _PATHS:
                yield _PATHS[key], f"{value['Value']:.12g} {unit}"
        elif isinstance(value, dict) and depth < _DEEPEST:
            waiting += [(str(name), inner, depth + 1) for name, inner in value.items()]
            if key == "Geometry" and isinstance(value.get("Name"), str):
                yield "geometry name", value["Name"]
            if key == "InstrumentConfigurations" and isinstance(value.get("Type"), str):
                yield "instrument type", value["Type"]


TRIOS_JSON = reader_of_blocks(
    "trios-json", "TA Instruments TRIOS, exported as JSON", _is_json, _of_json, "TA TRIOS JSON"
)


_SIGNAL = re.compile(r"^Sig\d{1,3}[ \t]+(\S.*)$")
_START = "StartOfData"


def _is_thermal(head: bytes) -> float:
    """High for the list of signals; the numbers may begin far below."""
    lines = head_text(head).splitlines()
    named = sum(1 for line in lines if _SIGNAL.match(line))
    announced = any(line.startswith(("Nsig", _START)) for line in lines)
    if named < 2 or not announced:
        return 0.0
    return 0.97


def _of_thermal(path: Path) -> tuple[list[Block], dict[str, str]]:
    """One block for each segment of the method, and what the lines above the numbers say."""
    lines = lines_of(text_of(path))
    start = next((i + 1 for i, line in enumerate(lines) if line.startswith(_START)), len(lines))
    titles = [match[1].strip() for line in lines[:start] if (match := _SIGNAL.match(line))]
    headings = tuple(map(heading, titles))
    numbered = [(line.split(), i) for i, line in enumerate(lines[start:], start + 1)]
    blocks: list[Block] = []
    for is_row, run in groupby(
        numbered, lambda row: len(row[0]) == len(titles) and all(map(is_number, row[0]))
    ):
        if is_row:
            # What is no row of all signals marks the end of a segment.
            cells, places = zip(*run, strict=True)
            blocks.append(Block(f"segment {len(blocks) + 1}", headings, cells, places))
    return blocks, facts_of(pairs_in(line.split("\t") for line in lines[:start]))


THERMAL = reader_of_blocks(
    "ta-thermal",
    "TA Instruments DMA (Q800, RSA), exported as text with Sig1, Sig2 and so on",
    _is_thermal,
    _of_thermal,
    "TA thermal analysis",
)
