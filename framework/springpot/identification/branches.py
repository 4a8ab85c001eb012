"""Variable projection.

The gains of a network's branches are linear, so only the shapes need a search.

A network is linear in the gain of each branch of its outermost composition: stiffnesses of parallel
branches add, compliances of branches in series add (G. H. Golub and V. Pereyra, 1973,
doi:10.1137/0710036; the Jacobian is that of L. Kaufman, 1975, doi:10.1007/BF01932995).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.model import Model
from springpot.rheology.nodes import Chain, Node, Parallel, Renamed, Series, Shift
from springpot.rheology.points import Complex, Real

LEAST_GAIN = 1e-7
"""Smallest share of the data that a branch is given; a logarithm cannot start at zero."""


@dataclass(frozen=True, eq=False)
class Branches:
    """The branches of a network's outermost composition.

    Parameters
    ----------
    compliance : bool
        Whether their compliances add, rather than their stiffnesses.
    gains : ndarray, shape (m, p)
        Power of stiffness of each parameter, in the row of the branch it belongs to.
    owner : ndarray of int, shape (p,)
        Branch of each parameter, or -1 for those of the measurement chain or of a frequency shift.
    """

    compliance: bool
    gains: Real
    owner: NDArray[np.intp]

    @classmethod
    def of(cls, network: Node) -> Branches:
        """The branches of `network`, seen through measurement chain and frequency shift."""
        powers = np.array([float(p.unit.stiffness) for p in network.parameters])
        node = network
        while isinstance(node, Renamed | Chain | Shift):
            # Chains and shifts act on the whole: the sum of branches stands inside them, as the
            # first child.
            if isinstance(node, Renamed):
                node = node.node
            else:
                node = node.children[0]
        if isinstance(node, Parallel | Series):
            sizes = [len(child.parameters) for child in node.children]
            owner = np.full(len(powers), -1)
            owner[: sum(sizes)] = np.repeat(np.arange(len(sizes)), sizes)
            gains = np.where(owner == np.arange(len(sizes))[:, None], powers, 0.0)
            if np.all(np.any(gains != 0.0, axis=1)):
                return cls(isinstance(node, Series), gains, owner)
        # No sum, or a branch without a stiffness to scale it by: then the network has one gain as a
        # whole.
        return cls(False, powers[None, :], np.zeros(len(powers), dtype=np.intp))

    @cached_property
    def leaders(self) -> NDArray[np.intp]:
        """The first stiffness of each branch, which its gain stands for."""
        scaled = self.gains != 0.0
        leaders: NDArray[np.intp] = np.argmax(scaled, axis=1)[np.any(scaled, axis=1)]
        return leaders

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """The other parameters, which give the branches their shapes."""
        return np.setdiff1d(np.arange(len(self.owner)), self.leaders)

    @cached_property
    def _steps(self) -> Real:
        """Derivative of ln theta by the logarithm of the leader of its branch, shape (m, p)."""
        if not len(self.leaders):
            return self.gains
        steps: Real = self.gains / self.gains[np.arange(len(self.gains)), self.leaders][:, None]
        return steps

    def shaped(self, v: Real, log: NDArray[np.bool_]) -> Real:
        """Search coordinates (..., p) of shapes (..., d) at unit gain."""
        base = np.zeros(len(log))
        base[self.leaders] = ~log[self.leaders]
        u: Real = np.matmul(v, self._places) + base
        return u

    @cached_property
    def _places(self) -> Real:
        """Where the shape coordinates go, shape (d, p)."""
        places: Real = np.eye(len(self.owner))[self.free]
        return places

    def shape(self, u: Real, log: NDArray[np.bool_]) -> Real:
        """Shapes (..., d) of search coordinates (..., p)."""
        if not len(self.leaders):
            return u
        led = np.where(log[self.leaders], u[..., self.leaders], 0.0)
        return self._moved(u, np.matmul(-led, self._steps), log)[..., self.free]

    def scaled(self, u: Real, log_gain: Real, log: NDArray[np.bool_]) -> Real:
        """Search coordinates (..., p) with the branches' gains (..., m) multiplied in."""
        return self._moved(u, np.matmul(log_gain, self.gains), log)

    def _moved(self, u: Real, change: Real, log: NDArray[np.bool_]) -> Real:
        # The exponent is zero where it is not asked for: it could overflow there.
        return np.where(log, u + change, u * np.exp(np.where(log, 0.0, change)))

    def shares(self, theta: Real, value: Complex, by_theta: Complex) -> Complex:
        """What each branch adds to K, or to 1/K, shape (r, m, n).

        K is homogeneous of degree one in the stiffnesses, so that by Euler's theorem a branch's
        share of it is the derivative by the logarithm of the branch's gain.
        """
        shares: Complex = np.matmul(self.gains * theta[:, None, :], by_theta)
        if self.compliance:
            shares /= (value * value)[:, None, :]
        return shares


@lru_cache(maxsize=128)
def branches_of(model: Model) -> Branches:
    """The branches of a model's network, found once."""
    return Branches.of(model.network)


def interleaved(values: Complex) -> Real:
    """Real and imaginary parts in turn along the last axis."""
    parts: Real = np.ascontiguousarray(values).view(np.float64)
    return parts


def plane_data(stiffness: Complex, weights: Complex, compliance: bool) -> tuple[Real, Real]:
    """Data and weights (B, 2n) in the plane in which the branches add."""
    if not compliance:
        return interleaved(stiffness), interleaved(weights)
    # 1/K mixes the parts of K, so both get the mean of their weights; d(1/K) = -dK / K^2.
    size = np.abs(weights) * np.abs(stiffness) ** 2 / np.sqrt(2.0)
    return interleaved(1.0 / stiffness), np.repeat(size, 2, axis=-1)


def non_negative(matrix: Real, right: Real) -> tuple[Real, Real]:
    """Minimise x M x - 2 b x with every x at least `LEAST_GAIN`.

    Parameters
    ----------
    matrix : ndarray, shape (..., m, m)
        M, with a unit diagonal.
    right : ndarray, shape (..., m)
        b.

    Returns
    -------
    x : ndarray, shape (..., m)
        The minimum.
    inverse : ndarray, shape (..., m, m)
        Inverse of M among those x that are not held at the least value, zero elsewhere.
    """
    inverse = _inverse(matrix)
    x: Real = np.matmul(inverse, right[..., None])[..., 0]
    # Mostly all gains are positive at once; only the others need a search for those to be held.
    held = x < LEAST_GAIN
    if not held.any():
        return x, inverse
    wrong = held.any(axis=-1)
    part, b = matrix[wrong], right[wrong]
    x[wrong] = _descended(part, b, np.maximum(x[wrong], LEAST_GAIN))
    free = x[wrong] > LEAST_GAIN
    inner = free[:, :, None] & free[:, None, :]
    inverse[wrong] = np.where(inner, _inverse(np.where(inner, part, np.eye(b.shape[-1]))), 0.0)
    return x, inverse


def _inverse(matrix: Real) -> Real:
    """Inverse of matrices with a unit diagonal."""
    m = matrix.shape[-1]
    if m == 1:
        return np.ones_like(matrix)
    if m > 2:
        try:
            # Branches of nearly one shape: so little on the unit diagonal is no more than rounding.
            return np.asarray(np.linalg.inv(matrix + 1e-15 * np.eye(m)), dtype=float)
        except np.linalg.LinAlgError:  # two branches of one shape
            return np.asarray(np.linalg.inv(matrix + 1e-11 * np.eye(m)), dtype=float)
    inverse = np.empty_like(matrix)
    # Of two branches the inverse is a formula.
    off = matrix[..., 0, 1]
    inverse[..., 0, 0] = inverse[..., 1, 1] = 1.0 / (1.0 - off * off + 1e-15)
    inverse[..., 0, 1] = inverse[..., 1, 0] = -off * inverse[..., 0, 0]
    return inverse


def _descended(matrix: Real, right: Real, x: Real) -> Real:
    """The same by coordinate descent from `x`, of shape (r, m)."""
    m = x.shape[1]
    passes = 6 * m
    # Where one of two gains is held, a single pass finds the other.
    if m == 2:
        passes = 1
    for _ in range(passes):
        for i in range(m):
            slope = right[:, i] - (matrix[:, i] * x).sum(axis=1)
            x[:, i] = np.maximum(x[:, i] + slope, LEAST_GAIN)
    return x


def project(shares: Real, target: Real) -> tuple[Real, Real, Real]:
    """Non-negative gains that bring the weighted shares closest to the weighted target.

    The shares are (r, m, q), the target is (r or 1, q).

    Returns
    -------
    gains : ndarray, shape (r, m)
        Their gains.
    residual : ndarray, shape (r, q)
        What is left.
    inverse : ndarray, shape (r, m, m)
        Inverse of the Gram matrix of the shares whose gains are not held at their least value.
    """
    # Normal equations of a few branches: what they lose in digits the descent in all parameters
    # brings back.
    gram = np.matmul(shares, shares.transpose(0, 2, 1))
    m = gram.shape[-1]
    # All columns and the target get length one, so that the least gain is a share of the data.
    unit = 1.0 / np.sqrt(gram.reshape(-1, m * m)[:, :: m + 1] + 1e-300)
    units = unit[:, :, None] * unit[:, None, :]
    size = np.sqrt((target * target).sum(axis=1, keepdims=True))
    right = np.matmul(shares, target[:, :, None])[:, :, 0] * unit
    x, inverse = non_negative(gram * units, right / size)
    gains = x * size * unit
    residual = np.matmul(gains[:, None, :], shares)[:, 0] - target
    return gains, residual, inverse * units
