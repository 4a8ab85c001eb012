"""What ``plot()`` of each result draws: whole figures, or one pair of axes of the caller's."""

from __future__ import annotations

from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.comparison.result import Comparison
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.errors import OutputError
from springpot.identification.material import is_material
from springpot.identification.prediction import Prediction
from springpot.identification.result import Identification
from springpot.invention.result import Invention
from springpot.measurement.measurement import Measurement
from springpot.superposition.curve import MasterCurve
from springpot.timetests.prediction import TestPrediction

from . import views
from .answers import worth_showing
from .canvas import COLOURS, blank, finished, logarithmic
from .figures import (
    VIEWS,
    beside_floors,
    draw_floors,
    draw_one_view,
    figure_identification,
    figure_material,
    figure_population,
    figure_view,
    marks_of,
    sweep_marks,
)
from .invention import draw_fits, figure_invention
from .ladder_text import beside_mark, broken, draw_ladder, entitled, error_axis, figure_ladder
from .mastercurve import figure_mastercurve
from .replay import SUFFIX, write_replay
from .residuals import figure_compared, fits_of
from .text import percent
from .timetests import figure_prediction, figure_tests, fits_in_time
from .views import ALONG_CLOCK, DrawnFit, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def figure_diagnosis(diagnosis: Diagnosis, path: str | Path | None = None) -> Figure | Path:
    """The diagnosis as a figure, which is written to `path` if there is one.

    Parameters
    ----------
    diagnosis : Diagnosis
        What to draw.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    with blank(6.4, 4.4) as figure:
        axes = figure.subplots()
        draw_diagnosis(axes, diagnosis)
        entitled(axes, f"{diagnosis.model.name} of {diagnosis.data}: {diagnosis.verdict}")
        return finished(figure, path)


def draw_diagnosis(axes: Axes, diagnosis: Diagnosis) -> None:
    """Error of the model as it is and with each leading effect alone, beside both floors."""
    shown = []
    # Where nothing is missing, remedies would be read as if something were.
    if diagnosis.verdict != "adequate":
        shown = worth_showing(diagnosis)
    own = diagnosis.error
    after = 100.0 * np.array([own.relative_rms, *(one.error_after for one in shown)])
    predicted = 100.0 * np.array([one.predicted_error for one in shown])
    places = np.arange(len(after))
    noise, material = 100.0 * own.noise_floor, 100.0 * own.material_floor
    # What any material reaches is known for the model as it is: with another effect it would be
    # another level.
    draw_floors(axes, np.full(len(after), noise), np.where(places == 0, material, np.nan))
    axes.plot(places, after, "o", color=COLOURS[0], label="error", zorder=4, markersize=6.0)
    if shown:
        axes.plot(
            places[1:],
            predicted,
            "D",
            color=COLOURS[1],
            markerfacecolor="white",
            label="predicted",
            zorder=3,
        )
    for x, error in enumerate(after):
        beside_mark(axes, (x, error), percent(error / 100.0, 2))
    axes.set_xticks(places, ["as it is", *(broken(f"+ {one.effect}") for one in shown)])
    axes.tick_params(axis="x", length=0)
    axes.grid(False, axis="x")
    error_axis(axes, np.array([noise, material, *after, *predicted]))


PLACES = "give ax= or a file to plot into, not both: save the figure of the axes"


def drawn(
    result: object, path: str | Path | None = None, axes: Axes | None = None
) -> Axes | Figure | Path:
    """Draw a result; see `springpot.lazy.draw`.

    Raises
    ------
    OutputError
        If there is no picture of such a thing, matplotlib is missing, or a path and axes are given.
    """
    # Axes are the caller's, with a figure around them that nobody else may save.
    if axes is None:
        return whole(result, path)
    if path is not None:
        raise OutputError(PLACES)
    onto(result, axes)
    return axes


def one_view(
    result: Identification,
    view: str,
    path: str | Path | None = None,
    axes: Axes | None = None,
) -> Axes | Figure | Path:
    """One view of a fit; see `springpot.lazy.draw_view`.

    Raises
    ------
    OutputError
        If there is no such view, or a path and axes are given.
    """
    if view not in VIEWS:
        raise OutputError(f"no view is called '{view:.40}': {', '.join(VIEWS)}")
    if axes is None:
        return figure_view(result, view, path)
    if path is not None:
        raise OutputError(PLACES)
    draw_one_view(axes, result, view)
    return axes


@singledispatch
def whole(result: object, path: str | Path | None) -> Figure | Path:
    """The figure of a result, written to `path` if there is one."""
    raise OutputError(f"there is no picture of a {type(result).__name__}")


@singledispatch
def onto(result: object, axes: Axes) -> None:
    """Draw a result on one pair of axes."""
    raise OutputError(f"there is no picture of a {type(result).__name__} on one pair of axes")


@whole.register
def _measured(result: Measurement, path: Any) -> Any:
    return figure_identification(result, [], path)


@onto.register
def _measured_onto(result: Measurement, axes: Any) -> None:
    _scene(axes, Scene(result))


@whole.register
def _fitted(result: Identification, path: Any) -> Any:
    if result.sweep is None:
        return figure_tests(result, result.data, path)
    # The spectrum is what such a fit is made for.
    if is_material(result.model):
        return figure_material(result, path)
    if result.populations:
        return figure_population(result, path)
    fitted = [DrawnFit(result.model, result.theta)]
    return figure_identification(result.measurement, fitted, path, beside=beside_floors(result))


@onto.register
def _fitted_onto(result: Identification, axes: Any) -> None:
    _scene(axes, Scene(result.measurement, [DrawnFit(result.model, result.theta)]))


@whole.register
def _predicted(result: Prediction, path: Any) -> Any:
    with blank() as figure:
        _predicted_onto(result, figure.subplots())
        return finished(figure, path)


@onto.register
def _predicted_onto(result: Prediction, axes: Any) -> None:
    # A line follows its points in their order, and one may ask for frequencies in any.
    order = result.frequency.argsort(kind="stable")
    x = result.units.on_clock(result.frequency[order])
    parts = (
        (result.storage, result.low.real, result.high.real),
        (result.loss, result.low.imag, result.high.imag),
    )
    # Of one or two points a line alone is not seen.
    marker = ""
    if len(result) < 3:
        marker = "o"
    names = result.units.parts
    for colour, label, (value, low, high) in zip(COLOURS, names, parts, strict=False):
        axes.plot(x, value[order], color=colour, label=label, marker=marker)
        axes.fill_between(x, low[order], high[order], color=colour, alpha=0.2, linewidth=0.0)
    # The limit at rest, frequency zero, has no place on a logarithmic axis.
    if x[0] > 0.0 and len(x) > 1:
        logarithmic(axes, "x")
    axes.set(
        xlabel=ALONG_CLOCK[result.units.clock],
        ylabel=f"{', '.join(names)} [{result.units.stiffness}]",
    )
    axes.legend(title=f"{result.model}, {100 * result.level:.0f} % bands")


whole.register(Diagnosis, figure_diagnosis)


@onto.register
def _diagnosed_onto(result: Diagnosis, axes: Any) -> None:
    draw_diagnosis(axes, result)


@whole.register
def _found(result: Ladder, path: Any) -> Any:
    if path is not None and Path(path).suffix.lower() == SUFFIX:
        return write_replay(result, path)
    # The last ones, if there are more than one picture shows.
    cases = [step.examined for step in reversed(result.steps) if step.examined is not None]
    fits = fits_in_time(case.base for case in cases)[::-1]
    if fits:
        return figure_tests(fits, fits[0].data, path)
    return figure_ladder(result, path)


@onto.register
def _found_onto(result: Ladder, axes: Any) -> None:
    draw_ladder(axes, result)


@whole.register
def _compared(result: Comparison, path: Any) -> Any:
    fits = fits_in_time(each.fitted for each in result.shown)
    if fits:
        return figure_tests(fits, fits[0].data, path)
    return figure_compared(result, path)


@onto.register
def _compared_onto(result: Comparison, axes: Any) -> None:
    _scene(axes, Scene(result.measurement, fits_of(result)))


whole.register(Invention, figure_invention)
onto.register(Invention, draw_fits)
whole.register(TestPrediction, figure_prediction)
whole.register(MasterCurve, figure_mastercurve)


def _scene(axes: Axes, scene: Scene) -> None:
    """Storage and loss with what the marks mean."""
    views.storage_and_loss(axes, scene)
    sweeps = []
    if scene.by_sweep:
        sweeps = sweep_marks(scene)
    axes.legend(handles=[*marks_of(scene), *sweeps])
