"""``springpot cycles``: what a test report tells of each cycle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from springpot.cli.common import (
    DATA,
    Output,
    emit,
    figure_option,
    json_option,
    of_each,
    tell_written,
)
from springpot.testreport.report import PAGE

if TYPE_CHECKING:
    from springpot.report.text import TextTable
    from springpot.testreport.report import CycleReport
    from springpot.testreport.summary import EvaluatedTest, VelocityLaw


@click.command(
    "cycles", epilog="Example: springpot cycles test-*.csv --cycles 3..10 -o report.xlsx"
)
@click.argument("records", type=DATA, nargs=-1, required=True, metavar="RECORD...")
@click.option(
    "--cycles",
    "wanted",
    metavar="A..B",
    help="Cycles that the means are of; by default all but the first and the last.",
)
@click.option(
    "-o",
    "--output",
    type=Output("springpot.testreport.report:check_sheets_path"),
    metavar="FILE",
    help="Write all rows here (.xlsx or .csv).",
)
@figure_option("the loops, their ellipse and backbone")
@json_option
def command(
    records: tuple[str, ...],
    wanted: str | None,
    output: Path | None,
    figure: Path | None,
    as_json: bool,
) -> int:
    """Stiffness, damping and energy of each cycle of a test, as a test report has them.

    Each RECORD holds displacement and force against time, read as 'springpot signals' reads it; one
    without a time gives what needs none. One that cannot be used is named on stderr. Each number
    has a 95 % interval: from the noise of the record, or from the scatter of the cycles where that
    is more. Tests at several speeds give the law F0 = C |v|^alpha.
    """
    from springpot.testreport.record import read_record
    from springpot.testreport.report import report_of
    from springpot.testreport.summary import evaluate, range_of

    meant = None if wanted is None else range_of(wanted)
    tests: list[EvaluatedTest] = []
    worst = of_each(records, lambda name: tests.append(evaluate(read_record(name), meant)))
    if not tests:
        return worst
    report = report_of(tests)
    if output is not None:
        report.write(output)
    if figure is not None:
        report.figure(figure)
    emit(report.to_dict(), as_json, lambda: _show(report, output, figure))
    return worst


def _show(report: CycleReport, output: Path | None, figure: Path | None) -> None:
    from springpot.report.text import with_interval

    for test in report.tests:
        table_of(test).show()
        print()
        value, interval = with_interval(test.energy.value, test.energy.low, test.energy.high)
        print(f"energy of the run  {value} {interval} {test.record.units['energy']}")
        for note in test.notes:
            print(f"note: {note}")
        print()
    if report.law is not None:
        print(f"velocity law  {law_text(report.law)}")
    tell_written(output, figure, above="")


def table_of(test: EvaluatedTest) -> TextTable:
    """Quantities down, the mean and the cycles across: as many numbers as can be read."""
    from springpot.report.text import TextTable, with_interval
    from springpot.testreport.quantities import BY_NAME
    from springpot.writing import counted

    numbers = [cycle.number for cycle in test.cycles]
    headers = [
        f"{test.name}: {counted(len(numbers), 'cycle')}",
        f"mean {test.first}..{test.last}",
        "95 % interval",
        "unit",
        "from",
        *(f"{number}" for number in numbers[: PAGE.cycles]),
    ]
    rows = []
    if test.record.timed:
        value, interval = with_interval(*test.frequency[:3])
        rows.append(["frequency", value, interval, "Hz", test.frequency.source])
        rows[0] += [""] * len(headers[5:])
    for name in test.names():
        mean = test.means[name]
        value, interval = with_interval(*mean[:3])
        each = [
            with_interval(*row[name][:3])[0] if name in row else "-"
            for row in test.each[: PAGE.cycles]
        ]
        rows.append([name, value, interval, test.unit(name), mean.source, *each])
    spare = [f"{number}" for number in reversed(numbers[1 : PAGE.cycles])]
    legend = {headers[0]: "; ".join(f"{name}: {BY_NAME[name].means}" for name in test.names())}
    return TextTable(headers, rows, frozenset(headers[1:2] + headers[5:]), spare, legend)


def law_text(law: VelocityLaw) -> str:
    """One line of the law of several speeds."""
    from springpot.report.text import with_interval

    told = law.to_dict()
    parts = []
    for name in ("C", "alpha"):
        value, interval = with_interval(*(told[name][key] for key in ("value", "low", "high")))
        unit = "" if told[name]["unit"] == "-" else f" {told[name]['unit']}"
        parts.append(f"{name} = {value} {interval}{unit}")
    origin = {"noise": "the noise of the tests", "tests": "the scatter of the tests"}[law.source]
    return f"F0 = C |v|^alpha with {' and '.join(parts)}, from {origin}"
