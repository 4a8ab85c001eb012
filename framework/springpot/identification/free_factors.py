"""Free factors of a fitted material, with what the data say about each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import Links, autocorrelation_time, student
from springpot.measurement.independence import meeting, ranges, reached_from
from springpot.measurement.measurement import Measurement
from springpot.numerics import ENDLESS, ROUNDING, Tangent, level_means
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.elements import Continuum
from springpot.rheology.levels import Levels, level_text, levels_of
from springpot.rheology.model import Model
from springpot.rheology.nodes import shift
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, INTERVAL

from .material import is_material, shifted_by
from .native import Fit, fit
from .problem import Objective, weighted
from .space import Expected, expectation

LOST = 1e-5
"""Singular value over the largest below which a direction of the factors is not determined."""


@dataclass(frozen=True, eq=False)
class Factors:
    """Factors a of frequency and b of stiffness at each level: K(omega) = b K_ref(a omega).

    Attributes
    ----------
    column : str
        The condition whose levels they are.
    levels : ndarray, shape (m,)
        The levels, temperatures in degC.
    reference : int
        Number of the level where both are one.
    log_a, log_b : ndarray, shape (m,)
        Natural logarithms; `log_b` is zero where no vertical factor was asked for.
    covariance : ndarray, shape (2 m, 2 m)
        Of `log_a`, then `log_b`.
    quantile : float
        Standard deviations to the end of an interval.
    """

    column: str
    levels: Real
    reference: int
    log_a: Real
    log_b: Real
    covariance: Real
    quantile: float

    def __len__(self) -> int:
        return len(self.levels)

    def referred_to(self, reference: int) -> Factors:
        """The same factors, one at another level."""
        m = len(self)
        # Differences to the reference: what is unsure there is passed on to all the others.
        turn = np.eye(2 * m)
        turn[:m, reference] -= 1.0
        turn[m:, m + reference] -= 1.0
        return Factors(
            self.column,
            self.levels,
            reference,
            self.log_a - self.log_a[reference],
            self.log_b - self.log_b[reference],
            turn @ self.covariance @ turn.T,
            self.quantile,
        )

    @property
    def of_modulus(self) -> Factors:
        """The factors of the modulus where these are of a compliance, its inverse."""
        turn = np.diag(np.repeat([1.0, -1.0], len(self)))
        covariance = turn @ self.covariance @ turn
        return replace(self, log_b=-self.log_b, covariance=covariance)

    @cached_property
    def reach_a(self) -> Real:
        """Half-widths (m,) of the intervals of ln a."""
        return self._reach(np.diag(self.covariance)[: len(self)])

    @cached_property
    def reach_b(self) -> Real:
        """Half-widths (m,) of the intervals of ln b."""
        return self._reach(np.diag(self.covariance)[len(self) :])

    def _reach(self, variance: Real) -> Real:
        reach = np.zeros(len(self))
        unsure = variance > 0.0
        # What is one by definition stays so where no degree of freedom is left and the quantile is
        # infinite.
        reach[unsure] = self.quantile * np.sqrt(variance[unsure])
        return reach


@dataclass(frozen=True, eq=False)
class FactorRows:
    """What the factors of a fitted model are judged by: rows of the weighted residual (2n,).

    Attributes
    ----------
    fit : Fit
        The model with its factors.
    elements : tuple of Levels
        One for each effect with factors, in the order of theta.
    own : tuple of int
        Numbers of their parameters in theta.
    number : ndarray of int, shape (n,)
        Level of each measured point.
    """

    fit: Fit
    elements: tuple[Levels, ...]
    own: tuple[int, ...]
    number: NDArray[np.int64]

    @classmethod
    def of(cls, fit: Fit, column: str = "") -> FactorRows:
        """Of a fit of a model with free factors of a column, the first one's by default."""
        column = column or columns_of_factors(fit.model)[0]
        elements: list[Levels] = []
        own: list[int] = []
        for effect in _with_factors(fit.model):
            element = effect.element
            if isinstance(element, Levels) and element.column == column:
                elements.append(element)
                own += [fit.model.names.index(name) for name in _names_of(effect)]
        number = levels_of(column, fit.measurement.points.need(column))
        return cls(fit, tuple(elements), tuple(own), number)

    @cached_property
    def expected(self) -> Expected | None:
        """What was expected of the free factors when they were fitted."""
        if self.fit.expected is None:
            return None
        first = len(self.fit.theta) - self.fit.expected.rows.shape[1]
        return self.fit.expected.of([i - first for i in self.own])

    def named(self, level: int) -> str:
        """A level with its unit."""
        first = self.elements[0]
        return level_text(first.column, first.shown[level])

    @cached_property
    def level_of_row(self) -> NDArray[np.int64]:
        """Level of each row (2n,): the real parts, then the imaginary ones."""
        return np.tile(self.number, 2)

    @cached_property
    def residual(self) -> Real:
        """Weighted residual (2n,), measured minus modelled."""
        return -self.fit.residual

    @cached_property
    def weights(self) -> NDArray[np.complex128]:
        """Weights (n,) of the real and of the imaginary parts."""
        return np.asarray(self.fit.task.weights[0], dtype=np.complex128)

    @cached_property
    def _complex_slopes(self) -> NDArray[np.complex128]:
        """Slopes (p, n) of what is compared, K or its logarithm, by the parameters."""
        model, points = self.fit.model, self.fit.measurement.points
        slopes = model.jacobian(self.fit.theta, points).T
        if self.fit.task.logarithmic:
            slopes = slopes / model.stiffness(self.fit.theta, points)
        return np.asarray(slopes, dtype=np.complex128)

    @cached_property
    def by_theta(self) -> Real:
        """Slopes (2n, p) of what is compared, weighted, by the parameters."""
        return weighted(self._complex_slopes, self.weights).T

    @cached_property
    def spectrum(self) -> Real:
        """Slopes (2n, s) by all that may follow in a factor's place.

        Of a spectrum the weights that are not zero, and the places of its lines; of other models
        and effects the parameters.
        """
        return weighted(np.concatenate([self._others, self._by_places]), self.weights).T

    @cached_property
    def bent(self) -> Real:
        """Derivative (2n, s) of the slopes by the spectrum with the logarithm of the frequency."""
        bent = np.zeros_like(self._others)
        slopes, bends = self._moved
        # A spring stays as it is, a dashpot's slope is itself, or of a compliance its negative.
        bent[1] = self.material.flow * self._others[1]
        bent[2 : 2 + len(slopes)] = np.where(self._unused[2:, None], 0.0, slopes)
        by_places = -self.fit.theta[2 : 2 + len(bends), None] * bends
        return weighted(np.concatenate([bent, by_places]), self.weights).T

    @cached_property
    def _others(self) -> NDArray[np.complex128]:
        """Slopes (s, n) by all parameters but the factors; zero by weights that are zero."""
        slopes = self._complex_slopes.copy()
        if is_material(self.fit.model):
            slopes[: len(self.fit.model.material.parameters)][self._unused] = 0.0
        return np.delete(slopes, self.own, axis=0)

    @property
    def _unused(self) -> NDArray[np.bool_]:
        return np.asarray(self.fit.theta[: len(self.fit.model.material.parameters)] == 0.0)

    @cached_property
    def _by_places(self) -> NDArray[np.complex128]:
        """Slopes (lines, n) by the logarithm of each line's rate."""
        if not is_material(self.fit.model):
            return np.zeros((0, len(self.number)), dtype=np.complex128)
        # The lines lie on a lattice; between its places the true ones may be anywhere, and that
        # makes factors less sure. A faster line does what a lower frequency does.
        slopes, _ = self._moved
        return -self.fit.theta[2 : 2 + len(slopes), None] * slopes

    @cached_property
    def _moved(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """First and second derivative (lines, n) of each line by ln omega, as it is measured."""
        # A spring adds one where a line adds its value: whatever acts on both cancels.
        spring = self._complex_slopes[0]
        lines = self._complex_slopes[2 : len(self.fit.model.material.parameters)] / spring
        slopes, bends = self.material.moved(lines)
        return slopes * spring, bends * spring

    @property
    def material(self) -> Continuum:
        """The fitted material, with its lines."""
        material = self.fit.model.material
        assert isinstance(material, Continuum)
        return material

    @cached_property
    def numbers(self) -> NDArray[np.int64]:
        """How many numbers count at each level (m,)."""
        counts = (self.weights.real != 0.0) * 1 + (self.weights.imag != 0.0)
        return np.bincount(self.number, counts).astype(np.int64)

    @cached_property
    def reduced(self) -> tuple[Real, Real]:
        """Vertical factor, and ln of the reduced angular frequency, of each point (n,)."""
        points = self.fit.measurement.points
        factor, x = np.ones(len(self.number)), points.log_omega
        start = 0
        for element in self.elements:
            stop = start + len(element.parameters)
            value = element.respond(self.fit.theta[list(self.own[start:stop])], points).value.real
            # Shifts move the logarithm of the frequency, vertical factors multiply the stiffness.
            if element.logarithmic:
                x = x + value
            else:
                factor = factor * value
            start = stop
        return factor, x

    @cached_property
    def factors(self) -> Real:
        """Slopes (2n, q) by the logarithms of the free factors."""
        own = list(self.own)
        return self.by_theta[:, own] * self.fit.theta[own]

    @cached_property
    def scale(self) -> Real:
        """Standard deviation (2n,) of each row, that of its level, degrees of freedom included.

        Given standard deviations only weigh: a factor compares sweeps of one series, and what these
        share, such as the calibration, cancels in it.
        """
        squares = level_means(self.level_of_row, self.residual**2)
        spent = len(self.residual) / max(self.fit.dof, 1)
        sd = np.maximum(np.sqrt(squares * spent), ROUNDING)
        return np.asarray(sd[self.level_of_row], dtype=np.float64)

    @cached_property
    def alike(self) -> float:
        """Factor on variances because neighbouring residuals are alike.

        (1 + r) / (1 - r) for their correlation r.
        """
        links = Links.of_levels(self.fit.measurement.omega, self.number)
        return autocorrelation_time(self.residual / self.scale, links)

    @cached_property
    def unit(self) -> float:
        """Variance of a weighted residual, by which departures from expectation are weighed."""
        return max(self.alike * self.fit.cost / max(self.fit.dof, 1), ROUNDING**2)

    @cached_property
    def objective(self) -> float:
        """What was minimised.

        The misfit, and beside it how far the factors lie from what was expected of them.
        """
        if self.expected is None:
            return self.fit.cost
        prior_residual = self.expected.weighted @ np.log(self.fit.theta[list(self.own)])
        return self.fit.cost + float(prior_residual @ prior_residual)


def columns_of_factors(model: Model) -> list[str]:
    """Columns of which the model has free factors, none of them held."""
    return list(dict.fromkeys(column for e in _with_factors(model) for column in e.needs))


def _with_factors(model: Model) -> list[Effect]:
    return [
        effect
        for effect in model.effects
        if effect.by_levels and set(_names_of(effect)) <= set(model.names)
    ]


def _names_of(effect: Effect) -> list[str]:
    return [f"{effect.name}.{parameter.name}" for parameter in effect.element.parameters]


def factors_of(rows: FactorRows) -> Factors:
    """The factors with the covariance that the exact slopes give, the spectrum free to follow.

    The scatter of each level is its own: where a level is not followed its factors are that much
    less certain. What was expected of the factors counts as measured beside the data.
    """
    return _spread(rows, _covariance(rows, rows.expected))


def told_by_data(rows: FactorRows, reference: int) -> NDArray[np.bool_]:
    """Levels (m,) whose vertical factor the data tell more nearly than was expected of it.

    All, where nothing was.

    Parameters
    ----------
    rows : FactorRows
        The fitted material with its factors.
    reference : int
        Number of the level where the factors are one.
    """
    if rows.expected is None:
        return np.ones(len(rows.elements[0].values), dtype=np.bool_)
    after = _spread(rows, _covariance(rows, None)).referred_to(reference)
    before = _spread(rows, rows.expected.covariance).referred_to(reference)
    told = after.reach_b < before.reach_b
    # There it is one by definition.
    told[reference] = True
    return np.asarray(told, dtype=np.bool_)


def _covariance(rows: FactorRows, expected: Expected | None) -> Real:
    """Covariance (q, q) of the logarithms of the free factors."""
    # What the spectrum could do in a factor's place tells nothing of the factor.
    sd = np.sqrt(rows.alike) * rows.scale
    slopes = Tangent.of(rows.spectrum).left(rows.factors)
    # The few parameters of a model with a name follow next to nothing of the noise.
    if is_material(rows.fit.model):
        slopes = _beyond_noise(slopes, _noise_of_slopes(rows, sd))
    if expected is not None:
        slopes = np.concatenate([slopes, expected.weighted])
        sd = np.concatenate([sd, np.full(len(expected.rows), np.sqrt(expected.unit))])
    size = np.linalg.norm(slopes, axis=0)
    # Of a factor of which nothing is known the slope has no size to divide by.
    size = np.maximum(size, max(ROUNDING * np.max(size), 1e-150))
    left, values, right = np.linalg.svd(slopes / size, full_matrices=False)
    known = values > LOST * values[0]
    # Least squares: u = (V / s) L' r, so that its covariance is that of r carried along.
    carry = (right[known].T / values[known]) @ left[:, known].T / size[:, None]
    covariance = (carry * sd**2) @ carry.T
    # What the data do not determine gets a deviation that nobody takes for knowledge, rather than
    # infinity, with which nothing can be computed.
    # By an orthonormal basis: which vectors span what is lost is chance.
    lost, _ = np.linalg.qr(right[~known].T / size[:, None])
    covariance = covariance + ENDLESS**2 * lost @ lost.T
    if expected is not None and expected.moved is not None:
        covariance = covariance + np.outer(expected.moved, expected.moved)
    return np.asarray(covariance, dtype=np.float64)


def _noise_of_slopes(rows: FactorRows, sd: Real) -> Real:
    """Products (q, q) of the errors of the slopes by the factors.

    The curve follows some noise, and so do they.

    A shift's slope is that of the curve, a vertical factor's the curve itself. On straight sweeps
    the one is a multiple of the other but for the noise, which would seem to tell them apart
    (errors in variables, Fuller 1987, doi:10.1002/9780470316665).

    Parameters
    ----------
    rows : FactorRows
        The fitted material with its factors.
    sd : ndarray, shape (2n,)
        Standard deviation of each row.
    """
    # By columns of one size: a line that has all but passed within the measured times is tiny, and
    # what rounding leaves of it would be taken for noise without end.
    size = np.linalg.norm(rows.spectrum, axis=0)
    size[size == 0.0] = 1.0
    basis, bent = rows.spectrum / size, rows.bent / size
    followed = Tangent.of(basis)
    # What the spectrum makes of the noise, in as many independent ways as it has.
    turn, spread, _ = np.linalg.svd(followed.back @ (followed.basis.T * sd), full_matrices=False)
    ways = turn * spread
    errors, seen, levels = [], [], []
    for element in rows.elements:
        by_level = basis @ ways
        if element.logarithmic:
            by_level = bent @ ways
        for level in element.free:
            here = np.where((rows.level_of_row == level)[:, None], by_level, 0.0)
            errors.append(here)
            seen.append((followed.basis.T @ here).ravel())
            levels.append(level)
    # Errors at different levels have no row in common; what the spectrum can do is taken out, as of
    # the slopes.
    products = -np.array(seen) @ np.array(seen).T
    for i, j in np.argwhere(np.equal.outer(levels, levels)):
        products[i, j] += np.sum(errors[i] * errors[j])
    return products


def _beyond_noise(slopes: Real, noise: Real) -> Real:
    """What slopes (m, q) tell beyond their errors, of which the products (q, q) are given.

    Of every direction the square of the slope is lessened by that of its error.
    """
    size = np.sqrt(np.sum(slopes**2, axis=0) + np.abs(np.diag(noise)))
    size = np.maximum(size, max(ROUNDING * np.max(size), 1e-150))
    power, ways = np.linalg.eigh(noise / np.outer(size, size))
    # At least a trifle, so that there is some error everywhere to be compared with.
    root = np.sqrt(np.maximum(power, LOST**2))[:, None] * ways.T * size
    left, values, right = np.linalg.svd(np.linalg.solve(root.T, slopes.T).T, full_matrices=False)
    beyond = np.sqrt(np.maximum(values**2 - 1.0, 0.0))
    return np.asarray((left * beyond) @ right @ root, dtype=np.float64)


def _spread(rows: FactorRows, covariance: Real) -> Factors:
    """Over all levels, those with the factor one included."""
    first = rows.elements[0]
    m = len(first.values)
    values, place = np.zeros(2 * m), []
    for element in rows.elements:
        # The logarithms of the shifts come first, then those of the vertical factors.
        first_place = m
        if element.logarithmic:
            first_place = 0
        place += [first_place + i for i in element.free]
    values[place] = np.log(rows.fit.theta[list(rows.own)])
    whole = np.zeros((2 * m, 2 * m))
    whole[np.ix_(place, place)] = covariance
    quantile = student(INTERVAL, rows.fit.dof)
    return Factors(
        first.column,
        np.array(first.shown),
        first.reference,
        values[:m],
        values[m:],
        whole,
        quantile,
    )


def superposed_fit(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    seeds_theta: Sequence[Real] = (),
    *,
    alone: Fit | None = None,
    unit: float | None = None,
) -> Fit:
    """A fit of a material and its shifts, free vertical factors as near to the expected as may be.

    Parameters
    ----------
    model : Model
        What is fitted; see `shifted_by`.
    measurement : Measurement
        To what.
    objective : Objective
        How points weigh; see `usual_objective`.
    seeds_theta : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    alone : Fit, optional
        The same without vertical factors, where it is known already.
    unit : float, optional
        Of a model with a law: the variance of a weighted residual that entirely free factors leave,
        where it is known already.
    """
    model = model.bound_to(measurement.points)
    lifts = [each for each in model.effects if each.by_levels and each.plane != "shift"]
    if not lifts or model.constrained:
        return fit(model, measurement, objective, seeds_theta=seeds_theta)
    # Shifts first: vertical factors could otherwise do what belongs to a shift.
    if alone is None:
        alone = fit(_without(model, lifts), measurement, objective)
    flat = _with_factors_of_one(alone, model)
    seeds = [*seeds_theta, flat.theta]
    by_law = any(not each.by_levels for each in model.effects)
    if by_law and unit is None:
        unit = _unit_of_factors(model, lifts, measurement, objective)
    if not by_law:
        free = fit(model, measurement, objective, seeds_theta=seeds)
        unit = FactorRows.of(free).unit
        seeds.append(free.theta)
    assert unit is not None
    expected = Expected(expectation(model), unit)
    best = fit(model, measurement, objective, seeds_theta=seeds, expected=expected)
    flat = replace(flat, expected=expected)
    if not _needless(FactorRows.of(flat), FactorRows.of(best)):
        return best
    # None the less they may be there: nothing is known better than they would move it.
    count = expected.rows.shape[1]
    there = (best.theta[-count:] != 0.0) & (flat.theta[-count:] != 0.0)
    moved = np.where(there, best.u[-count:] - flat.u[-count:], 0.0)
    return replace(flat, expected=replace(expected, moved=moved))


def _unit_of_factors(
    model: Model, lifts: Sequence[Effect], measurement: Measurement, objective: Objective
) -> float:
    """Variance of a weighted residual that a free factor at each level leaves in place of laws.

    Departures from the expected are weighed against it, whatever law the model has.
    """
    levels = Levels(shifted_by(model), "a", True)
    sideways = Effect("shift", shift, levels, "a factor for each level", Layer.TEMPERATURE)
    freest = replace(model, effects=(sideways, *lifts)).bound_to(measurement.points)
    flat = _with_factors_of_one(fit(_without(freest, lifts), measurement, objective), freest)
    return FactorRows.of(fit(freest, measurement, objective, seeds_theta=[flat.theta])).unit


def _without(model: Model, lifts: Sequence[Effect]) -> Model:
    return replace(model, effects=tuple(each for each in model.effects if each not in lifts))


def _with_factors_of_one(alone: Fit, model: Model) -> Fit:
    """A fit with shifts alone as one of the model with vertical factors too."""
    whole = replace(model, material=alone.model.material)
    known = alone.model.named(alone.theta)
    theta = np.array([known.get(name, 1.0) for name in whole.names])
    return replace(alone, model=whole, theta=theta)


def _together(rows: FactorRows) -> NDArray[np.bool_]:
    """Levels (m,) whose reduced frequencies meet with those of the reference, or through others."""
    return reached_from(rows.elements[0].reference, meeting(*ranges(rows.number, rows.reduced[1])))


def _needless(flat: FactorRows, best: FactorRows) -> bool:
    """Whether vertical factors of one do as well as those found."""
    # The lines are refined after the search for the factors, each time elsewhere: that can end
    # above where it began.
    if flat.objective <= best.objective:
        return True
    # A shift that tears sweeps apart leaves what they differ by to the spectrum between them.
    if not np.all(_together(flat)) and np.all(_together(best)):
        return False
    # On straight sweeps many factors follow the noise a little better than one does, and that is no
    # reason for them: by Bayes' theorem, with the likelihoods of Laplace's approximation, one does
    # unless the others are clearly better.
    assert best.expected is not None
    lifts = slice(len(best.own) - len(best.elements[-1].free), None)
    narrowed = [
        float(np.linalg.slogdet(covariance[lifts, lifts])[1])
        for covariance in (best.expected.covariance, _covariance(best, best.expected))
    ]
    gain = (flat.objective - best.objective) / best.unit
    return gain <= narrowed[0] - narrowed[1] + 2.0 * EVIDENCE.as_good
