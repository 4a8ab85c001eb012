"""An effect that was tried on tests in time, and how common it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.identification.result import Identification
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH

from .left import Left


@dataclass(frozen=True, eq=False)
class Tried:
    """An effect, what is left with it, and how much likelier it makes the tests.

    Attributes
    ----------
    effect : Effect
        The effect.
    model : Model
        The model with it.
    theta : ndarray, shape (p,)
        Its parameters.
    left : Left
        What is left of the tests.
    delta : float
        By how much the Bayesian information criterion falls.
    fit : Identification or None
        The exact fit, where there is one.
    """

    effect: Effect
    model: Model
    theta: Real
    left: Left
    delta: float
    fit: Identification | None = None

    @property
    def helps(self) -> bool:
        """Whether it explains what the model alone does not, beyond doubt."""
        return self.delta > SEARCH.decisive

    @property
    def evidence(self) -> float:
        """The same with how common the effect is: twice the logarithm of its odds."""
        return self.delta + 2.0 * float(np.log(weight_of(self.effect)))


def weight_of(effect: Effect) -> float:
    """How common an effect is in tests in time, before any data are seen."""
    if effect.of_apparatus:
        return effect.prior * EVIDENCE.apparatus
    return effect.prior
