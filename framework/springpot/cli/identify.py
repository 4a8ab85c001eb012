"""``springpot identify``: the parameters of a model from measurements, with their uncertainty."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.thresholds import INTERVALS
from springpot.writing import with_model

from . import timetests
from .common import (
    DATA,
    POSITIVE,
    TABLE,
    accuracy_option,
    complete_data,
    emit,
    figure_option,
    geometry_option,
    json_option,
    known_from,
    known_options,
    model_option,
    names_of,
    of_each,
    opened,
    opened_together,
    print_json,
    seed_option,
    verbose_option,
    window,
)
from .hints import Waiting, suggested

if TYPE_CHECKING:
    from springpot.identification.result import Identification
    from springpot.measurement.opening import Test
    from springpot.rheology.model import Model

OBJECTIVE = "See 'springpot list objectives'; suited to the data by default."
OPTIMISER = (
    "With options as in pso-paper:particles=40; see 'springpot list optimisers'."
    " By default the native solver."
)


@click.command(
    "identify",
    epilog="Example: springpot identify damper.csv --model fractional-maxwell --figure fit.png",
)
@click.argument(
    "data", type=DATA, nargs=-1, required=True, metavar="DATA...", shell_complete=complete_data
)
@model_option
@known_options
@click.option(
    "--start", multiple=True, metavar="NAME=VALUE", help="Where the native solver begins too."
)
@click.option(
    "--times", metavar="LOW:HIGH", help="Relaxation times in s that are held: --model prony."
)
@click.option(
    "--per-decade", type=POSITIVE, default=1, show_default=True, metavar="N", help="Of such times."
)
@click.option("--joint", is_flag=True, help="One fit of all DATA together.")
@click.option(
    "--csv", "as_csv", is_flag=True, help="Print a table with one row for each DATA as CSV."
)
@click.option("--optimiser", metavar="NAME", help=OPTIMISER, shell_complete=names_of("optimiser"))
@click.option("--objective", metavar="NAME", help=OBJECTIVE, shell_complete=names_of("objective"))
@click.option(
    "--budget",
    type=POSITIVE,
    metavar="N",
    help="Evaluations of each restart; the native solver ends by itself.",
)
@click.option(
    "--restarts", type=POSITIVE, metavar="N", help="Independent restarts, of which the best counts."
)
@seed_option
@geometry_option
@accuracy_option
@click.option(
    "--robust",
    type=click.Choice(("huber", "soft-l1")),
    help="Let numbers that lie far off count less.",
)
@click.option("--intervals", type=click.Choice(INTERVALS), default="jacobian", show_default=True)
@figure_option("data, fit and residuals")
@click.option(
    "--view",
    metavar="NAME",
    help="Draw this alone, 84 mm wide: storage-loss, loss-factor, cole-cole, black,"
    " van-gurp-palmen, residual.",
)
@click.option(
    "--table",
    type=TABLE,
    metavar="FILE",
    help="Write the parameters as .csv, .xlsx, .tex, .html or .md.",
)
@verbose_option
@json_option
def command(
    data: tuple[str, ...],
    model: str,
    geometry: str | None,
    joint: bool,
    as_csv: bool,
    figure: Path | None,
    view: str | None,
    table: Path | None,
    verbose: bool,
    times: str | None,
    per_decade: int,
    as_json: bool,
    **options: Any,
) -> int:
    """Parameters of a model that fit DATA, files or registered data sets, best.

    Conditions choose part of the data: nist-srm2491@temperature=20 or damper.csv@frequency=1..10.
    Of several sweeps each gets a row of its own, or with --json a line of JSON; one that cannot be
    used is named on stderr. Tests in time (relaxation, creep, startup, recovery, any record of
    displacement and force) are identified together with each other and with sweeps of the same
    specimen, each weighed by its own noise: springpot identify sweep.csv relaxation.csv --model
    fractional-zener
    """
    from springpot.constraints import asks_for_all, values_of
    from springpot.report.page import write_parameters

    if view is not None and figure is None:
        raise click.UsageError("--view says what is drawn: give --figure FILE too")
    if as_csv and as_json:
        raise click.UsageError("give --csv or --json, not both")
    model, expression, held = _meant(model, times, per_decade)
    known = known_from(options)
    known["fix"] = held | known["fix"]
    arguments = {**options, **known, "start": values_of(options["start"])}
    tests = timetests.named_tests(data, geometry)
    if tests and view is not None and not any(test.kind == "sweep" for test in tests):
        advice = "--view says how a sweep is drawn, and these are tests in time: leave it out"
        raise click.UsageError(advice)
    together = tests is not None or joint or asks_for_all(known["own"], known["share"])
    if len(data) > 1 and not together:
        if figure is not None:
            raise click.UsageError("--figure draws one fit: name one DATA, or give --joint")
        return _each(data, expression, geometry, arguments, table, as_csv, as_json)
    fit = _fitted(tests or [opened_together(data, geometry)], expression, arguments)
    if figure is not None:
        fit.plot(figure, view=view)
    if table is not None:
        write_parameters(table, [fit])
    if as_csv:
        from springpot.report.fit_text import many_csv

        # One row, in the columns that several files would have.
        print(many_csv([fit]), end="")
    else:
        emit(fit, as_json, lambda: _show(fit, data, model, figure, verbose))
    return 0


def _meant(model: str, times: str | None, per_decade: int) -> tuple[str, Model, dict[str, float]]:
    """The model with its name; of a family the member of so many times, and these, held."""
    from springpot.constraints import at_times, times_of
    from springpot.registry import parse_model, plugins

    if times is None:
        return model, parse_model(model), {}
    values = times_of(times, per_decade)
    family, plus, effects = model.partition("+")
    family = family.strip()
    # What has the name alone is another model: kelvin is one spring and one dashpot.
    if family.endswith("-N") or family not in plugins().names("model"):
        family = f"{family.removesuffix('-N')}-{len(values)}"
    expression = parse_model(f"{family} {plus}{effects}")
    return expression.name, expression, at_times(expression, values)


def _fitted(tests: Sequence[Test], model: Model, arguments: dict[str, Any]) -> Identification:
    """The fit, with the floors that its text tells; those who wait are told what is being done."""
    from springpot.api import identify
    from springpot.measurement.opening import together

    name = together(test.name for test in tests)
    # An optimiser runs in a copy of this process, which is safe only where no thread runs beside.
    with ExitStack() as stack:
        if arguments.get("optimiser") is None:
            stack.enter_context(Waiting()).told(f"fitting {model.name} to {name}")
        elif sys.stderr.isatty():
            print(f"fitting {model.name} to {name} by {arguments['optimiser']}", file=sys.stderr)
        fit = identify(tests, model, **arguments)
    with Waiting() as waiting:
        waiting.told(f"judging {model.name} of {name}")
        # Asked for here, while somebody says what is waited for: the text asks again at no cost.
        _ = fit.standing
    return fit


def _each(
    data: tuple[str, ...],
    model: Model,
    geometry: str | None,
    arguments: dict[str, Any],
    table: Path | None,
    as_csv: bool,
    as_json: bool,
) -> int:
    """A row for each file that can be used.

    What is there is printed even where the rest is interrupted.
    """
    from springpot.report.fit_text import many_csv, many_text
    from springpot.report.page import write_parameters

    fits: list[Identification] = []

    def answer(name: str) -> None:
        fits.append(_fitted([opened(name, geometry)], model, arguments))
        # With --json each is printed when it is there; a table needs all of them for its widths.
        if as_json:
            print_json(fits[-1], line=True)

    worst = of_each(data, answer)
    if fits and table is not None:
        write_parameters(table, fits)
    if fits and as_csv:
        print(many_csv(fits), end="")
    elif fits and not as_json:
        print(many_text(fits))
    return worst


def _show(
    identified: Identification,
    data: tuple[str, ...],
    model: str,
    figure: Path | None,
    verbose: bool,
) -> None:
    from springpot.report.told import told

    print(told(identified, window(), verbose=verbose))
    if figure is not None:
        print(f"figure      {figure}")
    # Several sweeps are diagnosed one by one.
    asked = len(data) == 1 or identified.sweep is None
    if asked and identified.standing is not None and not identified.standing.good_enough:
        print(f"\nnext: {suggested('diagnose', *data, *with_model(model))}")
