"""A model in time: relaxation, creep and the answer to any history, with exact derivatives.

The network's exact spectrum is a sum of exponentials, of which each obeys a recursion (see
`recursion`); a spring, a dashpot and a mass act for what they are. Nothing else is approximated: no
Mittag-Leffler function is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from springpot.errors import ModelError

from ..numerics import ALIKE, HALVINGS, SMALLEST
from .motion import Between, acceleration, velocity
from .nodes import FULL, Node
from .points import HALF_PI, Points, Real
from .rational import inside, settled
from .spectrum import Slopes, Spectrum, Sum, summed
from .terms import Modes, driven

FAR = 300.0
"""Logarithm of a frequency at which a stiffness has come to its limit: 130 decades from one."""
BEYOND = 1.0
"""Share of a decade by which a band of frequencies reaches beyond the inverse of the times."""


class Traced(NamedTuple):
    """Something in time and its derivatives.

    Attributes
    ----------
    value : ndarray, shape (n,)
        At each time.
    by_theta : ndarray, shape (n, p)
        Its derivatives by the parameters.
    """

    value: Real
    by_theta: Real


@dataclass(frozen=True, eq=False)
class Retardation:
    """1/K = glass + fluidity / s + sum of weights rates / (s + rates).

    Rates of oscillations are complex.

    Attributes
    ----------
    glass, fluidity : float
        Compliance at once, and its growth in the end.
    rates, weights : ndarray, shape (m,)
        In 1/s and in the unit of 1/K.
    by_theta : Slopes
        Derivatives under the names of a spectrum: `equilibrium` is that of the glass, `viscosity`
        of the fluidity.
    """

    glass: float
    fluidity: float
    rates: Modes
    weights: Modes
    by_theta: Slopes


@dataclass(frozen=True, eq=False)
class Passive:
    """A linear network at one temperature, in time.

    Parameters
    ----------
    network : Node
        Of springs, dashpots, springpots and a mass.
    theta : ndarray, shape (p,)
        Its parameters.
    conditions : Points
        Temperature and reference temperature.
    tolerance : float
        Relative error of K, and so of what follows in time.
    """

    network: Node
    theta: Real
    conditions: Points
    tolerance: float

    @cached_property
    def parts(self) -> Sum:
        """The network taken apart."""
        return Sum.of(self.network, self.theta, self.conditions)

    @cached_property
    def yielding(self) -> Sum:
        """The same of its compliance, in p = 1/s."""
        return Sum.of(self.network, self.theta, self.conditions, compliance=True)

    def spectrum(self, shortest: float, longest: float) -> Spectrum:
        """The sum of exponentials that serves times from `shortest` to `longest`."""
        return summed(self.parts, *self._band(shortest, longest), self.tolerance, signed=True)

    def _band(self, shortest: float, longest: float) -> tuple[float, float]:
        """The band in ln omega of these times, a little wider so that one time alone has one."""
        # What happens within a time is ruled by frequencies of about one over it.
        return -float(np.log(longest)) - BEYOND, BEYOND - float(np.log(shortest))

    def limit(self, log_omega: float) -> tuple[float, Real]:
        """K where it has levelled off, far above or below all frequencies.

        0 or infinite if it never does.
        """
        # At real s, where K is real.
        where = np.array([log_omega]) - HALF_PI
        own, grown = self.parts.classical, np.zeros(len(self.theta))
        value, slopes = float(own.ends[0]), own.end_slopes[0].copy()
        if log_omega > 0:
            # Far above all rates each mode is a spring of its weight, and a dashpot is rigid.
            lines = own.lines
            value, slopes = value + lines.weights.sum(), slopes + lines.weight_slopes.sum(axis=0)
            if own.ends[1] > 0.0:
                return np.inf, grown
        with np.errstate(all="ignore"):
            for part in self.parts.parts:
                response = part.respond(where, FULL)
                # Its local power tells a part that is level from one that still falls or grows.
                power = float((response.by_log_omega[0] / response.value[0]).real)
                if abs(power) < ALIKE:
                    value, slopes = (
                        value + float(response.value[0].real),
                        slopes + response.by_theta[:, 0].real,
                    )
                elif log_omega > 0:
                    return np.inf, grown
        return value, slopes

    def relaxation(self, t: Real) -> Traced:
        """Force for a unit displacement that is held since t = 0."""
        later = t > 0.0
        value, by_theta = np.empty(len(t)), np.empty((len(t), len(self.theta)))
        if later.any():
            modes = self.spectrum(t[later].min(), t[later].max())
            fade, slopes = np.exp(-np.outer(t[later], modes.rates)), modes.by_theta
            value[later] = modes.equilibrium + fade @ modes.weights
            by_theta[later] = slopes.equilibrium + fade @ slopes.weights
            by_theta[later] -= (t[later, None] * fade * modes.weights) @ slopes.rates
        # No sum of exponentials reaches t = 0: there the force is that of K far above all
        # frequencies.
        value[~later], by_theta[~later] = self.limit(FAR)
        return Traced(value, by_theta)

    def creep(self, t: Real) -> Traced:
        """Displacement for a unit force that is held since t = 0."""
        later = t > 0.0
        value, by_theta = np.zeros(len(t)), np.zeros((len(t), len(self.theta)))
        if later.any():
            at = t[later]
            modes = self.retardation(at.min(), at.max())
            grown, slopes = -np.expm1(-np.outer(at, modes.rates)), modes.by_theta
            value[later] = modes.glass + modes.fluidity * at + (grown @ modes.weights).real
            by_theta[later] = (
                slopes.equilibrium + np.outer(at, slopes.viscosity) + (grown @ slopes.weights).real
            )
            by_theta[later] += (((1.0 - grown) * modes.weights * at[:, None]) @ slopes.rates).real
        # A mass does not move at once: zero, as it stands.
        if not later.all() and not self.inertial:
            glass, glass_slopes = self.limit(FAR)
            value[~later] = 1.0 / glass
            by_theta[~later] = -glass_slopes / glass**2
        return Traced(value, by_theta)

    @property
    def inertial(self) -> bool:
        """Whether something has a mass, so that it can swing."""
        return self.parts.classical.ends[2] > 0.0 or any(part.is_layer for part in self.parts.parts)

    def respond(
        self, t: Any, displacement: Any, *, slopes: bool = True, motion: Between | None = None
    ) -> Traced:
        """Force for a displacement that was held at its first value before.

        Straight between samples, or as a `motion` with these knots has it. Reduced times may be
        complex.
        """
        # Of the kind of the times, so that a complex one is not cast to real on its way.
        displacement = displacement.astype(t.dtype)
        steps, changes = np.diff(t, prepend=t[0]), np.diff(displacement, prepend=displacement[0])
        # Only what these samples can show is worth modes: between the finest step and the whole
        # length.
        modes = self.spectrum(*_times(t.real))
        by = modes.by_theta
        # The modes begin at rest, so that they answer to the change since the first sample alone.
        moved = displacement - displacement[0]
        # Held for ever before the first sample: all but the spring that never relaxes has gone by
        # then.
        resting, resting_slopes = self.limit(-FAR)
        if motion is None:
            moving, pushed = velocity(t, displacement), acceleration(t, displacement)
            arriving = np.diff(displacement) / steps[1:]
        else:
            moving, pushed, changes = motion.speed, motion.push, motion.changes
            arriving = motion.arriving
        value = resting * displacement[0] + modes.equilibrium * moved
        value = value + modes.viscosity * moving + modes.mass * pushed
        # What is merely faster than the samples feels the speed as it arrives, as the modes do: of
        # a layer of fluid the two nearly cancel each other. At the first sample it feels none yet.
        own = self.parts.classical
        late = np.concatenate([moving[:1], moving[1:] - arriving])
        value = value - (modes.viscosity - own.ends[1]) * late
        if not slopes:
            alone = modes.weights[:, None]
            return Traced(
                value + driven(modes.rates, steps, changes, alone, np.zeros_like(alone))[:, 0],
                np.zeros((len(t), 0)),
            )
        by_theta = resting_slopes * displacement[0] + np.outer(moved, by.equilibrium)
        by_theta = by_theta + np.outer(moving, by.viscosity) + np.outer(pushed, by.mass)
        by_theta = by_theta - np.outer(late, by.viscosity - own.end_slopes[1])
        # One pass over the samples serves the force and all of its derivatives.
        mix = np.column_stack([modes.weights, by.weights])
        rate_mix = np.column_stack([np.zeros(len(modes.rates)), modes.weights[:, None] * by.rates])
        both = driven(modes.rates, steps, changes, mix, rate_mix)
        return Traced(value + both[:, 0], by_theta + both[:, 1:])

    def relaxation_rate(self, t: Real) -> Real:
        """Derivative by time (n,) of `relaxation`, after the step."""
        modes = self.spectrum(t.min(), t.max())
        return -np.exp(-np.outer(t, modes.rates)) @ (modes.rates * modes.weights)

    def creep_rate(self, t: Real) -> Real:
        """Derivative by time (n,) of `creep`, after the step."""
        modes = self.retardation(t.min(), t.max())
        rate: Real = (
            modes.fluidity
            + (np.exp(-np.outer(t, modes.rates)) @ (modes.rates * modes.weights)).real
        )
        return rate

    def respond_force(
        self, t: Any, force: Any, *, slopes: bool = True, motion: Between | None = None
    ) -> Traced:
        """Displacement for a force that was held at its first value before; see `respond`.

        Under that a fluid would have flowed without end: it was put upon one with the first sample.

        Raises
        ------
        ModelError
            If that is asked of complex times.
        """
        force = force.astype(t.dtype)
        steps, changes = np.diff(t, prepend=t[0]), np.diff(force, prepend=force[0])
        stiffness, stiffness_slopes = self.limit(-FAR)
        # A fluid that carried nothing before the first sample was at rest there, wherever that was.
        start, start_slopes = np.zeros(len(t)), np.zeros((len(t), len(self.theta)))
        if stiffness > 0.0:
            start = start + force[0] / stiffness
            start_slopes = start_slopes - force[0] / stiffness**2 * stiffness_slopes
        elif force[0] != 0.0:
            if np.iscomplexobj(t):
                raise ModelError("a fluid under a force at once has no clock: begin at 0")
            put = self.creep(t - t[0])
            start, start_slopes = force[0] * put.value, force[0] * put.by_theta
        # Its modes follow the force as those of K follow a displacement: one recursion serves both.
        modes = self.retardation(*_times(t.real))
        by = modes.by_theta
        # What was there before has crept to its end by now: `start` holds it.
        more = force - force[0]
        # By the trapezoidal rule, which is exact for a force that is straight between samples.
        impulse = np.concatenate([[0.0], np.cumsum(0.5 * (more[1:] + more[:-1]) * steps[1:])])
        if motion is not None:
            impulse, changes = motion.impulse, motion.changes
        value = start + (modes.glass + modes.weights.sum().real) * more + modes.fluidity * impulse
        if not slopes:
            alone = -modes.weights[:, None]
            value = value + driven(modes.rates, steps, changes, alone, np.zeros_like(alone))[:, 0]
            return Traced(value, np.zeros((len(t), 0)))
        mix = -np.column_stack([modes.weights, by.weights])
        rate_mix = -np.column_stack([np.zeros(len(modes.rates)), modes.weights[:, None] * by.rates])
        both = driven(modes.rates, steps, changes, mix, rate_mix)
        by_theta = start_slopes + np.outer(more, by.equilibrium + by.weights.sum(axis=0).real)
        by_theta = by_theta + np.outer(impulse, by.viscosity)
        return Traced(value + both[:, 0].real, by_theta + both[:, 1:].real)

    def retardation(self, shortest: float, longest: float) -> Retardation:
        """The compliance as a sum of exponentials for times from `shortest` to `longest`."""
        # With a mass the compliance swings: it is no sum of decays, and its rates are complex.
        if self.inertial:
            return swinging(self.spectrum(shortest, longest))
        # 1/K of passive parts has the form of a stiffness in p = 1/s: the same rule reads its
        # spectrum.
        low, high = self._band(shortest, longest)
        compliance = summed(self.yielding, -high, -low, self.tolerance)
        # In p = 1/s: p / (p + r) is 1/r / (s + 1/r).
        rates, slopes = 1.0 / compliance.rates, compliance.by_theta
        turned = Slopes(
            slopes.equilibrium,
            slopes.viscosity,
            slopes.mass,
            -slopes.rates * rates[:, None] ** 2,
            slopes.weights,
        )
        return Retardation(
            compliance.equilibrium, compliance.viscosity, rates, compliance.weights, turned
        )


def swinging(modes: Spectrum) -> Retardation:
    """The compliance of a network with a mass, by all zeros of K(s), one pair perhaps complex."""
    s, fluidity, fluidity_slopes = _motions(modes)
    rates, weights, rate_slopes, weight_slopes = modes.modes.compliance_at(s)
    nothing = np.zeros(rate_slopes.shape[1])
    by = Slopes(nothing, fluidity_slopes, nothing, rate_slopes, weight_slopes)
    return Retardation(0.0, fluidity, rates, weights, by)


def _motions(modes: Spectrum) -> tuple[Modes, float, Real]:
    """Zeros s of K but s = 0, and the fluidity, of a fluid, that belongs to that one.

    On the negative axis K is infinite at each rate, and changes its sign there: between two of
    them, and beyond the last, the signs tell where a zero is. Two are left; sum and product of all
    zeros tell their quadratic equation.
    """
    w, r, m = modes.weights, modes.rates, modes.mass
    # A mode without weight makes K neither infinite nor change its sign: it separates no zeros.
    w, r = w[w != 0.0], r[w != 0.0]
    solid = modes.equilibrium > 0.0
    steep, _, _, steep_by_theta = modes.modes.around(np.zeros(1))
    flow = float(1.0 / steep[0]), -steep_by_theta[0] / steep[0] ** 2
    # A mass on a dashpot alone: one zero, and no modes between which others could lie.
    if not solid and not len(r):
        fluidity_slopes = -(steep_by_theta[0] / steep[0] ** 2).real
        return np.array([-modes.viscosity / m + 0j]), float(1.0 / steep[0].real), fluidity_slopes
    sides = np.sign(w)
    # What a solid and a fluid have apart: where the search begins, how many zeros there are, and
    # what stays over.
    ahead, others, start = -1.0, len(r) - 1, float(steep[0])
    if solid:
        ahead, others, start = 1.0, len(r), modes.equilibrium
    left = np.append(ahead, sides)
    right = np.append(-sides, 1.0)
    edges = np.concatenate([[-np.inf], np.log(r), [np.inf]])
    # Neighbouring modes may differ in sign (Basset): between them K need not have a zero.
    turned = left != right
    turned[0] &= solid
    low, high = edges[:-1][turned], edges[1:][turned]
    zeros = _zeros_between(modes, low, high, left[turned])
    # With one missed the pair below, which stands for what is left, would be something else
    # altogether.
    if len(zeros) != others:
        raise ModelError(
            "the mass and the material balance so nearly that their motion cannot be told"
        )
    # All zeros but two are known: K(s) = m (s^2 + b s + d) times the product of (s + zero) / (s +
    # rate).
    b = modes.viscosity / m + float(np.sum(r) - np.sum(zeros))
    paired = np.sort(zeros)
    if not solid:
        paired = np.append(paired, 1.0)
    # By logarithms, rate against zero: the products of either alone would overflow.
    d = start / m * float(np.exp(np.sum(np.log(np.sort(r)) - np.log(paired))))
    pair = _pair(modes, b, d)
    # A zero that is a rate to the last digit cancels it: that mode is too weak to move the mass.
    s = np.concatenate([-zeros[~np.isin(zeros, r)].astype(complex), pair])
    if solid:
        return s, 0.0, np.zeros_like(steep_by_theta[0])
    return s, *flow


def _pair(modes: Spectrum, b: float, d: float) -> Modes:
    """The two zeros of K near those of s^2 + b s + d, shape (2,)."""
    # Over their size: of a mass that is next to nothing the square of b would overflow.
    half, size = 0.5 * b, max(abs(0.5 * b), abs(d) ** 0.5, SMALLEST)
    root = size * np.sqrt(complex((half / size) ** 2 - d / size / size))
    pair: Modes = -half + np.array([1.0, -1.0]) * root
    # Sum and product lose digits by cancellation: Newton steps on K itself bring them back.
    for _ in range(8):
        value, slope = modes.modes.at(pair)
        pair = pair - np.nan_to_num(value / slope)
    return pair


def _zeros_between(modes: Spectrum, low: Real, high: Real, sign: Real) -> Real:
    """One r with K(-r) = 0 in each interval of ln r, at whose lower end K has that sign.

    By bisection and Newton.
    """
    if not len(low):
        return low
    if low[0] == -np.inf:
        low[0] = high[0] - 1.0
        # The outermost intervals have one end only: the other is looked for, factor e by factor e.
        while np.sign(modes.modes.at(-np.exp(low[:1]))[0][0]) != sign[0]:
            low[0] -= 1.0
    if high[-1] == np.inf:
        high[-1] = low[-1] + 1.0
        while np.sign(modes.modes.at(-np.exp(high[-1:]))[0][0]) == sign[-1]:
            high[-1] += 1.0
    # In u = ln r rates of any size are equally near, and none becomes negative.
    u = 0.5 * (low + high)
    for _ in range(HALVINGS):
        value, slope = modes.modes.at(-np.exp(u))
        before = np.sign(value) == sign
        low, high = np.where(before, u, low), np.where(before, high, u)
        moved = inside(u + value / slope * np.exp(-u), u, low, high)
        if settled(moved, u):
            break
        u = moved
    return np.exp(u)


def _times(t: Real) -> tuple[float, float]:
    """Shortest and longest time that a record shows: its finest step over pi, and its length."""
    return float(np.min(np.diff(t))) / np.pi, float(t[-1] - t[0])
