"""The exact relaxation spectrum of a model, read from its network on the negative axis of s.

A network of springs, dashpots and springpots has K(s) = K_e + c s + m s^2 + integral H(r) s/(s+r)
dln r with H(r) = Im K(r exp(i pi)) / pi >= 0 (Bernstein functions; Gross 1953; Tschoegl 1989,
10.1007/978-3-642-73602-5). The trapezoidal rule in ln r turns the integral into a sum of
exponentials with positive weights, ever so accurate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from math import log
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from springpot.errors import ModelError

from ..numerics import BEYOND, NEGLIGIBLE, ROUNDING
from .effect import Effect, Layer
from .nodes import FULL, GRADIENT, VALUE, Chain, Node, Parallel, Series, Shift
from .points import HALF_PI, ROOM, Complex, Points, Real
from .poles import (
    Anywhere,
    Branch,
    Edge,
    all_peaks_of,
    branches,
    edge_of,
    lines_of,
    needed_on,
    nodes_of,
    peaks_of,
    resolved,
)
from .rational import Lines, Rational, rational_of

if TYPE_CHECKING:
    from .named import NamedNetwork

FINEST = 2
"""Times that a smaller step is tried before an error is accepted as it is."""
NEARLY = 100.0
"""Times the tolerance by which a smaller step alone will do."""
REFUSED = 1e-2
"""Relative error of K above which a network is said to have no spectrum.

Those that have one stay far below.
"""
SCALES = np.arange(-45.0, 45.0, 0.25)
"""Twenty decades of rates either side of one, in which a model's own relaxation times are sought.
"""
NOTED = 0.05
"""Share of the largest change of that power from which a turn is a time of the model's own."""
MOST_TERMS = 60
"""Of a sum of relaxations that stands for a model: three a decade over twenty decades."""
WITHOUT_TIME = (np.log(1e-3), np.log(1e3))
"""Band in ln omega for a model that has no time of its own, such as a springpot."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Derivatives of a spectrum by the model's parameters, under the names of `Spectrum`.

    Attributes
    ----------
    equilibrium, viscosity, mass : ndarray, shape (p,)
        Derivatives of the numbers.
    rates, weights : ndarray, shape (m, p)
        Derivatives of the lists; nodes of the trapezoidal rule stay where they are.
    """

    equilibrium: Real
    viscosity: Real
    mass: Real
    rates: Real
    weights: Real


@dataclass(frozen=True, eq=False)
class Spectrum:
    """K(s) = equilibrium + viscosity s + mass s^2 + sum of weights s / (s + rates).

    Attributes
    ----------
    equilibrium : float
        The spring: what is left of the stiffness below the band, in the unit of K.
    viscosity : float
        The dashpot: with it all that relaxes faster than the band sees, in the unit of K times s.
    mass : float
        In the unit of K times s^2.
    rates : ndarray, shape (m,)
        Relaxation rates in 1/s, rising.
    weights : ndarray, shape (m,)
        Stiffness of each, never negative, in the unit of K.
    band : tuple of float
        Angular frequencies in rad/s between which the sum stands for the model.
    error : float
        Largest |dK| / |K| on the band, measured against the network itself.
    by_theta : Slopes
        Exact derivatives by the model's parameters.

    Examples
    --------
    >>> from springpot.rheology import Model, dashpot, series, spring
    >>> modes = Model("maxwell", series(spring(), dashpot())).spectrum([2.0, 8.0])
    >>> modes.stiffness([0.25])
    array([1.+1.j])
    """

    equilibrium: float
    viscosity: float
    mass: float
    rates: Real
    weights: Real
    band: tuple[float, float]
    error: float
    by_theta: Slopes

    @cached_property
    def modes(self) -> Rational:
        """The same, ready to be asked at any s."""
        by = self.by_theta
        ends = np.array([self.equilibrium, self.viscosity, self.mass])
        lines = Lines(self.rates, self.weights, by.rates, by.weights)
        return Rational(ends, np.array([by.equilibrium, by.viscosity, by.mass]), lines)

    def stiffness(self, omega: Real | float) -> Complex:
        """Complex stiffness at omega in rad/s, shape (n,)."""
        return np.asarray(self.modes.at(1j * np.atleast_1d(np.asarray(omega, dtype=float)))[0])

    def jacobian(self, omega: Real | float) -> Complex:
        """Derivative of `stiffness` by the model's parameters, shape (n, p)."""
        return np.asarray(self.modes.around(1j * np.atleast_1d(np.asarray(omega, dtype=float)))[2])


def spectrum_of(
    model: NamedNetwork,
    theta: Real,
    band: tuple[float, float] | None = None,
    *,
    tolerance: float = 1e-6,
    temperature: float | None = None,
    reference_temperature: float = ROOM,
) -> Spectrum:
    """The spectrum of a model; see `Model.spectrum`."""
    # Before anything is evaluated: here the reason is known, and need not be searched for as in
    # `blaming`.
    refuse_what_is_no_relaxation(model)
    conditions = conditions_at(temperature, reference_temperature)
    theta = np.asarray(theta, dtype=float)
    limits = None
    if band is not None:
        limits = _checked(band)
    with blaming(model, theta, conditions):
        return _spectrum(model.network, theta, conditions, limits, tolerance)


@contextmanager
def blaming(model: NamedNetwork, theta: Real, conditions: Points) -> Iterator[None]:
    """Name the part of the model that has no spectrum, where one is found to have none.

    Raises
    ------
    ModelError
        In one line.
    """
    try:
        # A network may meet a pole on the way; what comes of it is seen in the error.
        with np.errstate(all="ignore"):
            yield
    except _NoSpectrumError as fault:
        raise ModelError(_guilty(model, theta, conditions, str(fault))) from None


def conditions_at(temperature: float | None, reference_temperature: float) -> Points:
    """A temperature in kelvin, else the reference temperature, without frequencies."""
    if temperature is None:
        temperature = reference_temperature
    return Points(np.zeros(1), None, np.array([temperature]), reference_temperature)


def refuse_what_is_no_relaxation(model: NamedNetwork) -> None:
    """Refuse, by name, effects of the signal, of the amplitude and of waves.

    Raises
    ------
    ModelError
        If the model has one.
    """
    for effect in model.effects:
        reason = _reason(effect)
        if reason:
            raise ModelError(
                f"{model.name} has no relaxation spectrum: '{effect.name}' {reason}; leave it out"
                f" with model - '{effect.name}'"
            )


def _reason(effect: Effect) -> str:
    if effect.layer is Layer.SIGNAL:
        return "belongs to the signals, not to the material"
    if effect.of_test:
        return "belongs to a test, not to the material"
    if "amplitude" in effect.needs:
        return "depends on the amplitude"
    if effect.composition.kind not in (Parallel, Series, Chain, Shift):
        return "is a wave in the specimen"
    return ""


def _guilty(model: NamedNetwork, theta: Real, conditions: Points, fault: str) -> str:
    """Which part of the model has no spectrum: the first effect with which it is lost."""
    values = dict(zip(model.names, theta, strict=True))
    # What stands beside the network or in the signals is followed on its own, and is not to blame.
    linear = tuple(effect for effect in model.effects if not _reason(effect))
    parts = [model.base, *(effect.name for effect in linear)]
    guilty = parts[-1]
    for count in range(len(linear)):
        # Coarsely and at the first attempt: that there is no spectrum shows at once.
        smaller = replace(model, effects=linear[:count])
        try:
            _spectrum(
                smaller.network,
                smaller.vector({n: values[n] for n in smaller.names}),
                conditions,
                None,
                1e-3,
                1,
            )
        except _NoSpectrumError:
            guilty = parts[count]
            break
    return f"{model.name} has no relaxation spectrum: '{guilty}' {fault}"


class _NoSpectrumError(Exception):
    """A network is no passive material; says why."""


def _checked(band: tuple[float, float]) -> tuple[float, float]:
    low, high = band
    if not 0.0 < low < high < np.inf:
        raise ModelError(
            f"a band is two angular frequencies in rad/s, the lower first, not {low:g} and {high:g}"
        )
    return float(np.log(low)), float(np.log(high))


def _spectrum(
    network: Node,
    theta: Real,
    conditions: Points,
    band: tuple[float, float] | None,
    tolerance: float,
    attempts: int = FINEST,
) -> Spectrum:
    # Springs, dashpots and masses are set apart: they are exact as they are, and cost no node.
    whole = Sum.of(network, theta, conditions)
    low, high = band or whole.own_band()
    return summed(whole, low, high, tolerance, attempts=attempts)


def summed(
    whole: Sum,
    low: float,
    high: float,
    tolerance: float,
    *,
    attempts: int = FINEST,
    signed: bool = False,
) -> Spectrum:
    """The sum of exponentials for the band from exp(low) to exp(high).

    With steps as fine as the tolerance asks.

    Parameters
    ----------
    whole : Sum
        The network taken apart.
    low, high : float
        The band in ln omega.
    tolerance : float
        Relative error of K that is aimed at.
    attempts : int
        How often a smaller step may be tried.
    signed : bool
        Let a layer of fluid that is set in motion (Basset) count as modes of negative weight.
    """
    # What is cut off at the ends of the band (see `needed_on`) needs a share of the tolerance too.
    wanted = 0.3 * tolerance
    best = whole.summed(low, high, wanted, peaks_of, signed)
    for _ in range(attempts):
        if best.error <= tolerance:
            break
        # An error not far off is a step a little too wide; a large one is a peak that was not seen.
        finder = all_peaks_of
        if best.error < NEARLY * tolerance:
            finder = peaks_of
        # Half as many digits again.
        wanted = wanted**1.5
        # A finer rule is not always a better one: where rounding rules, the coarser is kept.
        best = min(
            best, whole.summed(low, high, wanted, finder, signed), key=lambda each: each.error
        )
    if np.isnan(best.error):
        raise _NoSpectrumError("has no stiffness: one of its parameters is zero or too large")
    if not best.error < REFUSED:
        raise _NoSpectrumError(f"is no sum of relaxations: they miss K by {100 * best.error:.2g} %")
    return best


PeakFinder: TypeAlias = Callable[[Branch, Edge], Complex]


@dataclass(frozen=True, eq=False)
class Sum:
    """A network taken apart.

    Its masses, springs and dashpots, and branches that hold more than these.

    Attributes
    ----------
    classical : Rational
        Branches of nothing but springs and dashpots, and those that are a mass.
    parts : sequence of Branch
        The others.
    """

    classical: Rational
    parts: Sequence[Branch]

    @classmethod
    def of(cls, network: Node, theta: Real, conditions: Points, *, compliance: bool = False) -> Sum:
        """The network's parts, in parallel or, for its compliance, in series."""
        parts, classical = [], Rational.power(0, 0.0, np.zeros(len(theta)))
        for branch in branches(network, theta, conditions, compliance=compliance):
            # Asked first: what is made of springs and dashpots has a spectrum in closed form,
            # without any rule.
            modes = rational_of(branch.node, branch.theta, branch.chain, conditions)
            # What has no stiffness at all has no compliance that could be inverted.
            if modes is not None and not (compliance and modes.is_nothing):
                if compliance:
                    modes = modes.inverse()
                classical = classical.beside(modes)
            elif branch.is_mass and not compliance:
                classical = classical.beside(Rational.power(2, *branch.mass()))
            else:
                parts.append(branch)
        return cls(classical, parts)

    @property
    def count(self) -> int:
        """How many parameters there are."""
        return int(self.classical.end_slopes.shape[1])

    @cached_property
    def _massless(self) -> Rational:
        """The classical branches without their mass, beside which nothing else would be seen."""
        return replace(self.classical, ends=self.classical.ends * (1.0, 1.0, 0.0))

    def respond(self, log_omega: Anywhere, depth: int) -> tuple[Complex, Complex]:
        """What relaxes: value (n,) and derivative (p, n)."""
        nothing = np.zeros((self.count, len(log_omega)), dtype=complex)
        responses = [part.respond(log_omega, depth) for part in self.parts]
        value = sum((each.value for each in responses), np.zeros(len(log_omega), dtype=complex))
        if depth < GRADIENT:
            return value, nothing
        return value, sum((each.by_theta for each in responses), nothing)

    def own_band(self) -> tuple[float, float]:
        """Band in ln omega that reaches two decades beyond the times of the network itself."""
        s = 1j * np.exp(SCALES)
        value, slope = self._massless.at(s)
        responses = [part.respond(SCALES, FULL) for part in self.parts]
        value = value + sum(each.value for each in responses)
        slope = slope * s + sum(each.by_log_omega for each in responses)
        # The power of omega as which |K| grows: a relaxation time is where it changes most.
        power = (slope / value).real
        change = np.abs(np.diff(power))
        # Where |K| grows as one power throughout, as of a springpot alone, no time stands out.
        largest = np.max(change)
        if not largest > NEGLIGIBLE:
            return WITHOUT_TIME
        inner = change[1:-1]
        turns = (inner >= change[:-2]) & (inner >= change[2:]) & (inner > NOTED * largest)
        at = SCALES[1:-2][turns]
        if not len(at):
            return WITHOUT_TIME
        margin = log(BEYOND)
        return float(at.min() - margin), float(at.max() + margin)

    def summed(
        self,
        low: float,
        high: float,
        tolerance: float,
        find_peaks: PeakFinder,
        signed: bool = False,
    ) -> Spectrum:
        """The sum of exponentials for the band from exp(low) to exp(high).

        The error of the rule with the step h is 2 exp(-pi^2 / h), the kernel's poles lying pi/2
        from the axis.
        """
        modes = self.classical
        if self.parts:
            others = self._modes(low, high, tolerance, find_peaks, signed)
            modes = modes.beside(Rational(*self._ends(low, high, others), others))
        # Lines and nodes come one after the other: rising, as `Spectrum` promises, they are mixed.
        lines = modes.lines.some(np.argsort(modes.lines.rates))
        slopes, (spring, dashpot, mass) = modes.end_slopes, modes.ends.tolist()
        by = Slopes(slopes[0], slopes[1], slopes[2], lines.rate_slopes, lines.weight_slopes)
        band = (float(np.exp(low)), float(np.exp(high)))
        spectrum = Spectrum(spring, dashpot, mass, lines.rates, lines.weights, band, np.inf, by)
        if not self.parts:
            # Springs and dashpots are their modes: no rule is there to err.
            if not (np.all(np.isfinite(modes.ends)) and np.all(np.isfinite(lines.weights))):
                raise _NoSpectrumError("is not finite on the band")
            return replace(spectrum, error=0.0)
        # What the rule promises holds for smooth spectra only: the error is measured against the
        # network itself.
        return replace(spectrum, error=self._error(spectrum, low, high))

    def _whole(self, log_omega: Anywhere) -> Complex:
        """K (n,) without the mass."""
        own, _ = self._massless.at(np.exp(log_omega + HALF_PI))
        return np.asarray(own + self.respond(log_omega, VALUE)[0])

    def _sizes(self, low: float, high: float) -> tuple[float, float]:
        """|K| without its mass at the ends of the band."""
        first, last = np.abs(self._whole(np.array([low, high]))).tolist()
        return first, last

    def _modes(
        self, low: float, high: float, tolerance: float, find_peaks: PeakFinder, signed: bool
    ) -> Lines:
        """Single lines of the parts, and nodes for what is spread.

        As many of them as the band needs.
        """
        margin = np.log(2.0 / tolerance)
        lines = Lines.none(self.count)
        spread, peaks = [], [np.zeros(0, dtype=complex)]
        for part in self.parts:
            edge = edge_of(part, low - margin, high + margin)
            # Lines are sharper than any step: no rule of evenly spread nodes would meet them.
            if edge.discrete:
                lines = lines.beside(lines_of(part, resolved(part, edge, high)))
            else:
                spread.append(part)
                peaks.append(find_peaks(part, edge))
        if spread:
            # With this step the rule errs by 2 exp(-margin), which is the tolerance; so little is
            # seen of what lies a margin beyond. A peak that moves by its width changes its nodes'
            # weights by all that they are: so much finer the rule is, for its derivatives.
            narrow = np.concatenate(peaks)
            sharpness = float(np.clip(narrow.imag.min(initial=1.0), ROUNDING, 1.0))
            step = np.pi**2 / (margin - np.log(sharpness))
            u, share = nodes_of(low - margin, high + margin, step, narrow)
            value, by_theta = replace(self, parts=spread).respond(u + HALF_PI, GRADIENT)
            sizes = self._sizes(low, high)
            height = value.imag / np.pi
            if not signed and np.any(height < -NEGLIGIBLE * np.abs(value) - ROUNDING * max(sizes)):
                raise _NoSpectrumError(
                    "is no passive material: weights of its relaxation would be negative"
                )
            if not signed:
                # What is left below zero is rounding: a passive material has no such weights.
                height = np.maximum(height, 0.0)
            # The nodes belong to the rule and not to the model: only their weights move with theta.
            fixed = np.zeros((len(u), self.count))
            modes = Lines(np.exp(u), share * height, fixed, (share * by_theta.imag / np.pi).T)
            # A layer of fluid also leaves a mass beside the dashpot, which takes up one power of
            # the frequency more.
            order = 2
            if any(part.is_layer for part in spread):
                order = 3
            needed = needed_on(modes, sizes, (low, high), tolerance, order)
            lines = lines.beside(modes.some(needed))
        return lines

    def _ends(self, low: float, high: float, modes: Lines) -> tuple[Real, Real]:
        """Spring, dashpot and mass for all modes slower and faster than `modes`.

        With their derivatives.

        They are told from real s, where K is real. Only a layer of fluid needs a mass.
        """
        layered = any(part.is_layer for part in self.parts)
        powers = np.arange(2.0)
        if layered:
            powers = np.arange(3.0)
        # As many places as there are unknowns, so that these follow by linear algebra alone.
        where = np.linspace(low, high, len(powers))
        s = np.exp(where)[:, None]
        value, by_theta = self.respond(where - HALF_PI, GRADIENT)
        # At real s nothing oscillates, and no phase can be: a network that has one there is no
        # material.
        if np.any(np.abs(value.imag) > NEGLIGIBLE * np.abs(value)):
            raise _NoSpectrumError(
                "is no material: without oscillation its force would not be real"
            )
        kernel = s / (s + modes.rates)
        # What the modes change by themselves is not the ends' to change once more.
        slopes = (
            kernel @ modes.weight_slopes
            - (modes.weights * kernel / (s + modes.rates)) @ modes.rate_slopes
        )
        # In units of the highest s, or the matrix would be singular to rounding.
        inverse = np.linalg.inv((s / s[-1]) ** powers) / s[-1] ** powers[:, None]
        unknowns = inverse @ (value.real - kernel @ modes.weights)
        # What rounding leaves of a spring or dashpot that is not there is none.
        least = ROUNDING * np.abs(value.real[: len(powers)]) / s[-1, 0] ** powers
        there = layered | (unknowns > least)
        ends, end_slopes = np.zeros(3), np.zeros((3, self.count))
        ends[: len(powers)] = np.where(there, unknowns, 0.0)
        end_slopes[: len(powers)] = np.where(
            there[:, None], inverse @ (by_theta.real.T - slopes), 0.0
        )
        return ends, end_slopes

    def _error(self, spectrum: Spectrum, low: float, high: float) -> float:
        grid = np.linspace(low, high, max(9, int(4 * (high - low))))
        exact = self._whole(grid)
        if not np.all(np.isfinite(exact)):
            raise _NoSpectrumError("is not finite on the band")
        # Without the mass, which is exact, and far up so large that it would hide any error of the
        # rest.
        own = spectrum.stiffness(np.exp(grid)) + self.classical.ends[2] * np.exp(2.0 * grid)
        size = np.abs(exact)
        return float(np.max(np.abs(own - exact) / np.where(size > 0.0, size, 1.0)))
