"""How far two explanations lie apart after a measurement, when one may follow the other.

What is left between them is expressed in standard deviations (the T-criterion of Atkinson and Fedorov 1975,
doi:10.1093/biomet/62.1.57).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from springpot.identification import weighted
from springpot.rheology import GRADIENT, Complex, Real

from .actions import Action
from .bases import orthonormal
from .refit import Refit

EVALUATIONS = 40
FAR = 1e9
"""Stands for a difference beyond all numbers."""


@dataclass(frozen=True, eq=False)
class Clash:
    """Two explanations after an action, both of which follow the old data.

    Attributes
    ----------
    truth, rival : Refit
        The one that holds, and the one that may change its parameters to follow it.
    action : Action
        What would be measured.
    """

    truth: Refit
    rival: Refit
    action: Action

    @property
    def linear(self) -> float:
        """Standard deviations between the two where the rival follows as its slopes tell."""
        residual, slopes = self._seen(self.rival.theta)
        usable = np.all(np.isfinite(slopes), axis=1) & (np.sum(slopes**2, axis=1) > 0)
        if not np.all(np.isfinite(residual)):
            return 0.0
        absorbed = orthonormal(slopes[usable].T)
        left = residual - absorbed @ (absorbed.T @ residual)
        return float(np.sqrt(left @ left))

    def fitted(self) -> float:
        """The same where the rival is fitted to old and new points together."""
        parameters = self.rival.model.parameters
        logs = np.array([parameter.scale == "log" for parameter in parameters])
        bounds = np.array([(parameter.lower, parameter.upper) for parameter in parameters])
        with np.errstate(divide="ignore", invalid="ignore"):
            limits = np.where(logs[:, None], np.log(bounds), bounds)
        start = np.where(logs, np.log(np.maximum(self.rival.theta, 1e-300)), self.rival.theta)
        inside = np.clip(start, limits[:, 0] + 1e-9, limits[:, 1] - 1e-9)

        def theta(x: Real) -> Real:
            return np.where(logs, np.exp(np.minimum(x, 700.0)), x)

        def residual(x: Real) -> Real:
            return np.clip(np.nan_to_num(self._seen(theta(x))[0], nan=FAR), -FAR, FAR)

        def jacobian(x: Real) -> Real:
            scale = np.where(logs, theta(x), 1.0)
            slopes: Real = np.clip(-np.nan_to_num(self._seen(theta(x))[1] * scale[:, None], nan=0.0), -FAR, FAR).T
            return slopes

        # Parameters differ in size by many decades, and their columns carry the units: scaled by the columns.
        found = least_squares(
            residual, inside, jacobian, (limits[:, 0], limits[:, 1]), x_scale="jac", max_nfev=EVALUATIONS
        )
        return float(np.sqrt(2.0 * found.cost))

    @cached_property
    def _target(self) -> tuple[Complex, Complex]:
        """K of the truth at old and new points (n,), and their weights."""
        new = self._evaluated(self.truth, self.truth.theta)[0]
        noise, size = self.truth.noise.sd, np.abs(self.truth.stiffness)
        relative = complex(np.median(noise.real / size), np.median(noise.imag / size)) * self._quieter()
        # Without a specimen the force is small, and its noise is not.
        floor = np.abs(new) if self.action.scale else np.maximum(np.abs(new), float(np.median(size)))
        weights = np.sqrt(self.action.repeats) / np.maximum(floor, 1e-300)
        weights = weights / relative.real + 1j * weights / relative.imag
        return np.concatenate([self.truth.stiffness, new]), np.concatenate([self.truth.noise.weights, weights])

    def _quieter(self) -> float:
        """How much smaller the new amplitude is than the usual one: at worst the noise is a force of fixed size."""
        usual, new = self.truth.fit.measurement.points.amplitude, self.action.points.amplitude
        return 1.0 if usual is None or new is None else max(1.0, float(np.median(usual) / np.median(new)))

    def _seen(self, theta: Real) -> tuple[Real, Real]:
        """Whitened difference of truth and rival at old and new points (2n,), and the rival's slopes (p, 2n)."""
        old = self.truth.fit.measurement.points
        with np.errstate(all="ignore"):
            response = self.rival.model.network.respond(theta, old, GRADIENT)
        value, by_theta = self._evaluated(self.rival, theta)
        target, weights = self._target
        slopes = weighted(np.concatenate([response.by_theta, by_theta], axis=1), weights)
        return weighted(target - np.concatenate([response.value, value]), weights), slopes

    def _evaluated(self, refit: Refit, theta: Real) -> tuple[Complex, Complex]:
        """K and dK/dtheta where the action would measure, the specimen being larger, absent or a known mass."""
        scale, mass = self.action.scale, self.action.mass
        network = refit.model.network if scale == 1.0 else refit.model.resized(max(scale, 1e-9), mass)
        with np.errstate(all="ignore"):
            response = network.respond(theta, self.action.points, GRADIENT)
        return response.value, response.by_theta
