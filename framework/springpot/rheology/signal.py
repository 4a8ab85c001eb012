"""What the measurement chain does to a signal: factors for `chain`, and the clock for `shift`."""

from __future__ import annotations

from typing import Any

import numpy as np

from .elements import DAMPING_RATIO, RADIAN, delay_time, resonance
from .grammar import Formula
from .laws import delay as delay_law
from .laws import gain as gain_law
from .laws import one_filter as one_filter_law
from .parameters import PURE, Parameter
from .points import Points


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
    return Formula((delay_time(tau),), _delay, kind="delay", in_time=delay_law)


def _phase(at: Points, phi: Any) -> Any:
    value = np.exp(1j * phi)
    return value, (1j * value,), 0.0


def phase(phi: str = "phi") -> Formula:
    """exp(i phi): the same phase error in rad at all frequencies.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, phase
    >>> np.angle(phase().respond(np.array([0.02]), Points.at([10.0, 100.0])).value)
    array([0.02, 0.02])
    """
    return Formula(
        (Parameter(phi, "φ", RADIAN, -0.5 * np.pi, 0.5 * np.pi, "linear", 0.0),),
        _phase,
        kind="phase",
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
    )


def _force_resonance(at: Points, omega_r: Any, zeta: Any) -> Any:
    r = at.omega / omega_r
    value = 1.0 / (1.0 - r**2 + 2j * zeta * r)
    slope = value**2 * (2.0 * r**2 - 2j * zeta * r)
    return value, (-slope / omega_r, -2j * r * value**2), slope


def force_resonance(omega_r: str = "omega_r") -> Formula:
    """1 / (1 - r^2 + 2 i zeta r), r = omega / omega_r: the force channel has a resonance.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, force_resonance
    >>> at = Points.at([10.0, 100.0])
    >>> np.abs(force_resonance().respond(np.array([100.0, 0.05]), at).value).round(3)
    array([ 1.01, 10.  ])
    """
    return Formula((resonance(omega_r), DAMPING_RATIO), _force_resonance, kind="resonance")


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
    return Formula((delay_time(tau),), _filter, kind="filter", in_time=one_filter_law)


def _clock(at: Points, e: Any) -> Any:
    return np.log1p(e), (1.0 / (1.0 + e),), 0.0


def clock(e: str = "e") -> Formula:
    """ln(1 + e), for `shift`: the frequency is wrong by the fraction e.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Model, clock, dashpot, shift
    >>> off = Model("dashpot", shift(dashpot(), clock()))
    >>> off.stiffness(off.theta(c=1.0, e=0.02), [10.0]).imag.round(6)
    array([10.2])
    """
    return Formula(
        (Parameter(e, "e", PURE, -0.9, scale="linear", typical=0.1),), _clock, kind="clock"
    )
