"""What the measurement chain does to a signal: factors for `chain`, and the clock for `shift`."""

from __future__ import annotations

from typing import Any

import numpy as np

from .elements import delay_time
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
