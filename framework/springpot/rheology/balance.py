"""Nonlinear elements in series with a model, by the balance of the first harmonics.

A model and an element that carry the same force share the displacement X: across the element lies
X_e = X |K| / |K + K_e(X_e)|, one real equation at each point. Higher harmonics of the force would
move the model too; they are left out, which is exact for weak nonlinearity and where one of the two
takes nearly all of the displacement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .formula import Formula
from .nodes import GRADIENT, VALUE, Composing, Composition, Response, Series
from .nonlinear import NEEDS_AMPLITUDE, power_law
from .parameters import AMPLITUDE, FORCE, PURE, Parameter, stiffness
from .points import Complex, Points, Real

NEWTON_STEPS = 40
"""Six are enough for slip with exponents from 0.1 to 1 and forces over nine decades.

The equation is monotone.
"""
LONGEST = 100.0
"""Longest step in the logarithm of the amplitude.

Between its two asymptotes the equation bends one way, so that a
long first step ends beyond the solution and the next ones come back to it; this only keeps numbers
finite.
"""
CONVERGED = 1e-8
"""Step after which only rounding is left, as Newton's method squares the error each time."""


@dataclass(frozen=True)
class Compliant(Formula):
    """An element that may stand in series.

    Parameters
    ----------
    growth : callable
        ``growth(value, *parameters)`` gives dK / d ln X from K itself.
    """

    growth: Callable[..., Any] = lambda value, *_: 0.0 * value

    def log_slope(self, theta: Real, value: Complex) -> Complex:
        """The derivative dK / d ln X where K is `value`, shape (..., n)."""
        slope: Complex = self.growth(value, *self._columns(theta))
        return slope


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
            change: Complex = by_body * of_body + by_element * (of_element + steeper * shift)
            return change

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
        log_whole = np.log(at.need("amplitude")) + np.log(np.abs(body))
        shape = np.broadcast_shapes(body.shape, (*own.shape[:-1], 1))
        # Begun as if the element took all of the displacement.
        log_own = np.broadcast_to(np.log(at.need("amplitude")), shape)
        for _ in range(NEWTON_STEPS):
            there = at.at_amplitude(np.exp(log_own))
            own_value = element.respond(theta, there).value
            both = body + own_value
            # In logarithms of the amplitude, which then cannot become negative on the way.
            off = log_own + np.log(np.abs(both)) - log_whole
            slope = 1.0 + np.real(element.log_slope(theta, own_value) / both)
            step = np.clip(-off / slope, -LONGEST, LONGEST)
            log_own = log_own + step
            if np.max(np.abs(step), initial=0.0) < CONVERGED:
                break
        there = at.at_amplitude(np.exp(log_own))
        # By the outer node again: the derivative is asked for by the parameters that are free.
        response = outer.respond(own, there, depth)
        return response, element.log_slope(theta, response.value)


balanced_series = Composing(BalancedSeries)
"""The first node in series with a nonlinear one, a `Compliant`, the second."""


def _hardening(at: Points, k: Any, doubled: Any) -> Any:
    grown = (at.need("amplitude") / doubled) ** 2
    return k * (1.0 + grown), (1.0 + grown, -2.0 * k * grown / doubled), 0.0


def _hardening_growth(value: Any, k: Any, doubled: Any) -> Any:
    return 2.0 * (value - k)


def hardening_spring(k: str = "k", doubled: str = "Xh") -> Compliant:
    """A mount k x (1 + (4/3) (x / Xh)^2), K = k (1 + (X / Xh)^2).

    At the amplitude Xh it is twice as stiff.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, hardening_spring
    >>> at = Points.at([1.0, 1.0], amplitude=[0.001, 0.5])
    >>> hardening_spring().respond(np.array([3.0, 0.5]), at).value.real.round(3)
    array([3., 6.])
    """
    free = (stiffness(k), Parameter(doubled, "X_h", AMPLITUDE))
    return Compliant(
        free, _hardening, NEEDS_AMPLITUDE, "hardening spring", growth=_hardening_growth
    )


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
