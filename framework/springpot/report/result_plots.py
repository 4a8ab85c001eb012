"""What ``plot()`` of each result draws, and a discovery as a moving picture."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.comparison.result import Comparison
from springpot.diagnosis.ladder import Case, Examined, Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.errors import OutputError
from springpot.files import write_with
from springpot.identification.material import is_material
from springpot.identification.prediction import Prediction
from springpot.identification.result import Identification
from springpot.invention.result import Invention
from springpot.measurement.measurement import Measurement
from springpot.misfit.refit import Refit
from springpot.numerics import DEVIATIONS
from springpot.rheology.points import Complex, Points, Real
from springpot.superposition.curve import MasterCurve
from springpot.timetests.prediction import TestPrediction

from . import views
from .answers import worth_showing
from .canvas import (
    COLOURS,
    QUIET,
    blank,
    check_figure_path,
    finished,
    logarithmic,
)
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
from .interactive.answers import PLANE, TimeScene
from .invention import draw_fits, figure_invention
from .ladder_text import (
    LADDER,
    beside_mark,
    broken,
    draw_ladder,
    entitled,
    error_axis,
    figure_ladder,
)
from .mastercurve import figure_mastercurve
from .residuals import (
    figure_compared,
    figure_prediction,
    figure_tests,
    fits_in_time,
    fits_of,
    symmetric,
    with_noise_of,
)
from .text import percent
from .views import ALONG_CLOCK, DrawnFit, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image

SUFFIX = ".gif"


class Film(NamedTuple):
    """How a discovery is played."""

    hold: int
    """Milliseconds that a step stands still."""
    between: int
    """Milliseconds of a frame between two steps."""
    frames: int
    """Between two steps."""
    colours: int
    """Of a frame, which has few."""
    abreast: int
    """Tests beside one another."""
    most_played: int
    """Tests: those that the first model misses most."""


REPLAY = Film(hold=1800, between=60, frames=10, colours=64, abreast=3, most_played=6)


@dataclass(frozen=True, eq=False)
class OnTheWay(DrawnFit):
    """A curve on the way from one fit to the next.

    Parameters
    ----------
    before : DrawnFit
        Where it comes from; what it inherits is where it goes to.
    share : float
        Of the way.
    """

    before: DrawnFit | None = None
    share: float = 1.0

    def at(self, points: Points) -> Complex:
        """Complex stiffness (n,) at `points`."""
        there = super().at(points)
        if self.before is None:
            return there
        return there + (1.0 - self.share) * (self.before.at(points) - there)


def write_replay(ladder: Ladder, path: str | Path) -> Path:
    """Write a ladder as an animated GIF.

    Parameters
    ----------
    ladder : Ladder
        The discovery, as `springpot.discover` found it.
    path : str or Path
        Where to write.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    frames = frames_of(ladder)
    place = check_figure_path(path, (SUFFIX,))
    return write_with(place, lambda file: written_as_gif(frames, file))


def frames_of(ladder: Ladder) -> list[tuple[Image, int]]:
    """Frames of a ladder, each with the milliseconds that it stands."""
    replay, moments = Replay(ladder), _moments(len(ladder.steps))
    return [(replay.at(step, share), lasting) for step, share, lasting in moments]


def written_as_gif(frames: Sequence[tuple[Image, int]], file: IO[bytes]) -> None:
    """Write frames with their times into a stream."""
    images, lasting = zip(*frames, strict=True)
    images[0].save(
        file, format="GIF", save_all=True, append_images=images[1:], duration=lasting, loop=0
    )


def _moments(steps: int) -> Iterator[tuple[int, float, int]]:
    """Step, share of the way to it, and milliseconds of each frame."""
    yield 0, 1.0, REPLAY.hold
    for step in range(1, steps):
        for share in np.linspace(0.0, 1.0, REPLAY.frames, endpoint=False)[1:].tolist():
            # Slow, fast, slow, as what is moved by a hand.
            yield step, 0.5 - 0.5 * float(np.cos(np.pi * share)), REPLAY.between
        yield step, 1.0, REPLAY.hold


class Replay:
    """What all frames share: the steps, the ends of the axes, and the pictures that move.

    Parameters
    ----------
    ladder : Ladder
        What is played.
    """

    def __init__(self, ladder: Ladder) -> None:
        self.ladder = ladder
        with blank() as figure:
            whole = figure.subplots()
            draw_ladder(whole, ladder)
            self.ends = whole.get_xlim(), whole.get_ylim()
        cases = [step.examined for step in ladder.steps]
        self.played: Sequence[Played]
        if isinstance(cases[0], Case):
            self.played = [PlayedSweeps([step.case.search.base for step in ladder.steps])]
        else:
            self.played = _played_in_time(ladder, [case for case in cases if case is not None])

    def at(self, step: int, share: float) -> Image:
        """The frame on the way to a step."""
        from PIL import Image as images

        # The step's own mark only appears where its curve has arrived.
        reached = step + 1
        if share < 1.0:
            reached = step
        tiers = -(-len(self.played) // REPLAY.abreast)
        abreast = -(-len(self.played) // tiers)
        with blank(4.0 + 5.0 * abreast, 5.0 * tiers) as figure:
            panels = figure.subplot_mosaic(
                _mosaic(len(self.played), abreast),
                width_ratios=(*abreast * (1.25,), 1.0),
                height_ratios=tiers * (1.5, 1.0),
            )
            for i, one in enumerate(self.played):
                one.curve(panels[f"curve {i}"], step, share)
                panels[f"curve {i}"].set_xlabel("")
                one.residual(panels[f"residual {i}"], step, share)
                if i:
                    entitled(panels[f"curve {i}"], one.name)
            self._ladder(panels["ladder"], reached)
            model, of = self.ladder.steps[reached - 1].model, self.ladder.data
            if len(self.played) > 1:
                of = self.played[0].name
            entitled(panels["curve 0"], f"{model.name} of {of}")
            stream = BytesIO()
            figure.savefig(stream, format="png", dpi=100)
        return images.open(stream).convert("RGB").quantize(REPLAY.colours)

    def _ladder(self, axes: Axes, reached: int) -> None:
        draw_ladder(axes, replace(self.ladder, steps=self.ladder.steps[:reached]))
        axes.set(xlim=self.ends[0], ylim=self.ends[1])


def _mosaic(count: int, abreast: int) -> Any:
    """Where the pictures stand: each residual below its curve, the ladder beside all."""
    rows = []
    for first in range(0, count, abreast):
        for kind in ("curve", "residual"):
            named = [f"{kind} {i}" for i in range(first, min(first + abreast, count))]
            rows.append([*named, *(abreast - len(named)) * ["."], "ladder"])
    return rows


class Played(ABC):
    """What moves of one test.

    Attributes
    ----------
    name : str
        What the test is called.
    """

    name: str = ""

    @abstractmethod
    def curve(self, axes: Axes, step: int, share: float) -> None:
        """Draw the data, and the curve on its way to a step."""

    @abstractmethod
    def residual(self, axes: Axes, step: int, share: float) -> None:
        """Draw what is left there."""


class PlayedSweeps(Played):
    """Storage and loss of all sweeps, and the error at each point.

    Parameters
    ----------
    bases : sequence of Refit
        The fit of each step.
    """

    def __init__(self, bases: Sequence[Refit]) -> None:
        # The noise as the last model tells it: what falls is seen to fall against one band.
        self.data = with_noise_of(bases[-1].data.mean, bases[-1].noise.sd)
        self.fits = [DrawnFit(base.model, base.theta) for base in bases]
        size = self.data.magnitude
        self.largest = max(
            float(np.max(np.abs(self.data.stiffness - fit.at(self.data.points)) / size))
            for fit in self.fits
        )
        self.noise = 2.0 * float(np.median(np.abs(bases[-1].noise.sd) / size))

    def _scene(self, step: int, share: float) -> Scene:
        there, before = self.fits[step], self.fits[max(step - 1, 0)]
        return Scene(self.data, [OnTheWay(there.model, there.theta, there.label, before, share)])

    def curve(self, axes: Axes, step: int, share: float) -> None:
        """Draw storage and loss."""
        views.storage_and_loss(axes, self._scene(step, share))
        parts = np.abs([self.data.storage, self.data.loss])
        axes.set_ylim(parts[parts > 0.0].min() / LADDER.room, parts.max() * LADDER.room)

    def residual(self, axes: Axes, step: int, share: float) -> None:
        """Draw the error at each point."""
        views.residual(axes, self._scene(step, share))
        if self.noise > 0.0 and self.largest > self.noise:
            symmetric(axes, 100.0 * self.noise, 100.0 * self.largest)
        axes.set_ylim(-100.0 * LADDER.room * self.largest, 100.0 * LADDER.room * self.largest)


def _played_in_time(ladder: Ladder, cases: Sequence[Examined]) -> list[PlayedTest]:
    """Tests in time as the page draws them, in their order."""
    scene = TimeScene(cases[0].tests)
    told, bases = scene.to_dict(), [case.base for case in cases]
    whole = [scene.curve(base.model, base.theta, whole=True) for base in bases]
    tests = ladder.steps[0].tests
    missed = sorted(range(len(tests)), key=lambda i: -tests[i].over_floor)[: REPLAY.most_played]
    return [PlayedTest(told, whole, at) for at in sorted(missed)]


class PlayedTest(Played):
    """One test in time.

    Parameters
    ----------
    told : dict
        See `TimeScene.to_dict`.
    whole : sequence of dict
        What each step computes, see `TimeScene.curve`.
    at : int
        Which test.
    """

    def __init__(self, told: dict[str, Any], whole: Sequence[dict[str, Any]], at: int) -> None:
        self.name = told["sweeps"][at]["label"]
        self.view, self.grid = told["views"][f"test-{at}"], told["grids"][at]["x"]
        rows = np.equal(told["sweep"], at)
        self.x = np.array(told["x"])[rows]
        self.measured = _parts(told, self.view, rows)
        self.curves = [_parts(drawn["curves"][at], self.view) for drawn in whole]
        self.left = [
            _parts(drawn["planes"][PLANE], self.view, rows)
            / np.array(drawn["planes"][PLANE]["width"], dtype=float)[rows]
            for drawn in whole
        ]
        self.largest = max(DEVIATIONS, *(float(np.nanmax(np.abs(left))) for left in self.left))

    def curve(self, axes: Axes, step: int, share: float) -> None:
        """Draw what was measured and what is computed."""
        drawn = _between(self.curves, step, share)
        for measured, computed, colour in zip(self.measured, drawn, COLOURS, strict=False):
            axes.plot(self.x, measured, ".", color=QUIET)
            axes.plot(self.grid, computed, color=colour)
        axes.set_ylabel(self.view["y"]["label"])
        if self.view["y"]["log"]:
            logarithmic(axes, "y")
            parts = np.abs(self.measured)
            axes.set_ylim(parts[parts > 0.0].min() / LADDER.room, parts.max() * LADDER.room)
        self._along(axes)

    def residual(self, axes: Axes, step: int, share: float) -> None:
        """Draw what was measured less what is computed, over the noise."""
        axes.axhspan(-DEVIATIONS, DEVIATIONS, color="#EEEEEE")
        for left, colour in zip(_between(self.left, step, share), COLOURS, strict=False):
            axes.plot(self.x, left, ".", color=colour)
        if self.largest > 2.0 * DEVIATIONS:
            symmetric(axes, DEVIATIONS, self.largest)
        axes.set_ylim(-LADDER.room * self.largest, LADDER.room * self.largest)
        axes.set_ylabel("residual / noise")
        self._along(axes)

    def _along(self, axes: Axes) -> None:
        axes.set_xlabel(self.view["x"]["label"])
        if self.view["x"]["log"]:
            logarithmic(axes, "x")


def _parts(
    told: dict[str, Any], view: dict[str, Any], rows: NDArray[np.bool_] | slice = slice(None)
) -> Real:
    """The numbers of each part of a view, (parts, n); what is not known is nan."""
    return np.array([told[name] for name in view["parts"]], dtype=float)[:, rows]


def _between(drawn: Sequence[Real], step: int, share: float) -> Real:
    there, before = drawn[step], drawn[max(step - 1, 0)]
    return np.asarray(there + (1.0 - share) * (before - there))


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
