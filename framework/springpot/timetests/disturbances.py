"""What disturbs one test and is no effect: something that slips at an instant, a single frequency.

White noise has no lines; the largest of m ordinates of its periodogram is known (Fisher 1929,
doi:10.1098/rspa.1929.0151), and here each is held against those around it, as noise may have a
memory and a misfit is slow. What no effect of the library makes is something that slips or lets go
at one instant of one test.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from springpot.identification.result import Identification
from springpot.measurement.hum import (
    FEWEST_OF_LINE,
    RARE,
    WIDE,
    at_mains,
    over_neighbours,
    periodogram,
)
from springpot.measurement.imposed import ORDER, imposed_noise
from springpot.measurement.rounding import is_even
from springpot.misfit.error import plain
from springpot.rheology.points import Real

from ..numerics import DECADE, SMALLEST, rms
from .colour import UPPER
from .left import Left, delta_bic
from .residuals_of_tests import InTimePart, Residual, TestPart
from .scatter import TAILS, Jump, ResidualScatter, likeliest_jump, rougher, scatter_of
from .specimen import stepped

SHOWN = 0.5
"""Share of a jump by which its two samples at least differ, beside what their neighbours do."""
BESIDE = 3
"""Such neighbours on either side."""
FURTHER = 24
"""Steps at most by which the model makes way for a jump in tests that it misses plainly."""


class Slip(NamedTuple):
    """A jump that is in no library, as a story of all tests.

    Attributes
    ----------
    says : str
        Which.
    left : Left
        What it leaves of them.
    places : int
        At how many samples it might have been.
    shown : bool
        Whether the two samples beside it differ as it says.
    aside : tuple of (int, int, float), optional
        Of a sample at an end that is off by itself: the number of its test and its own, and by how
        many times the noise it is off.
    """

    says: str
    left: Left
    places: int
    shown: bool = True
    aside: tuple[int, int, float] | None = None

    def delta(self, before: Left, noise: Sequence[ResidualScatter]) -> float:
        """By how much the Bayesian information criterion falls, its place one of all samples."""
        # One that leaves more than noise is not the whole story: what has a name goes before it.
        if self.left.misfit or not self.shown:
            return -np.inf
        # Over even noise, as all other stories, and over noise that grows: the less is sure.
        stories = [(before, self.left, noise), _evened(before, self.left, noise)]
        told = [
            delta_bic(old, replace(new, count=old.count + 1), scatters)
            for old, new, scatters in stories
        ]
        return min(told) - 2.0 * float(np.log(max(self.places, 1)))


def _evened(
    before: Left, after: Left, noise: Sequence[ResidualScatter]
) -> tuple[Left, Left, list[ResidualScatter]]:
    """What two stories leave, and its noise, over the size that this has in each part of a test.

    Where the noise grows on the way, its largest swings are no jumps.
    """
    sizes = [rougher(value) for value in after.residuals]
    evened = [
        scatter if np.all(size == 1.0) else scatter_of(value / size)
        for scatter, value, size in zip(noise, after.residuals, sizes, strict=True)
    ]
    return _over(before, sizes), _over(after, sizes), evened


def _over(left: Left, sizes: Sequence[Real]) -> Left:
    """What is left of each test over the size (m,) of its noise there."""

    def divided(values: Sequence[Real]) -> tuple[Real, ...]:
        return tuple(value / size for value, size in zip(values, sizes, strict=True))

    return replace(
        left,
        residuals=divided(left.residuals),
        rounded=divided(left.rounded),
        felt=divided(left.felt),
    )


def slip_beside(parts: Sequence[TestPart], base: Identification, before: Left) -> Slip:
    """What slipped or let go in one test beside the model, if that is what it was."""
    plain, theta = [part.with_scale(1.0) for part in parts], base.theta
    weights = [
        np.where(part.counted, 1.0 / part.sd, 0.0) if isinstance(part, InTimePart) else None
        for part in plain
    ]

    def missed(at: Real) -> list[Residual]:
        return [part.residual(base.model, at, base.reference) for part in plain]

    residuals = missed(theta)
    jump = likeliest_jump(residuals, weights, before.noise)
    # Where the tests are missed the model makes way by more than one linear step, each as short as
    # it has to be for them to be missed by less (Marquardt 1963, doi:10.1137/0111030).
    damping = 1.0
    for _ in range(FURTHER * before.misfit):
        step, squares = _way_made(residuals, jump, weights, damping)
        nearer = stepped(base.model, theta, step)
        there = missed(nearer)
        if _way_made(there, jump, weights, damping)[1] < squares:
            theta, residuals, damping = nearer, there, damping / DECADE
            jump = likeliest_jump(residuals, weights, before.noise)
        else:
            damping *= DECADE
    scatters = [part.scatter(value) for part, value in zip(plain, jump.left, strict=True)]
    part, (value, slopes) = plain[jump.number], residuals[jump.number]
    name, when = part.test.name, f"{part.at[jump.row]:.3g} s"
    says, aside = f"a jump in {name} at {when}, as of what slips or lets go", None
    if jump.alone:
        off = (value + slopes @ jump.moved - jump.left[jump.number])[jump.row]
        off = float(abs(off) / scatters[jump.number].size)
        aside = jump.number, jump.row, off
        says = f"the sample of {name} at {when}, off by {off:.2g} x the noise"
    # Its size is one number, and the choice of its place costs as much as two.
    left = replace(
        before,
        count=before.count + 3,
        residuals=tuple(jump.left),
        scatters=tuple(scatters),
    )
    return Slip(says, left, jump.places, _is_shown(value + slopes @ jump.moved, jump), aside)


def _way_made(
    residuals: Sequence[Residual], jump: Jump, weights: Sequence[Real | None], damping: float
) -> tuple[Real, float]:
    """A damped step (p,) of a model beside a jump of any height, and what is missed before it."""
    column = np.concatenate([np.zeros(len(value)) for value, _ in residuals])
    begin = sum(len(value) for value, _ in residuals[: jump.number])
    weight = weights[jump.number]
    if weight is not None:
        last = jump.row + 1 if jump.alone else len(weight)
        column[begin + jump.row : begin + last] = weight[jump.row : last]
    column /= max(float(np.linalg.norm(column)), SMALLEST)
    value, slopes = (np.concatenate(each) for each in zip(*residuals, strict=True))
    value, slopes = value - column * (column @ value), slopes - np.outer(column, column @ slopes)
    size = np.maximum(np.linalg.norm(slopes, axis=0), SMALLEST)
    square = (slopes / size).T @ (slopes / size)
    step = np.linalg.solve(square + damping * np.eye(len(size)), -(slopes / size).T @ value)
    return step / size, float(value @ value)


def _is_shown(story: Real, jump: Jump) -> bool:
    """Whether what the model misses (m,) jumps there by itself, as far as noise lets it be seen.

    A bend may be missed like a jump, from where on the model lies beside the test: at it neighbours
    differ little.
    """
    if jump.alone or jump.row == 0 or len(story) <= ORDER:
        # None was found, or nothing tells the noise, or nothing beside it has moved.
        return jump.alone or jump.row > 0
    height = float((story - jump.left[jump.number])[jump.row])
    steps = np.sign(height) * np.diff(story)
    row = jump.row - 1
    around = np.concatenate([steps[max(row - BESIDE, 0) : row], steps[row + 1 : row + 1 + BESIDE]])
    # A step holds the noise of two samples.
    noise = np.sqrt(2.0) * imposed_noise(story)
    return bool(steps[row] - np.median(around) > SHOWN * abs(height) - TAILS * noise)


def lines_in(part: TestPart, residual: Real) -> Iterator[str]:
    """The strongest line in a residual (m,) over the noise, in words; nothing where there is none.

    Sought where a misfit of a model does not reach, and at the frequencies of the mains.
    """
    if not isinstance(part, InTimePart) or len(part.at) < FEWEST_OF_LINE or not is_even(part.at):
        return
    missed = residual * part.sd
    power, omega = periodogram(missed)
    hertz = omega / (2.0 * np.pi * float(np.mean(np.diff(part.at))))
    of_mains = at_mains(hertz)
    sought = np.where((omega > UPPER * np.pi) | of_mains, over_neighbours(power), 0.0)
    top = int(np.argmax(sought))
    # The largest of m: each might have been it.
    if len(power) * np.exp(-sought[top]) > RARE:
        return
    share = power[max(0, top - WIDE) : top + WIDE + 1].sum() / power.sum()
    size = np.sqrt(2.0 * share) * rms(missed - missed.mean())
    whose = "a vibration, or the hum of a device"
    if of_mains[top]:
        whose = "the hum of the mains"
    yield (
        f"what is left of {part.test.name} holds a line at {plain(float(hertz[top]), 3)} Hz,"
        f" {plain(float(size), 2)} {part.unit} in amplitude: {whose}, no part of the specimen"
    )
