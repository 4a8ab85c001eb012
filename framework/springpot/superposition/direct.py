"""A law of temperature in a material, fitted to the data as any model is.

The constants that every command gives.
"""

from __future__ import annotations

from dataclasses import dataclass

from springpot.identification.held_material import intervals_beside_material
from springpot.identification.problem import Objective
from springpot.identification.superposed_fit import superposed_fit
from springpot.identification.uncertainty import Uncertainty
from springpot.measurement.measurement import Measurement
from springpot.rheology.continuum import Continuum
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.formula import Formula
from springpot.rheology.model import Model
from springpot.rheology.nodes import shift
from springpot.rheology.points import Real


@dataclass(frozen=True, eq=False)
class Direct:
    """The data to which laws are fitted, and what stands beside them.

    Attributes
    ----------
    measurement : Measurement
        All sweeps, with the temperature of reference.
    weighing : Objective
        How points weigh.
    unfitted : Continuum
        Any material, as these data show it.
    upwards : Effect, optional
        Free vertical factors.
    unit : float, optional
        Variance of a weighted residual, by which vertical factors are weighed against what is
        expected of them.
    """

    measurement: Measurement
    weighing: Objective
    unfitted: Continuum
    upwards: Effect | None = None
    unit: float | None = None

    def __call__(self, element: Formula) -> tuple[Real, Real, Real]:
        """A law's parameters (k,), and the ends of their 95 % intervals."""
        law = Effect("law", shift, element, "a law", Layer.TEMPERATURE)
        model = Model("material", self.unfitted, effects=(law,))
        if self.upwards is not None:
            model = model + self.upwards
        best = superposed_fit(model, self.measurement, self.weighing, unit=self.unit)
        low, high = intervals_beside_material(Uncertainty.of(best))
        first = len(best.model.material.parameters)
        own = slice(first, first + len(element.parameters))
        return best.theta[own], low[own], high[own]
