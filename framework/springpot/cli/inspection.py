"""``springpot inspect``: what a file or data set holds, before anything is fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from . import timetests
from .common import data_argument, emit, geometry_option, json_option, opened

if TYPE_CHECKING:
    from springpot.measurement import Measurement, Part
    from springpot.measurement.runs import Run
    from springpot.rheology import Real

WIDE = 100
"""Signs of a list of words that are printed; JSON has all."""
LONG = 24
"""Runs that are printed."""


@click.command("inspect", epilog="Example: springpot inspect damper.csv")
@data_argument
@geometry_option
@json_option
def command(data: str, geometry: str | None, as_json: bool) -> None:
    """Show what DATA, a file or a registered data set, holds.

    Of a file with several steps, sweeps or sheets all that are dynamic tests open together; FILE#2 opens one of them.
    What a file leaves open is said by FILE?frequency=Hz, in quotes for some shells.
    """
    from springpot.errors import DataError
    from springpot.registry import open_in_time, parts_of

    if in_time := open_in_time(data):
        timetests.inspect(in_time, as_json)
        return
    parts = parts_of(data)
    try:
        result = described(opened(data, geometry, quiet=True), parts)
    except DataError as error:
        if not parts or as_json:
            raise
        _show_parts(_listed(parts))
        raise DataError(str(error)) from None
    emit(result, as_json, lambda: _show(result))


def described(measurement: Measurement, parts: Sequence[Part] = ()) -> dict[str, Any]:
    """What a measurement holds, schema ``springpot.inspection/1``."""
    from springpot.measurement.runs import runs_of

    units = {"temperature": "degC", "amplitude": measurement.units.amplitude}
    said = {key: value for key, value in measurement.provenance.items() if not key.startswith("unit ")}
    units |= {key[5:]: value for key, value in measurement.provenance.items() if key.startswith("unit ")}
    return {
        "schema": "springpot.inspection/1",
        "data": measurement.name,
        "points": len(measurement),
        "frequency": _range(measurement.frequency, "Hz"),
        "storage": _range(measurement.storage, measurement.units.stiffness),
        "loss": _range(measurement.loss, measurement.units.stiffness),
        "standard_deviations": measurement.sd is not None,
        "conditions": {name: _range(column, units.get(name, "")) for name, column in measurement.conditions.items()},
        "labels": {name: list(dict.fromkeys(map(str, column))) for name, column in measurement.labels.items()},
        "sweeps": [_sweep(measurement, run) for run in runs_of(measurement)],
        "parts": _listed(parts),
        "provenance": said,
    }


def _sweep(measurement: Measurement, run: Run) -> dict[str, Any]:
    amplitude = measurement.conditions.get("amplitude")
    return {
        "conditions": run.name,
        "points": len(run.rows),
        **run.conditions,
        "frequency": _range(measurement.frequency[run.rows], "Hz"),
        "amplitude": None if amplitude is None else _range(amplitude[run.rows], measurement.units.amplitude),
    }


def _listed(parts: Sequence[Part]) -> list[dict[str, Any]]:
    return [
        {"number": i, "name": part.name, "points": part.points, "usable": part.usable, "says": part.says}
        for i, part in enumerate(parts, 1)
    ]


def _range(column: Real, unit: str) -> dict[str, Any]:
    import numpy as np

    there = column[np.isfinite(column)]
    lowest, highest = (float(there.min()), float(there.max())) if len(there) else (float("nan"), float("nan"))
    return {"from": lowest, "to": highest, "unit": unit}


def _show(result: dict[str, Any]) -> None:
    from springpot.report.numbers import number
    from springpot.report.text import Table

    count, points = len(result["sweeps"]), result["points"]
    what = f"{points} {'point' if points == 1 else 'points'}, {count} {'sweep' if count == 1 else 'sweeps'}"
    print(f"{result['data']}: {what}\n")
    ranges = {key: result[key] for key in ("frequency", "storage", "loss")} | result["conditions"]
    rows = [[name, number(r["from"]), number(r["to"]), r["unit"]] for name, r in ranges.items()]
    Table(("column", "from", "to", "unit"), rows, frozenset({"from", "to"})).show()
    for name, words in result["labels"].items():
        if name != "step":
            print(f"\n{name}: {_few(words)}")
    print(f"\nstandard deviations: {'given' if result['standard_deviations'] else 'not given'}")
    if count > 1:
        _show_sweeps(result["sweeps"], result["parts"])
    together = {sweep.get("step") for sweep in result["sweeps"]}
    if others := [part for part in result["parts"] if part["name"] not in together]:
        print()
        _show_parts(others)
    for key, value in result["provenance"].items():
        print(f"{key}: {value}")


def _few(words: Sequence[str]) -> str:
    """As many words as fit a line, and how many there are."""
    line = ", ".join(words)
    return line if len(line) <= WIDE else f"{line[:WIDE].rpartition(', ')[0] or line[:WIDE]}, ... ({len(words)})"


def _show_sweeps(sweeps: Sequence[dict[str, Any]], parts: Sequence[dict[str, Any]]) -> None:
    """A line for each run; the first column is what to write behind ``#`` for one of them."""
    from springpot.report.text import Table

    units = {"temperature": "degC", "frequency": "Hz", "amplitude": (sweeps[0]["amplitude"] or {}).get("unit")}
    known = ("step", "temperature", "repeat", "points", "frequency", "amplitude")
    keys = [key for key in known if sweeps[0].get(key) is not None]
    numbers = {part["name"]: f"#{part['number']}" for part in parts}
    rows = [[numbers.get(sweep.get("step"), ""), *(_cell(sweep[key]) for key in keys)] for sweep in sweeps[:LONG]]
    headers = ["part", *(f"{key} [{units[key]}]" if key in units else key for key in keys)]
    if not numbers:
        headers, rows = headers[1:], [row[1:] for row in rows]
    print()
    Table(headers, rows, frozenset(headers) - {"part", "step"}).show()
    if len(sweeps) > LONG:
        print(f"... and {len(sweeps) - LONG} more; --json has all")


def _cell(value: Any) -> str:
    from springpot.report.numbers import number

    if isinstance(value, dict):
        return " to ".join(dict.fromkeys([number(value["from"]), number(value["to"])]))
    return value if isinstance(value, str) else f"{value:.4g}"


def _show_parts(parts: list[dict[str, Any]]) -> None:
    from springpot.report.text import Table

    rows = [[f"#{p['number']}", p["name"], str(p["points"]), "" if p["usable"] else p["says"]] for p in parts]
    Table(("part", "name", "rows", "cannot be opened"), rows, frozenset({"rows"})).show()
    print()
