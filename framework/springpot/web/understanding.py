"""What was understood of sweeps and of tests in time, and what a user leaves with of these."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from springpot.diagnosis.ladder import Ladder
from springpot.errors import DataError
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_tests import runs_of
from springpot.measurement.opening import Test
from springpot.measurement.other_test import OtherTest
from springpot.measurement.reader import Part, parts_as_opened
from springpot.report.interactive.in_time import TimeScene, case_of
from springpot.report.interactive.scene import PageScene
from springpot.timetests.residuals_of_tests import parts_of_specimen
from springpot.writing import csv_text

from . import leaving
from .sessions import State
from .specimen import Specimen

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


LACKS = {
    "data": "tests in time leave as the files that were opened, which the session holds too",
    "plan": "a further test in time is told in words; a table is made of frequencies",
}
"""Why something that leaves with sweeps does not leave with tests in time."""


def understood_in_time(data: Specimen) -> dict[str, Any]:
    """What was understood of tests in time, as `springpot.web.tasks.understand` tells it."""
    columns = [column for test in data.tests for column in _columns(test, len(data.tests) > 1)]
    notes = {
        key if len(data.tests) == 1 else f"{test.name}: {key}": str(value)
        for test in data.tests
        for key, value in test.provenance.items()
    }
    return {
        "scene": TimeScene(data.tests).to_dict(),
        "columns": [
            {"name": name, "unit": unit, "from": float(np.min(values)), "to": float(np.max(values))}
            for name, unit, values in columns
        ],
        "runs": [],
        "levels": [],
        "repeats": 0,
        "deviations": False,
        "parts": [],
        "provenance": notes,
    }


def _columns(test: Test, several: bool) -> list[tuple[str, str, Any]]:
    of = f"{test.name}: " if several else ""
    if isinstance(test, Measurement):
        unit = test.units.stiffness
        columns = [("frequency", "Hz", test.frequency)]
        columns += [("storage", unit, test.storage), ("loss", unit, test.loss)]
        return [(f"{of}{name}", unit, values) for name, unit, values in columns]
    if isinstance(test, OtherTest):
        return [(f"{of}{test.quantity}", test.unit, test.measured)]
    imposed, answered = test.words
    return [
        (f"{of}time", "s", test.time),
        (f"{of}{answered}", test.response_unit, test.response),
        (f"{of}{imposed}", test.loading_unit, test.loading.value),
    ]


def leave_in_time(
    kind: str, state: State, data: Specimen, used: Sequence[Test], ladder: Callable[[], Ladder]
) -> dict[str, str]:
    """One of the things that a user leaves with; `ladder` is asked only where it is needed.

    `used` are the tests as the model sees them, without what is left out.

    Raises
    ------
    DataError
        If there is no such thing of tests in time.
    """
    if kind in LACKS:
        raise DataError(LACKS[kind])

    sources, stem = data.sources, Path(data.sources[0]).stem
    if kind in ("script", "command") and state.excluded and len(data.tests) > 1:
        raise DataError("rows of several tests were left out, which only the session can say")
    if kind == "script":
        return {"name": f"{stem}.py", "text": leaving.script(state, *sources)}
    # The command takes one file.
    command = leaving.command(state, sources[0])
    if kind == "command":
        if len(sources) > 1:
            raise DataError("one command takes one file: the Python script takes all of them")
        return {"name": f"{stem}.txt", "text": command + "\n"}
    if kind == "curves":
        return {"name": f"{stem}-curves.csv", "text": _curves(ladder(), used)}
    if kind == "replay":
        return {"name": f"{stem}-replay.gif", "base64": leaving.replay(ladder())}
    if kind == "report":
        text = leaving.report(ladder(), used, shlex.split(command))
        return {"name": f"{stem}-report.html", "text": text}
    raise DataError(f"there is nothing called '{kind[:40]}' to leave with")


def _curves(ladder: Ladder, tests: Sequence[Test]) -> str:
    """What each test measured and what the model computes there, number by number."""
    base = case_of(ladder.steps[-1]).base
    table: list[list[Any]] = [["test", "at [s, or Hz of a sweep]", "measured", "model", "unit"]]
    for part in parts_of_specimen(tests):
        rows = np.arange(len(part.measured))
        model = part.answer(base.model, base.theta, base.reference, rows).value
        unit = part.unit
        table += [
            [part.test.name, float(at), float(measured), float(computed), unit]
            for at, measured, computed in zip(part.at, part.measured, model, strict=True)
        ]
    return csv_text(table)
