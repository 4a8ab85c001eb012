"""Optimisers that are asked for points and told values, so that several may be out at once."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from springpot.rheology.points import Real

from .recorder import Recorder
from .runs import Optimiser


class Enquiry(ABC):
    """A search that is asked for points of the unit cube and told their values, in any order."""

    @abstractmethod
    def ask(self) -> Real:
        """Next point (d,) to evaluate; others may be out, asked for and not told yet."""

    @abstractmethod
    def tell(self, u: Real, value: float) -> None:
        """Take the objective at a point (d,) that was asked for.

        Parameters
        ----------
        u : ndarray, shape (d,)
            The point.
        value : float
            Its objective.
        """


class AskingOptimiser(Optimiser):
    """An optimiser that can be asked: several of its points may be evaluated at the same time."""

    @abstractmethod
    def enquiry(self, dimension: int, budget: int, rng: np.random.Generator) -> Enquiry:
        """Begin a search.

        Parameters
        ----------
        dimension : int
            Number of parameters.
        budget : int
            Evaluations that will be counted.
        rng : numpy.random.Generator
            The only source of randomness.
        """

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Ask for one point after another until the recorder ends the run."""
        enquiry = self.enquiry(problem.dimension, budget, rng)
        width = problem.upper - problem.lower
        while True:
            u = enquiry.ask()
            enquiry.tell(u, problem(problem.lower + u * width))
