"""Where a model is evaluated: frequencies and the conditions of each measured point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]


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
    """

    log_omega: Real
    amplitude: Real | None = None
    temperature: Real | None = None
    reference_temperature: float = 293.15
    columns: Mapping[str, Real] = field(default_factory=dict)

    @classmethod
    def at(cls, omega: Real | float) -> Points:
        """Points at the angular frequencies `omega` in rad/s, without conditions."""
        return cls(np.log(np.atleast_1d(np.asarray(omega, dtype=float))))

    @property
    def omega(self) -> Real:
        """Angular frequency in rad/s, shape (..., n)."""
        return np.exp(self.log_omega)

    def shifted(self, log_shift: Real) -> Points:
        """The same points with `log_shift` added to the logarithm of the frequency."""
        return replace(self, log_omega=self.log_omega + log_shift)

    def mapped(self, change: Callable[[Real], Real]) -> Points:
        """The points with every condition changed: to some of the rows, say, or interpolated; frequencies stay."""
        return replace(
            self,
            amplitude=None if self.amplitude is None else change(self.amplitude),
            temperature=None if self.temperature is None else change(self.temperature),
            columns={name: change(column) for name, column in self.columns.items()},
        )

    def need(self, condition: str) -> Real:
        """The column `condition`: "amplitude", "temperature" or another by its name.

        Raises
        ------
        ValueError
            If the measurement has no such column.
        """
        own = {"amplitude": self.amplitude, "temperature": self.temperature}
        column = own[condition] if condition in own else self.columns.get(condition)
        if column is None:
            raise ValueError(f"the model needs the column '{condition}', which these data do not have")
        return column
