"""``springpot inspect``: what a file or data set holds, before anything is fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from .common import data_argument, emit, geometry_option, json_option, opened

if TYPE_CHECKING:
    from springpot.measurement import Measurement, Part
    from springpot.rheology import Real

SHOWN = 12
"""Values of a label that are printed; JSON has all."""


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
    from springpot.registry import parts_of

    parts = parts_of(data)
    try:
        result = described(opened(data, geometry), parts)
    except DataError as error:
        if not parts or as_json:
            raise
        _show_parts(_listed(parts))
        raise DataError(str(error)) from None
    emit(result, as_json, lambda: _show(result))


def described(measurement: Measurement, parts: Sequence[Part] = ()) -> dict[str, Any]:
    """What a measurement holds, schema ``springpot.inspection/1``."""
    units = measurement.units
    condition_units = {"temperature": "degC", "amplitude": units.amplitude}
    return {
        "schema": "springpot.inspection/1",
        "data": measurement.name,
        "points": len(measurement),
        "frequency": _range(measurement.frequency, "Hz"),
        "storage": _range(measurement.storage, units.stiffness),
        "loss": _range(measurement.loss, units.stiffness),
        "standard_deviations": measurement.sd is not None,
        "conditions": {
            name: _range(column, condition_units.get(name, "")) for name, column in measurement.conditions.items()
        },
        "labels": {name: sorted({str(word) for word in column}) for name, column in measurement.labels.items()},
        "sweeps": [{"conditions": label, "points": len(rows)} for label, rows in measurement.sweeps()],
        "parts": _listed(parts),
        "provenance": dict(measurement.provenance),
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

    count = len(result["sweeps"])
    print(f"{result['data']}: {result['points']} points, {count} {'sweep' if count == 1 else 'sweeps'}\n")
    ranges = {key: result[key] for key in ("frequency", "storage", "loss")} | result["conditions"]
    rows = [[name, number(r["from"]), number(r["to"]), r["unit"]] for name, r in ranges.items()]
    numbers = frozenset({"from", "to", "points"})
    Table(("column", "from", "to", "unit"), rows, numbers).show()
    for name, words in result["labels"].items():
        print(f"\n{name}: {', '.join(words[:SHOWN])}{', ...' if len(words) > SHOWN else ''}")
    print(f"\nstandard deviations: {'given' if result['standard_deviations'] else 'not given'}")
    if count > 1:
        print()
        rows = [[sweep["conditions"], str(sweep["points"])] for sweep in result["sweeps"]]
        Table(("sweep", "points"), rows, numbers).show()
    if result["parts"]:
        print()
        _show_parts(result["parts"])
    for key, value in result["provenance"].items():
        print(f"{key}: {value}")


def _show_parts(parts: list[dict[str, Any]]) -> None:
    from springpot.report.text import Table

    rows = [[f"#{p['number']}", p["name"], str(p["points"]), "" if p["usable"] else p["says"]] for p in parts]
    Table(("part", "name", "rows", "cannot be opened"), rows, frozenset({"rows"})).show()
    print()
