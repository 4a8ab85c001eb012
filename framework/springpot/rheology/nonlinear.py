"""Elements that depend on the amplitude, and the laws in time of what is not linear.

First harmonics (describing functions) of nonlinear forces: the displacement is x = X cos(omega t),
the force the real part of sum F_n exp(i n omega t), and K = F_1 / X. In parallel these are exact
for a sinusoidal displacement. A third harmonic is F_3 / X in the same convention.

In series with a model they are found by the balance of the first harmonics. A model and an element
that carry the same force share the displacement X: across the element lies X_e = X |K| / |K +
K_e(X_e)|, one real equation at each point. Higher harmonics of the force would move the model too;
they are left out, which is exact for weak nonlinearity and where one of the two takes nearly all of
the displacement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..numerics import ALIKE, MOST_STEPS
from .elements import RADIAN
from .grammar import Formula
from .nodes import GRADIENT, VALUE, Composing, Composition, Response, Series
from .parameters import AMPLITUDE, FORCE, PURE, Dimension, Parameter, stiffness
from .points import Complex, Points, Real
from .terms import FOUR_OVER_PI, driven, slip_fraction

Law: TypeAlias = tuple[Any, tuple[Any, ...]]


def friction_law(t: Real, x: Real, v: Real, force: float) -> Law:
    """F sgn(v)."""
    direction = np.sign(v)
    return force * direction, (direction,)


def jenkins_law(t: Real, x: Real, v: Real, k: float, force: float) -> Law:
    """A spring that slips at the force F: exact for a path that is straight between its samples.

    Notes
    -----
    The force remembers its last reversal only, so that each run in one direction is one vectorised
    step.
    """
    slider, by_k, by_force = np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x))
    # From one reversal to the next the path goes one way, and is one step.
    moves = np.sign(np.diff(x))
    turns = np.flatnonzero(np.diff(moves) != 0.0) + 1
    for first, last in zip([0, *turns], [*turns, len(x) - 1], strict=True):
        run = slice(first + 1, last + 1)
        way = x[run] - x[first]
        free = slider[first] + k * way
        slips = np.abs(free) > force
        slider[run] = np.clip(free, -force, force)
        by_k[run] = np.where(slips, 0.0, by_k[first] + way)
        by_force[run] = np.where(slips, np.sign(free), by_force[first])
    return slider, (by_k, by_force)


def jenkins_step(before: float, way: float, k: float, force: float) -> float:
    """Force of the same after one more straight way."""
    return min(max(before + k * way, -force), force)


def power_law_law(t: Real, x: Real, v: Real, force: float, exponent: float) -> Law:
    """F |v|^a sgn(v)."""
    speed = np.abs(v)
    moving = speed > 0.0
    # At rest there is no logarithm; the sign of the speed is zero there, so that any number will
    # do.
    log_speed = np.log(np.where(moving, speed, 1.0))
    unit = np.sign(v) * np.exp(exponent * log_speed)
    return force * unit, (unit, force * unit * log_speed)


def cubic_spring_law(t: Real, x: Real, v: Real, k3: float) -> Law:
    """k3 x^3."""
    return k3 * x**3, (x**3,)


def cubic_dashpot_law(t: Real, x: Real, v: Real, c3: float) -> Law:
    """c3 v^3."""
    return c3 * v**3, (v**3,)


def dead_zone_law(t: Real, x: Real, v: Real, k: float, b: float) -> Law:
    """K times the way beyond the gap."""
    beyond = np.sign(x) * np.maximum(np.abs(x) - b, 0.0)
    return k * beyond, (beyond, np.where(np.abs(x) > b, -k * np.sign(x), 0.0))


def delay(t: Real, signals: Real, tau: float) -> Law:
    """Each signal tau later; before the record begins, and after its end, it stands still."""
    before = t - tau
    late = np.stack([np.interp(before, t, column) for column in signals.T], axis=-1)
    # The derivative by the delay is minus the rate of what is delayed, which is at rest outside.
    rate = np.interp(before, t, np.gradient(signals[:, 0], t))
    moving = (before > t[0]) & (before <= t[-1])
    return late, (np.where(moving, -rate, 0.0),)


def gain(t: Real, signals: Real, g: float) -> Law:
    """1 + g times each signal."""
    return (1.0 + g) * signals, (signals[:, 0],)


def one_filter(t: Real, signals: Real, tau: float) -> Law:
    """First-order filter of the force (tau > 0), or of the displacement (tau < 0).

    Then the force seems to lead.
    """
    if tau <= 0.0:
        rate = np.gradient(signals, t, axis=0)
        # What sets off at once was at rest before, as what is late is there.
        rate[0] = 0.0
        return signals - tau * rate, (-rate[:, 0],)
    steps, size = np.diff(t, prepend=t[0]), signals.shape[1]
    one, none = np.ones((1, 1)), np.zeros((1, 1))
    rates = np.array([1.0 / tau])
    changes = np.diff(signals, axis=0, prepend=signals[:1])
    # What a filter lags behind is a mode that the signal drives: the same exact recursion as of a
    # material.
    behind = [driven(rates, steps, changes[:, i], one, none)[:, 0] for i in range(size)]
    slope = driven(rates, steps, changes[:, 0], none, one)[:, 0] / tau**2
    return signals - np.stack(behind, axis=-1), (slope,)


def delay_of_force(t: Real, signals: Real, tau: float) -> Law:
    """The displacement of a force that is recorded tau late: it seems to come tau early."""
    early, (slope,) = delay(t, signals, -tau)
    return early, (-slope,)


def gain_of_force(t: Real, signals: Real, g: float) -> Law:
    """The displacement of a force that is recorded 1 + g times as large."""
    less = signals / (1.0 + g)
    return less, (-less[:, 0] / (1.0 + g),)


def one_filter_of_force(t: Real, signals: Real, tau: float) -> Law:
    """The displacement of a force that is recorded by a filter (tau > 0), or a filtered one."""
    turned, (slope,) = one_filter(t, signals, -tau)
    return turned, (-slope,)


NEARLY_SINE = 1.0 / 12.0
"""Most that the third harmonic of filled rubber may be of dK / d ln X.

Half of what an elastic law makes (a sixth for
a cubic spring, up to a third for dry friction), which is 3 % of a force whose K falls as X^-0.35.
"""
NEEDS_AMPLITUDE = ("amplitude",)


def _friction(at: Points, force: Any) -> Any:
    unit = 1j * FOUR_OVER_PI / at.need("amplitude")
    return force * unit, (unit,), 0.0


def _friction_third(at: Points, force: Any) -> Any:
    return 1j * FOUR_OVER_PI * force / (3.0 * at.need("amplitude"))


def coulomb_friction(force: str = "F") -> Formula:
    """Dry friction, F sgn(velocity): K = i 4 F / (pi X).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, coulomb_friction
    >>> at = Points.at([1.0, 10.0], amplitude=0.5)
    >>> coulomb_friction().respond(np.array([2.0]), at).value.round(3)
    array([0.+5.093j, 0.+5.093j])
    """
    return Formula(
        (Parameter(force, "F", FORCE),),
        _friction,
        NEEDS_AMPLITUDE,
        "friction",
        _friction_third,
        friction_law,
    )


def _jenkins(at: Points, k: Any, force: Any) -> Any:
    amplitude = at.need("amplitude")
    rho = force / (k * amplitude)
    value, slope = slip_fraction(rho)
    return k * value, (value - rho * slope, slope / amplitude), 0.0


def _jenkins_third(at: Points, k: Any, force: Any) -> Any:
    # Where it sticks there is no loop: at rho = 1 the formula is zero.
    rho = np.minimum(force / (k * at.need("amplitude")), 1.0)
    turn = np.exp(-2j * np.arccos(1.0 - 2.0 * rho))
    return 1j * k * (turn - 0.5 * (1.0 + turn**2)) / (6.0 * np.pi)


def elasto_sliding(k: str = "k", force: str = "F") -> Formula:
    """A spring in series with a friction slider (Jenkins): it sticks while k X < F.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, elasto_sliding
    >>> at = Points.at([1.0, 1.0], amplitude=[0.2, 0.5])
    >>> elasto_sliding().respond(np.array([4.0, 1.0]), at).value.round(3)
    array([4.+0.j   , 2.+1.273j])
    """
    free = (stiffness(k), Parameter(force, "F", FORCE))
    return Formula(
        free,
        _jenkins,
        NEEDS_AMPLITUDE,
        "jenkins",
        _jenkins_third,
        in_time=jenkins_law,
        step=jenkins_step,
    )


def power_law(at: Points, force: Any, exponent: Any) -> Any:
    """The law of F |v|^a sgn(v): first harmonic, its derivatives by F and a, and by ln omega."""
    from scipy.special import digamma, loggamma

    amplitude = at.need("amplitude")
    half = 0.5 * exponent
    # By logarithms of the gamma function, which also take a complex exponent (tests of
    # derivatives).
    factor = 2.0 / np.sqrt(np.pi) * np.exp(loggamma(1.0 + half) - loggamma(1.5 + half))
    log_speed = at.log_omega + np.log(amplitude)
    unit = 1j * factor * np.exp(exponent * log_speed) / amplitude
    value = force * unit
    bend = log_speed + 0.5 * (digamma(1.0 + half) - digamma(1.5 + half))
    return value, (unit, value * bend), exponent * value


def _power_law_third(at: Points, force: Any, exponent: Any) -> Any:
    return power_law(at, force, exponent)[0] * (1.0 - exponent) / (3.0 + exponent)


def power_law_damper(force: str = "F", exponent: str = "a") -> Formula:
    """F |v|^a sgn(v): F is the force at a speed of one amplitude unit per second, a = 2 an orifice.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, power_law_damper
    >>> at = Points.at([2.0], amplitude=0.1)
    >>> power_law_damper().respond(np.array([3.0, 1.0]), at).value.round(6)
    array([0.+6.j])
    """
    free = (
        Parameter(force, "F", FORCE),
        Parameter(exponent, "a", PURE, 0.0, 3.0, "linear", 0.5),
    )
    return Formula(
        free, power_law, NEEDS_AMPLITUDE, "power-law damper", _power_law_third, power_law_law
    )


def _cubic_spring(at: Points, k3: Any) -> Any:
    unit = 0.75 * at.need("amplitude") ** 2
    return k3 * unit, (unit,), 0.0


def _cubic_spring_third(at: Points, k3: Any) -> Any:
    return 0.25 * k3 * at.need("amplitude") ** 2


def cubic_spring(k3: str = "k3") -> Formula:
    """Force k3 x^3, K = (3/4) k3 X^2; k3 < 0 softens.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, cubic_spring
    >>> at = Points.at([1.0, 1.0], amplitude=[1.0, 2.0])
    >>> cubic_spring().respond(np.array([4.0]), at).value.real
    array([ 3., 12.])
    """
    free = (Parameter(k3, "k₃", Dimension(stiffness=1, amplitude=-2), -np.inf, scale="linear"),)
    return Formula(
        free, _cubic_spring, NEEDS_AMPLITUDE, "cubic spring", _cubic_spring_third, cubic_spring_law
    )


def _cubic_dashpot(at: Points, c3: Any) -> Any:
    unit = 0.75j * at.omega**3 * at.need("amplitude") ** 2
    return c3 * unit, (unit,), 3.0 * c3 * unit


def _cubic_dashpot_third(at: Points, c3: Any) -> Any:
    return -0.25j * c3 * at.omega**3 * at.need("amplitude") ** 2


def cubic_dashpot(c3: str = "c3") -> Formula:
    """Force c3 v^3, K = i (3/4) c3 omega^3 X^2.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, cubic_dashpot
    >>> at = Points.at([1.0, 2.0], amplitude=1.0)
    >>> cubic_dashpot().respond(np.array([4.0]), at).value.imag.round(6)
    array([ 3., 24.])
    """
    free = (Parameter(c3, "c₃", Dimension(stiffness=1, time=3, amplitude=-2)),)
    return Formula(
        free,
        _cubic_dashpot,
        NEEDS_AMPLITUDE,
        "cubic dashpot",
        _cubic_dashpot_third,
        cubic_dashpot_law,
    )


def _gap(at: Points, b: Any) -> tuple[Any, Any]:
    """Half gap over amplitude and where the gap is open all the time."""
    ratio = b / at.need("amplitude")
    return ratio, np.real(ratio) >= 1.0


def _dead_zone(at: Points, k: Any, b: Any) -> Any:
    ratio, open_ = _gap(at, b)
    # Within the gap there is no contact, and no formula: any number stands in for it there.
    inside = np.where(open_, 0.0, ratio)
    root = np.sqrt(1.0 - inside**2)
    share = np.where(open_, 0.0, 1.0 - (np.arcsin(inside) + inside * root) * 2.0 / np.pi)
    slope = np.where(open_, 0.0, -FOUR_OVER_PI * root)
    return k * share, (share, k * slope / at.need("amplitude")), 0.0


def _dead_zone_third(at: Points, k: Any, b: Any) -> Any:
    ratio, open_ = _gap(at, b)
    # Where the gap stays open: at one the formula is zero.
    inside = np.where(open_, 1.0, ratio)
    return k * FOUR_OVER_PI / 3.0 * inside * (1.0 - inside**2) ** 1.5


def gapped_spring(k: str = "k", b: str = "b") -> Formula:
    """A spring that touches only beyond a gap of b on either side; nothing happens while X < b.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, gapped_spring
    >>> at = Points.at([1.0, 1.0], amplitude=[0.9, 10.0])
    >>> gapped_spring().respond(np.array([4.0, 1.0]), at).value.real.round(3)
    array([0.   , 3.492])
    """
    free = (stiffness(k), Parameter(b, "b", AMPLITUDE))
    return Formula(
        free, _dead_zone, NEEDS_AMPLITUDE, "gapped spring", _dead_zone_third, dead_zone_law
    )


def _payne(at: Points, k: Any, h: Any, limit: Any, m: Any) -> Any:
    # The power by its logarithm, which the derivative by m needs in any case.
    log_ratio = np.log(at.need("amplitude") / limit)
    u = np.exp(m * log_ratio)
    down = 1.0 / (1.0 + u**2)
    shape = (1.0 + 2j * h * u) * down
    # d shape / d ln u
    turn = 2j * h * u * down - 2.0 * u**2 * down * shape
    return k * shape, (shape, 2j * k * u * down, -k * turn * m / limit, k * turn * log_ratio), 0.0


def _payne_third_at_most(at: Points, k: Any, h: Any, limit: Any, m: Any) -> Any:
    by_limit = _payne(at, k, h, limit, m)[1][2]
    return NEARLY_SINE * np.abs(by_limit * limit)


def payne_softening(k: str = "k") -> Formula:
    """Filler network that breaks up (Kraus): K = k (1 + 2 i h u) / (1 + u^2), u = (X / Xc)^m.

    k is the stiffness lost at large amplitude and h k the peak of the loss, at the amplitude Xc.
    The stress of filled rubber stays a sinusoid to the eye while its moduli fall, down to 1e-5 Hz
    (doi:10.5254/rct.25.00018): its third harmonic has no formula but a bound, a share of dK / d ln
    X.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, payne_softening
    >>> at = Points.at([1.0, 1.0, 1.0], amplitude=[0.001, 1.0, 1000.0])
    >>> payne_softening().respond(np.array([2.0, 0.3, 1.0, 0.6]), at).value.round(2)
    array([2.+0.02j, 1.+0.6j , 0.+0.02j])
    """
    free = (
        stiffness(k),
        Parameter("h", "h", PURE, typical=0.3),
        Parameter("Xc", "X_c", AMPLITUDE),
        Parameter("m", "m", PURE, 0.1, 2.0, "linear", 0.6),
    )
    return Formula(free, _payne, NEEDS_AMPLITUDE, "payne", third_at_most=_payne_third_at_most)


def _leak(at: Points, force: Any, angle: Any) -> Any:
    unit = np.exp(1j * angle) / at.need("amplitude")
    return force * unit, (unit, 1j * force * unit), 0.0


def _no_third(at: Points, *_: Any) -> Any:
    # A disturbance at the test frequency has no other; without this it would count as one that is
    # not known.
    return 0.0


def crosstalk_force(force: str = "F", angle: str = "phi") -> Formula:
    """A disturbance of fixed force and phase at the test frequency, K = F exp(i phi) / X.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, crosstalk_force
    >>> at = Points.at([1.0, 1.0], amplitude=[0.1, 1.0])
    >>> crosstalk_force().respond(np.array([0.1, 0.0]), at).value.real
    array([1. , 0.1])
    """
    free = (
        Parameter(force, "F", FORCE, typical=0.1),
        Parameter(angle, "φ", RADIAN, -np.pi, np.pi, "linear", 0.0),
    )
    return Formula(free, _leak, NEEDS_AMPLITUDE, "crosstalk", _no_third)


FARTHEST = 100.0
"""Farthest that the logarithm of a part's amplitude lies from that of the whole.

Below, the part sticks, as one that yields at a steady force does. Between its two asymptotes the
equation bends one way, so that a long first step ends beyond the solution and the next ones come
back to it; this only keeps numbers finite.
"""


def _no_growth(value: Complex, *_: Real) -> Complex:
    # By its name a pickle finds it, as it would not find one without.
    return 0.0 * value


@dataclass(frozen=True)
class Compliant(Formula):
    """An element that may stand in series.

    Parameters
    ----------
    growth : callable
        ``growth(value, *parameters)`` gives dK / d ln X from K itself.
    """

    growth: Callable[..., Any] = _no_growth

    def growing(self, theta: Real, at: Points) -> tuple[Complex, Complex]:
        """K and its derivative dK / d ln X, both (..., n)."""
        value = self.respond(theta, at).value
        return value, self.growth(value, *self._columns(theta))


class BalancedSeries(Composition):
    """A model in series with an element that is not linear: 1 / K = 1 / K_a + 1 / K_e(X_e)."""

    plane, order = Series.plane, Series.order + 1
    residual, slope = staticmethod(Series.residual), staticmethod(Series.slope)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K at the displacement X_e that the element takes."""
        body_theta, own = theta[..., self.cuts[0]], theta[..., self.cuts[1]]
        # The material is linear: its K needs no amplitude, and is evaluated once for the whole
        # search of the balance.
        body = self.children[0].respond(body_theta, at, depth)
        element, slope = self._balanced(body.value, own, at, depth)
        both = body.value + element.value
        value = body.value * element.value / both
        if depth == VALUE:
            return Response(value)
        columns = (body.value, element.value, both, slope)
        alone, other, whole, steeper = (column[..., None, :] for column in columns)
        by_body, by_element = (other / whole) ** 2, (alone / whole) ** 2
        # The amplitude is real: only the real part of a relative change moves it.
        stiffening = 1.0 + np.real(steeper / whole)

        def total(of_body: Complex | float, of_element: Complex | float) -> Complex:
            """Changes (..., q, n) of the whole K; the element's share of motion moves too."""
            moved = np.real((of_body + of_element) / whole - of_body / alone)
            shift = -moved / stiffening
            return by_body * of_body + by_element * (of_element + steeper * shift)

        by_theta = np.concatenate(
            [total(body.by_theta, 0.0), total(0.0, element.by_theta)], axis=-2
        )
        if depth == GRADIENT:
            return Response(value, by_theta)
        slopes = total(body.by_log_omega[..., None, :], element.by_log_omega[..., None, :])
        return Response(value, by_theta, slopes[..., 0, :])

    def _balanced(
        self, body: Complex, own: Real, at: Points, depth: int
    ) -> tuple[Response, Complex]:
        """The element's response at the amplitude that it takes, and dK_e / d ln X_e there."""
        outer = element = self.children[1]
        theta = own
        while not isinstance(
            element, Compliant
        ):  # names in front of its parameters, values that are held
            theta, element = element.within(theta)
        # X |K| stays as it is on the way: only X_e is sought.
        log_all = np.log(at.need("amplitude"))
        log_whole = log_all + np.log(np.abs(body))
        shape = np.broadcast_shapes(body.shape, (*own.shape[:-1], 1))
        # Begun as if the element took all of the displacement.
        log_own = np.broadcast_to(log_all, shape)
        least, most = log_all - FARTHEST, log_all + FARTHEST
        low, high = np.broadcast_to(least - 1.0, shape), np.broadcast_to(most + 1.0, shape)
        step = np.full(shape, np.inf)
        for _ in range(MOST_STEPS):
            there = at.at_amplitude(np.exp(log_own))
            own_value, own_slope = element.growing(theta, there)
            both = body + own_value
            # In logarithms of the amplitude, which then cannot become negative on the way.
            off = log_own + np.log(np.abs(both)) - log_whole
            slope = 1.0 + np.real(own_slope / both)
            low, high = np.where(off < 0.0, log_own, low), np.where(off > 0.0, log_own, high)
            further = np.clip(log_own - off / slope, least, most)
            # About a bend Newton's steps go round in circles: the middle is tried instead of what
            # lies outside, or between two ends is hardly nearer.
            away = np.abs(further - log_own)
            between = (low >= least) & (high <= most)
            astray = (further < low) | (further > high) | ((away > 0.5 * step) & between)
            # Where it is found, rounding alone says on which side.
            astray &= away >= ALIKE
            further = np.where(astray, 0.5 * (low + high), further)
            step, log_own = np.abs(further - log_own), further
            if np.max(step, initial=0.0) < ALIKE:
                break
        there = at.at_amplitude(np.exp(log_own))
        # By the outer node again: the derivative is asked for by the parameters that are free.
        response = outer.respond(own, there, depth)
        return response, element.growing(theta, there)[1]


balanced_series = Composing(BalancedSeries)
"""The first node in series with a nonlinear one, a `Compliant`, the second."""


def _slip_growth(value: Any, force: Any, exponent: Any) -> Any:
    return (exponent - 1.0) * value


def slip_film(force: str = "F", exponent: str = "a") -> Compliant:
    """A film that slips at a speed which grows as the force to the power 1 / a, F |v|^a sgn(v).

    F is the force at a speed of one amplitude unit per second. a = 1 is a film of Newtonian fluid;
    molten polymers slip with 1 / a of 2 to 6.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, slip_film
    >>> at = Points.at([2.0], amplitude=0.1)
    >>> slip_film().respond(np.array([3.0, 1.0]), at).value.imag.round(3)
    array([6.])
    """
    free = (Parameter(force, "F", FORCE), Parameter(exponent, "a", PURE, 0.1, 1.0, "linear", 0.4))
    return Compliant(free, power_law, NEEDS_AMPLITUDE, "slip film", growth=_slip_growth)
