"""``springpot certify``: whether tests are as a code asks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from springpot.cli.common import DATA, INPUT, Output, emit, json_option, tell_written

if TYPE_CHECKING:
    from springpot.testreport.certificate import Certificate


@click.command("certify", epilog="Example: springpot certify tests/ --code damper.toml -o c.html")
@click.argument("tests", type=DATA, nargs=-1, required=True, metavar="TESTS...")
@click.option("--code", type=INPUT, required=True, metavar="FILE.toml", help="What is asked.")
@click.option(
    "-o",
    "--output",
    type=Output("springpot.testreport.certificate:check_certificate_path"),
    metavar="FILE",
    help="Write it here (.html, .xlsx or .csv).",
)
@click.option(
    "--why/--no-why",
    default=True,
    show_default=True,
    help="Diagnose the records of the tests that fail most.",
)
@json_option
def command(
    tests: tuple[str, ...], code: Path, output: Path | None, why: bool, as_json: bool
) -> int:
    """Whether tests are as a code asks: required tests, tolerances, property factors, decisions.

    TESTS are records or folders of them, named as the code's patterns say. Each result has an
    expanded uncertainty, from the cycles and from what the code states of the instruments, and is
    decided with it as a guard band. Where a test fails, its record is diagnosed: play, lag,
    friction and whatever else is hidden. Exit code 1: not conforming.
    """
    from springpot.testreport.certificate import certify
    from springpot.testreport.deciding import FAILING

    certificate = certify(tests, code, why=why)
    if output is not None:
        certificate.write(output)
    emit(certificate.to_dict(), as_json, lambda: _show(certificate, output))
    # A shell is told 1 where the answer is no.
    return int(certificate.verdict == FAILING)


def _show(certificate: Certificate, output: Path | None) -> None:
    import numpy as np

    from springpot.report.text import TextTable, with_interval
    from springpot.testreport.deciding import chance
    from springpot.writing import number

    print(f"{certificate.code.name}: {certificate.says}")
    print(f"{certificate.standing}\n")
    rows = []
    for row in certificate.rows:
        value, expanded = row.budget.value, row.budget.expanded
        told, _ = with_interval(value, value - expanded, value + expanded)
        ends = [f"{end:.5g}" if np.isfinite(end) else "" for end in (row.low, row.high)]
        rows.append([row.name, row.quantity, row.subject, told, number(expanded, 2), *ends,
                     row.unit, chance(row.risk), row.verdict])  # fmt: skip
    headers = ("requirement", "quantity", "of", "result", "U", "low", "high", "unit", "outside",
               "verdict")  # fmt: skip
    TextTable(headers, rows, frozenset(headers[3:7]), cuts=True).show()
    print()
    for factor in certificate.factors:
        ends = [number(budget.value) for budget in (factor.low, factor.high)]
        print(f"property factor {factor.name}: {ends[0]} to {ends[1]}")
    for line in certificate.missing:
        print(f"missing: {line}")
    for line in certificate.left_out:
        print(f"left out: {line}")
    for reason in certificate.reasons:
        for text in reason.says:
            print(f"why {reason.test}: {text}")
    tell_written(output, above="")
