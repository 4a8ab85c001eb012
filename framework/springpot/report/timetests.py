"""Pictures of tests in time.

Measured and computed, over logarithmic and linear time or as a loop, with what is left.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.identification.result import Identification
from springpot.measurement.recording import recorded
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units
from springpot.misfit.residuals_of_tests import (
    InTimePart,
    OtherPart,
    SweepPart,
    Test,
    TestPart,
    parts_of_specimen,
)
from springpot.numerics import ENOUGH, evenly
from springpot.rheology.points import Real
from springpot.timetests.prediction import TestPrediction
from springpot.writing import FEW

from . import views
from .canvas import CANVAS, COLOURS, QUIET, blank, finished, logarithmic
from .figures import marks_of, scene_of
from .views import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CLOCKS = {"Hz": "f [Hz]", "rad/s": "ω [rad/s]"}
"""Titles of an axis of frequencies."""


def figure_tests(
    identified: Identification | Sequence[Identification],
    tests: Sequence[Test],
    path: str | Path | None = None,
) -> Figure | Path:
    """Each test with its fits.

    Over logarithmic time (of a record its loop), over linear time, and the residual over its noise.

    Parameters
    ----------
    identified : Identification, or a sequence of them
        The fits, of one model or of several.
    tests : sequence of TimeTest or Measurement
        What they were fitted to.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    if isinstance(identified, Identification):
        fits = [identified]
    else:
        fits = list(identified)
    # Sweeps and tests in time of one specimen, each drawn in its own way.
    parts = parts_of_specimen(tests)
    with blank(10.5, 2.7 * len(parts) + 0.3) as figure:
        grid = figure.subplots(len(parts), 3, squeeze=False)
        for row, part in zip(grid, parts, strict=True):
            if isinstance(part, SweepPart):
                _draw_sweep(row, scene_of(part, fits))
            elif isinstance(part, InTimePart):
                _draw_test(row, part, fits)
            elif isinstance(part, OtherPart):
                _draw_other(row, part, fits)
        return finished(figure, path)


def fits_in_time(behind: Iterable[object]) -> list[Identification]:
    """The first few fits of tests in time behind answers; none of an answer about sweeps."""
    return [fit for fit in behind if isinstance(fit, Identification)][:FEW]


def _draw_test(row: Sequence[Axes], part: InTimePart, fits: Sequence[Identification]) -> None:
    test = part.test
    shown = evenly(len(test), ENOUGH)
    first, clock = _draw_first(row[0], part, fits, shown), _even_times(test)
    row[1].plot(test.time[shown], test.response[shown], ".", color=QUIET, ms=2.5)
    for colour, fit in zip(COLOURS, fits, strict=False):
        drawn = recorded(fit.model, fit.theta, test, fit.reference, clock).value
        row[1].plot(clock, drawn, color=colour)
    row[0].set_xlabel(first)
    row[1].set_xlabel("t [s]")
    row[0].set_ylabel(f"{test.words[1]} [{test.response_unit}]")
    row[0].set_title(f"{test.name}: {test.kind}")
    row[0].legend()
    _draw_residual(row[2], part, fits, shown, "t [s]")


def _draw_first(
    axes: Axes, part: InTimePart, fits: Sequence[Identification], shown: NDArray[np.intp]
) -> str:
    """The loop of a record, any other test over the logarithm of time; what the axis is."""
    test = part.test
    loading, clock = test.loading, _even_times(test)
    loop = test.kind == "history"
    if not loop:
        # Computed at times of its own: between samples a curve is smooth where its points are few.
        # The beginning has no place on a logarithmic axis.
        positive = test.time[test.time > 0.0]
        clock = np.geomspace(positive[0], positive[-1], CANVAS.smooth)

    def along(time: Real) -> Real:
        return np.interp(time, loading.time, loading.value) if loop else time

    axes.plot(
        along(test.time[shown]), test.response[shown], ".", color=QUIET, ms=2.5, label="measured"
    )
    for colour, fit in zip(COLOURS, fits, strict=False):
        drawn = recorded(fit.model, fit.theta, test, fit.reference, clock).value
        axes.plot(along(clock), drawn, color=colour, label=fit.model.name)
    if loop:
        return f"{test.words[0]} [{test.loading_unit}]"
    logarithmic(axes, "x")
    if test.response.min() > 0.0 and test.response.max() > CANVAS.tenfold * test.response.min():
        logarithmic(axes, "y")
    return "t [s]"


def _draw_other(row: Sequence[Axes], part: OtherPart, fits: Sequence[Identification]) -> None:
    """The numbers of a test of a further kind as they were measured, over either axis."""
    test, every = part.test, np.arange(len(part.at))
    for axes in row[:2]:
        axes.plot(test.at, test.measured, ".", color=QUIET, ms=4, label="measured")
        for colour, fit in zip(COLOURS, fits, strict=False):
            told = part.answer(fit.model, fit.theta, fit.reference, every).value
            axes.plot(test.at, told, "+", color=colour, ms=4, label=fit.model.name)
        axes.set_xlabel(test.clock)
    logarithmic(row[0], "x")
    row[0].set_ylabel(f"{test.quantity} [{test.unit}]")
    row[0].set_title(f"{test.name}: {test.kind}")
    row[0].legend()
    _draw_residual(row[2], part, fits, every, test.clock)


def _draw_residual(
    axes: Axes,
    part: TestPart,
    fits: Sequence[Identification],
    shown: NDArray[np.intp],
    clock: str,
) -> None:
    # Two standard deviations of the noise.
    axes.axhspan(-2.0, 2.0, color="#EEEEEE")
    for colour, fit in zip(_colours_of_residuals(fits), fits, strict=False):
        # Measured less computed, as residuals of sweeps are drawn.
        residual = -part.over_noise(fit.model, fit.theta, fit.reference).value
        axes.plot(part.at[shown], residual[shown], ".", color=colour, ms=2.5)
    axes.set(xlabel=clock, ylabel="residual / noise")
    if part.at.min() > 0.0:
        logarithmic(axes, "x")


def _colours_of_residuals(fits: Sequence[Identification]) -> Sequence[str]:
    """Those of the models where there are several, else one that is no curve's."""
    if len(fits) > 1:
        return COLOURS
    return COLOURS[1:]


def _even_times(test: TimeTest) -> Real:
    """Times of a smooth curve over time."""
    # A record may swing faster than evenly spaced times would show: computed where it was measured.
    if test.kind == "history":
        return test.time
    return np.linspace(test.time[0], test.time[-1], CANVAS.smooth)


def _draw_sweep(row: Sequence[Axes], scene: Scene) -> None:
    """A sweep as one that stands alone is drawn."""
    for axes, draw in zip(
        row, (views.storage_and_loss, views.loss_factor, views.residual), strict=True
    ):
        draw(axes, scene)
    row[0].set_title(f"{scene.measurement.name}: sweep")
    row[0].legend(handles=marks_of(scene), fontsize="x-small")


def figure_prediction(predicted: TestPrediction, path: str | Path | None = None) -> Figure | Path:
    """A predicted test with its band: over log and linear time, or K' and K'' over frequency.

    A record swings in linear time alone.

    Parameters
    ----------
    predicted : TestPrediction
        The prediction.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    places = 1 if predicted.kind == "history" else 2
    with blank(9.0, 3.6) as figure:
        row = figure.subplots(1, places, squeeze=False)[0]
        if predicted.kind == "sweep":
            # A predicted sweep holds all of storage, then all of loss.
            half = len(predicted.at) // 2
            for axes, name, rows in zip(
                row, ("storage", "loss"), (slice(half), slice(half, None)), strict=True
            ):
                _draw_predicted(axes, predicted, rows)
                axes.set(xlabel=CLOCKS[predicted.clock], ylabel=f"{name} [{predicted.unit}]")
                logarithmic(axes, "x")
        else:
            for axes in row:
                _draw_predicted(axes, predicted, slice(None))
                axes.set(xlabel="t [s]", ylabel=f"{predicted.quantity} [{predicted.unit}]")
            if places > 1:
                logarithmic(row[0], "x")
        row[0].set_title(f"{predicted.test}: {predicted.verdict}", loc="left")
        # Beside the title: no corner of a picture is free of a curve that swings.
        row[-1].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)
        return finished(figure, path)


def _draw_predicted(axes: Axes, predicted: TestPrediction, rows: slice) -> None:
    order = np.argsort(predicted.at[rows])
    told = predicted.at
    if predicted.kind == "sweep":
        told = Units(clock=predicted.clock).on_clock(told)
    at = told[rows][order]
    if predicted.judged:
        axes.plot(told[rows], predicted.measured[rows], ".", color=QUIET, ms=2.5, label="measured")
    axes.fill_between(
        at,
        predicted.low[rows][order],
        predicted.high[rows][order],
        color=COLOURS[0],
        alpha=0.2,
        lw=0,
    )
    axes.plot(
        at, predicted.value[rows][order], color=COLOURS[0], label=f"{predicted.model}, predicted"
    )
