"""The cycles of several tests in one answer: plain data, tables, files and pictures of it.

Tables are a workbook with a sheet for each, or one CSV with all below each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from springpot.errors import OptionError, OutputError
from springpot.files import require_writable, write_text, write_with
from springpot.writing import csv_text

from .record import LoopRecord, read_record
from .summary import EvaluatedTest, Told, VelocityLaw, evaluate, range_of, velocity_law

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SUFFIXES = (".xlsx", ".csv")
_FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")
"""What the name of a sheet cannot hold."""
LONGEST = 31
"""Letters of the name of a sheet."""


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
        try:
            import openpyxl  # noqa: F401
        except ImportError:
            raise OutputError(
                "Excel files need openpyxl: pip install 'springpot[instruments]'"
            ) from None
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
    return write_with(path, lambda stream: _workbook(sheets, stream))


def _lines(sheet: Sheet) -> list[Sequence[float | str]]:
    return [sheet.header, *sheet.rows, *([note] for note in sheet.notes)]


def _workbook(sheets: Sequence[Sheet], stream: IO[bytes]) -> None:
    from openpyxl import Workbook
    from openpyxl.styles import Font

    book = Workbook()
    book.remove(book.active)
    taken: set[str] = set()
    for sheet in sheets:
        page = book.create_sheet(_title(sheet.name, taken))
        for number, row in enumerate(_lines(sheet), 1):
            for column, value in enumerate(row, 1):
                cell = page.cell(number, column)
                if isinstance(value, str):
                    # Control signs cannot stand in a workbook.
                    cell.value = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f]", " ", value)
                    # Text stays text, whatever sign it begins with.
                    cell.data_type = "s"
                elif isfinite(value):
                    cell.value = value
                if number == 1:
                    cell.font = Font(bold=True)
        page.freeze_panes = "B2"
        # As wide as most names are.
        page.column_dimensions["A"].width = 24
    book.save(stream)


def _title(name: str, taken: set[str]) -> str:
    """A name that a sheet can have, and no other has."""
    stem = _FORBIDDEN.sub(" ", name).strip("' ")[:LONGEST] or "test"
    title, number = stem, 2
    while title.casefold() in taken:
        end = f" {number}"
        title, number = f"{stem[: LONGEST - len(end)]}{end}", number + 1
    taken.add(title.casefold())
    return title


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
        from .figures import figure_cycles

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
