"""A law of temperature in a material, fitted to the data as any model is.

The constants that every command gives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from springpot.identification.expected_factors import whitening
from springpot.identification.free_factors import Factors
from springpot.identification.held_material import intervals_beside_material
from springpot.identification.native import fit
from springpot.identification.problem import Objective
from springpot.identification.uncertainty import Uncertainty
from springpot.measurement.measurement import Measurement
from springpot.rheology.continuum import Continuum
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.formula import Formula
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.nodes import chain, shift
from springpot.rheology.points import KELVIN, Real


@dataclass(frozen=True, eq=False)
class Direct:
    """The data to which laws are fitted, and what stands beside them.

    Attributes
    ----------
    measurement : Measurement
        All sweeps.
    weighing : Objective
        How the misfit is measured.
    factors : Factors
        The free factors, from which the search begins.
    unit : float, optional
        Variance of a weighted residual, by which vertical factors are weighed against what is
        expected of them; none without vertical factors.
    unfitted : Continuum
        Any material, as these data show it.
    """

    measurement: Measurement
    weighing: Objective
    factors: Factors
    unit: float | None
    unfitted: Continuum

    def __call__(self, element: Formula, theta: Real) -> tuple[Real, Real, Real]:
        """A law's parameters (k,) fitted from `theta` on, and the ends of their 95 % intervals."""
        factors, count = self.factors, len(theta)
        data = replace(
            self.measurement, reference=float(factors.levels[factors.reference]) + KELVIN
        )
        model = Model(
            "material",
            self.unfitted,
            effects=(Effect("law", shift, element, "a law", Layer.TEMPERATURE),),
        )
        expected = None
        if self.unit is not None:
            vertical = Levels(factors.column, "b", False)
            upwards = Effect(
                "vertical", chain, vertical, "a factor for each level", Layer.TEMPERATURE
            )
            model = (model + upwards).bound_to(data.points)
            bound = vertical.bound_to(data.points)
            beside = np.sqrt(self.unit) * whitening(bound)
            expected = np.column_stack([np.zeros((len(beside), count)), beside])
            theta = np.concatenate(
                [theta, np.exp(factors.log_b - factors.log_b[bound.reference])[list(bound.free)]]
            )
        best = fit(model, data, self.weighing, seeds_theta=[theta], expected=expected)
        known = replace(Uncertainty.of(best), expected=expected)
        low, high = intervals_beside_material(known)
        own = slice(
            len(best.model.material.parameters), len(best.model.material.parameters) + count
        )
        return best.theta[own], low[own], high[own]
