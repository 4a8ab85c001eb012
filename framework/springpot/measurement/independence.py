"""How far a condition was varied by itself, and when two frequencies are one.

Every rig lets the amplitude wander a little with frequency, one that controls the force lets it
follow the specimen, and an operator chooses it to suit the temperature. Then whatever depends on
frequency or temperature depends on the amplitude too, and no fit can say that the amplitude is the
cause.

Two frequencies are one by either of two rules, as there are two questions.

*Written alike*: rows of which a file says that they have one frequency, but for the last digits of
a conversion from Hz. This is the rule wherever rows are counted, averaged or compared as points of
one frequency: fine sweeps of time signals have steps of less than a tenth of a per cent, and stay
sweeps.

*Held alike*: rows at which a rig held one frequency and wrote down what it measured, now a little
higher and now a little lower. This is the rule where the question is what was set: whether a
condition was swept at each frequency.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real
from springpot.thresholds import VARIED

from ..numerics import NORMAL
from .measurement import CONDITIONS, Measurement, numbers_of_levels

DECIMALS = 6
"""Decimals of ln omega, or of a condition, to which values are written alike.

Instruments print six or seven.
"""
HELD_ALIKE = 1e-3
"""Distance of neighbouring ln omega, or relative spread of a condition, within which it was held.

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
    >>> from springpot.measurement.independence import rounded_log_omega
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
    >>> from springpot.measurement.independence import frequency_numbers
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
    >>> from springpot.measurement.independence import distinct_log_omega
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
    >>> from springpot.measurement.independence import held_frequency_numbers
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
    >>> from springpot.measurement.independence import at_one_frequency
    >>> at_one_frequency(Measurement([1.0, 1.0002], [1j, 2j]))
    True
    """
    return float(np.ptp(np.log(data.omega))) < HELD_ALIKE


WANDER: Mapping[str, float] = {
    "amplitude": VARIED.amplitude_wanders,
    "temperature": VARIED.temperature_wanders,
}
"""What moves without being varied, in a whole test."""
CHOSEN: Mapping[str, float] = {
    "amplitude": VARIED.amplitude_chosen,
    "temperature": VARIED.temperature_wanders,
}
"""Least distance of values that were chosen."""
SMOOTH_DEGREE = 5
"""Highest degree of the polynomial in the logarithm of the frequency that counts as moving with it.

And of a sweep that counts as structure, not as noise.
"""
POINTS_PER_DEGREE = 3
"""Distinct frequencies, or times, that a degree needs.

With fewer, the polynomial would follow levels chosen at random, or noise.
"""
ROUNDS = 20
"""Reweighted fits towards the least sum of absolute deviations.

Changes are below a per cent after ten.
"""


@dataclass(frozen=True)
class Spread:
    """How much a condition varied.

    Attributes
    ----------
    whole : float
        Twice the standard deviation over all rows: for two levels alike often, their distance. In
        kelvin, and of amplitudes in units of their logarithm.
    own : float
        The same of what is left when the frequency, and for an amplitude the temperature, have
        explained what they can. Where some rows share both, it is the spread among these; else what
        a slow curve through most of the rows leaves, so that a resonance of the rig is not taken
        for a choice.
    held, chosen : float
        What a rig holds, and what values that were chosen differ by at least, in the same unit.
    """

    whole: float
    own: float
    held: float
    chosen: float

    @property
    def varied(self) -> bool:
        """Whether it was varied at all."""
        return self.whole > self.held

    @property
    def independent(self) -> bool:
        """Whether it was varied by itself, so that data can show what it does."""
        return self.varied and self.own >= self.chosen


# Every search asks anew, of the same data: of a few it is remembered.
@lru_cache(maxsize=8)
def spread_of(measurement: Measurement, condition: str) -> Spread | None:
    """How much a condition varied, and how much of that nothing else explains.

    Parameters
    ----------
    measurement : Measurement
        The data.
    condition : {"amplitude", "temperature"}
        Which.

    Returns
    -------
    Spread or None
        None without such a column.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> omega = np.geomspace(0.1, 100.0, 12)
    >>> conditions = {"amplitude": 0.3 / omega**0.5}
    >>> follows = Measurement(omega, 1e3 * omega**0.5 + 0j, conditions=conditions)
    >>> spread_of(follows, "amplitude").independent
    False
    """
    column = measurement.conditions.get(condition)
    if column is None:
        return None
    values = column
    # Amplitudes go by shares, as a rig holds them.
    if condition == "amplitude":
        values = np.log(np.maximum(np.abs(column), np.finfo(float).tiny))
    whole = float(np.std(values))
    own = 0.0
    # What frequency and temperature explain was not varied by anyone: an effect of it cannot be
    # told from theirs.
    if np.ptp(values) > 0.0:
        own = min(whole, _unexplained(measurement, condition, values))
    return Spread(2.0 * whole, 2.0 * own, WANDER[condition], CHOSEN[condition])


def independent(measurement: Measurement, condition: str) -> bool:
    """Whether a condition was varied by itself; see `Spread`.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import independent
    >>> omega = np.tile([1.0, 10.0], 4)
    >>> amplitude = np.repeat([0.1, 0.2, 0.4, 0.8], 2)
    >>> varied = Measurement(omega, omega + 1j, conditions={"amplitude": amplitude})
    >>> independent(varied, "amplitude")
    True
    """
    spread = spread_of(measurement, condition)
    return spread is not None and spread.independent


def telling(measurement: Measurement) -> frozenset[str]:
    """Names of the conditions whose effects these data can show.

    These are the ones that were varied by themselves, and an amplitude that was held: an effect
    that needs one is still told by what it does along the frequency. A temperature that was held
    shows nothing.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement.independence import telling
    >>> columns = {"amplitude": [0.1, 0.1], "temperature": [20.0, 20.0]}
    >>> sorted(telling(Measurement([1.0, 2.0], [1j, 2j], conditions=columns)))
    ['amplitude']
    """
    names = {
        name
        for name in measurement.conditions
        if name not in WANDER or independent(measurement, name)
    }
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is not None and np.ptp(amplitude) == 0.0:
        names.add("amplitude")
    return frozenset(names)


def moved_along(measurement: Measurement) -> set[str]:
    """Conditions that varied, but not by themselves.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement.independence import moved_along
    >>> omega = np.geomspace(0.1, 100.0, 12)
    >>> conditions = {"amplitude": 0.3 / omega**0.5}
    >>> moved_along(Measurement(omega, 1e3 * omega**0.5 + 0j, conditions=conditions))
    {'amplitude'}
    """
    spreads = {name: spread_of(measurement, name) for name in CONDITIONS}
    varied = {name for name, spread in spreads.items() if spread is not None and spread.varied}
    return varied - telling(measurement)


def steadied(measurement: Measurement) -> Measurement:
    """The same data, an amplitude that only wandered (see `Spread.varied`) set to its median.

    What an effect of the amplitude does at one amplitude can then still be told, but nothing is
    read into the wander.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement import steadied
    >>> conditions = {"amplitude": [0.1, 0.1002, 0.0999]}
    >>> wandering = Measurement([1.0, 2.0, 3.0], [1j, 2j, 3j], conditions=conditions)
    >>> steadied(wandering).conditions["amplitude"]
    array([0.1, 0.1, 0.1])
    """
    spread = spread_of(measurement, "amplitude")
    if spread is None or spread.varied:
        return measurement
    column = measurement.conditions["amplitude"]
    # The median, as a single slip of the rig moves it least.
    steady = np.full_like(column, np.median(column))
    return replace(measurement, conditions={**measurement.conditions, "amplitude": steady})


def _unexplained(measurement: Measurement, condition: str, values: Real) -> float:
    """Standard deviation that neither frequency nor, for an amplitude, temperature explains."""
    log_omega = np.log(measurement.omega)
    if condition == "temperature":
        return _off_curves(np.zeros(len(values), dtype=np.int64), log_omega, values)
    temperature = measurement.conditions.get("temperature", np.zeros(len(values)))
    same_omega = held_frequency_numbers(measurement.omega)
    same_temperature = numbers_of_levels(temperature, WANDER["temperature"])
    both = same_omega * (int(same_temperature.max()) + 1) + same_temperature
    rest = values - (np.bincount(both, values) / np.maximum(np.bincount(both), 1))[both]
    free = len(values) - len(np.unique(both))
    within = float(np.sqrt(np.sum(rest**2) / max(free, 1)))
    # Rows that share frequency and temperature show without any curve what was chosen: they come
    # first.
    if free >= VARIED.share_left * len(values) or (
        free >= VARIED.fewest_choices and 2.0 * within >= CHOSEN["amplitude"]
    ):
        return within
    # Whichever of the two explains more: then it may be the cause.
    return min(
        _off_curves(same_temperature, log_omega, values),
        _off_curves(same_omega, temperature, values),
    )


def _off_curves(level: NDArray[np.int64], x: Real, y: Real) -> float:
    """Standard deviation of y, told from most of the rows, about a slow curve in x for each level.

    Else infinite.
    """
    left: list[Real] = []
    for number in range(int(level.max()) + 1):
        rows = np.flatnonzero(level == number)
        left.append(_off_curve(x[rows], y[rows]))
    rest = np.concatenate(left)
    # Too few are left to tell their scatter.
    if len(rest) < VARIED.share_left * len(y):
        return np.inf
    return NORMAL * float(np.median(rest))


def _off_curve(x: Real, y: Real) -> Real:
    """Absolute deviations from a course that only rises or only falls.

    Where rows are off such a course, from a polynomial.

    One that rises in steps is no polynomial, and yet it went up with the frequency.
    """
    # The first look at a file must not take its time.
    from scipy.optimize import isotonic_regression

    if len(np.unique(np.round(x, DECIMALS))) >= VARIED.fewest_one_way:
        order = np.argsort(x, kind="stable")
        for upwards in (True, False):
            off = np.abs(y[order] - isotonic_regression(y[order], increasing=upwards).x)
            if np.max(off) < WANDER["amplitude"]:
                return np.sort(off)
    return _off_polynomial(x, y)


def _off_polynomial(x: Real, y: Real) -> Real:
    """Absolute deviations from the polynomial of least sum of them, without those made zero."""
    degree = min(SMOOTH_DEGREE, len(np.unique(np.round(x, DECIMALS))) // POINTS_PER_DEGREE)
    # Legendre polynomials are nearly independent of one another on -1 to 1 only.
    scaled = 2.0 * (x - x.min()) / (float(np.ptp(x)) or 1.0) - 1.0
    basis = np.polynomial.legendre.legvander(scaled, degree)
    weight, rest = np.ones(len(y)), y
    for _ in range(ROUNDS):
        rest = y - basis @ np.linalg.lstsq(basis * weight[:, None], y * weight, rcond=None)[0]
        # No deviation is as good as none: its weight would be endless.
        weight = 1.0 / np.sqrt(np.maximum(np.abs(rest), 1e-3 * WANDER["amplitude"]))
    return np.sort(np.abs(rest))[degree + 1 :]


def ranges(number: NDArray[np.int64], values: Real) -> tuple[Real, Real]:
    """Least and largest value (m,) of each level."""
    parts = [values[number == i] for i in range(number.max() + 1)]
    return np.array([part.min() for part in parts]), np.array([part.max() for part in parts])


def meeting(low: Real, high: Real, room: Real | float = 0.0) -> NDArray[np.bool_]:
    """Which ranges (m, m) meet within room."""
    return np.asarray(
        (low[:, None] <= high[None, :] + room) & (low[None, :] <= high[:, None] + room)
    )


def reached_from(reference: int, touching: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Levels (m,) that touch one of them, directly or through others."""
    reached = np.arange(len(touching)) == reference
    # In as many rounds as there are levels, any chain of overlaps has been followed to its end.
    for _ in range(len(touching)):
        reached = touching[reached].any(axis=0)
    return np.asarray(reached)
