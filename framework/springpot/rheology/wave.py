"""Specimen inertia: a shear wave that crosses a specimen of mass m and quasi-static stiffness K.

With z^2 = m omega^2 / K (that is, omega h sqrt(rho / G)), the force at the moving side is K z cot z
and at the fixed side K z / sin z. Both are functions of u = -E / K alone, where E = -m omega^2 is
the mass element.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.polynomial.polynomial import polyval

from .nodes import VALUE, Composing, Composition, Response, _combine
from .points import Complex, Points, Real

SMALL = 0.02
"""Below this |u| the power series is exact to rounding and the closed form is not."""
MOVING_SERIES = (1.0, -1 / 3, -1 / 45, -2 / 945, -1 / 4725, -2 / 93555, -1382 / 638512875)
FIXED_SERIES = (1.0, 1 / 6, 7 / 360, 31 / 15120, 127 / 604800, 73 / 3421440, 1414477 / 653837184000)
_SERIES = {
    moving_side: (np.array(terms), np.arange(1, len(terms)) * terms[1:])
    for moving_side, terms in ((True, MOVING_SERIES), (False, FIXED_SERIES))
}


class SpecimenWave(Composition):
    """The first child carried by a wave in a specimen whose mass element is the second child.

    The children are the specimen without inertia and its mass, -m omega^2.

    Attributes
    ----------
    moving_side : bool
        Whether the force is measured where the specimen is moved, or at its other, fixed end.
    """

    order = 6
    moving_side: ClassVar[bool] = True

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K f(u), u = -E / K; dK_m/dK = f - u f', dK_m/dE = -f'."""
        parts = self._respond_each(theta, at, depth)
        # Of K and E alone: so the wave needs no geometry, and the chain rule no third part.
        u = -parts[1].value / parts[0].value
        f, slope = wave_factor(u, self.moving_side)
        return _combine(parts[0].value * f, parts, [f - u * slope, -slope], depth)


class FixedSideWave(SpecimenWave):
    """The same where the force is measured at the fixed end."""

    moving_side = False


def wave_factor(u: Complex, moving_side: bool) -> tuple[Complex, Complex]:
    """Z cot z (moving side) or z / sin z (fixed side) with z = sqrt(u), and its derivative by u."""
    small = np.abs(u) < SMALL
    # Where no point needs it the series is left out: this runs at every step of a search.
    if not small.any():
        return _closed(u, moving_side)
    near = np.where(small, u, 0.0)
    value, slope = (polyval(near, terms) for terms in _SERIES[moving_side])
    far, far_slope = _closed(np.where(small, 1.0, u), moving_side)
    return np.where(small, value, far), np.where(small, slope, far_slope)


def _closed(u: Complex, moving_side: bool) -> tuple[Complex, Complex]:
    z = np.sqrt(u.astype(complex))
    # Both functions are even in z: the root above the real axis keeps the exponential from
    # overflowing.
    z = np.where(z.imag < 0.0, -z, z)
    p = np.exp(1j * z)
    below = p * p - 1.0
    cotangent = 1j * (p * p + 1.0) / below
    cosecant = 2j * p / below
    if moving_side:
        return z * cotangent, (cotangent - z * cosecant**2) / (2.0 * z)
    return z * cosecant, cosecant * (1.0 - z * cotangent) / (2.0 * z)


moving_side_wave = Composing(SpecimenWave)
"""Specimen inertia as felt by a force transducer at the moving side."""
fixed_side_wave = Composing(FixedSideWave)
"""Specimen inertia as felt by a force transducer at the fixed side."""
