"""``springpot identify``: the parameters of a model from measurements, with their uncertainty."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.errors import DataError

from . import timetests
from .common import (
    FILE,
    POSITIVE,
    emit,
    geometry_option,
    json_option,
    model_option,
    opened,
    seed_option,
)

if TYPE_CHECKING:
    from springpot.identification import Identification

INTERVALS = ("jacobian", "profile", "bootstrap")


@click.command(
    "identify", epilog="Example: springpot identify damper.csv --model fractional-maxwell --figure fit.png"
)
@click.argument("data", metavar="DATA...", nargs=-1, required=True)
@model_option
@click.option("--optimiser", metavar="NAME", help="See 'springpot list optimisers'; the native solver by default.")
@click.option("--objective", metavar="NAME", help="See 'springpot list objectives'; suited to the data by default.")
@click.option(
    "--budget", type=POSITIVE, metavar="N", help="Evaluations of each restart; the native solver ends by itself."
)
@click.option("--restarts", type=POSITIVE, metavar="N", help="Independent restarts, of which the best counts.")
@seed_option
@geometry_option
@click.option("--intervals", type=click.Choice(INTERVALS), default="jacobian", show_default=True)
@click.option("--figure", type=FILE, metavar="FILE", help="Draw data, fit and residuals (.png, .svg or .pdf).")
@json_option
def command(
    data: tuple[str, ...], model: str, geometry: str | None, figure: Path | None, as_json: bool, **options: Any
) -> None:
    """Parameters of a model that fit DATA, a file or a registered data set, best.

    Conditions choose part of the data: nist-srm2491@temperature=20. Tests in time (relaxation, creep, startup,
    recovery, any record of displacement and force) are identified together with each other and with sweeps of the
    same specimen, each weighed by its own noise: springpot identify sweep.csv relaxation.csv --model fractional-zener
    """
    from springpot.api import identify
    from springpot.registry import parse_model
    from springpot.report.canvas import check_figure_path

    if figure is not None:
        check_figure_path(figure)
    expression = parse_model(model)
    tests = timetests.named_tests(data, geometry)
    if tests is not None:
        timetests.identify(tests, model, figure, as_json, options)
        return
    if len(data) > 1:
        raise DataError(
            f"{data[1]}: a second sweep; name one, or sweeps together with tests in time of the same specimen"
        )
    found = identify(opened(data[0], geometry), expression, **options)
    if figure is not None:
        draw(found, figure)
    emit(found, as_json, lambda: show(found, figure))


def draw(found: Identification, path: Path) -> None:
    """Write the figure of data, fit and residuals, and of the spectrum where the data choose one."""
    from springpot.identification import is_material
    from springpot.report.curves import Fit
    from springpot.report.figures import figure_identification
    from springpot.report.spectrum import figure_material

    if is_material(found.model):
        figure_material(found, path)
        return
    figure_identification(found.measurement, [Fit(found.model, found.theta)], path)


def show(found: Identification, figure: Path | None) -> None:
    """Print the result for people."""
    from springpot.report.numbers import number, percent, seconds
    from springpot.report.reference import reference_note
    from springpot.report.spectrum import in_words
    from springpot.report.text import indented
    from springpot.rheology.drawing import drawing_of

    result = found.to_dict()
    data = found.measurement
    low, high = number(float(data.frequency.min()), 3), number(float(data.frequency.max()), 3)
    print(f"{result['model']} fitted to {data.name} ({len(data)} points, {low} to {high} Hz)\n")
    print(indented(drawing_of(found.model)) + "\n")
    _show_parameters("parameter", result["parameters"])
    if result["search_parameters"]:
        print()
        _show_parameters("search form", result["search_parameters"])
    if refers := reference_note(data, [found.model.network]):
        print(f"\n{refers}")
    objective = result["objective"]
    if found.spectrum is not None:
        print(f"\nspectrum    {in_words(found.spectrum, data.units.stiffness)}")
    print(f"\nerror       {percent(result['relative_rms'])} of |K| (relative rms){_beside_floors(found)}")
    print(f"objective   {objective['name']}, {number(objective['value'])}")
    spent = f"{result['evaluations']} evaluations in {seconds(result['seconds'])}"
    print(f"optimiser   {result['optimiser']}, {result['status']}, {spent}")
    for note in result["notes"]:
        print(f"note        {note}")
    if figure is not None:
        print(f"figure      {figure}")


def _beside_floors(found: Identification) -> str:
    """The error beside what noise alone leaves and what any material leaves, where the data are enough to tell."""
    from springpot.report.numbers import number, percent

    standing = found.standing
    if standing is None or not standing.noise_floor > 0.0:
        return ""
    ratio = number(found.relative_rms / standing.noise_floor, 2)
    noise = f"{ratio} x the noise floor of {percent(standing.noise_floor, 2)} ({standing.noise_source})"
    return f", {noise}; material floor {percent(standing.material_floor, 2)}"


def _show_parameters(heading: str, parameters: dict[str, dict[str, Any]]) -> None:
    from springpot.report.numbers import with_interval
    from springpot.report.text import Table

    rows = [
        [name, *with_interval(entry["value"], entry.get("low"), entry.get("high")), entry["unit"]]
        for name, entry in parameters.items()
    ]
    Table((heading, "value", "95 % interval", "unit"), rows, frozenset({"value"})).show()
