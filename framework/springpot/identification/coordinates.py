"""Search coordinates.

Every parameter as a ratio to its natural size, so that all directions are alike.

A parameter searched by its logarithm becomes ln(theta / size). A springpot's constant becomes the
logarithm of its stiffness at the reference frequency, c omega^alpha, which unlike c itself is all
but independent of alpha.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Complex, Real

Slopes = TypeVar("Slopes", Real, Complex)

WIDEST = 12.0 * float(np.log(10.0))
"""A parameter twelve decades from its natural size leaves no trace in the data."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The map between a model's parameters and the coordinates of the native solver.

    Parameters
    ----------
    parameters : sequence of Parameter
        The model's parameters.
    size : ndarray, shape (B, p)
        Natural size for each data set, without the power of time of a fractional order.
    log : ndarray of bool, shape (p,)
        Which are searched by their logarithm.
    pairs : tuple of (int, int)
        Positions of each constant whose unit holds a fractional order, and of that order.
    log_omega : float
        Logarithm of the reference frequency.
    amplitude : float
        Typical amplitude.
    """

    parameters: tuple[Parameter, ...]
    size: Real
    log: NDArray[np.bool_]
    pairs: tuple[tuple[int, int], ...]
    log_omega: float
    amplitude: float = 1.0

    @classmethod
    def of(
        cls,
        parameters: Sequence[Parameter],
        log_omega: float,
        stiffness: Real,
        amplitude: float = 1.0,
    ) -> Coordinates:
        """Coordinates for data of these sizes.

        Parameters
        ----------
        parameters : sequence of Parameter
            The model's parameters, length p.
        log_omega : float
            Mean logarithm of the angular frequencies.
        stiffness : ndarray, shape (B,)
            Typical |K| of each data set.
        amplitude : float
            Typical amplitude.
        """
        # Remembered for each model: a study fits one to thousands of data sets.
        layout = _layout(tuple(parameters))
        return cls(
            tuple(parameters),
            layout.sizes(log_omega, stiffness, amplitude),
            layout.log,
            layout.pairs,
            log_omega,
            amplitude,
        )

    def at_unit_stiffness(self) -> Coordinates:
        """The same for data whose typical |K| is 1, shape (1, p)."""
        size = _layout(self.parameters).sizes(self.log_omega, np.ones(1), self.amplitude)
        return replace(self, size=size)

    def rows(self, which: NDArray[np.intp]) -> Coordinates:
        """Those of some of the data sets."""
        return replace(self, size=self.size[which])

    def theta(self, u: Real, size: Real) -> Real:
        """Parameters (..., p) at `u` (..., p), the sizes being `size` (..., p)."""
        # A trial may overflow: it then has no finite objective and is taken back.
        with np.errstate(over="ignore"):
            theta: Real = np.where(self.log, np.exp(u), u) * size
            for constant, order in self.pairs:
                theta[..., constant] *= np.exp(-self.log_omega * theta[..., order])
        return theta

    def u(self, theta: Real, size: Real) -> Real:
        """Search coordinates (..., p) of the parameters `theta` (..., p)."""
        ratio = theta / size
        for constant, order in self.pairs:
            ratio[..., constant] *= np.exp(self.log_omega * theta[..., order])
        # Zero has no logarithm: it is put further down than any search goes.
        tiny = np.exp(-2.0 * WIDEST)
        return np.where(self.log, np.log(np.where(self.log, np.maximum(ratio, tiny), 1.0)), ratio)

    def carry(self, by_theta: Slopes, theta: Real, size: Real) -> Slopes:
        """Turn derivatives by theta (..., p, m) into those by u, in place."""
        for constant, order in self.pairs:
            # The coordinate of c stands still while the order moves: c itself then has to follow,
            # as omega^-alpha.
            drift = -self.log_omega * theta[..., constant, None]
            by_theta[..., order, :] += drift * by_theta[..., constant, :]
        # d theta / du is theta itself of a logarithm, and the size of a ratio.
        by_theta *= np.where(self.log, theta, size)[..., None]
        return by_theta

    def slopes(self, theta: Real, size: Real) -> Real:
        """Derivative of theta by u at one point, shape (p, p)."""
        return self.carry(np.eye(len(theta)), theta, size).T

    def bounds(self) -> tuple[Real, Real]:
        """Lower and upper u for each data set, shape (B, p).

        Half-open ones end twelve decades from the natural size.
        """
        lower = np.array([p.lower for p in self.parameters]) / self.size
        upper = np.array([p.upper for p in self.parameters]) / self.size
        with np.errstate(divide="ignore", invalid="ignore"):
            low = np.where(self.log, np.log(np.maximum(lower, 0.0)), lower)
            high = np.where(self.log, np.log(np.maximum(upper, 0.0)), upper)
        # A range with two ends is searched to both of them.
        ended = ~self.log.astype(bool) | (np.isfinite(low) & np.isfinite(high))
        low = np.where(ended, low, np.maximum(low, -WIDEST))
        return low, np.where(ended, high, np.minimum(high, WIDEST))


@dataclass(frozen=True, eq=False)
class _Layout:
    """What a model's parameters say about its coordinates, whatever the data."""

    base: Real
    powers: Real
    log: NDArray[np.bool_]
    pairs: tuple[tuple[int, int], ...]

    def sizes(self, log_omega: float, stiffness: Real, amplitude: float) -> Real:
        """Natural sizes (B, p) of the parameters of data with these |K| (B,)."""
        ends = np.array([-log_omega, np.log(amplitude)])
        # A product of powers of |K|, time and amplitude, by its logarithm.
        logs = np.log(stiffness)[:, None] * self.powers[0] + ends @ self.powers[1:]
        sizes: Real = np.exp(logs) * self.base
        return sizes


@lru_cache(maxsize=256)
def _layout(parameters: tuple[Parameter, ...]) -> _Layout:
    names = {parameter.name: i for i, parameter in enumerate(parameters)}
    pairs = tuple((i, names[p.unit.time]) for i, p in enumerate(parameters) if p.unit.time in names)
    sized = [_size(p) for p in parameters]
    return _Layout(
        np.array([size[0] for size in sized]),
        np.array([size[1:] for size in sized]).reshape(-1, 3).T,
        np.array([p.scale == "log" for p in parameters]),
        pairs,
    )


def _size(parameter: Parameter) -> tuple[float, float, float, float]:
    """Natural size as a factor and powers of |K|, time and amplitude."""
    if parameter.scale == "linear" and np.isfinite(parameter.upper - parameter.lower):
        # What has two ends, such as an order, is measured by the way between them, whatever the
        # data.
        return parameter.upper - parameter.lower, 0.0, 0.0, 0.0
    unit = parameter.unit
    # A power of time that is itself a parameter is dealt with where its value is known: see
    # `pairs`.
    time = 0.0
    if not isinstance(unit.time, str):
        time = float(unit.time)
    return parameter.typical, float(unit.stiffness), time, float(unit.amplitude)
