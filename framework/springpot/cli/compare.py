"""``springpot compare``: models against the same data and noise floor."""

from __future__ import annotations

from pathlib import Path

import click

from .common import FILE, data_argument, emit, geometry_option, json_option, opened


@click.command(
    "compare",
    epilog="Example: springpot compare damper.csv -m fractional-maxwell -m fractional-zener --figure views.png",
)
@data_argument
@click.option(
    "--model", "-m", "models", metavar="EXPR", required=True, multiple=True, help="A model expression; give several."
)
@click.option("--figure", type=FILE, metavar="FILE", help="Draw all views and residual planes (.png, .svg or .pdf).")
@geometry_option
@json_option
def command(data: str, models: tuple[str, ...], figure: Path | None, geometry: str | None, as_json: bool) -> None:
    """Judge models of DATA against one noise floor: how far each is off, where, and how sure that is."""
    from springpot.api import compare
    from springpot.registry import parse_model
    from springpot.report.answers import comparison_text
    from springpot.report.canvas import check_figure_path

    if figure is not None:
        check_figure_path(figure)
    comparison = compare(opened(data, geometry), [parse_model(model) for model in dict.fromkeys(models)])
    if figure is not None:
        from springpot.report.residuals import figure_compared

        figure_compared(comparison, figure)
    emit(comparison, as_json, lambda: print(comparison_text(comparison)))
    if figure is not None and not as_json:
        print(f"\nwritten: {figure}")
