"""Search forms: the parameters a paper searches, beside those of the elements.

The paper searches (k0, kinf, tau, alpha) and maps to (k1, k2, c, alpha): eq.
(6), (9), (20), (21), (34), (35), (45)-(49).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .parameters import Parameter, order, relaxation_time, stiffness
from .points import Real

MARGIN = 1.01
"""The paper's repair of a violated kinf > k0: kinf becomes 1.01 k0 (section 4)."""


@dataclass(frozen=True)
class SearchForm:
    """Parameters to search in, with the exact map to the element parameters.

    Parameters
    ----------
    parameters : tuple of Parameter
        What is searched.
    to_elements : callable
        (..., q) to (..., p).
    jacobian : callable
        (..., q) to (..., p, q).
    from_elements : callable
        (..., p) to (..., q).
    ordered : tuple of int or None
        Indices (low, high) of two searched stiffnesses (or orders) of which the second must exceed
        the first.
    margin : float
        Where it does not, it becomes `margin` times the first: 1.01 in the paper, 1 for orders,
        which may be equal.
    """

    parameters: tuple[Parameter, ...]
    to_elements: Callable[[Real], Real]
    jacobian: Callable[[Real], Real]
    from_elements: Callable[[Real], Real]
    ordered: tuple[int, int] | None = None
    margin: float = MARGIN

    def repaired(self, x: Real) -> Real:
        """`x` with kinf = 1.01 k0 wherever kinf > k0 is violated (and likewise for orders)."""
        if self.ordered is None:
            return x
        low, high = self.ordered
        violated = x[..., high] <= x[..., low]
        # Most points keep the order: they are spared a copy.
        if not violated.any():
            return x
        mended = x.copy(order="K")
        mended[..., high] = np.where(violated, self.margin * x[..., low], x[..., high])
        return mended


def columns(*parts: Real | float) -> Real:
    """Parameter vectors (..., p) from their p components, each (...) or a number.

    Complex ones stay complex.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import columns
    >>> columns(np.array([1.0, 2.0]), 5.0)
    array([[1., 5.],
           [2., 5.]])
    """
    if not any(isinstance(part, np.ndarray) and part.ndim for part in parts):
        return np.array(parts) * 1.0
    # Each component lies side by side, as the elements take them.
    lead = np.broadcast_shapes(*(np.shape(part) for part in parts))
    x = np.empty((len(parts), *lead), np.result_type(float, *parts))
    for component, part in zip(x, parts, strict=True):
        component[...] = part
    return x.transpose(*range(1, x.ndim), 0)


def components(x: Real) -> Real:
    """The components (p, ...) of parameter vectors (..., p)."""
    # By hand, for `moveaxis` takes longer than an element.
    return x.transpose(-1, *range(x.ndim - 1))


def rows(*parts: Real) -> Real:
    """Jacobian (..., p, q) from its p rows (..., q).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import rows
    >>> rows(np.array([1.0, 0.0]), np.array([2.0, 3.0]))
    array([[1., 0.],
           [2., 3.]])
    """
    return np.stack(np.broadcast_arrays(*parts), axis=-2)


# The maps are functions of the module, so that a fit of a model that has one can be pickled.


def _time_to_elements(x: Real) -> Real:
    k, tau, alpha = components(x)
    # The springpot is as stiff as the spring at omega = 1 / tau: (c / k) = tau^alpha.
    return columns(k, k * tau**alpha, alpha)


def _time_jacobian(x: Real) -> Real:
    k, tau, alpha = components(x)
    power = tau**alpha
    c = k * power
    one, nil = np.ones_like(k), np.zeros_like(k)
    return rows(
        columns(one, nil, nil),
        columns(power, alpha * c / tau, c * np.log(tau)),
        columns(nil, nil, one),
    )


def _time_from_elements(theta: Real) -> Real:
    k, c, alpha = components(theta)
    return columns(k, (c / k) ** (1.0 / alpha), alpha)


def _maxwell_to_elements(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    return columns(k0, kinf - k0, tau**alpha * (kinf - k0), alpha)


def _maxwell_jacobian(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    power = tau**alpha
    c = power * (kinf - k0)
    one, nil = np.ones_like(k0), np.zeros_like(k0)
    return rows(
        columns(one, nil, nil, nil),
        columns(-one, one, nil, nil),
        columns(-power, power, alpha * c / tau, c * np.log(tau)),
        columns(nil, nil, nil, one),
    )


def _maxwell_from_elements(theta: Real) -> Real:
    k1, k2, c, alpha = components(theta)
    return columns(k1, k1 + k2, (c / k2) ** (1.0 / alpha), alpha)


def _kelvin_to_elements(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    gap = kinf - k0
    return columns(kinf, k0 * kinf / gap, tau**alpha * kinf**2 / gap, alpha)


def _kelvin_jacobian(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    gap = kinf - k0
    power = tau**alpha
    c = power * kinf**2 / gap
    one, nil = np.ones_like(k0), np.zeros_like(k0)
    return rows(
        columns(nil, one, nil, nil),
        columns((kinf / gap) ** 2, -((k0 / gap) ** 2), nil, nil),
        columns(c / gap, power * kinf * (kinf - 2 * k0) / gap**2, alpha * c / tau, c * np.log(tau)),
        columns(nil, nil, nil, one),
    )


def _kelvin_from_elements(theta: Real) -> Real:
    k1, k2, c, alpha = components(theta)
    return columns(k1 * k2 / (k1 + k2), k1, (c / (k1 + k2)) ** (1.0 / alpha), alpha)


def _limits() -> tuple[Parameter, ...]:
    return (stiffness("k0", "k₀"), stiffness("kinf", "k∞"), relaxation_time(), order())


@dataclass(frozen=True)
class _Limits:
    """The maps of `limits_form` for p parameters."""

    count: int

    def to_elements(self, x: Real) -> Real:
        return columns(x[..., 0], x[..., 1] - x[..., 0], *np.moveaxis(x[..., 2:], -1, 0))

    def jacobian(self, x: Real) -> Real:
        step = np.eye(self.count)
        step[1, 0] = -1.0
        return np.broadcast_to(step, (*x.shape[:-1], *step.shape))

    def from_elements(self, theta: Real) -> Real:
        return columns(
            theta[..., 0], theta[..., 0] + theta[..., 1], *np.moveaxis(theta[..., 2:], -1, 0)
        )


def limits_form(parameters: tuple[Parameter, ...]) -> SearchForm:
    """The form (k0, kinf, ...) of a model whose parameters are (k0, k1, ...) with kinf = k0 + k1.

    Parameters
    ----------
    parameters : tuple of Parameter
        The model's; all but the second are searched as they are.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import limits_form, stiffness
    >>> limits_form((stiffness("k0"), stiffness("k1"))).to_elements(np.array([2.0, 5.0]))
    array([2., 3.])
    """
    searched = (*_limits()[:2], *parameters[2:])
    maps = _Limits(len(parameters))
    return SearchForm(searched, maps.to_elements, maps.jacobian, maps.from_elements, ordered=(0, 1))


TIME_FORM = SearchForm(
    (stiffness("k"), relaxation_time(), order()),
    _time_to_elements,
    _time_jacobian,
    _time_from_elements,
)
"""(k, tau, alpha) of the three-parameter models, tau^alpha = c / k; eq. (20), (21), (33)."""
MAXWELL_FORM = SearchForm(
    _limits(), _maxwell_to_elements, _maxwell_jacobian, _maxwell_from_elements, ordered=(0, 1)
)
"""(k0, kinf, tau, alpha) of the Maxwell type: k1 = k0, k2 = kinf - k0, c = tau^alpha k2; eq.

(9), (35).
"""
KELVIN_FORM = SearchForm(
    _limits(), _kelvin_to_elements, _kelvin_jacobian, _kelvin_from_elements, ordered=(0, 1)
)
"""(k0, kinf, tau, alpha) of the Kelvin type, inverse of eq. (6), (34)."""
