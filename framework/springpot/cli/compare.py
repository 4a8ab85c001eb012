"""``springpot compare``: models against the same data, noise floor and material floor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.writing import with_model

from . import timetests
from .common import (
    data_argument,
    emit,
    figure_option,
    geometry_option,
    json_option,
    opened,
    seed_option,
    tell_written,
    window,
    with_rows,
)
from .hints import Waiting, suggested

if TYPE_CHECKING:
    from springpot.comparison.result import Comparison
    from springpot.measurement.measurement import Measurement
    from springpot.measurement.opening import Test
    from springpot.rheology.model import Model

MODELS = "A model expression; give several, or none to rank all installed models."


@click.command(
    "compare",
    epilog=(
        "Example: springpot compare damper.csv -m fractional-maxwell -m fractional-zener --figure"
        " views.png"
    ),
)
@data_argument
@click.option("--model", "-m", "models", metavar="EXPR", multiple=True, help=MODELS)
@figure_option("all views and residual planes")
@seed_option
@geometry_option
@json_option
def command(
    data: str,
    models: tuple[str, ...],
    figure: Path | None,
    seed: int | None,
    geometry: str | None,
    as_json: bool,
) -> None:
    """Judge models of DATA against one noise floor.

    How far each is off, where, and how sure that is.

    Without --model all installed models are ranked, with the effects that no material can do
    without: the simplest that follows the data as well as any material does comes first. Tests in
    time serve as well as sweeps.
    """
    from springpot.registry import parse_model

    # A model that was named twice is judged once.
    expressions = [parse_model(model) for model in dict.fromkeys(models)]
    tests = timetests.named_tests([data], geometry)
    comparison = _compared(tests or opened(data, geometry), expressions, seed or 0)
    if figure is not None:
        comparison.plot(figure)
    emit(comparison, as_json, lambda: _show(comparison, data, models, figure))


def _show(comparison: Comparison, data: str, models: Sequence[str], figure: Path | None) -> None:
    """The answer, and the command that goes on from it."""
    from springpot.report.told import told

    print(told(comparison, window()))
    tell_written(figure)
    print(f"\nnext: {_next_command(comparison, data, models)}")


def _next_command(comparison: Comparison, data: str, models: Sequence[str]) -> str:
    """One test of several.

    Else what is missing from the best model, or its parameters where nothing is.
    """
    from springpot.comparison.result import Ranking

    # Before any model: what sets several tests apart is part of none.
    if comparison.one_test:
        given = [word for model in dict.fromkeys(models) for word in with_model(model)]
        return suggested("compare", with_rows(data, comparison.one_test), *given)
    best, not_enough = comparison.best, False
    if isinstance(comparison, Ranking):
        # What is missing from any material is not to be sought beside one model of it.
        if not comparison.adequate and comparison.near:
            return suggested("diagnose", data)
        not_enough = not comparison.adequate
    # Of a model that holds the parameters are worth having; of another what is missing from it.
    verb = "identify"
    if not_enough or best.fails or best.unclear:
        verb = "diagnose"
    return suggested(verb, data, *with_model(best.model.name))


def _compared(measurement: Measurement | Sequence[Test], models: list[Model], seed: int) -> Any:
    """The given models, or all that are installed."""
    from springpot.api import compare

    with Waiting() as waiting:
        compared: Any = compare(measurement, models or None, seed=seed, progress=waiting.told)
    return compared
