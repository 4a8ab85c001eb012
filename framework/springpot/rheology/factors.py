"""Factors of a stiffness: of the temperature, and of the chain that measures a signal."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..numerics import ALIKE, DECADE, MOST_STEPS
from .elements import delay_time
from .grammar import Formula
from .nodes import FULL, GRADIENT, VALUE, Composing, Composition, Node, Response, Shift
from .nonlinear import (
    delay as delay_law,
    delay_of_force,
    gain as gain_law,
    gain_of_force,
    one_filter as one_filter_law,
    one_filter_of_force,
)
from .parameters import PURE, Dimension, Parameter, viscosity
from .points import GAS_CONSTANT, LARGEST_SHIFT, Points, Real

NEEDS_TEMPERATURE = ("temperature",)
ACTIVATION = Dimension(label="kJ/mol")


def activation_energy(name: str = "Ea", typical: float = 50.0) -> Parameter:
    """An activation energy in kJ/mol.

    At the glass transition it is R T_g m ln 10 with the fragility m: 1,270 at 350 K for one of 190
    (Qin and McKenna 2006, doi:10.1016/j.jnoncrysol.2006.04.014).
    """
    return Parameter(name, "E_a", ACTIVATION, 0.0, 2e3, typical=typical)


def bounded_shift(value: Any, slopes: tuple[Any, ...]) -> Any:
    """The logarithm of a factor of the frequency within its bound, its slopes, and zero."""
    # Beyond the bound the slopes are zero too: a solver must not be drawn further where nothing
    # changes.
    inside = np.abs(np.real(value)) < LARGEST_SHIFT
    kept = np.where(inside, value, np.clip(np.real(value), -LARGEST_SHIFT, LARGEST_SHIFT))
    return kept, tuple(np.where(inside, slope, 0.0) for slope in slopes), 0.0


def _inverse_temperature(at: Points) -> Real:
    """(1/T - 1/Tr) / R in mol/kJ."""
    return (1.0 / at.need("temperature") - 1.0 / at.reference_temperature) / GAS_CONSTANT


def _arrhenius(at: Points, energy: Any) -> Any:
    unit = _inverse_temperature(at)
    return bounded_shift(energy * unit, (unit,))


def arrhenius(energy: str = "Ea") -> Formula:
    """Ln a_T = (Ea / R) (1/T - 1/Tr).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, arrhenius
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 30.0])
    >>> np.exp(arrhenius().respond(np.array([50.0]), at).value.real).round(3)
    array([1.   , 0.508])
    """
    return Formula((activation_energy(energy),), _arrhenius, NEEDS_TEMPERATURE, "arrhenius")


def _wlf(at: Points, c1: Any, c2: Any) -> Any:
    above = at.need("temperature") - at.reference_temperature
    # Beyond the pole the law would change its sign, and a frozen material flow at once.
    room = c2 + above
    # At and below the pole Tr - C2 the material is frozen: the shift stays at its bound.
    frozen = np.real(room) <= 1e-6
    unit = -DECADE * above / np.where(frozen, 1.0, room)
    value, slopes, flat = bounded_shift(c1 * unit, (unit, -c1 * unit / np.where(frozen, 1.0, room)))
    return (
        np.where(frozen, LARGEST_SHIFT, value),
        tuple(np.where(frozen, 0.0, s) for s in slopes),
        flat,
    )


def wlf(c1: str = "C1", c2: str = "C2") -> Formula:
    """log10 a_T = -C1 (T - Tr) / (C2 + T - Tr) (Williams, Landel and Ferry).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, wlf
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 30.0])
    >>> np.exp(wlf().respond(np.array([8.86, 101.6]), at).value.real).round(3)
    array([1.   , 0.161])
    """
    free = (
        Parameter(c1, "C₁", PURE, 0.0, 200.0, typical=10.0),
        Parameter(c2, "C₂", Dimension(label="K"), 1.0, 2000.0, typical=100.0),
    )
    return Formula(free, _wlf, NEEDS_TEMPERATURE, "wlf")


def _vogel(at: Points, b: Any, pole: Any) -> Any:
    warm, reference = at.need("temperature") - pole, at.reference_temperature - pole
    # At and below the pole T0 nothing flows any more: as in WLF the shift stays at its bound.
    frozen = np.real(np.minimum(np.real(warm), np.real(reference))) <= 1e-6
    warm, reference = (np.where(frozen, 1.0, part) for part in (warm, reference))
    unit = 1.0 / warm - 1.0 / reference
    value, slopes, flat = bounded_shift(b * unit, (unit, b * (1.0 / warm**2 - 1.0 / reference**2)))
    return (
        np.where(frozen, LARGEST_SHIFT, value),
        tuple(np.where(frozen, 0.0, s) for s in slopes),
        flat,
    )


def vogel() -> Formula:
    """Ln a_T = B / (T - T0) - B / (Tr - T0) (Vogel, Fulcher and Tammann).

    WLF with B = ln(10) C1 C2, T0 = Tr - C2.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points
    >>> from springpot.rheology.factors import vogel
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 30.0])
    >>> theta = np.array([np.log(10.0) * 8.86 * 101.6, 293.15 - 101.6])
    >>> np.exp(vogel().respond(theta, at).value.real).round(3)
    array([1.   , 0.161])
    """
    kelvin = Dimension(label="K")
    free = (
        Parameter("B", "B", kelvin, 0.0, 1e5, typical=1000.0),
        Parameter("T0", "T₀", kelvin, 0.0, 2000.0, "linear", 150.0),
    )
    return Formula(free, _vogel, NEEDS_TEMPERATURE, "vogel")


def _vertical(at: Points, n: Any) -> Any:
    log_ratio = np.log(at.need("temperature") / at.reference_temperature)
    value = np.exp(n * log_ratio)
    return value, (value * log_ratio,), 0.0


def temperature_power(n: str = "n") -> Formula:
    """b_T = (T / Tr)^n.

    n = 1 for entropic elasticity, negative where thermal expansion or softening wins.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, temperature_power
    >>> at = Points.at([1.0], temperature=30.0)
    >>> temperature_power().respond(np.array([1.0]), at).value.real.round(4)
    array([1.0341])
    """
    free = (Parameter(n, "n", PURE, -20.0, 20.0, "linear", 1.0),)
    return Formula(free, _vertical, NEEDS_TEMPERATURE, "vertical shift")


def _steady_dashpot(at: Points, c: Any) -> Any:
    # Asked for and not used: without temperatures it could not be told from a dashpot of the
    # material.
    at.need("temperature")
    s = 1j * at.omega
    return c * s, (s,), c * s


def steady_dashpot(c: str = "c") -> Formula:
    """A dashpot of the rig, the same at every temperature.

    Without temperatures it is a plain dashpot.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, steady_dashpot
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 40.0])
    >>> steady_dashpot().respond(np.array([1.0]), at).value.imag
    array([1., 1.])
    """
    return Formula((viscosity(c),), _steady_dashpot, NEEDS_TEMPERATURE, "dashpot")


def _heating(at: Points, s: Any) -> Any:
    unit = 0.5 * at.omega * at.need("amplitude") ** 2
    return s * unit, (unit,), s * unit


def _no_third(at: Points, *_: Any) -> Any:
    return 0.0


def heating(s: str = "s") -> Formula:
    """Shift in -ln omega for each unit of loss stiffness, s omega X^2 / 2.

    s is the shift per unit of power.

    The temperature that a specimen reaches in many cycles does not follow one of them, so that no
    harmonic arises.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, heating
    >>> at = Points.at([1.0, 1.0], amplitude=[1.0, 2.0])
    >>> heating().respond(np.array([0.1]), at).value.real.round(3)
    array([0.05, 0.2 ])
    """
    unit = Dimension(stiffness=-1, time=1, amplitude=-2)
    return Formula(
        (Parameter(s, "s", unit, typical=0.1),), _heating, ("amplitude",), "heating", _no_third
    )


class Heated(Composition):
    """A specimen that its own loss warms.

    K(omega exp(-h)), h = s P, P = omega K''(omega exp(-h)) X^2 / 2: the loss that warms it is that
    of the warm specimen. Of several such temperatures it is one that it comes to from the cold.
    """

    plane, order = Shift.plane, Shift.order + 1
    residual, slope = staticmethod(Shift.residual), staticmethod(Shift.slope)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K_a at the frequency that the warmer specimen feels."""
        body, heater = self.children
        base_theta, heat_theta = theta[..., self.cuts[0]], theta[..., self.cuts[1]]
        heat = heater.respond(heat_theta, at, FULL if depth > VALUE else VALUE)
        # Power and shift are real: only the loss heats, and a real temperature moves the frequency.
        factor = heat.value.real
        shift, warm = _steady(body, base_theta, at, factor)
        if depth == VALUE:
            return Response(warm.value)
        # Where the shift rests on its bound it does not follow the parameters.
        free = np.abs(shift) < (1.0 - ALIKE) * LARGEST_SHIFT
        # By so much less than its cause the shift grows, as the warm specimen loses less.
        share = np.where(free, 1.0 / _stiffened(factor, warm), 0.0)
        fall = warm.by_log_omega * share
        by_base = warm.by_theta - (fall * factor)[..., None, :] * warm.by_theta.imag
        by_heat = -(fall * warm.value.imag)[..., None, :] * heat.by_theta
        by_theta = np.concatenate([by_base, by_heat], axis=-2)
        if depth == GRADIENT:
            return Response(warm.value, by_theta)
        growth = heat.by_log_omega.real * warm.value.imag + factor * warm.by_log_omega.imag
        return Response(warm.value, by_theta, warm.by_log_omega - fall * growth)


def _stiffened(factor: Real, warm: Response) -> Real:
    """Slope by h of h - s P(h), above zero where the temperature is steady."""
    slope = 1.0 + factor * warm.by_log_omega.imag
    return np.where(slope > ALIKE, slope, 1.0)


def _steady(body: Node, theta: Real, at: Points, factor: Real) -> tuple[Real, Response]:
    """The shift h at which the loss of the warm specimen keeps it warm, and its response there.

    By Newton's method from the cold, kept between shifts that are too small and too large.
    """
    shift, settled = np.zeros_like(factor), False
    low, high, pace = shift - np.inf, shift + np.inf, shift + 1.0
    for _ in range(MOST_STEPS):
        warm = body.respond(theta, at.shifted(-shift), FULL)
        if settled:
            break
        missed = shift - factor * warm.value.imag
        low, high = np.where(missed < 0.0, shift, low), np.where(missed > 0.0, shift, high)
        # Where each rise of temperature makes loss for a larger one, steps that miss little would
        # creep past a temperature that is nearly steady.
        runs_away = 1.0 + factor * warm.by_log_omega.imag <= ALIKE
        pace = np.where(runs_away, 2.0 * pace, 1.0)
        new = shift + pace * (_nearer(shift, factor, warm) - shift)
        new = np.clip(new, -LARGEST_SHIFT, LARGEST_SHIFT)
        # A step from where nearly nothing is missed leaves no more than is rounded.
        near = np.abs(missed) <= ALIKE * (1.0 + np.abs(shift))
        beyond = (low >= LARGEST_SHIFT) | (high <= -LARGEST_SHIFT)
        middle = 0.5 * (np.maximum(low, -LARGEST_SHIFT) + np.minimum(high, LARGEST_SHIFT))
        inside = near | beyond | ((new > low) & (new < high))
        shift = np.where(beyond, shift, np.where(inside, new, middle))
        settled = bool((near | beyond).all())
    return shift, warm


def _nearer(shift: Real, factor: Real, warm: Response) -> Real:
    """The next shift of Newton's method.

    For ln h = ln(s P(h)), which is nearly straight for a loss that goes by a power of the
    frequency; for h = s P(h) from the cold.
    """
    heat = factor * warm.value.imag
    plain = shift - (shift - heat) / _stiffened(factor, warm)
    with np.errstate(all="ignore"):
        slope = 1.0 + shift * warm.by_log_omega.imag / warm.value.imag
        by_logarithms = shift * (1.0 - np.log(shift / heat) / slope)
    return np.where((shift * heat > 0.0) & (slope > ALIKE), by_logarithms, plain)


heated = Composing(Heated)
"""The first node warmed by its own loss; the second gives the shift per loss stiffness."""


def _delay(at: Points, tau: Any) -> Any:
    s = 1j * at.omega
    value = np.exp(-s * tau)
    return value, (-s * value,), -s * tau * value


def delay(tau: str = "tau") -> Formula:
    """exp(-s tau): the force signal comes tau late (early where tau < 0).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, delay
    >>> np.angle(delay().respond(np.array([0.001]), Points.at([10.0, 100.0])).value)
    array([-0.01, -0.1 ])
    """
    return Formula(
        (delay_time(tau),), _delay, kind="delay", in_time=delay_law, under_force=delay_of_force
    )


def _gain(at: Points, g: Any) -> Any:
    return 1.0 + g, (1.0,), 0.0


def gain(g: str = "g") -> Formula:
    """1 + g: calibration, area or gap wrong by the fraction g.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, gain
    >>> gain().respond(np.array([0.05]), Points.at([10.0])).value.real
    array([1.05])
    """
    return Formula(
        (Parameter(g, "g", PURE, -0.99, scale="linear", typical=0.5),),
        _gain,
        kind="gain",
        in_time=gain_law,
        under_force=gain_of_force,
    )


def _filter(at: Points, tau: Any) -> Any:
    s = 1j * at.omega
    late = np.real(tau) >= 0.0
    whole = 1.0 + s * np.where(late, tau, -tau)
    # A slow force channel divides, a slow displacement channel multiplies.
    value = np.where(late, 1.0 / whole, whole)
    by_tau = np.where(late, -s / whole**2, -s)
    return value, (by_tau,), tau * by_tau


def filter_mismatch(tau: str = "tau") -> Formula:
    """A first-order filter tau in one channel only.

    Force where tau > 0, displacement where tau < 0.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, filter_mismatch
    >>> np.abs(filter_mismatch().respond(np.array([0.01]), Points.at([1.0, 100.0])).value).round(3)
    array([1.   , 0.707])
    """
    return Formula(
        (delay_time(tau),),
        _filter,
        kind="filter",
        in_time=one_filter_law,
        under_force=one_filter_of_force,
    )
