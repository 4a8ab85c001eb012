"""Bayesian optimisation by the library bayesian-optimization, for evaluations that cost much.

Imported when its name is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log10
from typing import Any, ClassVar

import numpy as np

from springpot.identification import AskingOptimiser, Card, Enquiry
from springpot.rheology import Real

from .cube import integer, seeded
from .families import family

PREFIX = "bayesian-"
LIBRARY = "bayes_opt"
INSTALL = "pip install 'springpot[surrogate]'"
LEAST = 1e-12
"""Objective below which its logarithm tells no more."""


@dataclass(frozen=True)
class ExpectedImprovement(AskingOptimiser):
    """A Gaussian process of the objective's logarithm, asked where it expects the most.

    Points that are still being evaluated are taken for as good as the mean of those told (a
    constant liar), so that several can be out at once: as good as the best, the library's own
    choice, it would rather ask anywhere else.

    Parameters
    ----------
    initial : int
        Uniform points before the process is asked; 0 takes two for each parameter.
    xi : float
        Improvement of the logarithm that is not worth an evaluation.
    """

    initial: int = 0
    xi: float = 0.0

    name: ClassVar[str] = f"{PREFIX}ei"
    card: ClassVar[Card] = Card(
        "Gaussian process and expected improvement (bayesian-optimization)",
        "Jones et al. 1998, doi:10.1023/A:1008306431147; Ginsbourger et al. 2010 (constant liar)",
        distribution="bayesian-optimization",
    )

    def __post_init__(self) -> None:
        self._require("initial", self.initial >= 0, "at least 0")
        self._require("xi", self.xi >= 0, "at least 0")

    def enquiry(self, dimension: int, budget: int, rng: np.random.Generator) -> Enquiry:
        """A search that can be asked for points."""
        return _Asked(self, dimension, rng)


class _Asked(Enquiry):
    def __init__(
        self, options: ExpectedImprovement, dimension: int, rng: np.random.Generator
    ) -> None:
        from bayes_opt import BayesianOptimization, acquisition

        self._rng, self._first = rng, options.initial or 2 * dimension
        self._names = [f"u{i:03d}" for i in range(dimension)]
        self._search: Any = BayesianOptimization(
            None,
            dict.fromkeys(self._names, (0.0, 1.0)),
            acquisition_function=acquisition.ConstantLiar(
                acquisition.ExpectedImprovement(xi=options.xi), strategy="mean"
            ),
            random_state=integer(rng),
            verbose=0,
            allow_duplicate_points=True,
        )
        self._asked = self._told = 0

    def ask(self) -> Real:
        """Next point (d,) of the cube."""
        self._asked += 1
        # Before anything is told there is nothing to model.
        if self._asked <= self._first or self._told == 0:
            return self._rng.random(len(self._names))
        with seeded(self._rng):
            asked = self._search.suggest()
        return np.array([float(asked[name]) for name in self._names])

    def tell(self, u: Real, value: float) -> None:
        """Take the objective at a point (d,) that was asked for."""
        if not np.isfinite(value):
            return
        self._told += 1
        # The library climbs.
        height = -log10(max(value, LEAST))
        self._search.register(dict(zip(self._names, u.tolist(), strict=True)), height)


FAMILY = family(
    PREFIX,
    "ei: a Gaussian process, by bayesian-optimization",
    LIBRARY,
    INSTALL,
    {ExpectedImprovement.name: ExpectedImprovement},
)
