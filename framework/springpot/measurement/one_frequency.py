"""When two frequencies are one. There are two answers, as there are two questions.

*Written alike*: rows of which a file says that they have one frequency, but for the last digits of
a conversion from Hz. This is the rule wherever rows are counted, averaged or compared as points of
one frequency: fine sweeps of time signals have steps of less than a tenth of a per cent, and stay
sweeps.

*Held alike*: rows at which a rig held one frequency and wrote down what it measured, now a little
higher and now a little lower. This is the rule where the question is what was set: whether a
condition was swept at each frequency.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from .measurement import numbers_of_levels

DECIMALS = 6
"""Decimals of ln omega, or of a condition, to which values are written alike.

Instruments print six or seven.
"""
HELD_ALIKE = 1e-3
"""Distance of neighbouring ln omega within which a frequency was held.

Instruments set it to a part in a thousand.
"""


class Frequencies(Protocol):
    """Rows with a frequency each."""

    @property
    def omega(self) -> Real:
        """Angular frequency (n,) in rad/s."""


def rounded_log_omega(omega: Real) -> Real:
    """Ln omega (n,), equal where frequencies are written alike.

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Angular frequency in rad/s.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import rounded_log_omega
    >>> float(np.ptp(rounded_log_omega(np.array([6.2831853, 6.2831855]))))
    0.0
    """
    # In logarithms, as instruments print so many digits of each frequency, whatever its size.
    return np.asarray(np.round(np.log(omega), DECIMALS), dtype=np.float64)


def frequency_numbers(data: Frequencies) -> NDArray[np.int64]:
    """Number of the distinct frequency, as written, of each row, ascending; shape (n,).

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement import frequency_numbers
    >>> frequency_numbers(Measurement([2.0, 1.0, 2.0], [1j, 2j, 3j]))
    array([1, 0, 1])
    """
    _, number = np.unique(rounded_log_omega(data.omega), return_inverse=True)
    return np.asarray(number.ravel(), dtype=np.int64)


def distinct_log_omega(data: Frequencies) -> Real:
    """Ln omega of the distinct frequencies, as written, ascending.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import distinct_log_omega
    >>> np.exp(distinct_log_omega(Measurement([2.0, 1.0, 2.0], [1j, 2j, 3j]))).round(6)
    array([1., 2.])
    """
    return np.asarray(np.unique(rounded_log_omega(data.omega)), dtype=np.float64)


def held_frequency_numbers(omega: Real) -> NDArray[np.int64]:
    """Number of the frequency that was held, of each row, ascending; shape (n,).

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Angular frequency in rad/s, as measured.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import held_frequency_numbers
    >>> held_frequency_numbers(np.array([1.0001, 2.0, 0.9999]))
    array([0, 1, 0])
    """
    return numbers_of_levels(np.log(omega), HELD_ALIKE)


def at_one_frequency(data: Frequencies) -> bool:
    """Whether all rows were held at one frequency.

    Of what depends on it no more can be told than one complex number.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement import at_one_frequency
    >>> at_one_frequency(Measurement([1.0, 1.0002], [1j, 2j]))
    True
    """
    return float(np.ptp(np.log(data.omega))) < HELD_ALIKE
