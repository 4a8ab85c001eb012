"""``springpot inspect``: what a file or data set holds, before anything is fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from . import timetests
from .common import (
    complete_data,
    emit,
    geometry_option,
    json_option,
    of_each,
    opened,
    seen_through,
    window,
)

if TYPE_CHECKING:
    from springpot.measurement.measurement import Measurement
    from springpot.measurement.mixed_up import ConditionRun
    from springpot.measurement.reader import Part
    from springpot.rheology.points import Real


@click.command("inspect", epilog="Example: springpot inspect damper.csv")
@click.argument("data", nargs=-1, required=True, metavar="DATA...", shell_complete=complete_data)
@geometry_option
@json_option
def command(data: tuple[str, ...], geometry: str | None, as_json: bool) -> int:
    """Show what DATA, a file or a registered data set, holds.

    Each of several gets its own answer, with --json a line; one that cannot be used is named on
    stderr. Of a file with several steps, sweeps or sheets all that are dynamic tests open together;
    FILE#2 opens one of them. What a file leaves open is said by FILE?frequency=Hz, in quotes for
    some shells.
    """

    def answer(name: str) -> None:
        if name != data[0] and not as_json:
            print()
        _inspect(name, geometry, as_json, line=len(data) > 1)

    return of_each(data, answer)


def _inspect(data: str, geometry: str | None, as_json: bool, line: bool) -> None:
    from springpot.errors import DataError
    from springpot.registry import open_in_time, parts_of
    from springpot.report.inspection import inspected_text, parts_text

    # First: a reader of sweeps would ask what a column of time is.
    if in_time := open_in_time(data):
        seen = [seen_through(test, geometry) for test in in_time]
        timetests.inspect(seen, data, as_json, line)
        return
    # Listed before the data are opened: where that fails, they show what could be opened instead.
    parts = parts_of(data)
    try:
        # Its notes are part of the answer.
        measured = opened(data, geometry, quiet=True)
    except DataError as error:
        if parts and not as_json:
            print(parts_text(_listed(parts), window()), end="\n\n")
        raise DataError(str(error)) from None
    result = described(measured, parts)
    emit(
        result, as_json, lambda: print(inspected_text(result, measured.units, data, window())), line
    )


def described(measurement: Measurement, parts: Sequence[Part] = ()) -> dict[str, Any]:
    """What a measurement holds, schema ``springpot.inspection/1``."""
    from springpot.measurement.mixed_up import runs_of
    from springpot.measurement.reader import parts_as_opened

    units = {"temperature": "degC", "amplitude": measurement.units.amplitude}
    provenance = {}
    for key, value in measurement.provenance.items():
        # Readers keep the unit of a further condition there.
        if key.startswith("unit "):
            units[key.removeprefix("unit ")] = value
        else:
            provenance[key] = value
    return {
        "schema": "springpot.inspection/1",
        "data": measurement.name,
        "points": len(measurement),
        "frequency": _range(measurement.frequency, "Hz"),
        "storage": _range(measurement.storage, measurement.units.stiffness),
        "loss": _range(measurement.loss, measurement.units.stiffness),
        "standard_deviations": measurement.sd is not None,
        "conditions": {
            name: _range(column, units.get(name, ""))
            for name, column in measurement.conditions.items()
        },
        "labels": {
            name: list(dict.fromkeys(map(str, column)))
            for name, column in measurement.labels.items()
        },
        "sweeps": [_sweep(measurement, run) for run in runs_of(measurement)],
        "parts": _listed(parts_as_opened(parts, measurement)),
        "provenance": provenance,
    }


def _sweep(measurement: Measurement, run: ConditionRun) -> dict[str, Any]:
    amplitude = None
    if "amplitude" in measurement.conditions:
        amplitude = _range(
            measurement.conditions["amplitude"][run.rows], measurement.units.amplitude
        )
    return {
        "conditions": run.name,
        "points": len(run.rows),
        **run.conditions,
        "frequency": _range(measurement.frequency[run.rows], "Hz"),
        "amplitude": amplitude,
    }


def _listed(parts: Sequence[Part]) -> list[dict[str, Any]]:
    return [
        {
            "number": i,
            "name": part.name,
            "points": part.points,
            "usable": part.usable,
            "says": part.says,
        }
        for i, part in enumerate(parts, 1)
    ]


def _range(column: Real, unit: str) -> dict[str, Any]:
    import numpy as np

    # A table may leave a condition open in some of its rows.
    known = column[np.isfinite(column)]
    lowest = highest = float("nan")
    if len(known):
        lowest, highest = float(known.min()), float(known.max())
    return {"from": lowest, "to": highest, "unit": unit}
