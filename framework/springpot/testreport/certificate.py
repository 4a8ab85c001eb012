"""A certificate: what a code asks of tests, answered, as data, as tables and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from springpot.errors import OutputError
from springpot.files import write_text
from springpot.plain_data import Plain
from springpot.registry import versions
from springpot.report.page import page
from springpot.report.residuals import framed
from springpot.report.text import with_interval
from springpot.writing import Html, number, table, tag, wide_table

from .code import TestCode
from .deciding import (
    CONFORMING,
    FAILING,
    UNDECIDED,
    DecidedRow,
    FoundFactor,
    chance,
)
from .report import CycleReport, Sheet, check_sheets_path, figure_cycles, write_sheets

SHOWN = 40
"""Rows of a budget on a page: all are in the workbook."""


@dataclass(frozen=True)
class Reason(Plain):
    """Why a test fails.

    Parameters
    ----------
    test : str
        Its name.
    says : tuple of str
        What a diagnosis finds in its record, and what goes with the temperature.
    effects : tuple of str
        The hidden effects that are named, the likeliest first.
    """

    test: str
    says: tuple[str, ...]
    effects: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Certificate:
    """What a code asks of tests, answered.

    Parameters
    ----------
    code : TestCode
        What was asked.
    report : CycleReport
        The tests.
    rows : tuple of DecidedRow
        Each result against its limits.
    factors : tuple of FoundFactor
        Property modification factors, the last of them all together.
    missing : tuple of str
        Tests that are asked for and are not there.
    left_out : tuple of str
        Files that could not be used, each with its reason.
    reasons : tuple of Reason
        Why the worst tests fail.
    """

    code: TestCode
    report: CycleReport
    rows: tuple[DecidedRow, ...]
    factors: tuple[FoundFactor, ...]
    missing: tuple[str, ...]
    left_out: tuple[str, ...]
    reasons: tuple[Reason, ...]

    @property
    def verdict(self) -> str:
        """``conforming``, ``undecided`` or ``not conforming``; the worst of all rows."""
        verdicts = {row.verdict for row in self.rows}
        if self.missing or FAILING in verdicts:
            return FAILING
        return UNDECIDED if UNDECIDED in verdicts else CONFORMING

    @property
    def says(self) -> str:
        """The verdict in one sentence."""
        counts = {word: sum(row.verdict == word for row in self.rows) for word in
                  (CONFORMING, UNDECIDED, FAILING)}  # fmt: skip
        told = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
        lack = f"; {len(self.missing)} required tests are missing" if self.missing else ""
        return f"{self.verdict}: of {len(self.rows)} rows {told}{lack}"

    @property
    def standing(self) -> str:
        """Who stands for the code."""
        if self.code.status == "signed":
            return f"signed by {self.code.signed_by}"
        return (
            "unchecked: nobody with the text of the standard has compared this file with it;"
            " its numbers are no standard's"
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data, schema ``springpot.certificate/1``."""
        return {
            "schema": "springpot.certificate/1",
            "code": {
                "name": self.code.name,
                "status": self.code.status,
                "signed_by": self.code.signed_by or None,
                "source": self.code.source,
                "guard": self.code.guard,
            },
            "verdict": self.verdict,
            "says": self.says,
            "rows": [row.to_dict() for row in self.rows],
            "factors": [factor.to_dict() for factor in self.factors],
            "missing": list(self.missing),
            "left_out": list(self.left_out),
            "reasons": [reason.to_dict() for reason in self.reasons],
            "tests": [test.to_dict() for test in self.report.tests],
        }

    def write(self, path: str | Path) -> Path:
        """Write it as .html (a browser prints it), .xlsx or .csv.

        Raises
        ------
        OutputError
            If the name ends otherwise or it cannot be written.
        """
        path = check_certificate_path(path)
        if path.suffix.lower() in {".html", ".htm"}:
            return write_text(path, certificate_page(self))
        return write_sheets([*self._sheets(), *self.report.sheets()], path)

    def _sheets(self) -> list[Sheet]:
        header = ("requirement", "quantity", "of", "result", "U", "k", "low", "high", "unit",
                  "chance outside", "verdict", "source")  # fmt: skip
        rows: list[list[float | str]] = [
            [row.name, row.quantity, row.subject, row.budget.value, row.budget.expanded,
             row.budget.coverage, row.low, row.high, row.unit, row.risk, row.verdict, row.source]
            for row in self.rows
        ]  # fmt: skip
        budget: list[list[float | str]] = [
            [row.name, row.subject, line.name, line.kind, line.standard, line.freedom, row.unit]
            for row in self.rows
            for line in row.budget.lines
        ]
        notes = [f"{self.code.name}: {self.says}", self.code.source, self.standing, *self.missing]
        notes += [f"left out: {each}" for each in self.left_out]
        notes += [f"{each.test}: {text}" for each in self.reasons for text in each.says]
        names = ("requirement", "of", "contribution", "type", "u", "freedom", "unit")
        return [Sheet("certificate", header, rows, notes), Sheet("budget", names, budget)]


def check_certificate_path(path: str | Path) -> Path:
    """`path`, after a check that a certificate can be written there.

    Raises
    ------
    OutputError
        If not.
    """
    path = Path(path)
    if path.suffix.lower() in {".html", ".htm"}:
        from springpot.report.html import check_report_path

        return check_report_path(path)
    if path.suffix.lower() == ".pdf":
        raise OutputError(f"cannot write {path}: write .html, which a browser prints as PDF")
    return check_sheets_path(path, (".html", ".xlsx", ".csv"))


def certificate_page(certificate: Certificate) -> Html:
    """The page; every name in it is escaped."""
    code = certificate.code
    body = [
        tag("h1", code.name),
        tag("p", certificate.standing, class_="quiet"),
        tag("p", f"Source: {code.source}", class_="quiet"),
        tag("div", tag("b", certificate.says), class_="verdict"),
        *(tag("p", f"Missing: {line}.") for line in certificate.missing),
        *_reasons(certificate),
        tag("h2", "Results and decisions"),
        _rows(certificate.rows),
        tag("p", _rule(certificate), class_="quiet"),
        *_factors(certificate),
        tag("h2", "Budget of uncertainty"),
        _budget(certificate.rows),
        tag("h2", "Tests"),
        *_tests(certificate),
        *(tag("p", f"Left out: {line}") for line in certificate.left_out),
        tag("h2", "Made by"),
        tag("p", ", ".join(f"{name} {number_}" for name, number_ in versions().items())),
    ]
    return page(code.name, *body)


def _rule(certificate: Certificate) -> str:
    if certificate.code.guard == "none":
        return (
            "Each result is taken as it is, without a guard band: at a limit a decision is wrong"
            " in one of two cases."
        )
    return (
        "Conforming is what lies within the limits by more than its expanded uncertainty U (95 %),"
        " not conforming what lies outside by more, undecided what is between (ISO 14253-1,"
        " ILAC-G8): a decision is wrong in at most 2.5 of 100 cases."
    )


def _rows(rows: Sequence[DecidedRow]) -> Html:
    headers = ("requirement", "quantity", "of", "result", "U", "limits", "unit", "outside",
               "verdict")  # fmt: skip
    cells = []
    for row in rows:
        value, expanded = row.budget.value, row.budget.expanded
        told, _ = with_interval(value, value - expanded, value + expanded)
        verdict: str = row.verdict
        if verdict != CONFORMING:
            verdict = tag("b", verdict)
        cells.append(
            [row.name, row.quantity, row.subject, told, number(expanded, 2), _limits(row), row.unit,
             chance(row.risk), verdict]
        )  # fmt: skip
    return wide_table(headers, cells, ("result", "U", "outside"))


def _limits(row: DecidedRow) -> str:
    ends = [f"{end:.5g}" if np.isfinite(end) else "" for end in (row.low, row.high)]
    return " .. ".join(ends).strip()


def _factors(certificate: Certificate) -> Iterator[Html]:
    if not certificate.factors:
        return
    yield tag("h2", "Property modification factors")
    rows = []
    for factor in certificate.factors:
        cells = [factor.name]
        for budget in (factor.low, factor.high):
            sure = f" ± {number(budget.expanded, 2)}" if budget.lines else ""
            cells.append(f"{number(budget.value)}{sure}")
        rows.append([*cells, factor.source])
    yield table(("cause", "lowest", "highest", "source"), rows)
    if certificate.code.system < 1.0:
        yield tag(
            "p",
            f"Of their product's distance from 1 the system takes {certificate.code.system:g}.",
            class_="quiet",
        )


def _reasons(certificate: Certificate) -> Iterator[Html]:
    for reason in certificate.reasons:
        yield tag("h2", f"Why not: {reason.test}")
        yield tag("ul", *(tag("li", text) for text in reason.says))


def _budget(rows: Sequence[DecidedRow]) -> Html:
    cells = []
    for row in rows[:SHOWN]:
        for line in row.budget.lines:
            freedom = number(line.freedom, 3) if np.isfinite(line.freedom) else "∞"
            cells.append([row.name, row.subject, line.name, line.kind, number(line.standard, 2),
                          freedom])  # fmt: skip
        budget = row.budget
        cells.append(
            [row.name, row.subject, f"combined, k = {number(budget.coverage, 3)}", "",
             tag("b", number(budget.standard, 2)), number(budget.freedom, 3).replace("inf", "∞")]
        )  # fmt: skip
    headers = ("requirement", "of", "contribution", "type", "u", "freedom")
    return tag("details", tag("summary", "Contributions"),
               table(headers, cells, ("u", "freedom")))  # fmt: skip


def _tests(certificate: Certificate) -> Iterator[Html]:
    report = certificate.report
    yield framed(
        figure_cycles(report.tests, report.law),
        "Loops as measured, the ellipse of the same stroke and energy, and the backbone",
    )
    for test in report.tests:
        rows = []
        for name in test.names():
            value, interval = with_interval(*test.means[name][:3])
            rows.append([name, value, interval, test.unit(name), test.means[name].source])
        headers = ("quantity", f"mean {test.first}..{test.last}", "95 % interval", "unit", "from")
        yield tag("h3", test.name)
        yield table(headers, rows, headers[1:2])
        for note in test.notes:
            yield tag("p", f"Note: {note}.", class_="quiet")
