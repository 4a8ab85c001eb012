"""``springpot quantities``: what follows from a fit or from data, with intervals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from springpot.cli.common import (
    COMPLETED,
    DATA,
    MODEL,
    TABLE,
    at_place,
    complete_data,
    emit,
    json_option,
    names_of,
    tell_written,
    window,
)


@click.command(
    "quantities",
    epilog="Example: springpot quantities sweep.csv --model fractional-zener --frequency 5",
)
@click.argument("data", type=DATA, metavar="FIT.json|DATA", shell_complete=complete_data)
@click.option("--model", "-m", metavar="EXPR", help=f"{MODEL} Without it the data.", **COMPLETED)
@click.option(
    "--frequency",
    "-f",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="HZ",
    help="Of |K|, loss factor and energy of a cycle.",
)
@click.option("--temperature", "-t", type=float, metavar="DEGC", help="Where the model needs it.")
@at_place
@click.option(
    "--without",
    multiple=True,
    metavar="EFFECT",
    help="Leave an effect of the material out; those of the rig are.",
    shell_complete=names_of("effect"),
)
@click.option("--csv", "as_csv", is_flag=True, help="Print a table as CSV.")
@click.option(
    "-o", "--output", type=TABLE, metavar="FILE", help="Write a .csv, .xlsx, .tex, .html or .md."
)
@json_option
def command(
    data: str,
    model: str | None,
    others: tuple[str, ...],
    as_csv: bool,
    output: Path | None,
    as_json: bool,
    **asked: Any,
) -> None:
    """Quantities of a fit or of data, each with its 95 % interval and who says it.

    FIT.json is what 'springpot identify DATA --model EXPR --json' prints. A model says crossover,
    plateau, moduli at rest and of fast changes, zero-shear viscosity, mean relaxation time, |K|,
    loss factor and energy of a cycle; sweeps of the amplitude say linear limit, yield and flow
    point. Without a model the points around a place say what lies within the data.
    """
    from springpot.constraints import settings_of
    from springpot.derived import quantities
    from springpot.files import write_text
    from springpot.report.page import write_values
    from springpot.report.told import told

    if as_csv and as_json:
        raise click.UsageError("give --csv or --json, not both")
    asked.update(settings_of(others))
    answer = quantities(data, model, **asked)
    if output is not None:
        if output.suffix == ".csv":
            write_text(output, answer.to_csv())
        else:
            rows = [((row.name, row.place(answer.units), row.source), row.value) for row in answer]
            write_values(output, answer.title, ("quantity", "at", "from"), rows)
    if as_csv:
        print(answer.to_csv(), end="")
        return
    emit(answer, as_json, lambda: print(told(answer, window())))
    if not as_json:
        tell_written(output)
