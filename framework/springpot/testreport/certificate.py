"""Whether tests are as a code asks, how sure that is, and why one fails: a certificate.

As data, as tables and as a page.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from springpot.api import diagnose
from springpot.distributions import student
from springpot.errors import DataError, OutputError, SpringpotError
from springpot.files import write_text
from springpot.measurement.from_signals import measurement_from_signals
from springpot.measurement.steady import Signals
from springpot.measurement.timetest import TimeTest
from springpot.numerics import FEWEST, SMALLEST
from springpot.plain_data import Plain
from springpot.registry import versions
from springpot.report.page import page
from springpot.report.residuals import framed
from springpot.report.text import with_interval
from springpot.testreport.report import PAGE
from springpot.thresholds import INTERVAL
from springpot.writing import NAMED, Html, number, table, tag, wide_table

from .code import TestCode, read_code
from .deciding import (
    CONFORMING,
    FAILING,
    UNDECIDED,
    DecidedRow,
    FoundFactor,
    chance,
    factors_of,
    limits_of,
    missing,
    rows_of,
)
from .record import LoopRecord, read_record
from .report import CycleReport, Sheet, check_sheets_path, figure_cycles, report_of, write_sheets
from .summary import EvaluatedTest, evaluate


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
    for row in rows[: PAGE.budget]:
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


BESIDE = frozenset((".toml", ".md", ".html", ".json", ".png", ".svg", ".pdf", ".py", ".log"))
"""What lies in a folder beside records."""


def certify(
    tests: str | Path | LoopRecord | Sequence[str | Path | LoopRecord],
    code: str | Path | TestCode,
    *,
    why: bool = True,
) -> Certificate:
    """Whether tests are as a code asks, how sure that is, and why one fails.

    Parameters
    ----------
    tests : str, Path, LoopRecord, or a sequence of them
        Records, or folders of them.
    code : str, Path or TestCode
        The TOML file that says what is asked; see the guide to test reports.
    why : bool
        Whether the records of the tests that fail most are diagnosed, which takes seconds each.

    Returns
    -------
    Certificate
        Rows with their decisions, budgets, property factors and reasons.

    Raises
    ------
    SpringpotError
        If the code cannot be read, no record is there, or a requirement is about none of them.
    """
    if not isinstance(code, TestCode):
        code = read_code(code)
    listed = [tests] if isinstance(tests, str | Path | LoopRecord) else list(tests)
    found, left_out = _evaluated(listed, code)
    rows = rows_of(code, found)
    factors = factors_of(code, found)
    rows += limits_of(code, factors)
    reasons = []
    if why:
        # Of each test the row that it fails by most, and of the tests those that fail by most.
        failing = [row for row in rows if row.verdict == FAILING and row.test]
        worst: dict[str, DecidedRow] = {}
        for row in sorted(failing, key=_excess, reverse=True):
            worst.setdefault(row.test, row)
        by_name = {test.name: test for test in found}
        reasons = [_reason(row, by_name[row.test], code) for row in [*worst.values()][:NAMED]]
        if failing:
            reasons += _of_all(found, code)
    return Certificate(
        code,
        report_of(found),
        tuple(rows),
        tuple(factors),
        tuple(missing(code, found)),
        tuple(left_out),
        tuple(reasons),
    )


def _evaluated(
    listed: Sequence[str | Path | LoopRecord], code: TestCode
) -> tuple[list[EvaluatedTest], list[str]]:
    found, left_out = [], []
    for given in listed:
        if isinstance(given, LoopRecord):
            found.append(evaluate(given, code.cycles))
            continue
        for spec in _files(given):
            try:
                found.append(evaluate(read_record(spec), code.cycles))
            # Of a folder the rest counts all the same; what was named is meant.
            except DataError as error:
                if spec == given:
                    raise
                left_out.append(str(error))
    if not found:
        reason = f": {left_out[0]}" if left_out else ""
        raise DataError(
            f"{listed[0] if listed else 'nothing'}: no record of a test is there{reason}"
        )
    return found, left_out


def _files(given: str | Path) -> list[str | Path]:
    """A file as it was named, or the files of a folder in the order of their names."""
    folder = Path(given)
    if not folder.is_dir():
        return [given]
    return [
        path
        for path in sorted(folder.iterdir())
        if path.is_file() and path.suffix.lower() not in BESIDE and not path.name.startswith(".")
    ]


def _excess(row: DecidedRow) -> float:
    """By how many uncertainties a result lies outside."""
    beyond = max(row.low - row.budget.value, row.budget.value - row.high)
    return float(beyond / max(row.budget.standard, SMALLEST))


def _reason(row: DecidedRow, test: EvaluatedTest, code: TestCode) -> Reason:
    """What is hidden in the record of a test that fails."""
    says = list(_with_temperature(test, row.quantity))
    # What a diagnosis cannot say, such as of too short a record, is said in its place.
    try:
        diagnosis = diagnose(_judged(test), code.model)
    except SpringpotError as error:
        return Reason(test.name, (*says, f"no diagnosis: {error}"), ())
    says.insert(0, diagnosis.says)
    return Reason(test.name, tuple(says), tuple(diagnosis.leading))


def _of_all(tests: Sequence[EvaluatedTest], code: TestCode) -> list[Reason]:
    """What is hidden in all tests together, as a sweep over their frequencies, where they have any.

    One frequency cannot tell a lag from a softer material, or a mass from a spring.
    """
    timed = [test for test in tests if test.record.timed]
    if len({f"{test.frequency.value:.2g}" for test in timed}) < FEWEST:
        return []
    records = [test.record for test in timed]
    signals = [
        Signals(each.time, each.displacement, each.force, each.displacement_unit, each.force_unit,
                each.name)
        for each in records
    ]  # fmt: skip
    name = f"all {len(timed)} tests together"
    try:
        diagnosis = diagnose(measurement_from_signals(signals, name=name), code.model)
    except SpringpotError as error:
        return [Reason(name, (f"no diagnosis: {error}",), ())]
    return [Reason(name, (diagnosis.says,), tuple(diagnosis.leading))]


def _judged(test: EvaluatedTest) -> TimeTest:
    """The record from its beginning to the end of some whole cycles."""
    record = test.record
    if not record.timed:
        raise DataError("the record has no time")
    last = test.cycles[min(FEWEST, len(test.cycles)) - 1]
    rows = record.time <= last.stop
    return TimeTest.of_history(
        record.time[rows] - record.time[0],
        record.displacement[rows],
        record.force[rows],
        record.displacement_unit,
        record.force_unit,
        control="displacement",
        name=record.name,
    )


def _with_temperature(test: EvaluatedTest, quantity: str) -> list[str]:
    """How a quantity changes from cycle to cycle, and the temperature with it, if surely."""
    if quantity not in BY_CYCLE or len(test.cycles) < FEWEST:
        return []
    number = np.arange(len(test.cycles), dtype=float)
    told = {}
    for name in (quantity, "T"):
        if name not in test.means:
            continue
        values = np.array([each[name].value for each in test.each])
        slope, sd = _trend(number, values)
        if abs(slope) > student(INTERVAL, len(number) - 2) * sd:
            told[name] = slope
    if quantity not in told:
        return []
    share = told[quantity] / test.means[quantity].value
    line = f"{quantity} changes by {100 * share:+.2g} % a cycle"
    if "T" in told:
        line += (
            f" while the temperature changes by {told['T']:+.2g} K: {100 * share / told['T']:+.2g}"
            " % a kelvin"
        )
    return [line]


BY_CYCLE = frozenset(("F0", "K_eff", "C_eff", "xi_eff", "W_d", "K'", "K''", "eta", "F_peak"))
"""Quantities that warming or wear change from cycle to cycle."""


def _trend(number: Any, values: Any) -> tuple[float, float]:
    """Slope of a straight line, and its deviation."""
    away = number - number.mean()
    size = float(away @ away)
    slope = float(away @ values) / size
    left = values - values.mean() - slope * away
    return slope, float(np.sqrt(left @ left / max(len(values) - 2, 1) / size))
