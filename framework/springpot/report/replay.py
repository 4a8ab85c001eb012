"""A discovery as a moving picture.

Step by step the curve meets the data, the residual falls into the noise, the error onto its floor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from springpot.diagnosis.case import Case
from springpot.diagnosis.ladder import Ladder
from springpot.errors import OutputError
from springpot.files import write_with
from springpot.rheology.points import Complex, Points

from . import views
from .canvas import blank, check_figure_path
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
DOTS = 100
"""Per inch."""


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
    """Write a ladder of a sweep as an animated GIF.

    Parameters
    ----------
    ladder : Ladder
        The discovery, as `springpot.discover` found it.
    path : str or Path
        Where to write.

    Raises
    ------
    OutputError
        If it cannot be written, or the ladder is of tests in time.
    """
    if not isinstance(ladder.steps[0].examined, Case):
        raise OutputError(f"{path}: a moving picture is drawn of sweeps; name a .png, .svg or .pdf")
    frames = frames_of(ladder)
    place = check_figure_path(path, (SUFFIX,))
    return write_with(place, lambda file: written_as_gif(frames, file))


def frames_of(ladder: Ladder) -> list[tuple[Image, int]]:
    """Frames of a ladder of a sweep, each with the milliseconds that it stands."""
    played = Replay(ladder)
    moments = _moments(len(ladder.steps))
    return [(played.at(step, share), lasting) for step, share, lasting in moments]


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
    """What all frames share: the data with their noise, the fits, the ends of the axes.

    Parameters
    ----------
    ladder : Ladder
        Of a sweep.
    """

    def __init__(self, ladder: Ladder) -> None:
        self.ladder = ladder
        bases = [step.case.search.base for step in ladder.steps]
        # The noise as the last model tells it: what falls is seen to fall against one band.
        self.data = with_noise_of(bases[-1].data.mean, bases[-1].noise.sd)
        self.fits = [DrawnFit(base.model, base.theta) for base in bases]
        size = self.data.magnitude
        self.largest = max(
            float(np.max(np.abs(self.data.stiffness - fit.at(self.data.points)) / size))
            for fit in self.fits
        )
        with blank() as figure:
            whole = figure.subplots()
            draw_ladder(whole, ladder)
            self.ends = whole.get_xlim(), whole.get_ylim()
        self.noise = 2.0 * float(np.median(np.abs(bases[-1].noise.sd) / size))

    def at(self, step: int, share: float) -> Image:
        """The frame on the way to a step."""
        from PIL import Image as images

        there = self.fits[step]
        before = self.fits[max(step - 1, 0)]
        passing = OnTheWay(there.model, there.theta, there.label, before, share)
        # The step's own mark only appears where its curve has arrived.
        reached = step + 1
        if share < 1.0:
            reached = step
        with blank(9.0, 5.0) as figure:
            panels = figure.subplot_mosaic(
                [["curve", "ladder"], ["residual", "ladder"]],
                width_ratios=(1.25, 1.0),
                height_ratios=(1.5, 1.0),
            )
            scene = Scene(self.data, [passing])
            self._curve(panels["curve"], scene)
            self._residual(panels["residual"], scene)
            self._ladder(panels["ladder"], reached)
            entitled(panels["curve"], f"{self.fits[reached - 1].name} of {self.ladder.data}")
            stream = BytesIO()
            figure.savefig(stream, format="png", dpi=DOTS)
        return images.open(stream).convert("RGB").quantize(COLOURS)

    def _curve(self, axes: Axes, scene: Scene) -> None:
        views.storage_and_loss(axes, scene)
        parts = np.abs([self.data.storage, self.data.loss])
        axes.set_ylim(parts[parts > 0.0].min() / ROOM, parts.max() * ROOM)
        axes.set_xlabel("")

    def _residual(self, axes: Axes, scene: Scene) -> None:
        views.residual(axes, scene)
        if self.noise > 0.0 and self.largest > self.noise:
            symmetric(axes, 100.0 * self.noise, 100.0 * self.largest)
        axes.set_ylim(-100.0 * ROOM * self.largest, 100.0 * ROOM * self.largest)

    def _ladder(self, axes: Axes, reached: int) -> None:
        draw_ladder(axes, replace(self.ladder, steps=self.ladder.steps[:reached]))
        axes.set(xlim=self.ends[0], ylim=self.ends[1])
