"""A model whose parameters are known, and how well, whatever tests they were found from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from springpot.distributions import student
from springpot.errors import DataError
from springpot.identification.prediction import Prediction, require_known, value_and_slopes
from springpot.identification.result import Identification
from springpot.measurement.covered import Covered
from springpot.measurement.units import Units
from springpot.rheology.model import Model
from springpot.rheology.points import KELVIN, Points, Real

ENDLESS = 1e12
"""Variance of a search coordinate that the data do not determine: a million natural sizes."""


class Knowing(Protocol):
    """What tells a model with its parameters: a fit of tests in time."""

    @property
    def known(self) -> Known:
        """The model without what the tests did, and how well it is known."""
        ...


@dataclass(frozen=True, eq=False)
class Known:
    """A model with its parameters and how well they are known.

    Attributes
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters, in `units`.
    covariance : ndarray, shape (p, p)
        Of these parameters.
    units : Units
        Of the test that they were fitted to.
    reference : float
        Temperature in kelvin at which shifts are one.
    misfit : float
        Relative error that the fit itself has.
    dof : float
        Degrees of freedom behind the covariance.
    covered : Covered
        What the fitted tests measured.
    """

    model: Model
    theta: Real
    covariance: Real
    units: Units
    reference: float
    misfit: float
    dof: float
    covered: Covered = field(default_factory=Covered)

    @classmethod
    def of(cls, identified: Identification | Knowing) -> Known:
        """From a fit to tests in time, or to a sweep."""
        if not isinstance(identified, Identification):
            return identified.known
        coordinates, data = identified.fit.task.coordinates, identified.measurement
        # An endless variance times a slope of zero would be no number.
        covariance = np.nan_to_num(identified.uncertainty.covariance, nan=0.0, posinf=ENDLESS)
        turn = coordinates.slopes(identified.theta, coordinates.size[0])
        return cls(
            identified.model,
            identified.theta,
            turn @ covariance @ turn.T,
            data.units,
            data.reference_temperature,
            identified.relative_rms,
            max(identified.fit.dof, 1),
            identified.covered,
        )

    def predict(
        self,
        frequency: ArrayLike | None = None,
        *,
        omega: ArrayLike | None = None,
        temperature: float | None = None,
        amplitude: float | None = None,
        level: float = 0.95,
    ) -> Prediction:
        """K at frequencies in Hz or angular frequencies in rad/s, with a band.

        See `Identification.predict`.

        Raises
        ------
        DataError
            If there are no such frequencies, or the model needs a temperature (degC) or an
            amplitude.
        """
        if (frequency is None) == (omega is None):
            raise DataError("give frequency [Hz] or omega [rad/s]")
        if frequency is not None:
            omega = 2.0 * np.pi * np.asarray(frequency, dtype=float)
        omega = np.atleast_1d(np.asarray(omega, dtype=float))
        if not (np.all(np.isfinite(omega)) and np.all(omega > 0.0)):
            raise DataError("frequencies are a list of numbers, finite and above zero")
        given = {"temperature": temperature, "amplitude": amplitude}
        conditions = {
            name: np.full(len(omega), value) for name, value in given.items() if value is not None
        }
        for name in sorted(self.model.needs - set(conditions)):
            raise DataError(f"{self.model.name} needs {name}: give it")
        for name, column in conditions.items():
            require_known(self.model, self.covered, name, column)
        kelvin = None
        if temperature is not None:
            kelvin = conditions["temperature"] + KELVIN
        points = Points(np.log(omega), conditions.get("amplitude"), kelvin, self.reference)
        value, slopes = value_and_slopes(self.model, self.theta, points)
        quantile = student(level, self.dof)
        real, imaginary = (
            quantile * reach(part, self.covariance) for part in (slopes.real, slopes.imag)
        )
        wide = real + 1j * imaginary
        low, high = value - wide, value + wide
        return Prediction(
            self.model.name, omega, value, low, high, conditions, self.units, level, self.covered
        )


def reach(slopes: Real, covariance: Real) -> Real:
    """Standard deviation (m,) of what has the derivatives `slopes` (m, p) by the parameters."""
    variance: Real = np.einsum("mi,ij,mj->m", slopes, covariance, slopes)
    # Rounding takes a variance of nothing below zero.
    return np.sqrt(np.maximum(variance, 0.0))
