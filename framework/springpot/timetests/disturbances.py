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
from springpot.measurement.imposed import ORDER, imposed_noise
from springpot.measurement.rounding import is_even
from springpot.misfit.error import plain
from springpot.misfit.regions import HARMONICS, MAINS
from springpot.rheology.points import Real

from ..numerics import SMALLEST, rms
from .colour import UPPER
from .left import Left, delta_bic
from .residuals_of_tests import InTimePart, TestPart
from .scatter import TAILS, WIDE, Jump, ResidualScatter, likeliest_jump, rougher, scatter_of
from .specimen import stepped

TAPER = 0.1
"""Share of the record at both ends that is faded, so that a slow misfit does not leak."""
FEWEST_OF_LINE = 200
"""Samples of a record in which a line is sought."""
AROUND = 20
"""Ordinates on either side with which one is compared."""
RARE = 1e-6
"""Chance of noise alone below which the largest ordinate is a line."""
SHOWN = 0.5
"""Share of a jump by which its two samples at least differ, beside what their neighbours do."""
BESIDE = 3
"""Such neighbours on either side."""
FURTHER = 3
"""Steps by which the model makes way for a jump in tests that it misses plainly."""


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
    # Where the tests are missed the model makes way by more than one linear step.
    for _ in range(1 + FURTHER * before.misfit):
        residuals = [part.residual(base.model, theta, base.reference) for part in plain]
        jump = likeliest_jump(residuals, weights, before.noise)
        theta = stepped(base.model, theta, jump.moved)
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
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(power, AROUND, mode="reflect"), 2 * AROUND + 1
    )
    # Of an exponential the median is ln 2 times the mean, and a line does not move it.
    ratio = power / np.maximum(np.median(around, axis=1) / np.log(2.0), SMALLEST)
    # As near as the record tells frequencies apart.
    mains = np.outer(MAINS, HARMONICS).ravel()
    of_mains = np.min(np.abs(hertz[:, None] - mains), axis=1) <= 1.5 * hertz[0]
    sought = np.where((omega > UPPER * np.pi) | of_mains, ratio, 0.0)
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


def periodogram(residual: Real) -> tuple[Real, Real]:
    """Power of a residual (n,) at each of its frequencies, in radians a sample; its mean left out.

    Of white noise the power is its variance at each of them.
    """
    n = len(residual)
    fade = max(1, int(TAPER * n))
    window = np.ones(n)
    window[:fade] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(fade) + 0.5) / fade)
    window[-fade:] = window[:fade][::-1]
    turned = np.fft.rfft((residual - residual.mean()) * window)
    power = np.abs(turned) ** 2 / np.sum(window**2)
    return power[1:], 2.0 * np.pi * np.arange(1, len(power)) / n
