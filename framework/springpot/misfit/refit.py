"""Refits of grown models and the evidence for each.

Prediction of what a fit has not seen: inner amplitudes, temperatures or bands left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.identification.leastsquares import Effort
from springpot.identification.material import is_material, own_parameters
from springpot.identification.native import Fit, fit
from springpot.identification.problem import Objective, weighted
from springpot.identification.searching import searched
from springpot.identification.uncertainty import Uncertainty, uses_sd
from springpot.measurement.independence import frequency_numbers
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.replicates import Averaged
from springpot.measurement.scatter import Noise
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Real, real_form
from springpot.thresholds import VERDICT

from ..numerics import ROUNDING, SMALLEST
from .error import times
from .frame import NoiseFrame, able_to_follow, folds_of, folds_of_bands, phase_of

STARTS_OF_A_ROUND = 2
"""Starts in a noise that only changed its size or shape: the minima stay nearly where they are."""


@dataclass(frozen=True, eq=False)
class Refit:
    """A model fitted to averaged data in units of their noise.

    Attributes
    ----------
    fit : Fit
        The fit; its cost is the whitened residual sum of squares.
    noise : Noise
        The noise it was weighted by.
    data : Averaged
        The data, raw and averaged.
    """

    fit: Fit
    noise: Noise
    data: Averaged

    @property
    def model(self) -> Model:
        """The fitted model."""
        return self.fit.model

    @property
    def theta(self) -> Real:
        """Its parameters, shape (p,)."""
        return self.fit.theta

    @property
    def reference(self) -> float:
        """Temperature in kelvin at which shifts are one."""
        return self.fit.reference

    @property
    def rss(self) -> float:
        """Whitened residual sum of squares."""
        return self.fit.cost

    @property
    def numbers(self) -> float:
        """How many numbers it was judged by: two for each averaged point."""
        return 2.0 * len(self.fit.measurement)

    @property
    def dof(self) -> float:
        """Those less what its parameters follow, of which the lines of a spectrum need no whole."""
        return float(self.fit.dof)

    @property
    def noise_dof(self) -> float:
        """Degrees of freedom of the noise."""
        return self.noise.dof

    @cached_property
    def curve(self) -> Real:
        """K of the fitted model over the noise, shape (2n,)."""
        return weighted(self.stiffness, self.noise.weights, self.noise.turn)

    @cached_property
    def stiffness(self) -> Complex:
        """K of the fitted model at the measured points, shape (n,)."""
        return self.model.stiffness(self.theta, self.fit.measurement.points)

    @property
    def own(self) -> list[int]:
        """Numbers of the parameters that are the model's own: all but those of a free spectrum."""
        if is_material(self.model):
            return own_parameters(self.model)
        return list(range(len(self.theta)))

    @cached_property
    def lines(self) -> int:
        """Weights of a free spectrum that are above zero; none for a model with a name."""
        return len(self.theta) - len(self.own) - self.fit.silent

    @property
    def has_one_minimum(self) -> bool:
        """Whether any start leads to the same fit.

        That of a free spectrum with no effect around it is convex.
        """
        return is_material(self.model) and not self.model.effects

    def seed_from(self, other: Refit) -> Real:
        """The parameters (p,) with the values of those that another fitted model shares."""
        own, known = (one.model.named(one.theta) for one in (self, other))
        return self.model.picked(own | known)

    @cached_property
    def log_likelihood(self) -> float:
        """Log-likelihood at the fit, less what the lines of a free spectrum follow of the noise.

        Each takes one from the expected chi-square, and how many there are is chance: without this
        two fits of a material could not be compared (Meyer and Woodroofe 2000,
        doi:10.1214/aos/1015956708).
        """
        return self.noise.log_likelihood(self.fair_rss, 2 * len(self.fit.measurement))

    @cached_property
    def fair_rss(self) -> float:
        """Residual sum of squares as it would be if a free spectrum's lines followed no noise."""
        return self.fair(self.rss)

    def fair(self, rss: float) -> float:
        """What a residual sum of squares would be if a free spectrum's lines followed no noise.

        Parameters
        ----------
        rss : float
            That of this fit, or what something beside it leaves of that.
        """
        if not self.lines:
            return rss
        if self.noise.source != "estimated":
            # In units of a known noise each line takes one from chi-square, on average.
            return rss + self.lines
        # An estimated noise has taken part in the fit: only the share that is left free tells how
        # much was followed.
        spare = 2 * len(self.fit.measurement) - len(self.own)
        return rss * spare / max(spare - self.lines, 1)

    @cached_property
    def log_evidence(self) -> float:
        """Minus half the Bayesian information criterion (Schwarz 1978, doi:10.1214/aos/1176344136).

        That all models with a free spectrum share it, is no reason to prefer one of them: it costs
        them nothing.
        """
        return self.log_likelihood - 0.5 * len(self.own) * float(
            np.log(2 * len(self.fit.measurement))
        )

    @property
    def log_evidence_of_all(self) -> float:
        """The same with a price for each line, to be held beside models with a name."""
        price = float(np.log(2 * len(self.fit.measurement)))
        # Less one for each line: `fair_rss` has charged its share of chi-square already.
        return self.log_evidence - 0.5 * self.lines * (price - 1.0)

    @cached_property
    def relative_rms(self) -> float:
        """Root mean square of |K_model - K| / |K| over all rows, of the fit by the noise."""
        return self.data.relative_rms(self.model, self.theta)

    @cached_property
    def identified(self) -> Fit:
        """The model as `identify` fits it to the same rows, begun where this fit ended too.

        Quick fits end in other minima, and what a noise weighs little may be far off: an error is
        told of this one alone, whichever way a model was reached.
        """
        return searched(self.model, self.data.raw, seeds_theta=[self.theta])

    @cached_property
    def error(self) -> float:
        """Root mean square of |K_model - K| / |K| that `identify` leaves, as it is printed."""
        return self.data.relative_rms(self.identified.model, self.identified.theta)

    @cached_property
    def known(self) -> Uncertainty:
        """How surely `identify` tells its parameters.

        Where it does not fit, its misfit and not given standard deviations sets that.
        """
        fits = self.relative_rms < VERDICT.misfit * self.floor
        return replace(Uncertainty.of(self.identified), absolute=fits and uses_sd(self.identified))

    @property
    def least_error(self) -> float:
        """Below which no parameters bring the error, as none leave less in units of the noise."""
        size, parts = self.data.mean.magnitude, self.noise.parts
        # Repeats weigh their mean otherwise than the noise does: nothing is known of their error.
        if len(self.data.raw) > len(size):
            return 0.0
        quietest = min(float(np.min(parts.real / size)), float(np.min(parts.imag / size)))
        return quietest * float(np.sqrt(self.rss / len(size)))

    @property
    def floor(self) -> float:
        """The relative error that noise alone leaves, less what fitted parameters follow of it."""
        # Over the raw rows, as the error is: parameters follow means, and the scatter of repeats
        # about them stays.
        followed = 2 * len(self.fit.measurement) - max(self.fit.dof, 1)
        free = 1.0 - followed / (2 * len(self.data.raw))
        return self.data.floor(self.noise) * float(np.sqrt(free))

    @property
    def error_dof(self) -> float:
        """Degrees of freedom of `relative_rms`, in which every point counts by its own noise.

        Where few points are far noisier than all others it is as uncertain as theirs (Satterthwaite
        1946, doi:10.2307/3002019).
        """
        relative = self.noise.sd / self.data.mean.magnitude
        variances = real_form(relative) ** 2
        counts = float(np.sum(variances)) ** 2 / float(np.sum(variances**2))
        return max(self.noise.worth * self.fit.dof * counts / len(variances), 1.0)

    def without(self, rows: NDArray[np.bool_]) -> Refit:
        """The fit of all data but some of the averaged rows, (n,), from where this one ended."""
        # No further starts: a few rows less do not move the minimum far, and this is asked for many
        # times.
        return refit(
            self.model, self.data.without(rows), self.noise.of(~rows), [self.theta], starts=0
        )

    def frame(self) -> NoiseFrame:
        """The linear geometry at this fit."""
        measurement = self.fit.measurement
        # At a bound (a time of zero, a rigid spring) a derivative may have no value, and changes
        # nothing.
        with np.errstate(all="ignore"):
            response = self.model.network.respond(self.theta, measurement.points, GRADIENT)
        by_theta = np.where(np.isfinite(response.by_theta), response.by_theta, 0.0)
        left, slopes, curve = (
            weighted(each, self.noise.weights, self.noise.turn)
            for each in (measurement.stiffness - response.value, by_theta, response.value)
        )
        free = by_theta[able_to_follow(self.model, self.theta, left, slopes, curve)]
        estimated = self.noise.source == "estimated"
        return NoiseFrame(
            measurement,
            response.value,
            self.noise.weights,
            free,
            self.noise.dof,
            estimated,
            self.noise.turn,
            self.noise.memory,
            self.noise.tails,
        )

    # Asked where a point was set aside: its own noise is not known, but noise goes with |K|.
    def frame_of(self, measurement: Measurement) -> NoiseFrame:
        """The fit beside other data under the same conditions.

        Their noise is that of one row of the point of nearest |K|.
        """
        apart = np.abs(np.subtract.outer(measurement.magnitude, self.fit.measurement.magnitude))
        nearest = np.argmin(apart, axis=1)
        stiffness = self.model.stiffness(self.theta, measurement.points)
        nothing = np.zeros((0, len(measurement)), dtype=np.complex128)
        weights = (self.noise.weights / np.sqrt(self.data.count))[nearest]
        turn = None
        if self.noise.turn is not None:
            turn = np.conj(phase_of(stiffness, measurement))
        return NoiseFrame(measurement, stiffness, weights, nothing, self.noise.dof, turn=turn)


@dataclass(frozen=True, eq=False)
class OfNoise:
    """Weights (n,) that a noise gives.

    A function made on the spot would keep every fit from being pickled.
    """

    weights: Complex

    def __call__(self, measurement: Measurement) -> Complex:
        """The weights, whatever the measurement."""
        return self.weights


def noise_objective(noise: Noise) -> Objective:
    """Differences of K' and K'' in units of their noise."""
    return Objective(
        "noise",
        "the differences over the standard deviations of the noise",
        OfNoise(noise.weights),
        turn=noise.turn,
    )


def refit(
    model: Model,
    data: Averaged,
    noise: Noise,
    seeds: Sequence[Real] = (),
    starts: int = 8,
    effort: Effort | None = None,
) -> Refit:
    """Fit `model` in units of the noise.

    Parameters
    ----------
    model : Model
        What to fit.
    data : Averaged
        The data.
    noise : Noise
        The noise of their averages.
    seeds : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    starts : int
        Starts read off the data.
    effort : Effort, optional
        How far the fit goes, in units of the residual sum of squares.
    """
    found = fit(
        model,
        data.mean,
        noise_objective(noise),
        starts=starts,
        seeds_theta=list(seeds),
        effort=effort,
    )
    return Refit(found, noise, data)


def in_noise(before: Refit, noise: Noise, starts: int = STARTS_OF_A_ROUND) -> Refit:
    """A fit in units of another noise of its data, begun where it ended.

    Parameters
    ----------
    before : Refit
        The fit.
    noise : Noise
        The other noise; in one that is only smaller or larger the best fit is the same.
    starts : int
        Starts read off the data, as in a noise of another shape another minimum may be the least.
    """
    own, other = before.noise, noise
    ratios = np.concatenate([own.parts.real / other.parts.real, own.parts.imag / other.parts.imag])
    alike = own.turn is other.turn or (
        own.turn is not None and other.turn is not None and np.array_equal(own.turn, other.turn)
    )
    if not (alike and before.fit.converged and np.ptp(ratios) <= ROUNDING * ratios[0]):
        return refit(before.model, before.data, noise, [before.theta], starts)
    cost = float(np.mean(ratios)) ** 2 * before.rss
    return replace(
        before, fit=replace(before.fit, objective=noise_objective(noise), cost=cost), noise=noise
    )


def validation(base: Refit, grown: Refit) -> Iterator[str]:
    """One sentence for each condition of which several levels were measured.

    Parameters
    ----------
    base : Refit
        The user's model.
    grown : Refit
        The model with what is missing.
    """
    for name in CONDITIONS:
        folds = folds_of(base.fit.measurement, name)
        if not folds:
            continue
        # From the ends of the fits of all data: a few rows less do not move a minimum far.
        old, new = (left_out_error(fitted, folds) for fitted in (base, grown))
        word = "does not predict it better"
        if new < VERDICT.predicts_better * old:
            word = "predicts it better"
        yield (
            f"leaving out one {name} at a time, {grown.model} {word}: {times(new)} the noise"
            f" instead of {times(old)}"
        )


def prediction_gain(before: Refit, after: Refit) -> float:
    """Error of prediction after over before, where something inside the data is left out.

    One where nothing can be.

    What is physics predicts what it has not seen; a curve that was bent to a misfit does not.

    Parameters
    ----------
    before, after : Refit
        A model, and the same with an effect.
    """
    measurement = after.fit.measurement
    # A condition before the frequency: leaving out a whole level is the harder question.
    by_condition = (folds for name in CONDITIONS if (folds := folds_of(measurement, name)))
    folds = next(by_condition, folds_of_bands(frequency_numbers(measurement)))
    # Nothing to predict is no sign of physics: the rung is judged as one that gains nothing.
    if not folds:
        return 1.0
    # Both on the same data in units of the same noise: outliers may have been set aside on one rung
    # only.
    again = refit(before.model, after.data, after.noise, [before.theta], starts=2)
    return left_out_error(after, folds) / max(left_out_error(again, folds), SMALLEST)


def left_out_error(fitted: Refit, folds: list[NDArray[np.bool_]]) -> float:
    """Root mean square error, in units of the noise, of points that the fit has not seen.

    Parameters
    ----------
    fitted : Refit
        A fit of all data, from which each fit of less starts.
    folds : list of ndarray of bool, shape (n,)
        Rows to leave out.
    """
    total, count = 0.0, 0
    for fold in folds:
        less = fitted.without(fold)
        off = fitted.fit.measurement.stiffness - less.model.stiffness(
            less.theta, fitted.fit.measurement.points
        )
        # In units of the noise of all data: a fit of less has no better one.
        noise = fitted.noise
        missed = weighted(off, noise.weights, noise.turn)[np.tile(fold, 2)]
        total += float(missed @ missed)
        count += 2 * int(np.sum(fold))
    return float(np.sqrt(total / count))
