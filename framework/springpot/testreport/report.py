"""The cycles of several tests in one answer: plain data, tables, files and pictures of it.

Tables are a workbook with a sheet for each, or one CSV with all below each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import ceil, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from springpot.errors import OptionError, OutputError
from springpot.files import require_writable, write_text
from springpot.report.canvas import CANVAS, COLOURS, INK, QUIET, blank, logarithmic, save
from springpot.report.page import require_openpyxl, write_workbook
from springpot.writing import csv_text

from .record import LoopRecord, read_record
from .summary import EvaluatedTest, Told, VelocityLaw, evaluate, range_of, velocity_law

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SUFFIXES = (".xlsx", ".csv")


@dataclass(frozen=True)
class Sheet:
    """One table.

    Parameters
    ----------
    name : str
        Of the sheet.
    header : sequence of str
        Above the columns.
    rows : sequence of sequences of float or str
        Its cells.
    notes : sequence of str
        Below the table.
    """

    name: str
    header: Sequence[str]
    rows: Sequence[Sequence[float | str]]
    notes: Sequence[str] = ()


def check_sheets_path(path: str | Path, suffixes: Sequence[str] = SUFFIXES) -> Path:
    """`path`, after a check that tables can be written there; called before long work.

    Raises
    ------
    OutputError
        If its name ends otherwise, openpyxl is missing, or the place cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise OutputError(f"cannot write {path}: its name must end in {' or '.join(suffixes)}")
    if path.suffix.lower() == ".xlsx":
        require_openpyxl()
    return require_writable(path)


def write_sheets(sheets: Sequence[Sheet], path: str | Path) -> Path:
    """Write tables to .xlsx or .csv.

    Raises
    ------
    OutputError
        If that cannot be.
    """
    path = check_sheets_path(path)
    if path.suffix.lower() == ".csv":
        blocks = [[[], [sheet.name], *_lines(sheet)] for sheet in sheets]
        # All below each other, an empty line between them.
        return write_text(path, csv_text(list(chain(*blocks))[1:]))
    return write_workbook(path, [(sheet.name, _lines(sheet)) for sheet in sheets])


def _lines(sheet: Sheet) -> list[Sequence[float | str]]:
    return [sheet.header, *sheet.rows, *([note] for note in sheet.notes)]


@dataclass(frozen=True, eq=False)
class CycleReport:
    """What a test report tells of records.

    Parameters
    ----------
    tests : tuple of EvaluatedTest
        One for each record.
    law : VelocityLaw or None
        Of tests at several speeds.
    """

    tests: tuple[EvaluatedTest, ...]
    law: VelocityLaw | None

    def to_dict(self) -> dict[str, Any]:
        """As plain data, schema ``springpot.cycles/1``."""
        return {
            "schema": "springpot.cycles/1",
            "tests": [test.to_dict() for test in self.tests],
            "velocity_law": self.law.to_dict() if self.law is not None else None,
        }

    def write(self, path: str | Path) -> Path:
        """Write a row for each cycle and each test to .xlsx or .csv.

        Raises
        ------
        SpringpotError
            If the name ends otherwise, the tests are in different units and the file is a .csv, or
            it cannot be written.
        """
        return write_sheets(self.sheets(), path)

    def sheets(self) -> list[Sheet]:
        """Means of all tests, and the cycles of each."""
        return [_means(self.tests), *(_cycles(test) for test in self.tests), *_law(self.law)]

    def figure(self, path: str | Path | None = None) -> Figure:
        """Loops with their ellipse, and the backbone; see `figure_cycles`."""
        return figure_cycles(self.tests, self.law, path)


def cycles(
    records: str | Path | LoopRecord | Sequence[str | Path | LoopRecord],
    *,
    cycles: str | tuple[int, int] | None = None,
) -> CycleReport:
    """What a test report tells of each cycle of a test, with intervals.

    Parameters
    ----------
    records : str, Path, LoopRecord, or a sequence of them
        Displacement and force against time, one test each.
    cycles : str or (int, int), optional
        Those that the means are of, such as ``"3..10"``; by default all but the first and the last.

    Returns
    -------
    CycleReport
        A row for each cycle and each test, the law of several speeds, files and figures of them.

    Raises
    ------
    SpringpotError
        If a record cannot be read, or holds no whole cycle.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> time = np.linspace(0.0, 5.0, 1001)
    >>> moved = 10.0 * np.sin(2.0 * np.pi * time)
    >>> columns = np.column_stack([time, moved, 0.3 * moved + 2.0 * np.cos(2.0 * np.pi * time)])
    >>> header = "time [s],displacement [mm],force [kN]"
    >>> np.savetxt("pad.csv", columns, delimiter=",", header=header, comments="")
    >>> report = springpot.cycles("pad.csv")
    >>> mean = report.tests[0].means
    >>> round(mean["K_eff"].value, 4), round(mean["W_d"].value, 2)
    (0.3, 62.83)
    """
    wanted = range_of(cycles) if isinstance(cycles, str) else cycles
    listed = [records] if isinstance(records, str | Path | LoopRecord) else list(records)
    if not listed:
        raise OptionError("there is no record: name one or several")
    tests = tuple(
        evaluate(each if isinstance(each, LoopRecord) else read_record(each), wanted)
        for each in listed
    )
    return report_of(tests)


def report_of(tests: Sequence[EvaluatedTest]) -> CycleReport:
    """The report of tests that are evaluated already."""
    return CycleReport(tuple(tests), velocity_law(tests))


def _cells(told: Told | None) -> list[float | str]:
    if told is None:
        return ["", "", ""]
    return [told.value, told.low, told.high]


def _headers(test: EvaluatedTest, names: Sequence[str]) -> list[str]:
    headers = []
    for name in names:
        unit = test.unit(name)
        headers += [f"{name} [{unit}]", f"{name} low", f"{name} high"]
    return headers


def _means(tests: Sequence[EvaluatedTest]) -> Sheet:
    """A row for each test; where units differ, each has a line of its own names."""
    names = list(dict.fromkeys(name for test in tests for name in test.names()))
    rows: list[list[float | str]] = []
    header: list[str] = []
    for test in tests:
        titles = ["test", "cycles", "frequency [Hz]", *_headers(test, names)]
        titles.append(f"energy of the run [{test.record.units['energy']}]")
        if titles != header:
            if header:
                rows.append([*titles])
            else:
                header = titles
        row: list[float | str] = [test.name, f"{test.first}..{test.last}"]
        row.append(test.frequency.value if test.record.timed else "")
        for name in names:
            row += _cells(test.means.get(name))
        rows.append([*row, test.energy.value])
    return Sheet("tests", header, rows)


def _cycles(test: EvaluatedTest) -> Sheet:
    names = test.names()
    clock = "s" if test.record.timed else "samples"
    header = ["cycle", f"start [{clock}]", f"stop [{clock}]", *_headers(test, names)]
    rows: list[list[float | str]] = []
    for cycle, each in zip(test.cycles, test.each, strict=True):
        row: list[float | str] = [cycle.number, cycle.start, cycle.stop]
        for name in names:
            row += _cells(each.get(name))
        rows.append(row)
    mean: list[float | str] = [f"mean {test.first}..{test.last}", "", ""]
    for name in names:
        mean += _cells(test.means.get(name))
    return Sheet(test.name, header, [*rows, mean], list(test.notes))


def _law(law: VelocityLaw | None) -> list[Sheet]:
    if law is None:
        return []
    told = law.to_dict()
    rows: list[list[float | str]] = [
        [name, *(told[name][key] for key in ("value", "low", "high", "unit"))]
        for name in ("C", "alpha")
    ]
    rows.append(["scatter of the tests", law.scatter, "", "", "-"])
    return [Sheet("velocity law", ["F0 = C v^alpha", "value", "low", "high", "unit"], rows)]


class Shown(NamedTuple):
    """How much of a report is shown at once."""

    across: int
    """Panels beside each other."""
    tests: int
    """Tests that are drawn: more would be too small to be read."""
    budget: int
    """Rows of a budget on a page: all are in the workbook."""
    cycles: int
    """Cycles that a table shows beside their mean; all are in files and in JSON."""


PAGE = Shown(across=3, tests=9, budget=40, cycles=12)


def figure_cycles(
    tests: Sequence[EvaluatedTest], law: VelocityLaw | None, path: str | Path | None = None
) -> Figure:
    """The loops of each test with their ellipse and backbone; the law of several speeds.

    Parameters
    ----------
    tests : sequence of EvaluatedTest
        The first of them are drawn.
    law : VelocityLaw or None
        Of all of them.
    path : str or Path, optional
        Where to write it.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.
    """
    shown = tests[: PAGE.tests]
    count = len(shown) + (law is not None)
    across = min(ceil(sqrt(count)), PAGE.across)
    down = -(-count // across)
    with blank(max(4.4, 3.6 * across), 3.2 * down) as figure:
        panels = figure.subplots(down, across, squeeze=False).ravel()
        for panel, test in zip(panels, shown, strict=False):
            draw_loops(panel, test)
        if law is not None:
            _draw_law(panels[len(shown)], tests, law)
        for panel in panels[count:]:
            panel.set_axis_off()
        if path is not None:
            save(figure, path)
    return figure


def draw_loops(axes: Axes, test: EvaluatedTest) -> None:
    """The whole cycles, the ellipse of the same stroke and energy, and the backbone."""
    record = test.record
    for cycle in test.cycles:
        inside = (record.time >= cycle.start) & (record.time <= cycle.stop)
        counted = test.first <= cycle.number <= test.last
        axes.plot(
            record.displacement[inside],
            record.force[inside],
            color=COLOURS[5] if counted else QUIET,
            lw=0.7,
            zorder=2 if counted else 1,
        )
    means = {name: told.value for name, told in test.means.items()}
    centre = 0.5 * (means["D+"] + means["D-"])
    half = 0.5 * (means["D+"] - means["D-"])
    phase = np.linspace(0.0, 2.0 * np.pi, CANVAS.smooth)
    middle = 0.5 * (means["F+"] + means["F-"])
    ellipse = means["K_eff"] * half * np.sin(phase)
    ellipse = ellipse + means["W_d"] / (np.pi * half) * np.cos(phase)
    # Force over displacement: K_eff x in phase, and as much across it as gives the same area.
    axes.plot(
        centre + half * np.sin(phase),
        middle + ellipse,
        "--",
        color=COLOURS[1],
        lw=1.2,
        label="ellipse",
    )
    axes.plot(
        [means["D-"], means["D+"]],
        [means["F-"], means["F+"]],
        "o-",
        color=INK,
        ms=3.5,
        lw=1.0,
        label="backbone",
    )
    title = test.name
    if record.timed:
        title = f"{test.name}, {test.frequency.value:.3g} Hz"
    axes.set(
        xlabel=f"displacement [{record.displacement_unit}]",
        ylabel=f"force [{record.force_unit}]",
        title=title,
    )
    axes.legend(loc="upper left")


def _draw_law(axes: Axes, tests: Sequence[EvaluatedTest], law: VelocityLaw) -> None:
    tests = [test for test in tests if {"F0", "v_peak"} <= test.means.keys()]
    speed = np.array([test.means["v_peak"].value for test in tests])
    force = [test.means["F0"] for test in tests]
    axes.errorbar(
        speed,
        [each.value for each in force],
        [[each.value - each.low for each in force], [each.high - each.value for each in force]],
        fmt="o",
        color=COLOURS[0],
    )
    at = np.geomspace(speed.min() / 1.2, speed.max() * 1.2, CANVAS.smooth)
    low, high = law.exponent_ends
    axes.plot(at, law.force(at), color=COLOURS[1])
    record = tests[0].record
    axes.set(
        xlabel=f"peak speed [{record.units['velocity']}]",
        ylabel=f"F0 [{record.force_unit}]",
        title=f"F = C |v|^{law.exponent:.3g}  [{low:.3g}, {high:.3g}]",
    )
    logarithmic(axes, "x")
    logarithmic(axes, "y")
