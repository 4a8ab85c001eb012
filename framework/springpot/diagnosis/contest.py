"""Which of several feasible measurements tells two explanations apart best.

The two are evaluated where the new points would lie, and one is allowed to follow the other with
all its parameters. Measurements are ranked with linear slopes; those that would be named are fitted
in earnest, since a rival far from its old parameters can follow much better than its slopes tell.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeVar

import numpy as np
from scipy.optimize import least_squares

from springpot.misfit.error import plain
from springpot.misfit.frame import orthonormal
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EXPERIMENT

from ..numerics import ALIKE, SMALLEST
from .result import NextExperiment

TYPED_IN, WAITED_FOR, WORKED_FOR = 1.0, 1.5, 2.0
"""Effort of an amplitude, which is a number.

Of frequencies, a temperature or an empty rig, which take a while; of a
specimen that must be made, or of several repeats."""
ENOUGH = 3.0
"""Times the separation that settles the matter beyond which more is worth nothing."""
EVALUATIONS = 40
"""Evaluations of a fit of one explanation to the other."""
FAR = 1000000000.0
"""Stands for a difference beyond all numbers."""
TRIED = 3
"""Actions that are fitted in earnest at most."""
MOST_TOLD = 1000.0
"""Standard deviations that are told at most.

So far from the data a model is a guess, and nobody doubts that it is
enough."""

Pair = tuple[float, float]
"""Of the first and of the second explanation."""


class Fitted(Protocol):
    """A fitted model."""

    @property
    def model(self) -> Model:
        """The model."""

    @property
    def theta(self) -> Real:
        """Its parameters (p,)."""


class Measurable(Protocol):
    """A measurement that could be made."""

    @property
    def says(self) -> str:
        """What to do."""

    @property
    def effort(self) -> float:
        """Relative cost, by which the expected separation is divided."""

    @property
    def action(self) -> dict[str, list[float]]:
        """The new conditions."""


A = TypeVar("A", bound=Measurable)


class Contest(ABC):
    """Two explanations after a measurement: one holds, the rival may change to follow it."""

    rival: Fitted

    @abstractmethod
    def seen(self, theta: Real) -> tuple[Real, Real]:
        """Whitened difference (m,) of truth and rival, and the rival's slopes (p, m).

        At old and new points together.
        """

    @property
    def linear(self) -> float:
        """Standard deviations between the two where the rival follows as its slopes tell."""
        residual, slopes = self.seen(self.rival.theta)
        # A parameter without a slope here follows nothing; one without a value would spoil the
        # whole basis.
        usable = np.all(np.isfinite(slopes), axis=1) & (np.sum(slopes**2, axis=1) > 0)
        # A rival that overflows under the new conditions has no slopes to go by: it is worth no
        # trial.
        if not np.all(np.isfinite(residual)):
            return 0.0
        absorbed = orthonormal(slopes[usable].T)
        left = residual - absorbed @ (absorbed.T @ residual)
        return float(np.sqrt(left @ left))

    def fitted(self) -> float:
        """The same where the rival is fitted to old and new points together."""
        # What is no number to begin with promises nothing.
        if not np.all(np.isfinite(self.seen(self.rival.theta)[0])):
            return 0.0
        parameters = self.rival.model.parameters
        logs = np.array([parameter.scale == "log" for parameter in parameters])
        bounds = np.array([(parameter.lower, parameter.upper) for parameter in parameters])
        with np.errstate(divide="ignore", invalid="ignore"):
            limits = np.where(logs[:, None], np.log(bounds), bounds)
        start = np.where(logs, np.log(np.maximum(self.rival.theta, SMALLEST)), self.rival.theta)
        # The solver refuses a start on a bound, where fits often end.
        inside = np.clip(start, limits[:, 0] + ALIKE, limits[:, 1] - ALIKE)

        def theta(x: Real) -> Real:
            return np.where(logs, np.exp(np.clip(x, -700.0, 700.0)), x)

        def residual(x: Real) -> Real:
            return np.clip(np.nan_to_num(self.seen(theta(x))[0], nan=FAR), -FAR, FAR)

        def jacobian(x: Real) -> Real:
            scale = np.where(logs, theta(x), 1.0)
            by_x = self.seen(theta(x))[1] * scale[:, None]
            slopes: Real = np.clip(-np.nan_to_num(by_x, nan=0.0), -FAR, FAR).T
            return slopes

        # Parameters differ in size by many decades, and their columns carry the units: scaled by
        # the columns.
        nearest = least_squares(
            residual,
            inside,
            jacobian,
            (limits[:, 0], limits[:, 1]),
            x_scale="jac",
            max_nfev=EVALUATIONS,
        )
        return float(np.sqrt(2.0 * nearest.cost))


def most_telling(
    actions: Sequence[A],
    clash: Callable[[A, int], Contest],
    names: tuple[str, str],
    chances: Pair,
) -> NextExperiment:
    """The measurement that should best separate two explanations for its effort.

    Parameters
    ----------
    actions : sequence of Measurable
        What can be done.
    clash : callable
        From one of them and which explanation holds, 0 or 1, to the two after it.
    names : tuple of str
        The effects that set them apart.
    chances : tuple of float
        Their probabilities: who holds decides what a measurement can show, as a larger model
        follows a smaller one.
    """
    # Of these two only: what a third would be is not what the measurement is asked.
    shares = (chances[0] / sum(chances), chances[1] / sum(chances))

    # Either may be right, and the one that is not may change all its parameters to follow.
    def worth(sigmas: Pair, action: A) -> float:
        return _expected(shares, (_enough(sigmas[0]), _enough(sigmas[1]))) / action.effort

    # Slopes first, as a fit for each action would take far longer; but a promise is made from a fit
    # only.
    contests = {each: (clash(each, 0), clash(each, 1)) for each in actions}
    feasible = {each: (one.linear, other.linear) for each, (one, other) in contests.items()}
    tried = sorted(feasible, key=lambda action: -worth(feasible[action], action))[:TRIED]
    reached = {each: (contests[each][0].fitted(), contests[each][1].fitted()) for each in tried}
    # By the better of the two ways: a larger model follows a smaller one wherever one measures.
    telling = [action for action in tried if max(reached[action]) >= EXPERIMENT.telling]
    if not telling:
        best = max(tried, key=lambda action: max(reached[action]))
        expected = separation(shares, reached[best])
        return NextExperiment(_no_use(best.says, names, expected), names, expected)
    best = max(telling, key=lambda action: worth(reached[action], action))
    expected = separation(shares, reached[best])
    return NextExperiment(
        f"{best.says}: {promise(names, shares, reached[best])}", names, expected, best.action
    )


def _no_use(says: str, names: tuple[str, str], sigma: float) -> str:
    """Where one explanation follows the other everywhere, nothing is to be bought by measuring."""
    size = "less than 0.1"
    if sigma > 0.1:
        size = plain(sigma, 2)
    return (
        f"no feasible measurement tells {names[0]} from {names[1]}: even the best ({says})"
        f" would separate them by {size} sigma"
    )


def _expected(shares: Pair, sigmas: Pair) -> float:
    return shares[0] * sigmas[0] + shares[1] * sigmas[1]


def _enough(sigma: float) -> float:
    """More than enough separation is worth no more."""
    return min(sigma, ENOUGH * EXPERIMENT.settled)


def separation(shares: Pair, sigmas: Pair) -> float:
    """The standard deviations that are promised.

    At least so many, or where it depends on who is right, the mean.
    """
    if _either_way(sigmas):
        return min(sigmas)
    return _expected(shares, sigmas)


def _either_way(sigmas: Pair) -> bool:
    """Whether the measurement tells the two apart whoever is right."""
    # Beyond what settles the matter a difference of the two is of no matter; below, up to two-fold
    # is about the same.
    return min(sigmas) >= EXPERIMENT.settled or 2.0 * min(sigmas) >= max(sigmas)


def promise(names: tuple[str, str], shares: Pair, sigmas: Pair) -> str:
    """What the measurement will show if the first or the second of two explanations holds."""
    less, more = sorted(range(2), key=lambda i: sigmas[i])
    apart = _sigmas(separation(shares, sigmas))
    if _either_way(sigmas):
        return f"it separates {names[0]} from {names[1]} by {apart}"
    verb = "speaks against"
    if sigmas[more] >= EXPERIMENT.settled:
        verb = "rules out"
    return (
        f"if {names[more]} is right it {verb} {names[less]} by {_sigmas(sigmas[more])}; "
        f"if not, {names[more]} stays possible; {apart} are to be expected"
    )


def _sigmas(number: float) -> str:
    """Standard deviations in words."""
    if number > MOST_TOLD:
        return f"more than {MOST_TOLD:.0f} sigma"
    return f"{plain(number, 2)} sigma"


def openness(chances: Mapping[str, float]) -> float:
    """Odds of the second likeliest answer against the likeliest."""
    most = sorted(chances.values())[-2:]
    if len(most) < 2 or most[1] <= 0.0:
        return 0.0
    return most[0] / most[1]


def worth_telling_apart(chances: Mapping[str, float]) -> tuple[str, str] | None:
    """The two likeliest, where it is open which of them holds and both are believed in.

    Two, not all rivals: a measurement that separates the leading ones can be promised in one
    sentence.
    """
    if openness(chances) < EXPERIMENT.rival:
        return None
    if sorted(chances.values())[-2] < EXPERIMENT.rival:
        return None
    first, second = sorted(chances, key=lambda name: -chances[name])[:2]
    return first, second
