"""A fit and how well its parameters are known: what an answer prints, keeps and predicts from."""

from __future__ import annotations

from dataclasses import dataclass

from springpot.measurement.measurement import Measurement
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .native import Fit
from .uncertainty import Uncertainty


@dataclass(frozen=True, eq=False)
class Estimate:
    """Parameters of a model with their intervals, in the units of the measurement.

    Attributes
    ----------
    fit : Fit
        The fit.
    low, high : ndarray, shape (p,)
        Ends of the 95 % intervals of theta; infinite where the data give none.
    uncertainty : Uncertainty
        What the Jacobian says.
    """

    fit: Fit
    low: Real
    high: Real
    uncertainty: Uncertainty

    @property
    def model(self) -> Model:
        """The model; parameters that were held are none of its own."""
        return self.fit.model

    @property
    def measurement(self) -> Measurement:
        """The measurement."""
        return self.fit.measurement

    @property
    def theta(self) -> Real:
        """The free parameters, shape (p,), in the units of the measurement.

        A mass of data in kN/m is in Mg.

        `parameters` of an `Identification` has them as they are printed.
        """
        return self.fit.theta
