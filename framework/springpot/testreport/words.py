"""The cycles of a test as a table to be read."""

from __future__ import annotations

from springpot.format_numbers import counted
from springpot.report.text import TextTable, with_interval

from .quantities import BY_NAME
from .summary import EvaluatedTest, Told
from .velocity import VelocityLaw

SHOWN = 12
"""Cycles that a table shows beside their mean; all are in files and in JSON."""


def table_of(test: EvaluatedTest) -> TextTable:
    """Quantities down, the mean and the cycles across: as many numbers as can be read."""
    numbers = [cycle.number for cycle in test.cycles]
    headers = [
        f"{test.name}: {counted(len(numbers), 'cycle')}",
        f"mean {test.first}..{test.last}",
        "95 % interval",
        "unit",
        "from",
        *(f"{number}" for number in numbers[:SHOWN]),
    ]
    rows = []
    if test.record.timed:
        value, interval = with_interval(*test.frequency[:3])
        rows.append(["frequency", value, interval, "Hz", test.frequency.source])
        rows[0] += [""] * len(headers[5:])
    for name in test.names():
        mean = test.means[name]
        value, interval = with_interval(*mean[:3])
        each = [_cell(row.get(name)) for row in test.each[:SHOWN]]
        rows.append([name, value, interval, test.unit(name), mean.source, *each])
    spare = [f"{number}" for number in reversed(numbers[1:SHOWN])]
    legend = {headers[0]: "; ".join(f"{name}: {BY_NAME[name].means}" for name in test.names())}
    return TextTable(headers, rows, frozenset(headers[1:2] + headers[5:]), spare, legend)


def _cell(told: Told | None) -> str:
    if told is None:
        return "-"
    return with_interval(*told[:3])[0]


def law_text(law: VelocityLaw) -> str:
    """One line of the law of several speeds."""
    told = law.to_dict()
    parts = []
    for name in ("C", "alpha"):
        value, interval = with_interval(*(told[name][key] for key in ("value", "low", "high")))
        unit = "" if told[name]["unit"] == "-" else f" {told[name]['unit']}"
        parts.append(f"{name} = {value} {interval}{unit}")
    origin = {"noise": "the noise of the tests", "tests": "the scatter of the tests"}[law.source]
    return f"F0 = C |v|^alpha with {' and '.join(parts)}, from {origin}"


SURE = 1e-4
"""A chance below it is not told by its size: the tails of a distribution are not known so far."""


def chance(value: float) -> str:
    """A chance in per cent.

    Examples
    --------
    >>> chance(0.0234), chance(1e-9), chance(1.0)
    ('2.3 %', '< 0.01 %', '> 99.99 %')
    """
    if value < SURE:
        return "< 0.01 %"
    if value > 1.0 - SURE:
        return "> 99.99 %"
    return f"{100.0 * value:.2g} %"
