"""Springs and dashpots in any arrangement, as one spring, one dashpot and Maxwell modes, exactly.

Networks in parallel add their modes; those in series add the modes of their compliances, and the
compliance of such a network is one of the same kind in p = 1/s, whose rates are the zeros of K
(they lie between its poles). All of them are found at once by Newton's method, each held between
two ends of different sign.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .elements import Continuum, FixedPower
from .grammar import Formula
from .nodes import GRADIENT, Chain, Mapped, Node, Parallel, Renamed, Scaled, Series, Shift
from .points import Points, Real


def inside(newton: NDArray[np.inexact[Any]], u: Real, low: Real, high: Real) -> Real:
    """The next places to look at behind `u`, shape (n,).

    Newton's where it lies between the ends, else their middle.
    """
    # Newton ends in few steps, where it stays inside; half the interval always ends. Where it has
    # arrived, `u` is an end itself, and the middle would lead away again.
    within = ((newton > low) & (newton < high)) | (np.abs(newton - u) <= ROUNDING * (1 + np.abs(u)))
    return np.where(within, newton, 0.5 * (low + high))


ROUNDING = 1e-14
"""Of a place, relative: a further step would change the last digits only."""


def settled(moved: Real, u: Real) -> bool:
    """Whether no place has moved from `u` by more than rounding."""
    return bool(np.all(np.abs(moved - u) <= ROUNDING * (1.0 + np.abs(u))))


@dataclass(frozen=True, eq=False)
class Rational:
    """K = spring + dashpot s + sum of weights s / (s + rates), with derivatives by theta of each.

    Attributes
    ----------
    ends : ndarray, shape (2,)
        Spring and dashpot.
    rates, weights : ndarray, shape (l,)
        The modes.
    end_slopes : ndarray, shape (2, p)
        Derivatives of spring and dashpot.
    rate_slopes, weight_slopes : ndarray, shape (l, p)
        Derivatives of the modes.
    """

    ends: Real
    rates: Real
    weights: Real
    end_slopes: Real
    rate_slopes: Real
    weight_slopes: Real

    @classmethod
    def power(cls, exponent: int, factor: float, slope: Real) -> Rational:
        """A spring (0) or a dashpot (1)."""
        empty, end, end_slopes = np.zeros(0), np.zeros(2), np.zeros((2, len(slope)))
        end[exponent], end_slopes[exponent] = factor, slope
        none = np.zeros((0, len(slope)))
        return cls(end, empty, empty, end_slopes, none, none)

    def beside(self, other: Rational) -> Rational:
        """Both in parallel."""
        return Rational(
            self.ends + other.ends,
            np.concatenate([self.rates, other.rates]),
            np.concatenate([self.weights, other.weights]),
            self.end_slopes + other.end_slopes,
            np.concatenate([self.rate_slopes, other.rate_slopes]),
            np.concatenate([self.weight_slopes, other.weight_slopes]),
        )

    def times(self, factor: float, slope: Real) -> Rational:
        """Its stiffness multiplied by a factor with the derivative `slope`."""
        return replace(
            self,
            ends=factor * self.ends,
            weights=factor * self.weights,
            end_slopes=factor * self.end_slopes + self.ends[:, None] * slope,
            weight_slopes=factor * self.weight_slopes + self.weights[:, None] * slope,
        )

    def slowed(self, log_shift: float, slope: Real) -> Rational:
        """Read at s exp(log_shift)."""
        factor = float(np.exp(log_shift))
        stretch = np.array([[1.0], [factor]])
        # Only the dashpot, which is multiplied by s, feels a stretched clock; the spring does not.
        viscosity = np.vstack([np.zeros_like(slope), self.ends[1] * factor * slope])
        return replace(
            self,
            ends=self.ends * stretch[:, 0],
            rates=self.rates / factor,
            end_slopes=self.end_slopes * stretch + viscosity,
            rate_slopes=(self.rate_slopes - self.rates[:, None] * slope) / factor,
        )

    def inverse(self) -> Rational:
        """The compliance 1/K as a function of p = 1/s."""
        # Rates of the compliance: 1/K has a line where K is zero.
        zeros = self._zeros()
        ends, end_slopes = self._inverse_ends()
        away = 1.0 / (self.rates - zeros[:, None])
        squares = away * away
        pull = self.weights * self.rates * squares
        steep = self.ends[1] + pull.sum(axis=1)
        bend = -2.0 * (pull * away).sum(axis=1)
        # Derivatives by theta of K and of dK/ds at s = -zeros.
        by_theta = self.end_slopes[0] - zeros[:, None] * self.end_slopes[1]
        by_theta = by_theta - (zeros[:, None] * away) @ self.weight_slopes
        steep_slopes = self.end_slopes[1] + (self.rates * squares) @ self.weight_slopes
        # Given rates move with no parameter, shifted ones with those of the law alone.
        moving = self.rate_slopes.any(axis=0)
        rate_slopes = self.rate_slopes[:, moving]
        by_theta[:, moving] += (self.weights * zeros[:, None] * squares) @ rate_slopes
        cubes = squares * away
        steep_slopes[:, moving] -= (
            self.weights * (zeros[:, None] + self.rates) * cubes
        ) @ rate_slopes
        # How a zero moves, along which K stays zero.
        moved = by_theta / steep[:, None]
        residue = 1.0 / steep
        residue_slopes = -(steep_slopes - bend[:, None] * moved) * residue[:, None] ** 2
        column = zeros[:, None]
        weight_slopes = residue_slopes / column - residue[:, None] * moved / column**2
        return Rational(
            ends, 1.0 / zeros, residue / zeros, end_slopes, -moved / column**2, weight_slopes
        )

    def _inverse_ends(self) -> tuple[Real, Real]:
        """Instantaneous compliance and fluidity, where there are any."""
        ends, slopes = np.zeros(2), np.zeros_like(self.end_slopes)
        spring, dashpot = self.ends
        # Beside a dashpot nothing gives way at once, beside a spring nothing flows.
        if dashpot == 0.0:
            glass = spring + self.weights.sum()
            ends[0] = 1.0 / glass
            slopes[0] = -(self.end_slopes[0] + self.weight_slopes.sum(axis=0)) / glass**2
        if spring == 0.0:
            flow = dashpot + (self.weights / self.rates).sum()
            ends[1] = 1.0 / flow
            change = (self.weight_slopes / self.rates[:, None]).sum(axis=0)
            change = change - ((self.weights / self.rates**2)[:, None] * self.rate_slopes).sum(
                axis=0
            )
            slopes[1] = -(self.end_slopes[1] + change) / flow**2
        return ends, slopes

    def _zeros(self) -> Real:
        """All r > 0 at which K(-r) = 0, rising.

        One between two rates, and where a spring or a dashpot is, beyond.
        """
        spring, dashpot = self.ends
        order = np.argsort(self.rates)
        poles, pulls = self.rates[order], self.weights[order]
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
        return Rational(
            theta[:2],
            rates,
            theta[2:],
            chain[:2],
            np.zeros((len(rates), chain.shape[1])),
            chain[2:],
        )
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
        if any(not part.ends.any() and not part.weights.any() for part in parts):
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
