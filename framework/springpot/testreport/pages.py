"""A certificate as one page that needs nothing else; a browser prints it as PDF."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from springpot.format_numbers import number
from springpot.markup import Html, table, tag
from springpot.report.residuals import framed
from springpot.report.style import page
from springpot.report.text import with_interval
from springpot.versions import versions

from .certified import CertifiedTests
from .deciding import CONFORMING, DecidedRow
from .figures import figure_cycles
from .words import chance

SHOWN = 40
"""Rows of a budget on a page: all are in the workbook."""


def certificate_page(certificate: CertifiedTests) -> Html:
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


def _rule(certificate: CertifiedTests) -> str:
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
    return tag("div", table(headers, cells, ("result", "U", "outside")), class_="scroll")


def _limits(row: DecidedRow) -> str:
    ends = [f"{end:.5g}" if np.isfinite(end) else "" for end in (row.low, row.high)]
    return " .. ".join(ends).strip()


def _factors(certificate: CertifiedTests) -> Iterator[Html]:
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


def _reasons(certificate: CertifiedTests) -> Iterator[Html]:
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


def _tests(certificate: CertifiedTests) -> Iterator[Html]:
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
