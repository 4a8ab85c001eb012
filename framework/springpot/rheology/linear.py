"""Linear elements beyond powers of s.

Relaxation and retardation modes, rate-independent loss, diffusion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .elements import FixedPower
from .formula import Formula
from .parameters import (
    RADIAN_PER_SECOND,
    SECOND,
    STIFFNESS,
    Dimension,
    Parameter,
    relaxation_time,
    stiffness,
)
from .points import Points

RADIAN = Dimension(label="rad")
DAMPING_RATIO = Parameter("zeta", "ζ", lower=1e-4, upper=1.0, scale="linear", typical=0.05)
STRUCTURAL_DAMPING = Parameter("zeta", "ζ", lower=1e-4, upper=0.3, scale="linear", typical=0.05)
"""Of steel frames and their joints, even on rubber mounts.

Above, it would be no resonance but a mode.
"""


def _maxwell(at: Points, k: Any, tau: Any) -> Any:
    s = 1j * at.omega
    whole = 1.0 + s * tau
    part = s * tau / whole
    return k * part, (part, k * s / whole**2), k * part / whole


def relaxation_mode(k: str = "k", tau: str = "tau") -> Formula:
    """A Maxwell branch, K = k s tau / (1 + s tau).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, relaxation_mode
    >>> relaxation_mode().respond(np.array([2.0, 0.5]), Points.at([2.0])).value
    array([1.+1.j])
    """
    return Formula((stiffness(k), relaxation_time(tau)), _maxwell, kind="maxwell")


def _kelvin(at: Points, k: Any, tau: Any) -> Any:
    s = 1j * at.omega
    return k * (1.0 + s * tau), (1.0 + s * tau, k * s), k * s * tau


def retardation_mode(k: str = "k", tau: str = "tau") -> Formula:
    """A Kelvin unit, K = k (1 + s tau), to be put in series.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, retardation_mode
    >>> retardation_mode().respond(np.array([2.0, 0.5]), Points.at([2.0])).value.round(6)
    array([2.+2.j])
    """
    return Formula((stiffness(k), relaxation_time(tau)), _kelvin, kind="kelvin")


def _hysteretic(at: Points, h: Any) -> Any:
    return 1j * h, (1j,), 0.0


def hysteretic(h: str = "h") -> Formula:
    """Structural damping, K = i h.

    Independent of frequency and of amplitude, and therefore not causal.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, hysteretic
    >>> hysteretic().respond(np.array([2.0]), Points.at([0.1, 10.0])).value
    array([0.+2.j, 0.+2.j])
    """
    return Formula((Parameter(h, "h", STIFFNESS),), _hysteretic, kind="hysteretic")


def _diffusion(at: Points, k: Any, tau: Any) -> Any:
    root = np.sqrt(1j * at.omega * tau)
    ratio = np.tanh(root) / root
    # d(1 - tanh r / r) / d ln(omega), with r growing as omega to the one half.
    slope = 0.5 * (ratio - 1.0 + np.tanh(root) ** 2)
    return k * (1.0 - ratio), (1.0 - ratio, k * slope / tau), k * slope


def diffusion(k: str = "k", tau: str = "tau") -> Formula:
    """Fluid that seeps through the specimen, K = k (1 - tanh sqrt(s tau) / sqrt(s tau)).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, diffusion
    >>> np.abs(diffusion().respond(np.array([2.0, 1.0]), Points.at([1e-3, 1e6])).value).round(3)
    array([1.000e-03, 1.999e+00])
    """
    return Formula((stiffness(k), relaxation_time(tau)), _diffusion, kind="diffusion")


def basset(c: str = "c") -> FixedPower:
    """Oscillating boundary layer in a fluid (Basset), K = c s^(3/2).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, basset
    >>> basset().respond(np.array([1.0]), Points.at([4.0])).value.round(3)
    array([-5.657+5.657j])
    """
    return FixedPower(Parameter(c, "c", Dimension(stiffness=1, time=1.5)), 1.5, "basset")


def _frame(at: Points, k: Any, omega_r: Any, zeta: Any) -> Any:
    r = at.omega / omega_r
    whole = 1.0 - r**2 + 2j * zeta * r
    slope = k * (2j * zeta * r - 2.0 * r**2)
    return k * whole, (whole, -slope / omega_r, 2j * k * r), slope


def resonant_frame(k: str = "k") -> Formula:
    """A frame with its own resonance, K = k (1 - r^2 + 2 i zeta r), r = omega / omega_r.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, resonant_frame
    >>> at = Points.at([5.0, 50.0])
    >>> resonant_frame().respond(np.array([100.0, 50.0, 0.02]), at).value.round(3)
    array([99.+0.4j,  0.+4.j ])
    """
    return Formula((stiffness(k), resonance(), STRUCTURAL_DAMPING), _frame, kind="frame")


def resonance(name: str = "omega_r") -> Parameter:
    """An angular resonance frequency."""
    return Parameter(name, "ω_r", RADIAN_PER_SECOND, typical=100.0)


def delay_time(name: str = "tau") -> Parameter:
    """A time that may be negative: the other channel may be the late one."""
    return Parameter(name, "τ", SECOND, lower=-np.inf, scale="linear", typical=0.1)
