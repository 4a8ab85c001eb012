"""What fits leave: of sweeps in the planes in which effects add up, of tests in time over time.

A missing effect is simplest in its own plane: a moving mass grows as omega squared in the
stiffness, a compliant mounting is constant in the compliance, a delay grows as omega in the phase,
a temperature shift is constant in the shift. Tests in time are drawn over logarithmic and linear
time or as a loop, measured and computed, with what is left. On a page each figure is a small
picture by itself, so that a narrow screen stacks them.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.identification.result import Identification
from springpot.measurement.measurement import Measurement
from springpot.measurement.recording import recorded
from springpot.measurement.replicates import thinned
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units
from springpot.misfit.error import Error
from springpot.misfit.residuals_of_tests import (
    InTimePart,
    OtherPart,
    SweepPart,
    Test,
    TestPart,
    parts_of_specimen,
)
from springpot.numerics import ENOUGH, evenly
from springpot.rheology.nodes import FULL, PLANES, Composition, Parallel, Response
from springpot.rheology.points import Complex, Real
from springpot.timetests.prediction import TestPrediction
from springpot.writing import FEW, Html, joined, tag

from . import views
from .canvas import CANVAS, COLOURS, QUIET, blank, finished, logarithmic
from .figures import DASHES, headed, literal, marks_of, scene_of
from .text import LETTERS, cut, percent
from .views import DrawnFit, Scene, draw_bands, sweep_colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from springpot.comparison.result import Comparison


def residual_in(
    plane: type[Composition], measurement: Measurement, fit: DrawnFit
) -> tuple[Complex, Real]:
    """Residual in a plane, and twice the standard deviation of the noise there.

    Parameters
    ----------
    plane : type of Composition
        One of `PLANES`.
    measurement : Measurement
        The data; without standard deviations the band is zero.
    fit : DrawnFit
        The model.

    Returns
    -------
    tuple of ndarray
        Complex residual (n,) and the half-width (n,) of its band.
    """
    modelled = fit.model.network.respond(fit.theta, measurement.points, FULL)
    sd = np.zeros_like(measurement.stiffness)
    if measurement.sd is not None:
        sd = measurement.sd
    # One band for both parts: two would be too many to tell apart.
    width = 2.0 * np.maximum(sd.real, sd.imag)
    return plane_of(plane, measurement.stiffness, modelled, width)


def plane_of(
    plane: type[Composition], measured: Complex, modelled: Response, width: Real
) -> tuple[Complex, Real]:
    """Residual (n,) in a plane, and the half-width (n,) there of one that is `width` wide in K."""
    # It is the measured K that scatters.
    slope = plane.slope(modelled._replace(value=measured))
    return plane.residual(measured, modelled), width / np.abs(slope)


def draw_plane(axes: Axes, scene: Scene, plane: type[Composition]) -> None:
    """Residuals of the scene's fits in one plane.

    Real part filled, imaginary part open, noise as bands.
    """
    data = scene.measurement
    largest, bands = 0.0, []
    # Only what is drawn decides how the axis is scaled.
    shown = np.concatenate([sweep.rows for sweep in scene.sweeps])
    for j, fit in enumerate(scene.fits):
        values, width = residual_in(plane, data, fit)
        bands.append(width)
        largest = max(largest, float(np.max(np.abs(values[shown]))))
        views.draw_parts(axes, scene, j, values)
    axes.axhline(0.0, color=QUIET, linewidth=1.0, zorder=1)
    # In some planes the band depends on the model: the widest is drawn, which accuses none of them
    # falsely.
    draw_bands(axes, scene, np.max(bands, axis=0))
    middle = float(np.median(np.max(bands, axis=0)[shown]))
    if middle > 0 and largest > CANVAS.tenfold * middle:
        symmetric(axes, middle, largest)
    if scene.axis.logarithmic:
        logarithmic(axes, "x")
    label = f"{plane.plane} residual\n{plane.label(data.units.stiffness)}"
    axes.set(xlabel=scene.axis.label, ylabel=label)


def symmetric(axes: Axes, within: float, largest: float) -> None:
    """Linear within the noise, by decades beyond, with at most three numbers on each side."""
    axes.set_yscale("symlog", linthresh=within, linscale=0.5)
    first, last = int(np.ceil(np.log10(within))), int(np.floor(np.log10(largest)))
    decades = 10.0 ** np.arange(first, max(last, first) + 1)[:: max(1, (last - first + 3) // 3)]
    axes.set_yticks(np.concatenate([-decades[::-1], [0.0], decades]))
    axes.minorticks_off()


def fits_of(comparison: Comparison) -> list[DrawnFit]:
    """The models of a comparison as drawn."""
    return [DrawnFit(judgement.model, judgement.refit.theta) for judgement in comparison.shown]


def figure_compared(comparison: Comparison, path: str | Path | None = None) -> Figure | Path:
    """The views of rheologists, of data and all models, above the residual planes of each model.

    Parameters
    ----------
    comparison : Comparison
        What to draw.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    measurement, fits = comparison.measurement, fits_of(comparison)
    everything = Scene(measurement, fits)
    drawings = (
        views.storage_and_loss,
        views.loss_factor,
        views.cole_cole,
        views.black,
        views.van_gurp_palmen,
    )
    names = ("storage and loss", "loss factor", "Cole-Cole", "Black", "van Gurp-Palmen")
    with blank(19.0, 3.3 * (1 + len(fits)) + 0.8) as figure:
        grid = figure.subplots(1 + len(fits), 5, squeeze=False)
        for axes, draw, name in zip(grid[0], drawings, names, strict=True):
            draw(axes, everything)
            axes.set_title(name)
        for row, fit, judged in zip(grid[1:], fits, comparison.shown, strict=True):
            _row_of_residuals(row, Scene(measurement, [fit]), judged.error, len(fits) > 1)
        # Above a colour is a model, in the rows below a sweep: the legend tells both.
        headed(figure, everything, Scene(measurement, fits[:1]), floors=True)
        return finished(figure, path)


def _row_of_residuals(row: Sequence[Axes], scene: Scene, error: Error, named: bool) -> None:
    """One model's residual in % of |K| beside the least of any material, and in the four planes."""
    views.residual(row[0], scene)
    for side in (-100.0, 100.0):
        row[0].axhline(side * error.material_floor, zorder=2.5, **DASHES)
    title = f"error {percent(error.relative_rms)}, material floor {percent(error.material_floor)}"
    # The headline names a single model.
    if named:
        title = f"{literal(cut(scene.fits[0].name, LETTERS.panel))}\n{title}"
    row[0].set_title(title)
    for axes, plane in zip(row[1:], PLANES, strict=True):
        draw_plane(axes, scene, plane)
        axes.set_title(plane_name(plane, scene.measurement.units))


def with_noise_of(measurement: Measurement, sd: Complex) -> Measurement:
    """The data with the standard deviations of their noise floor, drawn as a band."""
    return replace(measurement, sd=sd)


def set_aside(measurement: Measurement, kept: Measurement) -> Measurement | None:
    """The points that were measured and could have been used, but were taken for outliers.

    None if there are none.
    """
    used = thinned(measurement)
    # By their values: a subset does not remember its rows.
    known = set(zip(kept.omega.tolist(), kept.stiffness.tolist(), strict=True))
    points = zip(used.omega.tolist(), used.stiffness.tolist(), strict=True)
    rows = [i for i, point in enumerate(points) if point not in known]
    if not rows:
        return None
    return used.subset(np.array(rows))


VIEWS: tuple[tuple[str, Callable[[Axes, Scene], None]], ...] = (
    ("Loss factor", views.loss_factor),
    ("Cole-Cole: loss against storage", views.cole_cole),
    ("Black: size against phase", views.black),
    ("van Gurp-Palmen: phase against size", views.van_gurp_palmen),
)


def panel(
    draw: Callable[[Axes], None], caption: str, width: float = 4.6, height: float = 3.3
) -> Html:
    """A figure with its caption as an element of a page.

    Parameters
    ----------
    draw : callable
        Draws on a pair of axes.
    caption : str
        Below the figure; also read aloud in its place.
    width, height : float
        In inches.
    """
    with blank(width, height) as figure:
        draw(figure.subplots())
        return framed(figure, caption)


def framed(figure: Figure, caption: str) -> Html:
    """A figure that is drawn already; see `panel`."""
    picture = BytesIO()
    # Without a date: the same answer gives the same page.
    figure.savefig(picture, format="svg", metadata={"Date": None})
    width, height = figure.get_size_inches().tolist()
    # Inside the page, and as a picture: an SVG that stands in an image runs no script.
    source = f"data:image/svg+xml;base64,{b64encode(picture.getvalue()).decode()}"
    # The browser knows the room before the picture is there; an inch of a page is 96 pixels.
    size = {"width": f"{96 * width:.0f}", "height": f"{96 * height:.0f}"}
    return tag("figure", tag("img", src=source, alt=caption, **size), tag("figcaption", caption))


def pairs(scenes: dict[str, Scene], draw: Callable[[Axes, Scene], None], caption: str) -> Html:
    """The same view of several scenes side by side, each with its name."""
    figures = [
        panel(lambda axes, s=scene: draw(axes, s), f"{caption} · {name}")  # type: ignore[misc]
        for name, scene in scenes.items()
    ]
    return tag("div", *figures, class_="pair")


def data_and_model(scenes: dict[str, Scene]) -> Html:
    """Storage and loss, and the residual in per cent."""
    return joined(
        [
            pairs(scenes, views.storage_and_loss, "Storage and loss"),
            pairs(scenes, views.residual, "Measured minus model in per cent of |K|"),
        ]
    )


def other_views(scenes: dict[str, Scene]) -> Html:
    """Loss factor, Cole-Cole, Black and van Gurp-Palmen."""
    return joined(pairs(scenes, draw, caption) for caption, draw in VIEWS)


def plane_name(plane: type[Composition], units: Units) -> str:
    """What a plane is called: ``modulus plane`` where K is a modulus."""
    word = plane.plane
    if plane is Parallel and units.is_modulus:
        word = "modulus"
    return f"{word} plane"


def residual_planes(scenes: dict[str, Scene]) -> Iterator[Html]:
    """The four planes, each with what it shows."""
    units = next(iter(scenes.values())).measurement.units
    for plane in PLANES:
        yield tag("h3", f"{plane_name(plane, units).capitalize()}: {plane.shows}")
        yield pairs(
            scenes,
            lambda axes, scene, p=plane: draw_plane(axes, scene, p),  # type: ignore[misc]
            f"Residual, {plane.plane}",
        )


def keys(scene: Scene) -> Html:
    """What marks and colours mean."""
    text = (
        "Points are measured, lines fitted. Filled and solid: storage, or the real part; open and"
        " dashed: loss, or the imaginary part. The band is what noise explains (two standard"
        " deviations); where sweeps differ, each has its own in its colour."
    )
    # The colours mean what they mean in the pictures: sweeps where there are several, else the two
    # parts.
    if scene.by_sweep:
        colours, labels = sweep_colours(len(scene.sweeps)), [sweep.label for sweep in scene.sweeps]
    else:
        colours, labels = list(COLOURS[:2]), ["storage", "loss"]
    swatches = [
        tag("span", tag("i", style=f"background:{colour}"), label, class_="key")
        for colour, label in zip(colours, labels, strict=True)
    ]
    if scene.drawn:
        text += f" {scene.drawn}, evenly spread; errors are those of all."
    if scene.aside is not None:
        text += " Open diamonds: single points that were set aside; no model was fitted to them."
    return joined([tag("p", text, class_="quiet"), tag("p", *swatches)])


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
