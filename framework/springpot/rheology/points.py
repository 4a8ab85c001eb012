"""Where a model is evaluated: frequencies and the conditions of each measured point."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
    """

    log_omega: Real
    amplitude: Real | None = None
    temperature: Real | None = None
    reference_temperature: float = 293.15

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

    def need(self, condition: str) -> Real:
        """The column `condition` ("amplitude" or "temperature").

        Raises
        ------
        ValueError
            If the measurement has no such column.
        """
        column: Real | None = getattr(self, condition)
        if column is None:
            raise ValueError(f"the model needs the column '{condition}', which these data do not have")
        return column
