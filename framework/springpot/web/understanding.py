"""What was understood of sweeps and of tests in time, and what a user leaves with of these."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from springpot.diagnosis.ladder import Ladder
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_tests import runs_of
from springpot.measurement.opening import Test
from springpot.measurement.other_test import OtherTest
from springpot.measurement.reader import Part, parts_as_opened
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.report.interactive.answers import TimeScene
from springpot.report.interactive.scene import PageScene
from springpot.timetests.specimen import reference_of
from springpot.writing import csv_text

from .specimen import Opened, Specimen, tests_in


def understood(data: Opened, parts: tuple[Part, ...] = ()) -> dict[str, Any]:
    """What was understood of data, as `springpot.web.tasks.understand` tells it."""
    tests = tests_in(data)
    columns = [column for test in tests for column in _columns(test, len(tests) > 1)]
    notes = {
        key if len(tests) == 1 else f"{test.name}: {key}": str(value)
        for test in tests
        for key, value in test.provenance.items()
    }
    whole = {
        "columns": [
            {
                "name": name,
                "unit": unit,
                "from": float(np.nanmin(column)),
                "to": float(np.nanmax(column)),
            }
            for name, unit, column in columns
        ],
        "provenance": notes,
    }
    if isinstance(data, Specimen):
        nothing: dict[str, list[Any]] = {"runs": [], "levels": [], "parts": []}
        scene = TimeScene(tests).to_dict()
        return {**whole, **nothing, "scene": scene, "repeats": 0, "deviations": False}
    return {**whole, **_of_sweeps(data, parts)}


def _of_sweeps(measurement: Measurement, parts: tuple[Part, ...]) -> dict[str, Any]:
    """What only sweeps have."""
    runs = list(runs_of(measurement))
    # A single sweep is all of the data: there is nothing to choose.
    if len(runs) == 1:
        runs = []
    repeats = 0
    if measurement.repeat is not None:
        repeats = len(np.unique(measurement.repeat))
    return {
        "scene": PageScene(measurement).to_dict(),
        "runs": [{"name": run.name, "rows": run.rows.tolist()} for run in runs],
        "levels": _levels(measurement),
        "repeats": repeats,
        "deviations": measurement.sd is not None,
        "parts": [
            {"number": i, "name": part.name, "usable": part.usable}
            for i, part in enumerate(parts_as_opened(parts, measurement), 1)
        ],
    }


def _levels(measurement: Measurement) -> list[dict[str, Any]]:
    """Rows of each level of a condition, where there are several."""
    units = {"temperature": "°C", "amplitude": measurement.units.amplitude}
    levels = []
    for name, column in measurement.conditions.items():
        numbers = measurement.levels(name)
        count = int(numbers.max()) + 1
        # A column that goes on with each row was measured, and not set.
        if not 1 < count <= len(measurement) / 2:
            continue
        for number in range(count):
            rows = np.flatnonzero(numbers == number)
            label = f"{name} {np.mean(column[rows]):.4g} {units.get(name, '')}".strip()
            levels.append({"name": label, "column": name, "rows": rows.tolist()})
    return levels


def _columns(test: Test, several: bool) -> list[tuple[str, str, Any]]:
    of = f"{test.name}: " if several else ""
    if isinstance(test, Measurement):
        unit = test.units.stiffness
        columns = [("frequency", "Hz", test.frequency)]
        columns += [("storage", unit, test.storage), ("loss", unit, test.loss)]
        units = {"temperature": "°C", "amplitude": test.units.amplitude}
        held = test.conditions.items() if not several else ()
        columns += [(name, units.get(name, ""), column) for name, column in held]
        return [(f"{of}{name}", unit, values) for name, unit, values in columns]
    if isinstance(test, OtherTest):
        return [(f"{of}{test.quantity}", test.unit, test.measured)]
    imposed, answered = test.words
    return [
        (f"{of}time", "s", test.time),
        (f"{of}{answered}", test.response_unit, test.response),
        (f"{of}{imposed}", test.loading_unit, test.loading.value),
    ]


def curves_in_time(ladder: Ladder, tests: Sequence[Test]) -> str:
    """What each test measured and what the model computes there, number by number."""
    case, reference = ladder.steps[-1].examined, reference_of(tests)
    assert case is not None
    table: list[list[Any]] = [["test", "at [s, or Hz of a sweep]", "measured", "model", "unit"]]
    for part in parts_of_specimen(tests):
        rows = np.arange(len(part.measured))
        model = part.answer(case.base.model, case.base.theta, reference, rows).value
        unit = part.unit
        table += [
            [part.test.name, float(at), float(measured), float(computed), unit]
            for at, measured, computed in zip(part.at, part.measured, model, strict=True)
        ]
    return csv_text(table)
