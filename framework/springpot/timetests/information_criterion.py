"""How likely each model is where the size of the noise is unknown and neighbours may be alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .residuals_of_tests import InTimePart, Part
from .scatter import Scatter, scatter_of, scatter_of_sweep, times_noise

PLAINLY = 10.0
"""Difference of the Bayesian information criterion that is very strong evidence
(Kass & Raftery 1995, doi:10.1080/01621459.1995.10476572)."""
HINT = 6.0
"""The same where it is strong evidence: neither proof nor nothing."""
ALIKE = 6.0
"""Difference within which two effects cannot be told from one another (the same scale)."""


@dataclass(frozen=True, eq=False)
class Left:
    """What a fit leaves of each test.

    Attributes
    ----------
    count : int
        Parameters of the model.
    residuals : tuple of ndarray
        Of each test over the noise of its signal.
    scatters : tuple of Scatter
        The noise in them.
    """

    count: int
    residuals: tuple[Real, ...]
    scatters: tuple[Scatter, ...]

    @classmethod
    def by(cls, model: Model, theta: Real, reference: float, parts: Sequence[Part]) -> Left:
        """What a model with these parameters leaves of these tests."""
        # By its noise alone, whatever the test weighed in a fit.
        plain = [part.with_scale(1.0) for part in parts]
        residuals = [part.residual(model, theta, reference).value for part in plain]
        scatters = []
        for value, part in zip(residuals, parts, strict=True):
            if isinstance(part, InTimePart):
                scatters.append(scatter_of(value))
            else:
                scatters.append(scatter_of_sweep(value, part.test.sd is not None))
        return cls(len(theta), tuple(residuals), tuple(scatters))

    @property
    def misfit(self) -> bool:
        """Whether some test is missed by more than noise."""
        return any(scatter.misfit for scatter in self.scatters)

    @property
    def doubtful(self) -> bool:
        """Whether some test may well be missed by more than noise."""
        return any(scatter.doubtful for scatter in self.scatters)

    def squares(self, noise: Sequence[Scatter]) -> float:
        """Sum of squares over that noise, a sample counted for what it adds to its neighbours."""
        pairs = zip(self.residuals, noise, strict=True)
        return sum(scatter.surprise(value) for value, scatter in pairs)

    def over(self, noise: Sequence[Scatter]) -> float:
        """Error over that noise, of the worst test."""
        pairs = zip(self.residuals, noise, strict=True)
        return max(times_noise(value, scatter.size) for value, scatter in pairs)


def independent(residuals: Sequence[Real], noise: Sequence[Scatter]) -> float:
    """Number of samples, counting once those whose noise is alike.

    Bayley & Hammersley (1946, doi:10.2307/2983560).
    """
    pairs = zip(residuals, noise, strict=True)
    counts = [
        len(value) * (1.0 - scatter.memory) / (1.0 + scatter.memory) for value, scatter in pairs
    ]
    # Two at least: the logarithm of their number is what a parameter costs.
    return max(float(sum(counts)), 2.0)


def delta_bic(base: Left, other: Left, noise: Sequence[Scatter], more: int) -> float:
    """By how much the Bayesian information criterion falls with `more` parameters."""
    gain = base.squares(noise) - other.squares(noise)
    return float(gain - more * np.log(independent(base.residuals, noise)))
