"""``springpot mastercurve``: sweeps brought onto one curve by free factors, and what these say."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import timetests
from .common import (
    DATA,
    FILE,
    complete_data,
    emit,
    figure_option,
    geometry_option,
    json_option,
    opened,
    tell_written,
    window,
)

if TYPE_CHECKING:
    from springpot.measurement.opening import Test
    from springpot.superposition.curve import MasterCurve


@click.command(
    "mastercurve",
    epilog="Example: springpot mastercurve nist-srm2491 --reference 25degC --figure curve.png",
)
@click.argument(
    "data", type=DATA, nargs=-1, required=True, metavar="DATA...", shell_complete=complete_data
)
@click.option(
    "--reference",
    metavar="LEVEL",
    help="Where the factors are one, such as 25degC; the middle by default.",
)
@click.option(
    "--column",
    metavar="NAME",
    default="temperature",
    show_default=True,
    help="The condition that is shifted.",
)
@click.option(
    "--vertical/--no-vertical",
    default=True,
    show_default=True,
    help="A factor of the stiffness as well.",
)
@click.option(
    "--objective",
    metavar="NAME",
    help="See 'springpot list objectives'; suited to the data by default.",
)
@click.option(
    "-o",
    "--output",
    type=FILE,
    metavar="CSV",
    help="Write the reduced data here, as a measurement.",
)
@figure_option("curve, factors and errors")
@geometry_option
@json_option
def command(
    data: tuple[str, ...],
    reference: str | None,
    column: str,
    vertical: bool,
    objective: str | None,
    output: Path | None,
    figure: Path | None,
    geometry: str | None,
    as_json: bool,
) -> None:
    """Bring the sweeps of DATA onto one curve with free factors for each temperature.

    Relaxations at several temperatures, in one file or in many, become one curve as sweeps do, and
    so does creep. The levels of another column may stand in the place of temperatures.

    No model and no law is assumed: the curve is that of any linear passive material. Laws of
    temperature are then judged by the free factors, and a test says whether one curve is enough and
    where it is not.
    """
    from springpot.api import mastercurve
    from springpot.files import write_text
    from springpot.registry import write_measurement
    from springpot.report.told import told

    tests: Sequence[Test] | None = timetests.named_tests(data, geometry)
    curve = mastercurve(
        tests or [opened(name, geometry) for name in data],
        column=column,
        reference=reference,
        vertical=vertical,
        objective=objective,
    )
    if output is not None:
        if tests is None:
            write_measurement(curve.reduced, output)
        else:
            write_text(output, _table_text(curve))
    if figure is not None:
        curve.plot(figure)
    emit(curve, as_json, lambda: print(told(curve, window())))
    if not as_json:
        tell_written(output, figure, above="")


def _table_text(curve: MasterCurve) -> str:
    """A CSV table of the curve after a step, which opens again as a test of its kind."""
    data = curve.reduced
    told = dict(zip(curve.columns, curve.drawn(data.omega, data.stiffness), strict=True))
    units = ("s", curve.measured_unit)
    names = [f"{name} [{unit}]" for name, unit in zip(told, units, strict=True)]
    # The temperature that was measured is no column of the test that the curve is.
    others = {name: data.conditions[name] for name in ("a", "a_low", "a_high", "determined")}
    order = data.omega.argsort()[::-1]
    columns = [column[order].tolist() for column in (*told.values(), *others.values())]
    rows = [",".join(map(repr, row)) for row in zip(*columns, strict=True)]
    return "\n".join([",".join([*names, *others]), *rows]) + "\n"
