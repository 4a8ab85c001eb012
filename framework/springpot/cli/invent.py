"""``springpot invent``: a law that is in no library."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.writing import accepting, in_shell, with_model

from .common import (
    FILE,
    data_argument,
    emit,
    figure_option,
    geometry_option,
    json_option,
    judged_option,
    known_from,
    known_options,
    opened,
    seed_option,
    tell_written,
    window,
)
from .hints import Waiting, kept_by

if TYPE_CHECKING:
    from springpot.invention.result import Invention


@click.command("invent", epilog="Example: springpot invent damper.csv -o law.json")
@data_argument
@judged_option
@click.option(
    "--along",
    multiple=True,
    metavar="COLUMN",
    help="Column that a law may go with; by default all that were varied by themselves.",
)
@click.option("-o", "--output", type=FILE, metavar="JSON", help="Write the answer here too.")
@figure_option("it")
@known_options
@seed_option
@geometry_option
@json_option
def command(
    data: str,
    model: str | None,
    along: tuple[str, ...],
    output: Path | None,
    figure: Path | None,
    seed: int | None,
    geometry: str | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Find the law that is missing from a model of DATA, as a formula, where no library has it.

    Formulas of frequency, amplitude, temperature and the other columns are held against the data
    beside the model, or without --model beside any linear passive material. The answer is first of
    all a class: the laws that these data cannot tell apart. It is never accepted by itself:
    'springpot discover DATA --accept law.json' does that, and 'springpot init plugin --from
    law.json' makes a plugin of it.
    """
    from springpot.api import invent
    from springpot.diagnosis.result import within
    from springpot.files import write_text
    from springpot.registry import parse_model
    from springpot.report.text import to_json
    from springpot.report.told import told

    expression = None if model is None else parse_model(model)
    arguments = {"along": along or None, "seed": seed or 0, **known_from(options)}
    measurement = opened(data, geometry)
    with Waiting() as waiting:
        progress = within(measurement.name, waiting.told)
        found: Any = invent(measurement, expression, progress=progress, **arguments)
    if output is not None:
        write_text(output, to_json(found.to_dict()) + "\n")
    if figure is not None:
        found.plot(figure)

    def show() -> None:
        print(told(found, window()))
        tell_written(output, figure)
        if following := _next(found, data, model):
            print(f"\nnext: springpot {following}")

    emit(found, as_json, show)


def _next(found: Invention, data: str, model: str | None) -> str:
    """The command that takes the law up; empty where none was found."""
    if found.best is None:
        return ""
    judged = [*with_model(model), *accepting([found.best.text]), *kept_by("discover")]
    return " ".join(map(in_shell, ["discover", data, *judged]))
