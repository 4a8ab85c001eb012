"""The linear geometry of a fit: whitened residuals, what the fitted parameters can absorb, and what they cannot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from springpot.identification import weighted
from springpot.measurement import Measurement
from springpot.rheology import Complex, Real

from .bases import orthonormal
from .sweeps import shared_shapes, slow_shapes


@dataclass(frozen=True, eq=False)
class Frame:
    """A fit seen in units of the noise.

    Parameters
    ----------
    measurement : Measurement
        The data, repeats averaged.
    model_stiffness : ndarray of complex, shape (n,)
        K of the fitted model.
    weights : ndarray of complex, shape (n,)
        Reciprocal standard deviations of K' and K''.
    jacobian : ndarray of complex, shape (p, n)
        dK/dtheta at the fit.
    scale_dof : float
        Degrees of freedom behind the common scale of the noise; infinite where it is known.
    """

    measurement: Measurement
    model_stiffness: Complex
    weights: Complex
    jacobian: Complex
    scale_dof: float = inf

    def whiten(self, values: Complex) -> Real:
        """Complex values (..., n) as real ones (..., 2n) in units of the noise."""
        return weighted(values, self.weights)

    @cached_property
    def residual(self) -> Real:
        """Whitened residual (2n,): measured minus modelled."""
        return self.whiten(self.measurement.stiffness - self.model_stiffness)

    @cached_property
    def absorbed(self) -> Real:
        """Orthonormal basis (2n, q) of all that the fitted parameters can follow."""
        return orthonormal(self.whiten(self.jacobian).T)

    @property
    def size(self) -> int:
        """Number of real data."""
        return 2 * len(self.measurement)

    @cached_property
    def rest(self) -> Real:
        """Residual (2n,) without what the fitted parameters can follow."""
        return self.project(self.residual[:, None])[:, 0]

    def scale_draws(self, count: int, rng: np.random.Generator) -> Real | float:
        """Draws (count,) of estimated over true variance, by which a simulated score is to be divided."""
        return 1.0 if self.scale_dof == inf else rng.chisquare(self.scale_dof, count) / self.scale_dof

    def project(self, columns: Real) -> Real:
        """Columns (2n, m) without what the fitted parameters can follow."""
        return columns - self.absorbed @ (self.absorbed.T @ columns)

    def beyond(self, columns: Real, least: float = 1e-6) -> Real:
        """Orthonormal basis (2n, q) of what the fitted parameters cannot follow of some columns (2n, m).

        A column of which less than the share `least` is left is one that they can follow: the rest is rounding.
        """
        size = np.linalg.norm(columns, axis=0)
        columns = columns[:, size > 0] / size[size > 0]
        left = self.project(columns)
        return orthonormal(left[:, np.linalg.norm(left, axis=0) > least], least)

    @cached_property
    def smooth(self) -> Real:
        """Orthonormal basis of slow structure that the parameters cannot follow, shape (2n, q).

        Polynomials along each sweep, in magnitude and in phase: what a missing effect looks like,
        whichever it is.
        """
        return self.beyond(self.relative(slow_shapes(self.measurement)))

    @cached_property
    def shared(self) -> Real:
        """Orthonormal basis (2n, q) of what is alike in all sweeps at a frequency and is not slow."""
        columns = self.relative(shared_shapes(self.measurement))
        return self.beyond(columns - self.smooth @ (self.smooth.T @ columns))

    @cached_property
    def structured(self) -> Real:
        """Orthonormal basis (2n, q) of all that would be no noise: slow along a sweep, or alike in all of them."""
        return np.concatenate([self.smooth, self.shared], axis=1)

    @cached_property
    def rough(self) -> Real:
        """Residual (2n,) that neither the parameters nor structure can follow: noise, if all is well."""
        return self.rest - self.structured @ (self.structured.T @ self.rest)

    @property
    def rough_dof(self) -> int:
        """Degrees of freedom of `rough`."""
        return self.size - int(self.absorbed.shape[1]) - int(self.structured.shape[1])

    def relative(self, shapes: Real) -> Real:
        """Shapes (m, n) as changes of magnitude and of phase, whitened, as columns (2n, 2m)."""
        columns = [self.whiten(factor * self.model_stiffness * shapes) for factor in (1.0, 1.0j)]
        return np.concatenate(columns).T
