"""LIPO of dlib, by the library lipo where it is installed.

Its package is built from source, and what it costs grows with the evaluations: it is for some
hundreds of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from springpot.identification import AskingOptimiser, Card, Enquiry
from springpot.rheology import Real

from .cube import integer
from .families import family

PREFIX = "lipo-"
INSTALL = "pip install 'springpot[lipo]'"


@dataclass(frozen=True)
class MaxLipo(AskingOptimiser):
    """Upper bounds by a Lipschitz constant that is learnt, in turn with a trust region."""

    name: ClassVar[str] = f"{PREFIX}tr"
    card: ClassVar[Card] = Card(
        "LIPO with a trust region (dlib)",
        "Malherbe and Vayatis 2017, arXiv:1703.02628; King 2017, blog.dlib.net",
        distribution="lipo",
    )

    def enquiry(self, dimension: int, budget: int, rng: np.random.Generator) -> Enquiry:
        """A search that can be asked for points."""
        return _Candidates(dimension, integer(rng))


class _Candidates(Enquiry):
    def __init__(self, dimension: int, seed: int) -> None:
        from lipo import GlobalOptimizer

        self._names = [f"u{i:03d}" for i in range(dimension)]
        self._search: Any = GlobalOptimizer(
            lower_bounds=dict.fromkeys(self._names, 0.0),
            upper_bounds=dict.fromkeys(self._names, 1.0),
            log_args=[],
            maximize=False,
            random_state=seed,
        )
        self._out: dict[bytes, Any] = {}

    def ask(self) -> Real:
        """Next point (d,) of the cube."""
        candidate = self._search.get_candidate()
        told = candidate.x
        u = np.array([float(told[name]) for name in self._names])
        self._out[u.tobytes()] = candidate
        return u

    def tell(self, u: Real, value: float) -> None:
        """Take the objective at a point (d,) that was asked for."""
        candidate = self._out.pop(u.tobytes())
        # What is infinite has no upper bound: that candidate stays open.
        if np.isfinite(value):
            candidate.set(value)


FAMILY = family(PREFIX, "tr: LIPO of dlib, by lipo", "lipo", INSTALL, {MaxLipo.name: MaxLipo})
