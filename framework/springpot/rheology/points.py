"""Where a model is evaluated: frequencies and the conditions of each measured point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.errors import DataError

Real: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]

KELVIN = 273.15
"""0 degC in kelvin."""
LARGEST_SHIFT = 60.0
"""Bound on |ln a_T|: 26 decades, so that a search that strays cannot overflow."""
ROOM = 293.15
"""20 degC in kelvin: where a shift is one if no test and no user says another temperature."""
COLDEST = 75.0
"""Kelvin below which a number is rather one in degC.

Specimens are cooled by nitrogen, which boils at 77.4 K.
"""
HELD: Mapping[str, float] = {"amplitude": 0.02, "temperature": 0.5}
"""How nearly a rig holds what was set: amplitudes as a share, temperatures in kelvin.

Rheometers state 1 to 2 % and
0.1 to 0.5 K. Values that lie closer to one another are one level."""
STEADY = HELD["amplitude"]
"""Share of its largest value by which what is called held may move."""
HELD_OTHER = 2e-3
"""The same of other settings, as a share of the largest.

They are written down rather than measured. What counts, as specimens from one on, is no setting.
"""

HALF_PI = 0.5j * np.pi
"""ln i."""
GAS_CONSTANT = 8.31446261815324e-3
"""Molar gas constant in kJ/(mol K), exact in the SI of 2019."""
FURTHEST = 700.0
"""Logarithm of what is no floating-point number any more.

As that of a frequency it was meant as the frequency itself.
"""


def held(column: str, values: Real) -> Real:
    """How far apart values (n,) of a column may be and be one setting, in its unit (n,)."""
    if column == "temperature":
        return np.full(len(values), HELD[column])
    if column in HELD:
        return HELD[column] * np.abs(values)
    # The thousandth specimen and the next differ by less than any share of a thousand.
    if len(values) and np.min(values) in (0.0, 1.0) and np.all(values == np.round(values)):
        return np.zeros(len(values))
    return np.full(len(values), HELD_OTHER * float(np.max(np.abs(values), initial=0.0)))


def power_of_s(exponent: Real | float, log_omega: Real) -> Complex:
    """(i omega)^exponent, from real exponentials: a complex power costs eighty times as much.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import power_of_s
    >>> power_of_s(0.5, np.log([4.0])).round(6)
    array([1.414214+1.414214j])
    """
    return np.exp(exponent * log_omega) * np.exp(HALF_PI * exponent)


def real_form(values: NDArray[Any]) -> Real:
    """Real parts and then imaginary ones (2 n, ...) of complex numbers (n, ...).

    Examples
    --------
    >>> from springpot.rheology.points import real_form
    >>> real_form(np.array([1.0 + 3.0j, 2.0 + 4.0j]))
    array([1., 2., 3., 4.])
    """
    return np.concatenate([values.real, values.imag])


def complex_form(values: Real) -> Complex:
    """Complex numbers (n,) of their real parts and then imaginary ones (2 n,).

    Examples
    --------
    >>> from springpot.rheology.points import complex_form
    >>> complex_form(np.array([1.0, 2.0, 3.0, 4.0]))
    array([1.+3.j, 2.+4.j])
    """
    real, imag = np.split(values, 2)
    return np.asarray(real + 1j * imag, dtype=np.complex128)


@dataclass(frozen=True, eq=False)
class Points:
    """The points at which a complex stiffness is wanted.

    Parameters
    ----------
    log_omega : ndarray, shape (..., n)
        Natural logarithm of the angular frequency in rad/s.
    amplitude : ndarray, shape (n,), optional
        Displacement or strain amplitude in the unit of the measurement.
    temperature : ndarray, shape (n,), optional
        Absolute temperature in kelvin.
    reference_temperature : float
        Temperature in kelvin at which a temperature shift is one.
    columns : mapping of str to ndarray, shape (n,)
        Further conditions by name, such as a water content.

    Raises
    ------
    DataError
        If temperatures look like degC, frequencies were given for their logarithms, or a condition
        is not given for each point: see `at`, which takes these.

    Examples
    --------
    >>> from springpot.rheology import Points
    >>> Points.at([1.0, 10.0], temperature=[20.0, 30.0], amplitude=0.5).need("amplitude")
    array([0.5, 0.5])
    """

    log_omega: Real
    amplitude: Real | None = None
    temperature: Real | None = None
    reference_temperature: float = ROOM
    columns: Mapping[str, Real] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, column in (("amplitude", self.amplitude), ("temperature", self.temperature)):
            if column is not None and np.ndim(column) == 0:
                raise DataError(
                    f"{name} is one number for each point: use Points.at(omega, {name}=...)"
                )
        if self.temperature is not None and np.min(self.temperature, initial=COLDEST) < COLDEST:
            raise DataError(
                "temperature is in kelvin here: use Points.at(omega, temperature=...) for degC"
            )
        if np.max(np.real(self.log_omega), initial=FURTHEST) > FURTHEST:
            raise DataError(
                "log_omega is the natural logarithm of omega:"
                " use Points.at(omega) for omega in rad/s"
            )

    @classmethod
    def at(
        cls,
        omega: ArrayLike,
        *,
        temperature: ArrayLike | None = None,
        amplitude: ArrayLike | None = None,
        reference: float = 20.0,
    ) -> Points:
        """Points at angular frequencies, with conditions as users write them.

        Parameters
        ----------
        omega : array_like, shape (n,)
            In rad/s.
        temperature, amplitude : array_like, one or (n,), optional
            In degC, and in the unit of the measurement.
        reference : float
            Temperature in degC at which a temperature shift is one.

        Examples
        --------
        >>> from springpot.rheology import Points
        >>> Points.at([1.0, 10.0], temperature=25.0).temperature
        array([298.15, 298.15])
        """
        # One frequency is a list of one: answers then have the same axes throughout.
        rate = np.atleast_1d(np.asarray(omega, dtype=float))
        kelvin: Real | None = None
        reach: Real | None = None
        if temperature is not None:
            kelvin = _column(temperature, rate) + KELVIN
        if amplitude is not None:
            reach = _column(amplitude, rate)
        return cls(np.log(rate), reach, kelvin, reference + KELVIN)

    @property
    def omega(self) -> Real:
        """Angular frequency in rad/s, shape (..., n)."""
        return np.exp(self.log_omega)

    def shifted(self, log_shift: Real) -> Points:
        """The same points with `log_shift` added to the logarithm of the frequency."""
        return self._unchecked(log_omega=self.log_omega + log_shift)

    def at_amplitude(self, amplitude: Real) -> Points:
        """The same points at other amplitudes (..., n), as the share that a part takes."""
        return self._unchecked(amplitude=amplitude)

    def some(self, rows: NDArray[np.intp]) -> Points:
        """Some of the points, by their numbers."""
        changed: dict[str, Any] = {
            "log_omega": self.log_omega[..., rows],
            "columns": {name: column[..., rows] for name, column in self.columns.items()},
        }
        if self.amplitude is not None:
            changed["amplitude"] = self.amplitude[..., rows]
        if self.temperature is not None:
            changed["temperature"] = self.temperature[..., rows]
        return self._unchecked(**changed)

    def _unchecked(self, **changed: Any) -> Points:
        # On the way to a fit any shift is tried, however far, and in each evaluation: nothing is
        # checked here.
        other = object.__new__(Points)
        other.__dict__.update(self.__dict__, **changed)
        return other

    def mapped(self, change: Callable[[Real], Real]) -> Points:
        """The points with every condition changed: to some of the rows, say, or interpolated.

        Frequencies stay.
        """
        changed: dict[str, Any] = {
            "columns": {name: change(column) for name, column in self.columns.items()}
        }
        if self.amplitude is not None:
            changed["amplitude"] = change(self.amplitude)
        if self.temperature is not None:
            changed["temperature"] = change(self.temperature)
        return replace(self, **changed)

    def need(self, condition: str) -> Real:
        """The column `condition`: "amplitude", "temperature" or another by its name.

        Raises
        ------
        DataError
            If the measurement has no such column.
        """
        own = {"amplitude": self.amplitude, "temperature": self.temperature}
        column = self.columns.get(condition)
        if condition in own:
            column = own[condition]
        if column is None:
            raise DataError(
                f"the model needs the column '{condition}', which these data do not have"
            )
        return column


def _column(values: ArrayLike, omega: Real) -> Real:
    """One value, or one for each point, as a column."""
    # A copy: a broadcast view may not be written to, and would show what its owner changes.
    return np.broadcast_to(np.asarray(values, dtype=float), omega.shape).copy()
