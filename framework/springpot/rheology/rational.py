"""Springs and dashpots in any arrangement, as one spring, one dashpot and Maxwell modes, exactly.

Networks in parallel add their modes; those in series add the modes of their compliances, and the
compliance of such a network is one of the same kind in p = 1/s, whose rates are the zeros of K
(they lie between its poles). All of them are found at once by Newton's method, each held between
two ends of different sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics import ROUNDING
from .elements import Continuum, FixedPower
from .grammar import Formula
from .nodes import GRADIENT, Chain, Mapped, Node, Parallel, Renamed, Scaled, Series, Shift
from .points import Points, Real
from .terms import Modes


def inside(newton: NDArray[np.inexact[Any]], u: Real, low: Real, high: Real) -> Real:
    """The next places to look at behind `u`, shape (n,).

    Newton's where it lies between the ends, else their middle.
    """
    # Newton ends in few steps, where it stays inside; half the interval always ends. Where it has
    # arrived, `u` is an end itself, and the middle would lead away again.
    within = ((newton > low) & (newton < high)) | (np.abs(newton - u) <= ROUNDING * (1 + np.abs(u)))
    return np.where(within, newton, 0.5 * (low + high))


def settled(moved: Real, u: Real) -> bool:
    """Whether no place has moved from `u` by more than rounding."""
    return bool(np.all(np.abs(moved - u) <= ROUNDING * (1.0 + np.abs(u))))


class Lines(NamedTuple):
    """Single relaxation rates with their weights, and the derivatives of both.

    Attributes
    ----------
    rates, weights : ndarray, shape (l,)
        In K = sum of weight s / (s + rate).
    rate_slopes, weight_slopes : ndarray, shape (l, p)
        Their derivatives by theta.
    """

    rates: Real
    weights: Real
    rate_slopes: Real
    weight_slopes: Real

    @classmethod
    def none(cls, count: int) -> Lines:
        """Of so many parameters no line."""
        return cls(np.zeros(0), np.zeros(0), np.zeros((0, count)), np.zeros((0, count)))

    def beside(self, other: Lines) -> Lines:
        """All of both."""
        return Lines(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))

    def some(self, which: NDArray[Any]) -> Lines:
        """Some of them, or in another order."""
        return Lines(*(field[which] for field in self))


@dataclass(frozen=True, eq=False)
class Rational:
    """K = spring + dashpot s + mass s^2 + sum of weights s / (s + rates), with its derivatives.

    Attributes
    ----------
    ends : ndarray, shape (3,)
        Constants of spring, dashpot and mass.
    end_slopes : ndarray, shape (3, p)
        Their derivatives.
    lines : Lines
        The modes.
    """

    ends: Real
    end_slopes: Real
    lines: Lines

    @classmethod
    def power(cls, exponent: int, factor: float, slope: Real) -> Rational:
        """A spring (0), a dashpot (1) or a mass (2)."""
        unit = np.eye(3)[exponent]
        return cls(factor * unit, np.outer(unit, slope), Lines.none(len(slope)))

    @classmethod
    def known(cls, ends: tuple[float, float], rates: Real, weights: Real) -> Rational:
        """Of a spring, a dashpot and lines that no parameter moves."""
        none = np.zeros((len(rates), 0))
        return cls(np.array([*ends, 0.0]), np.zeros((3, 0)), Lines(rates, weights, none, none))

    def beside(self, other: Rational) -> Rational:
        """Both in parallel."""
        ends, slopes = self.ends + other.ends, self.end_slopes + other.end_slopes
        return Rational(ends, slopes, self.lines.beside(other.lines))

    def times(self, factor: float, slope: Real) -> Rational:
        """Its stiffness multiplied by a factor with the derivative `slope`."""
        rates, weights, rate_slopes, weight_slopes = self.lines
        weight_slopes = factor * weight_slopes + weights[:, None] * slope
        end_slopes = factor * self.end_slopes + self.ends[:, None] * slope
        lines = Lines(rates, factor * weights, rate_slopes, weight_slopes)
        return Rational(factor * self.ends, end_slopes, lines)

    def slowed(self, log_shift: float, slope: Real) -> Rational:
        """Read at s exp(log_shift)."""
        factor, powers = float(np.exp(log_shift)), np.arange(3.0)
        # A stretched clock is felt as often as s stands in a term; the spring does not feel it.
        stretch, (rates, _, rate_slopes, _) = factor**powers, self.lines
        ends = self.ends * stretch
        end_slopes = self.end_slopes * stretch[:, None] + (powers * ends)[:, None] * slope
        rate_slopes = (rate_slopes - rates[:, None] * slope) / factor
        lines = self.lines._replace(rates=rates / factor, rate_slopes=rate_slopes)
        return Rational(ends, end_slopes, lines)

    @property
    def is_nothing(self) -> bool:
        """Whether it has no stiffness at all, and so no compliance."""
        return not (self.ends.any() or self.lines.weights.any())

    def at(self, s: Modes) -> tuple[Modes, Modes]:
        """K and dK/ds at s (k,), real or complex."""
        (rates, weights, _, _), away = self.lines, 1.0 / (s[:, None] + self.lines.rates)
        value = self.ends[0] + self.ends[1] * s + self.ends[2] * s**2 + s * (away @ weights)
        return value, self.ends[1] + 2.0 * self.ends[2] * s + away**2 @ (weights * rates)

    def around(self, s: Modes) -> tuple[Modes, Modes, Modes, Modes]:
        """dK/ds, d2K/ds2, dK/dtheta and d2K/ds dtheta at s (k,), real or complex."""
        (rates, weights, rate_slopes, weight_slopes), column = self.lines, s[:, None]
        away = 1.0 / (column + rates)
        kernel, fall = column * away, rates * away**2
        steep = self.ends[1] + 2.0 * self.ends[2] * s + fall @ weights
        bend = 2.0 * self.ends[2] - 2.0 * (fall * away) @ weights
        by_theta = column ** np.arange(3) @ self.end_slopes + kernel @ weight_slopes
        steep_by_theta = self.end_slopes[1] + 2.0 * column * self.end_slopes[2]
        steep_by_theta = steep_by_theta + fall @ weight_slopes
        # Given rates move with no parameter, shifted ones with those of the law alone.
        moving = rate_slopes.any(axis=0)
        moved = rate_slopes[:, moving]
        by_theta[:, moving] -= (weights * column * away**2) @ moved
        steep_by_theta[:, moving] += (weights * (column - rates) * away**3) @ moved
        return steep, bend, by_theta, steep_by_theta

    def compliance_at(self, zeros: Modes) -> Lines:
        """The terms of 1/K, weights rates / (s + rates), of zeros s (k,) of K."""
        steep, bend, by_theta, steep_by_theta = self.around(zeros)
        # K stays zero along the way of a zero, so that ds/dtheta = -(dK/dtheta) / (dK/ds).
        moved = -by_theta / steep[:, None]
        # Near a zero 1/K = 1 / (K' (s - zero)): there lies the weight of its motion.
        residue, rates = 1.0 / steep, -zeros
        slopes = -(steep_by_theta + bend[:, None] * moved) * residue[:, None] ** 2
        slopes = slopes / rates[:, None] + (residue / rates**2)[:, None] * moved
        return Lines(rates, residue / rates, -moved, slopes)  # type: ignore[arg-type]

    def inverse(self) -> Rational:
        """The compliance 1/K, without a mass, as a function of p = 1/s."""
        rates, weights, rate_slopes, weight_slopes = self.compliance_at(-self._zeros())
        # A term r / (s + r) is p / (p + 1 / r).
        rate_slopes = -rate_slopes / rates[:, None] ** 2
        return Rational(
            *self._inverse_ends(), Lines(1.0 / rates, weights, rate_slopes, weight_slopes)
        )

    def _inverse_ends(self) -> tuple[Real, Real]:
        """Instantaneous compliance and fluidity, where there are any."""
        ends, slopes = np.zeros(3), np.zeros_like(self.end_slopes)
        (spring, dashpot, _), (rates, weights, rate_slopes, weight_slopes) = self.ends, self.lines
        # Beside a dashpot nothing gives way at once, beside a spring nothing flows.
        if dashpot == 0.0:
            glass = spring + weights.sum()
            ends[0] = 1.0 / glass
            slopes[0] = -(self.end_slopes[0] + weight_slopes.sum(axis=0)) / glass**2
        if spring == 0.0:
            flow = dashpot + (weights / rates).sum()
            ends[1] = 1.0 / flow
            change = (weight_slopes / rates[:, None]).sum(axis=0)
            change = change - ((weights / rates**2)[:, None] * rate_slopes).sum(axis=0)
            slopes[1] = -(self.end_slopes[1] + change) / flow**2
        return ends, slopes

    def _zeros(self) -> Real:
        """All r > 0 at which K(-r) = 0, rising.

        One between two rates, and where a spring or a dashpot is, beyond.
        """
        spring, dashpot, _ = self.ends
        order = np.argsort(self.lines.rates)
        poles, pulls = self.lines.rates[order], self.lines.weights[order]
        # K(-r) / r is infinite at each rate, and where there is a spring at r = 0.
        if spring > 0.0:
            poles, pulls = np.append(0.0, poles), np.append(spring, pulls)
        if not len(poles):
            return poles
        low, high = poles[:-1], poles[1:]
        if dashpot > 0.0:
            # No further out than if all of it pulled from the last pole. A hundredth more than need
            # be: rounding must not leave the zero outside.
            last = poles[-1] + 1.01 * pulls.sum() / dashpot
            low, high = np.append(low, poles[-1]), np.append(high, last)
        # Two modes of one rate are one, and no zero lies between them.
        apart = high > low * (1.0 + ROUNDING)
        return _between(poles, pulls, dashpot, low[apart], high[apart])


def _between(poles: Real, pulls: Real, constant: float, low: Real, high: Real) -> Real:
    """The zero of f(r) = constant + sum of pulls / (poles - r), which rises, in each interval.

    By the middle way: a constant and the two poles at the ends, with what lies to the left and to
    the right of r in their slopes, have a zero that is the next r (Li 1993, LAPACK Working Note
    89), held by bisection.
    """
    left = poles <= low[:, None]
    # In logarithms the middle is one: rates may lie twenty decades apart, intervals be as wide.
    with np.errstate(divide="ignore"):
        ends = np.log(np.where(low > 0.0, low, 0.5 * _least(poles, pulls, constant))), np.log(high)
    u = 0.5 * (ends[0] + ends[1])
    for _ in range(100):
        r = np.exp(u)
        away = 1.0 / (poles - r[:, None])
        value, squares = constant + away @ pulls, away * away
        slope, of_left = squares @ pulls, (squares * left) @ pulls
        before, behind = low - r, high - r
        a = (before + behind) * value - before * behind * slope
        b = before * behind * value
        c = value - before * of_left - behind * (slope - of_left)
        root = np.sqrt(np.maximum(a * a - 4.0 * b * c, 0.0))
        with np.errstate(all="ignore"):
            step = np.where(a > 0.0, 2.0 * b / (a + root), (a - root) / (2.0 * c))
            wanted = np.log(r + step)
        ends = np.where(value < 0.0, u, ends[0]), np.where(value < 0.0, ends[1], u)
        moved = inside(wanted, u, *ends)
        if settled(moved, u):
            break
        u = moved
    return np.exp(u)


def _least(poles: Real, pulls: Real, constant: float) -> float:
    """An r below the zero between a pole at 0 and the next: what pulls from beyond is at most this.

    Up to half the next pole each of the others pulls no more than twice as much as at 0.
    """
    if len(poles) < 2:
        return float(pulls[0] / constant)
    others = constant + 2.0 * float((pulls[1:] / poles[1:]).sum())
    return float(min(0.5 * poles[1], pulls[0] / others))


def rational_of(node: Node, theta: Real, chain: Real, conditions: Points) -> Rational | None:
    """The modes of a network, or None if it holds anything but springs and dashpots.

    Parameters
    ----------
    node : Node
        The network.
    theta : ndarray, shape (b,)
        Its parameters.
    chain : ndarray, shape (b, p)
        Their derivative by those of the whole model.
    conditions : Points
        Temperature and reference temperature.
    """
    if isinstance(node, Renamed):
        return rational_of(node.node, theta, chain, conditions)
    if isinstance(node, Mapped):
        return rational_of(node.node, node.forward(theta), node.jacobian(theta) @ chain, conditions)
    if isinstance(node, Scaled):
        inner = rational_of(node.node, theta, chain, conditions)
        # The factor is known: it has no derivative.
        return inner and inner.times(node.factor, np.zeros(chain.shape[1]))
    if isinstance(node, FixedPower) and node.exponent in (0.0, 1.0):
        return Rational.power(int(node.exponent), float(theta[0]), chain[0])
    if isinstance(node, Formula):
        return _of_law(node, theta, chain, conditions)
    if isinstance(node, Continuum):
        # Its rates are given and not fitted: they move with no parameter.
        rates = np.array(node.rates, dtype=float)
        lines = Lines(rates, theta[2:], np.zeros((len(rates), chain.shape[1])), chain[2:])
        massless = np.zeros((1, chain.shape[1]))
        return Rational(np.append(theta[:2], 0.0), np.concatenate([chain[:2], massless]), lines)
    if isinstance(node, Parallel | Series):
        parts = zip(node.children, node.cuts, strict=True)
        modes = [rational_of(child, theta[cut], chain[cut], conditions) for child, cut in parts]
        return _together([part for part in modes if part], len(modes), isinstance(node, Series))
    if isinstance(node, Shift | Chain):
        return _carried(node, theta, chain, conditions)
    return None


ASKED = np.array([-23.0, -7.0, 0.0, 11.0, 23.0])[:, None]
"""Logarithms of frequencies at which a law is asked whether it is a spring or a dashpot."""


def _of_law(node: Formula, theta: Real, chain: Real, conditions: Points) -> Rational | None:
    """A spring or a dashpot whose constant follows a law of the conditions, as the temperature."""
    response = node.respond(theta, conditions.shifted(ASKED - conditions.log_omega), GRADIENT)
    for exponent in (0, 1):
        power = np.exp(exponent * (ASKED + 0.5j * np.pi))
        constants = response.value / power
        constant = float(constants.real.flat[0])
        if np.all(np.abs(constants - constant) <= ROUNDING * abs(constant)):
            slope = (response.by_theta[0, :, 0] / power[0]).real
            return Rational.power(exponent, constant, slope @ chain)
    return None


def _together(parts: list[Rational], count: int, in_series: bool) -> Rational | None:
    # One part that holds more than springs and dashpots makes the whole no such network.
    if len(parts) < count:
        return None
    if in_series:
        # What has no stiffness at all has no compliance that could be added.
        if any(part.is_nothing for part in parts):
            return None
        parts = [part.inverse() for part in parts]
    whole = parts[0]
    for part in parts[1:]:
        whole = whole.beside(part)
    # What was added up were compliances.
    if in_series:
        return whole.inverse()
    return whole


def _carried(node: Shift | Chain, theta: Real, chain: Real, conditions: Points) -> Rational | None:
    """A network shifted in frequency or multiplied by what is the same at all frequencies."""
    first, second = node.cuts
    inner = rational_of(node.children[0], theta[first], chain[first], conditions)
    law = node.children[1].respond(theta[second], conditions, GRADIENT)
    # Asked at two frequencies: only a law that is the same at both leaves springs and dashpots what
    # they are.
    elsewhere = node.children[1].respond(theta[second], conditions.shifted(np.ones(1)))
    if inner is None or law.value.imag.any() or law.value[0] != elsewhere.value[0]:
        return None
    slope = law.by_theta[:, 0].real @ chain[second]
    value = float(law.value[0].real)
    if isinstance(node, Shift):
        return inner.slowed(value, slope)
    return inner.times(value, slope)
