"""What a fit leaves of each test, and how likely that makes it.

The size of the noise may be unknown, and neighbours may be alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.identification.material import is_material, own_parameters
from springpot.identification.value import PartResult
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .imposed_noise import felt
from .residuals_of_tests import TestPart
from .scatter import ResidualScatter, times_noise
from .where import rms


@dataclass(frozen=True, eq=False)
class Left:
    """What a fit leaves of each test.

    Attributes
    ----------
    count : int
        Parameters of the model that it answers for: all but the lines of a free spectrum.
    residuals : tuple of ndarray
        Of each test over the noise of its signal.
    scatters : tuple of ResidualScatter
        The noise in them.
    rounded : tuple of ndarray
        Of each test the errors that its digits may make of what the fit says, in the units of its
        residual (k, m); no rows where they are fine.
    felt : tuple of ndarray
        Of each test what the fit answers to noise of the imposed channel, likewise (m,).
    lines : int
        Weights of a free spectrum that are above zero. How many there are is chance, and that all
        models with one share it no reason to prefer one of them: each costs what it follows of the
        noise, and no more (Meyer and Woodroofe 2000, doi:10.1214/aos/1015956708).
    """

    count: int
    residuals: tuple[Real, ...]
    scatters: tuple[ResidualScatter, ...]
    rounded: tuple[Real, ...]
    felt: tuple[Real, ...]
    lines: int = 0

    @classmethod
    def by(cls, model: Model, theta: Real, reference: float, parts: Sequence[TestPart]) -> Left:
        """What a model with these parameters leaves of these tests."""
        # By its noise alone, whatever the test weighed in a fit.
        plain = [part.with_scale(1.0) for part in parts]
        residuals = [part.residual(model, theta, reference).value for part in plain]
        scatters = [part.scatter(value) for part, value in zip(parts, residuals, strict=True)]
        rounded = [part.rounded(value) for part, value in zip(plain, residuals, strict=True)]
        heard = [felt(part, model, theta, reference) for part in plain]
        lines = 0
        if is_material(model):
            lines = int(np.count_nonzero(theta[: len(model.material.parameters)]))
            theta = theta[own_parameters(model)]
        told = tuple(residuals), tuple(scatters), tuple(rounded), tuple(heard)
        return cls(len(theta), *told, lines)

    @property
    def noise(self) -> list[ResidualScatter]:
        """The noise of each test, as this fit alone tells it."""
        # Of a test that is missed the upper part of the spectrum may be misfit too, as corners are:
        # there it is no larger than the signal itself says.
        return [
            replace(scatter, size=min(scatter.size, 1.0)) if scatter.misfit else scatter
            for scatter in self.scatters
        ]

    @property
    def chance(self) -> float:
        """That noise alone leaves so much of the test that is missed most."""
        return min(scatter.chance for scatter in self.scatters)

    @property
    def misfit(self) -> bool:
        """Whether some test is missed by more than noise."""
        return any(scatter.misfit for scatter in self.scatters)

    @property
    def doubtful(self) -> bool:
        """Whether some test may well be missed by more than noise."""
        return any(scatter.doubtful for scatter in self.scatters)

    def beside(self, noise: Sequence[ResidualScatter]) -> Left:
        """The same, judged over that noise too: the one that its error is told in."""
        told = [
            replace(own, local=min(own.local, other.chance_of(value, own)))
            for value, own, other in zip(self.residuals, self.scatters, noise, strict=True)
        ]
        return replace(self, scatters=tuple(told))

    def rows(
        self,
        parts: Sequence[TestPart],
        noise: Sequence[ResidualScatter],
        told: Sequence[PartResult],
    ) -> tuple[PartResult, ...]:
        """Each test beside that noise, of which a fit has told with the noise of its signal."""
        rows = []
        for part, residual, scatter, row in zip(parts, self.residuals, noise, told, strict=True):
            error = rms(residual * part.relative_sd)
            ratio, floor = times_noise(residual, scatter.size), 0.0
            # A fit that leaves nothing at all says nothing of the noise.
            if ratio:
                floor = error / ratio
            # Whatever the noise, together and alone have one.
            alone = ratio * row.over_floor_alone / max(row.over_floor, 1e-300)
            rows.append(
                replace(
                    row,
                    relative_rms=error,
                    noise_floor=floor,
                    over_floor=ratio,
                    over_floor_alone=alone,
                )
            )
        return tuple(rows)

    def squares(self, noise: Sequence[ResidualScatter]) -> float:
        """Sum of squares over that noise, a sample counted for what it adds to its neighbours."""
        told = zip(self.residuals, noise, self.scatters, strict=True)
        return sum(scatter.squares(value, own) for value, scatter, own in told)

    def squares_felt(self, noise: Sequence[ResidualScatter]) -> float:
        """The same that noise of the imposed channels is to be expected to leave."""
        pairs = zip(self.felt, noise, strict=True)
        return sum(float(np.sum(scatter.whitened(value) ** 2)) for value, scatter in pairs)

    def over(self, noise: Sequence[ResidualScatter]) -> float:
        """Error over that noise, of the worst test."""
        pairs = zip(self.residuals, noise, strict=True)
        return max(times_noise(value, scatter.size) for value, scatter in pairs)


def independent(residuals: Sequence[Real], noise: Sequence[ResidualScatter]) -> float:
    """Number of samples, counting once those whose noise is alike.

    Bayley & Hammersley (1946, doi:10.2307/2983560).
    """
    pairs = zip(residuals, noise, strict=True)
    counts = [
        len(value) * (1.0 - scatter.memory) / (1.0 + scatter.memory) for value, scatter in pairs
    ]
    # Two at least: the logarithm of their number is what a parameter costs.
    return max(float(sum(counts)), 2.0)


def _alike(base: Left, other: Left, noise: Sequence[ResidualScatter]) -> float:
    """By how much rounding varies more than noise along what another fit changes; at least 1.

    Rounding to a coarse digit errs alike wherever the signal comes by again, so that as many
    samples tell less, as those of a cluster do (Kish 1965, Survey Sampling, section 5.4).
    """
    pairs = zip(base.residuals, other.residuals, noise, strict=True)
    changes = [scatter.whitened(one - two) for one, two, scatter in pairs]
    size, varied = sum(float(change @ change) for change in changes), 0.0
    for change, errors, scatter in zip(changes, base.rounded, noise, strict=True):
        share = 0.0
        if len(errors):
            share = min(float(np.mean(errors**2)) / scatter.size**2, 1.0)
        varied += (1.0 - share) * float(change @ change)
        if share > 0.0:
            drawn = np.array([scatter.whitened(row) for row in errors])
            varied += share * float(np.mean((drawn @ change) ** 2) / np.mean(drawn**2))
    return max(varied / max(size, 1e-300), 1.0)


def delta_bic(base: Left, other: Left, noise: Sequence[ResidualScatter], more: int) -> float:
    """By how much the Bayesian information criterion falls with `more` parameters."""
    # To answer less to what the specimen never felt is no evidence.
    spared = max(base.squares_felt(noise) - other.squares_felt(noise), 0.0)
    gain = (base.squares(noise) - other.squares(noise) - spared) / _alike(base, other, noise)
    gain += base.lines - other.lines
    return float(gain - more * np.log(independent(base.residuals, noise)))
