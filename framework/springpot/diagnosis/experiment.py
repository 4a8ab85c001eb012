"""The next experiment.

Which feasible measurement would tell the leading explanations apart, or what is unknown.

For every feasible action the two explanations are evaluated where the new points would lie, and one
is allowed to follow the other with all its parameters. Actions are ranked with linear slopes; those
that would be named are fitted in earnest, since a rival far from its old parameters can follow much
better than its slopes tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from springpot.identification.objective import weighted
from springpot.measurement.independence import moved_along, spread_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.one_frequency import distinct_log_omega
from springpot.measurement.sweeps import sweeps_of
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.misfit.shapes import orthonormal
from springpot.misfit.words import plain
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Real
from springpot.thresholds import EXPERIMENT

from .actions import MOST_POINTS, Action, actions
from .result import NextExperiment

ENOUGH = 3.0
"""Times the separation that settles the matter beyond which more is worth nothing."""
EVALUATIONS = 40
"""Evaluations of a fit of one explanation to the other."""
FAR = 1000000000.0
"""Stands for a difference beyond all numbers."""
TRIED = 3
"""Actions that are fitted in earnest at most."""
BESIDE = (0.97, 1.0, 1.03)
"""Factors of a frequency at which a point was bad.

So near that no material changes, and off the line of a hum.
"""
MOST_NAMED = 3
"""Effects that are named as what a measurement is for."""
MOST_TOLD = 1000.0
"""Standard deviations that are told at most.

So far from the data a model is a guess, and nobody doubts that it is
enough."""


@dataclass(frozen=True, eq=False)
class Clash:
    """Two explanations after an action, both of which follow the old data.

    Attributes
    ----------
    truth, rival : Refit
        The one that holds, and the one that may change its parameters to follow it.
    action : Action
        What would be measured.
    """

    truth: Refit
    rival: Refit
    action: Action

    @property
    def linear(self) -> float:
        """Standard deviations between the two where the rival follows as its slopes tell."""
        residual, slopes = self._seen(self.rival.theta)
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
        parameters = self.rival.model.parameters
        logs = np.array([parameter.scale == "log" for parameter in parameters])
        bounds = np.array([(parameter.lower, parameter.upper) for parameter in parameters])
        with np.errstate(divide="ignore", invalid="ignore"):
            limits = np.where(logs[:, None], np.log(bounds), bounds)
        start = np.where(logs, np.log(np.maximum(self.rival.theta, 1e-300)), self.rival.theta)
        # The solver refuses a start on a bound, where fits often end.
        inside = np.clip(start, limits[:, 0] + 1e-9, limits[:, 1] - 1e-9)

        def theta(x: Real) -> Real:
            return np.where(logs, np.exp(np.minimum(x, 700.0)), x)

        def residual(x: Real) -> Real:
            return np.clip(np.nan_to_num(self._seen(theta(x))[0], nan=FAR), -FAR, FAR)

        def jacobian(x: Real) -> Real:
            scale = np.where(logs, theta(x), 1.0)
            by_x = self._seen(theta(x))[1] * scale[:, None]
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

    @cached_property
    def _target(self) -> tuple[Complex, Complex]:
        """K of the truth at old and new points (n,), and their weights."""
        new = self._evaluated(self.truth, self.truth.theta)[0]
        # The new points are taken to be as noisy as the median of the old ones.
        noise, size = self.truth.noise.sd, np.abs(self.truth.stiffness)
        relative = (
            complex(np.median(noise.real / size), np.median(noise.imag / size)) * self._quieter()
        )
        floor = np.abs(new)
        if self.action.scale == 0.0:
            # Without a specimen the force is small, and its noise is not.
            floor = np.maximum(floor, float(np.median(size)))
        # The mean of so many repeats is quieter by the root of their number.
        weights = np.sqrt(self.action.repeats) / np.maximum(floor, 1e-300)
        weights = weights / relative.real + 1j * weights / relative.imag
        return np.concatenate([self.truth.stiffness, new]), np.concatenate(
            [self.truth.noise.weights, weights]
        )

    def _quieter(self) -> float:
        """How much smaller the new amplitude is than the usual one.

        At worst the noise is a force of fixed size.
        """
        usual, new = self.truth.fit.measurement.points.amplitude, self.action.points.amplitude
        if usual is None or new is None:
            return 1.0
        return max(1.0, float(np.median(usual) / np.median(new)))

    def _seen(self, theta: Real) -> tuple[Real, Real]:
        """Whitened difference of truth and rival, and the rival's slopes, at old and new points.

        Their shapes are (2n,) and (p, 2n).
        """
        old = self.truth.fit.measurement.points
        with np.errstate(all="ignore"):
            response = self.rival.model.network.respond(theta, old, GRADIENT)
        value, by_theta = self._evaluated(self.rival, theta)
        target, weights = self._target
        with np.errstate(over="ignore", invalid="ignore"):  # steps too far are cut off by `far`
            slopes = weighted(np.concatenate([response.by_theta, by_theta], axis=1), weights)
            return weighted(target - np.concatenate([response.value, value]), weights), slopes

    def _evaluated(self, refit: Refit, theta: Real) -> tuple[Complex, Complex]:
        """K and dK/dtheta where the action would measure.

        The specimen may be larger there, absent or a known mass.
        """
        scale, mass = self.action.scale, self.action.mass
        network = refit.model.network
        if scale != 1.0:
            # No specimen is one of hardly any size, as a network cannot be empty.
            network = refit.model.resized(max(scale, 1e-9), mass)
        with np.errstate(all="ignore"):
            response = network.respond(theta, self.action.points, GRADIENT)
        return response.value, response.by_theta


Pair = tuple[float, float]
"""Of the first and of the second explanation."""


def next_experiment(
    first: Refit, second: Refit, names: tuple[str, str], chances: Pair
) -> NextExperiment:
    """The action that should best separate two explanations for its effort.

    Parameters
    ----------
    first, second : Refit
        The two fitted explanations.
    names : tuple of str
        The effects that set them apart.
    chances : tuple of float
        Their probabilities: who holds decides what a measurement can show, as a larger model
        follows a smaller one.
    """
    # Of these two only: what a third would be is not what the measurement is asked.
    shares = (chances[0] / sum(chances), chances[1] / sum(chances))

    # Either may be right, and the one that is not may change all its parameters to follow.
    def linear(action: Action) -> Pair:
        return Clash(first, second, action).linear, Clash(second, first, action).linear

    def fitted(action: Action) -> Pair:
        return Clash(first, second, action).fitted(), Clash(second, first, action).fitted()

    def worth(sigmas: Pair, action: Action) -> float:
        return _expected(shares, (_enough(sigmas[0]), _enough(sigmas[1]))) / action.effort

    # Slopes first, as a fit for each action would take far longer; but a promise is made from a fit
    # only.
    feasible = {action: linear(action) for action in actions(first.fit.measurement)}
    tried = sorted(feasible, key=lambda action: -worth(feasible[action], action))[:TRIED]
    reached = {action: fitted(action) for action in tried}
    # By the better of the two ways: a larger model follows a smaller one wherever one measures.
    telling = [action for action in tried if max(reached[action]) >= EXPERIMENT.telling]
    if not telling:
        best = max(tried, key=lambda action: max(reached[action]))
        expected = separation(shares, reached[best])
        return NextExperiment(_no_use(best, names, expected), names, expected)
    best = max(telling, key=lambda action: worth(reached[action], action))
    expected = separation(shares, reached[best])
    return NextExperiment(
        f"{best.says}: {promise(names, shares, reached[best])}", names, expected, best.action
    )


def _no_use(action: Action, names: tuple[str, str], sigma: float) -> str:
    """Where one explanation follows the other everywhere, nothing is to be bought by measuring."""
    size = "less than 0.1"
    if sigma > 0.1:
        size = plain(sigma, 2)
    return (
        f"no feasible measurement tells {names[0]} from {names[1]}: even the best ({action.says})"
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


def experiment_on_confounded(measurement: Measurement, names: Sequence[str]) -> NextExperiment:
    """What to measure where a condition moved with the frequency.

    The same frequencies with the condition held.

    Parameters
    ----------
    measurement : Measurement
        The data in which it moved.
    names : sequence of str
        Effects of that condition which would explain the data.
    """
    moved, *_ = sorted(moved_along(measurement))
    middle = float(np.median(measurement.conditions[moved]))
    omega = np.exp(distinct_log_omega(measurement))[:MOST_POINTS]
    says = (
        f"measure the same frequencies at one {moved}, and again at another: only then can an"
        f" effect of it ({', '.join(names[:MOST_NAMED])}) be told from one of the frequency"
    )
    return NextExperiment(says, (), None, {"omega": omega.tolist(), moved: [middle]})


def experiment_on_points(outliers: Sequence[Outlier]) -> NextExperiment:
    """What to measure where nothing but single points is wrong.

    Parameters
    ----------
    outliers : sequence of Outlier
        The points that were set aside.
    """
    places = " and ".join(outlier.at for outlier in outliers[:MOST_NAMED])
    says = (
        f"measure again at {places}, and close beside: a bad point does not come back, an"
        " interference or a resonance does"
    )
    omega = [2.0 * np.pi * outlier.frequency * factor for outlier in outliers for factor in BESIDE]
    return NextExperiment(says, (), None, {"omega": omega})


def experiment_on_unknown(measurement: Measurement) -> NextExperiment:
    """What to measure where something is missing that no effect explains.

    Whether it is there again, and with what.

    Parameters
    ----------
    measurement : Measurement
        The data as measured, with their repeats.
    """
    longest = max(sweeps_of(measurement), key=lambda sweep: len(sweep.rows))
    # As they stand in the file, which is the order in which they were measured.
    omega = measurement.omega[np.sort(longest.rows)][:MOST_POINTS]
    again: dict[str, list[float]] = {"omega": omega[::-1].tolist()}
    # The cheapest question first: nothing else is worth asking of what is gone the next time.
    if measurement.repeat is None:
        says = (
            "measure the same points again in the opposite order: what comes back is the specimen's"
            " or the rig's, what does not is drift or ageing"
        )
        return NextExperiment(says, (), None, again)
    amplitude = spread_of(measurement, "amplitude")
    if amplitude is not None and not amplitude.varied:
        half = 0.5 * float(np.median(measurement.conditions["amplitude"]))
        says = (
            "measure the same points at half the amplitude:"
            " what then changes is no linear material's"
        )
        return NextExperiment(says, (), None, {"omega": omega.tolist(), "amplitude": [half]})
    says = (
        "measure something known in place of the specimen, such as a steel spring or a standard"
        " fluid: what it shows too is the rig's"
    )
    return NextExperiment(says, (), None)
