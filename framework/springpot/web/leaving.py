"""What a user leaves with: command, script, tables and session.

Among the tables what was understood of sweeps and of tests in time.
"""

from __future__ import annotations

import base64
import io
import shlex
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import numpy as np

from springpot.diagnosis.ladder import Ladder
from springpot.errors import DataError, plain
from springpot.measurement.covered import OtherTest
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import runs_of
from springpot.measurement.opening import Test
from springpot.measurement.reader import Part, parts_as_opened
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.report.interactive.answers import TimeScene, grown_by_each
from springpot.report.interactive.scene import PageScene, proposed_points
from springpot.rheology.points import KELVIN
from springpot.timetests.specimen import reference_of
from springpot.writing import csv_text

from .sessions import Opened, Specimen, State, safe_name, tests_in


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


MOST_RANGES = 20
"""Ranges of rows that are said on a command line; more are left out in a file of their own."""


def source_of(source: str, state: State, joined: bool) -> str:
    """The file that command and script read.

    The user's own, or the data as used where a file alone cannot say that.

    A registered data set stays its name.
    """
    # No command line names joined data, nor dozens of ranges.
    if joined or len(excluded_rows(state)) > MOST_RANGES:
        return f"{PurePath(safe_name(source)).stem}-used.csv"
    return source


def excluded_rows(state: State) -> list[str]:
    """The rows that are left out as ``--exclude`` takes them, the first being 1.

    The last ones come first: each choice counts the rows that the ones before it have left.

    Examples
    --------
    >>> excluded_rows(State("0" * 64, "", (), (0, 4, 5, 6)))
    ['row=5..7', 'row=1']
    """
    ranges: list[tuple[int, int]] = []
    for row in state.excluded:
        # Rows count from 0 here and from 1 for users: the end of a range is the number of the next
        # row.
        if ranges and ranges[-1][1] == row:
            ranges[-1] = ranges[-1][0], row + 1
        else:
            ranges.append((row + 1, row + 1))
    choices = []
    for low, high in reversed(ranges):
        choice = f"row={low}"
        if high > low:
            choice += f"..{high}"
        choices.append(choice)
    return choices


def rows_to_exclude(state: State) -> list[str]:
    """What command and script are to leave out.

    Nothing where the file that they read lacks these rows already.
    """
    rows = excluded_rows(state)
    if len(rows) > MOST_RANGES:
        return []
    return rows


def _exclude_argument(state: State) -> str:
    rows = rows_to_exclude(state)
    if not rows:
        return ""
    return f", exclude={rows!r}"


def command(state: State, source: str) -> str:
    """The command line that gives what the page shows.

    `source` is a path relative to where it is run.

    Examples
    --------
    >>> command(State("0" * 64, "maxwell", ("inertia",)), "my damper.csv")
    "springpot discover 'my damper.csv' --model maxwell --accept inertia --seed 0"
    """
    # `diagnose` accepts nothing: it tells what is missing from the model as it is.
    verb = "diagnose"
    if state.accepted:
        verb = "discover"
    # As a list, quoted at the end: a name with a blank or a quote stays one word of the shell.
    words = ["springpot", verb, source]
    if state.model:
        words += ["--model", state.model]
    for name in state.accepted:
        words += ["--accept", name]
    for name, value in state.fixed:
        words += ["--fix", f"{name}={value!r}"]
    for rows in rows_to_exclude(state):
        words += ["--exclude", rows]
    words += shlex.split(state.options)
    return shlex.join([*words, "--seed", str(state.seed)])


def script(state: State, *sources: str) -> str:
    """A Python program that gives the same numbers.

    It reads `sources`, each a test of the specimen, from the folder in which it is run.
    """
    # Names come from outside: a line break in one would end the comment and begin a statement.
    title = f"{state.expression} of {', '.join(sources)}, as the workbench showed it"
    comments = [" ".join(plain(title).split())]
    # Several tests are one specimen to Python alone; discover takes their names.
    reads = repr(list(sources))
    if len(sources) == 1:
        on_command_line = " ".join(plain(command(state, sources[0])).split())
        comments.append(f"On the command line: {on_command_line}")
        reads = f"springpot.read({sources[0]!r})"
    head = "\n".join(f"# {line}" for line in comments)
    # By `repr`, as all that is set into the program: a name stays a text, whatever stands in it.
    accepted, exclude = list(state.accepted), _exclude_argument(state)
    asked = f"{state.model or None!r}, accept={accepted!r}, seed={state.seed}{exclude}"
    for name, value in state.known.items():
        if value:
            asked += f", {name}={value!r}"
    return f"""{head}
import springpot

data = {reads}

# Each accepted effect is one rung: the model is fitted, and what is missing from it is sought anew.
ladder = springpot.discover(data, {asked})

for step in ladder.steps:
    print(f"{{step.model}}: error {{step.relative_rms:.6%}}, noise floor {{step.noise_floor:.6%}}")

# Values with their 95 % intervals, in the units in which the data came.
for name, value in ladder.steps[-1].parameters.items():
    print(f"{{name}} = {{value.value:.6g}} [{{value.low:.6g}}, {{value.high:.6g}}] {{value.unit}}")

print(ladder.verdict + ":", ladder.diagnosis.says)
"""


def report(ladder: Ladder, tests: Any, command: list[str]) -> str:
    """The page of a colleague; `tests` are the data, all rows, `command` what gave the answer.

    Raises
    ------
    OutputError
        If pictures cannot be drawn here.
    """
    # Pictures are an extra: the page works without them, and says here what is missing.
    from springpot.report.canvas import require_matplotlib
    from springpot.report.html import report_html

    require_matplotlib()
    return report_html(ladder, tests, command)


def replay(ladder: Ladder) -> str:
    """The moving picture of a ladder in base64."""
    # Drawing needs a library that nothing else here does.
    from springpot.report.result_plots import frames_of, written_as_gif

    stream = io.BytesIO()
    written_as_gif(frames_of(ladder), stream)
    return base64.b64encode(stream.getvalue()).decode()


def curves_csv(ladder: Ladder, measurement: Measurement) -> str:
    """K of data, model and every candidate, at the measured points and on the smooth curves.

    Frequencies are in Hz and, beside it, in rad/s, as the header says.
    """
    scene, case = PageScene(measurement), ladder.steps[-1].case
    base, unit = case.search.base, measurement.units.stiffness
    fits = [("model", base.model, base.theta)]
    # Only what was refitted: where a scan puts an effect is no fit, and would be read as one.
    fits += [
        (f"with {one.effect}", one.model, one.theta) for one in grown_by_each(case) if one.refitted
    ]
    # Frequency has columns of its own already.
    along = []
    if scene.axis.column != "frequency":
        along = [scene.axis.label]
    header = ["kind", "sweep", *along, "frequency [Hz]", "omega [rad/s]"]
    names = ["data", *(name for name, _, _ in fits)]
    for name in names:
        header += [f"{name} storage [{unit}]", f"{name} loss [{unit}]"]
    table: list[Sequence[Any]] = [header]
    numbers = np.zeros(len(measurement), dtype=int)
    for number, sweep in enumerate(scene.sweeps):
        numbers[sweep.rows] = number
    # A grown model may have no value at some points; these are left as nan.
    with np.errstate(all="ignore"):
        at_points = [model.stiffness(theta, scene.points) for _, model, theta in fits]
        for i, row in enumerate(scene.rows):
            x = [float(scene.axis.values[row])] * len(along)
            values = [measurement.stiffness[row], *(k[i] for k in at_points)]
            label = scene.sweeps[numbers[row]].label
            table.append(
                ["point", label, *x, *_frequencies(measurement.omega[row]), *_flat(values)]
            )
        for sweep, (places, points) in zip(scene.sweeps, scene.grids, strict=True):
            curves = [model.stiffness(theta, points) for _, model, theta in fits]
            for i, place in enumerate(places):
                x = [float(place)] * len(along)
                values = [k[i] for k in curves]
                # Between the points nothing was measured: the columns of the data stay empty.
                table.append(
                    [
                        "curve",
                        sweep.label,
                        *x,
                        *_frequencies(points.omega[i]),
                        "",
                        "",
                        *_flat(values),
                    ]
                )
    return csv_text(table)


IN_WORDS = "a further test in time is told in words; a table is made of frequencies"
"""Why there is no table of it."""


def plan_csv(ladder: Ladder, measurement: Measurement) -> str:
    """The proposed experiment as a table to be filled in.

    Frequencies and conditions, storage and loss left open.

    Raises
    ------
    DataError
        If nothing is proposed.
    """
    proposed = ladder.undecided.next_experiment
    if proposed is None or not proposed.action:
        raise DataError(
            "no further measurement is proposed here: nothing is left that one would decide"
        )
    if not proposed.action.get("omega"):
        raise DataError(IN_WORDS)
    points = proposed_points(proposed.action, measurement)
    unit, moved = measurement.units.stiffness, measurement.units.amplitude
    header, columns = ["frequency [Hz]"], [points.omega / (2 * np.pi)]
    if points.temperature is not None:
        header, columns = [*header, "temperature [degC]"], [*columns, points.temperature - KELVIN]
    if points.amplitude is not None:
        header, columns = [*header, f"amplitude [{moved}]"], [*columns, points.amplitude]
    table: list[list[Any]] = [[*header, f"storage [{unit}]", f"loss [{unit}]"]]
    for row in zip(*columns, strict=True):
        settings = [float(f"{value:.6g}") for value in row]
        table.append([*settings, "", ""])
    # The proposal is to stay one line of comment, whatever it says.
    reason = " ".join(proposed.says.split())
    return f"# {reason}\n" + csv_text(table)


def _frequencies(omega: float) -> list[float]:
    return [float(omega / (2 * np.pi)), float(omega)]


def _flat(values: Sequence[complex]) -> list[float]:
    parts = []
    for value in values:
        parts += [float(value.real), float(value.imag)]
    return parts
