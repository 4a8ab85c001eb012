"""What was understood of sweeps: their columns, and which rows can be chosen together."""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_tests import runs_of
from springpot.measurement.reader import Part, parts_as_opened
from springpot.report.interactive.scene import PageScene

MOST_LEVELS = 40
"""Levels of a condition that are offered for a choice of rows.

Of more, hardly a row would belong to each.
"""
MOST_RUNS = 200
"""Sweeps that are listed of one measurement."""


def understood_sweeps(measurement: Measurement, parts: tuple[Part, ...]) -> dict[str, Any]:
    """What was understood of sweeps, as `springpot.web.tasks.understand` tells it."""
    columns = [("frequency", "Hz", measurement.frequency)]
    columns += [("storage", measurement.units.stiffness, measurement.storage)]
    columns += [("loss", measurement.units.stiffness, measurement.loss)]
    units = {"temperature": "°C", "amplitude": measurement.units.amplitude}
    columns += [
        (name, units.get(name, ""), column) for name, column in measurement.conditions.items()
    ]
    runs = list(runs_of(measurement))
    # A single sweep is all of the data: there is nothing to choose.
    if len(runs) == 1:
        runs = []
    repeats = 0
    if measurement.repeat is not None:
        repeats = len(np.unique(measurement.repeat))
    return {
        "scene": PageScene(measurement).to_dict(),
        "columns": [
            {
                "name": name,
                "unit": unit,
                "from": float(np.nanmin(column)),
                "to": float(np.nanmax(column)),
            }
            for name, unit, column in columns
        ],
        "runs": [{"name": run.name, "rows": run.rows.tolist()} for run in runs[:MOST_RUNS]],
        "levels": _levels(measurement),
        "repeats": repeats,
        "deviations": measurement.sd is not None,
        "parts": [
            {"number": i, "name": part.name, "usable": part.usable}
            for i, part in enumerate(parts_as_opened(parts, measurement), 1)
        ],
        "provenance": {key: str(value) for key, value in measurement.provenance.items()},
    }


def _levels(measurement: Measurement) -> list[dict[str, Any]]:
    """Rows of each level of a condition, where there are several."""
    units = {"temperature": "°C", "amplitude": measurement.units.amplitude}
    levels = []
    for name, column in measurement.conditions.items():
        numbers = measurement.levels(name)
        count = int(numbers.max()) + 1
        # A column that goes on with each row was measured, and not set.
        if not 1 < count <= min(MOST_LEVELS, len(measurement) / 2):
            continue
        for number in range(count):
            rows = np.flatnonzero(numbers == number)
            label = f"{name} {np.mean(column[rows]):.4g} {units.get(name, '')}".strip()
            levels.append({"name": label, "column": name, "rows": rows.tolist()})
    return levels
