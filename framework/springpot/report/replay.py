"""A discovery as a moving picture.

Step by step the curve meets the data, the residual falls into the noise, the error onto its floor.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from springpot.diagnosis.ladder import Case, Examined, Ladder
from springpot.files import write_with
from springpot.misfit.refit import Refit
from springpot.numerics import DEVIATIONS
from springpot.rheology.points import Complex, Points, Real

from . import views
from .canvas import COLOURS as LINES, QUIET, blank, check_figure_path, logarithmic
from .interactive.answers import PLANE, TimeScene
from .ladder_text import ROOM, draw_ladder, entitled
from .residuals import symmetric, with_noise_of
from .views import DrawnFit, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from PIL.Image import Image

SUFFIX = ".gif"
HOLD = 1800
"""Milliseconds that a step stands still."""
BETWEEN = 60
"""Milliseconds of a frame between two steps."""
FRAMES = 10
"""Frames between two steps."""
COLOURS = 64
"""Of a frame, which has few."""
ABREAST, MOST_PLAYED = 3, 6
"""Tests beside one another, and at most: those that the first model misses most."""


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
    yield 0, 1.0, HOLD
    for step in range(1, steps):
        for share in np.linspace(0.0, 1.0, FRAMES, endpoint=False)[1:].tolist():
            # Slow, fast, slow, as what is moved by a hand.
            yield step, 0.5 - 0.5 * float(np.cos(np.pi * share)), BETWEEN
        yield step, 1.0, HOLD


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
        tiers = -(-len(self.played) // ABREAST)
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
        return images.open(stream).convert("RGB").quantize(COLOURS)

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
        axes.set_ylim(parts[parts > 0.0].min() / ROOM, parts.max() * ROOM)

    def residual(self, axes: Axes, step: int, share: float) -> None:
        """Draw the error at each point."""
        views.residual(axes, self._scene(step, share))
        if self.noise > 0.0 and self.largest > self.noise:
            symmetric(axes, 100.0 * self.noise, 100.0 * self.largest)
        axes.set_ylim(-100.0 * ROOM * self.largest, 100.0 * ROOM * self.largest)


def _played_in_time(ladder: Ladder, cases: Sequence[Examined]) -> list[PlayedTest]:
    """Tests in time as the page draws them, in their order."""
    scene = TimeScene(cases[0].tests)
    told, bases = scene.to_dict(), [case.base for case in cases]
    whole = [scene.curve(base.model, base.theta, whole=True) for base in bases]
    tests = ladder.steps[0].tests
    missed = sorted(range(len(tests)), key=lambda i: -tests[i].over_floor)[:MOST_PLAYED]
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
        for measured, computed, colour in zip(self.measured, drawn, LINES, strict=False):
            axes.plot(self.x, measured, ".", color=QUIET)
            axes.plot(self.grid, computed, color=colour)
        axes.set_ylabel(self.view["y"]["label"])
        if self.view["y"]["log"]:
            logarithmic(axes, "y")
            parts = np.abs(self.measured)
            axes.set_ylim(parts[parts > 0.0].min() / ROOM, parts.max() * ROOM)
        self._along(axes)

    def residual(self, axes: Axes, step: int, share: float) -> None:
        """Draw what was measured less what is computed, over the noise."""
        axes.axhspan(-DEVIATIONS, DEVIATIONS, color="#EEEEEE")
        for left, colour in zip(_between(self.left, step, share), LINES, strict=False):
            axes.plot(self.x, left, ".", color=colour)
        if self.largest > 2.0 * DEVIATIONS:
            symmetric(axes, DEVIATIONS, self.largest)
        axes.set_ylim(-ROOM * self.largest, ROOM * self.largest)
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
