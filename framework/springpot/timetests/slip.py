"""What no effect of the library makes: something slips or lets go at one instant of one test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from springpot.identification.result import Identification
from springpot.rheology.points import Real

from .left import Left, delta_bic
from .residuals_of_tests import InTimePart, TestPart
from .scatter import ResidualScatter, likeliest_jump, rougher, scatter_of
from .specimen import stepped

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
    """

    says: str
    left: Left
    places: int

    def delta(self, before: Left, noise: Sequence[ResidualScatter]) -> float:
        """By how much the Bayesian information criterion falls, its place one of all samples."""
        # One that leaves more than noise is not the whole story: what has a name goes before it.
        if self.left.misfit:
            return -np.inf
        before, after, noise = _evened(before, self.left, noise)
        return delta_bic(before, after, noise, 1) - 2.0 * float(np.log(max(self.places, 1)))


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
    part = plain[jump.number]
    says = f"a jump in {part.test.name} at {part.at[jump.row]:.3g} s, as of what slips or lets go"
    # Its size is one number, and the choice of its place costs as much as two.
    left = replace(
        before,
        count=before.count + 3,
        residuals=tuple(jump.left),
        scatters=tuple(scatters),
    )
    return Slip(says, left, jump.places)
