"""``springpot signals``: step one of the paper, from time signals to dynamic stiffness."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.writing import suggested

from .common import DATA, FILE, POSITIVE, emit, json_option, of_each

if TYPE_CHECKING:
    from springpot.measurement.from_signals import OneTest
    from springpot.measurement.measurement import Measurement


@click.command("signals", epilog="Example: springpot signals test-*.csv -o damper.csv")
@click.argument("files", type=DATA, nargs=-1, required=True, metavar="FILE...")
@click.option("-o", "--output", type=FILE, metavar="CSV", help="Write the measurement here.")
@click.option(
    "--frequency",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="HZ",
    help="Excitation frequency; estimated by default.",
)
@click.option(
    "--harmonics",
    type=POSITIVE,
    default=5,
    show_default=True,
    metavar="N",
    help="Harmonics to fit.",
)
@click.option(
    "--window",
    type=(float, float),
    metavar="START STOP",
    help="Seconds to use; by default the steady part is found.",
)
@json_option
def command(
    files: tuple[str, ...],
    output: Path | None,
    frequency: float | None,
    harmonics: int,
    window: tuple[float, float] | None,
    as_json: bool,
) -> int:
    """Storage and loss stiffness with standard deviations from displacement and force against time.

    Each FILE holds one test at one frequency and gives one row. One that cannot be used is named on
    stderr.
    """
    from springpot.measurement.from_signals import measurement_of_tests
    from springpot.registry import evaluated_signals, write_measurement

    omega = None
    if frequency is not None:
        omega = 2.0 * pi * frequency
    tests: list[OneTest] = []

    def evaluate(name: str) -> None:
        tests.append(evaluated_signals(name, omega=omega, n_harmonics=harmonics, window=window))

    worst = of_each(files, evaluate)
    if not tests:
        return worst
    # As the table is called: of several files none gives it its name.
    measured = measurement_of_tests(tests, output.stem if output is not None else None)
    if output is not None:
        write_measurement(measured, output)
    result = described(measured, files, output)
    emit(result, as_json, lambda: _show(result))
    return worst


def described(measured: Measurement, files: tuple[str, ...], output: Path | None) -> dict[str, Any]:
    """The measurement row by row, schema ``springpot.signals/1``."""
    nothing = [None] * len(measured)
    columns = {
        "file": [str(name) for name in measured.labels["file"]],
        "frequency": measured.frequency.tolist(),
        "storage": measured.storage.tolist(),
        "loss": measured.loss.tolist(),
        "storage_sd": nothing,
        "loss_sd": nothing,
        "amplitude": nothing,
    }
    if measured.sd is not None:
        columns |= {"storage_sd": measured.sd.real.tolist(), "loss_sd": measured.sd.imag.tolist()}
    if "amplitude" in measured.conditions:
        columns["amplitude"] = measured.conditions["amplitude"].tolist()
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    units = {
        "frequency": "Hz",
        "stiffness": measured.units.stiffness,
        "amplitude": measured.units.amplitude,
    }
    path = None
    if output is not None:
        path = str(output)
    return {
        "schema": "springpot.signals/1",
        "files": list(files),
        "output": path,
        "units": units,
        "rows": rows,
        "provenance": dict(measured.provenance),
    }


def _show(result: dict[str, Any]) -> None:
    from springpot.report.text import TextTable
    from springpot.writing import number

    units = result["units"]
    headers = (
        "frequency [Hz]",
        f"amplitude [{units['amplitude']}]",
        f"storage [{units['stiffness']}]",
        "storage_sd",
        f"loss [{units['stiffness']}]",
        "loss_sd",
    )
    keys = ("frequency", "amplitude", "storage", "storage_sd", "loss", "loss_sd")
    # Of a deviation two digits mean something.
    digits = {"storage_sd": 2, "loss_sd": 2}
    rows = []
    for row in result["rows"]:
        numbers = [number(row[key], digits.get(key, 5)) for key in keys]
        rows.append([*numbers, row["file"]])
    TextTable((*headers, "file"), rows, frozenset(headers)).show()
    for key, value in result["provenance"].items():
        if "note" in key:
            print(f"{key}: {value}")
    if result["output"]:
        print(f"written: {result['output']}\n\nnext: {suggested('compare', result['output'])}")
