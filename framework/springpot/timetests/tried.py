"""An effect on tests in time: what a scan promises of it, and what became of it when tried."""

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
class Promise:
    """One effect at one place of its parameters.

    Attributes
    ----------
    effect : Effect
        The effect.
    values : tuple of float
        Its parameters, as large as the record asks for.
    theta : ndarray, shape (p,)
        Parameters of the model beside it.
    drop : float
        By how much the sum of squares would fall.
    amount : float
        Of what was tried: far from one, it is no longer the effect that was tried.
    direction : ndarray, shape (m,)
        What it adds to the residuals that the model cannot take over, of length one.
    as_its_size : bool
        Whether it grows as a parameter of it does, so that a linear step leads to it.
    """

    effect: Effect
    values: tuple[float, ...]
    theta: Real
    drop: float
    amount: float
    direction: Real
    as_its_size: bool

    def start(self, base: Identification, model: Model, *, moved: bool = False) -> Real:
        """A start (p,) for the model with the effect.

        What it promises beside the parameters of the fit.

        Parameters
        ----------
        base : Identification
            The fit that was scanned.
        model : Model
            Its model with the effect.
        moved : bool
            Let the parameters of the fit make way for the effect, as far as a linear step says.
        """
        theta = base.theta
        if moved:
            theta = self.theta
        known = dict(zip(base.model.names, theta.tolist(), strict=True))
        new = [parameter for parameter in model.parameters if parameter.name not in known]
        for parameter, value in zip(new, self.values, strict=True):
            known[parameter.name] = float(np.clip(value, parameter.lower, parameter.upper))
        # Lines of a free spectrum, which the fit has and the model not yet, are found anew.
        return model.vector({name: known[name] for name in model.names})


@dataclass(frozen=True, eq=False)
class Atom:
    """A column: what an effect adds to the residuals of all tests, for an amount of one.

    Attributes
    ----------
    effect : Effect
        The effect.
    values : ndarray, shape (q,)
        Its parameters at that amount.
    powers : ndarray, shape (q,)
        With which power of the amount each of them goes.
    column : ndarray, shape (m,)
        The change of the residuals.
    signed : bool
        Whether a negative amount makes sense.
    """

    effect: Effect
    values: Real
    powers: Real
    column: Real
    signed: bool

    def at(self, amount: float) -> tuple[float, ...]:
        """Its parameters for an amount."""
        # A force grows with the amount; a time or an order, whose power is zero, stays what it is.
        size = abs(amount) ** self.powers
        sign = np.where((self.powers != 0.0) & (amount < 0.0), -1.0, 1.0)
        return tuple((self.values * size * sign).tolist())


TWINS = 0.995
"""Cosine between what two effects leave in a record from which they are one to it, whatever the
fits say: told apart they would need a hundred times the evidence that finds them."""


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
