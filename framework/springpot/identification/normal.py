"""The normal equations of a step: of all parameters together, or level by level.

A row depends on the own parameters of its level and on those that all levels share: its Jacobian is
block-diagonal with a border. The own ones are eliminated level by level, by the Schur complement,
and leave a small system of the shared ones (Björck 1996, Numerical Methods for Least Squares
Problems, sec. 6.3, doi:10.1137/1.9781611971484).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.levels import rows_of_levels
from springpot.rheology.points import Real

from ..numerics import SMALLEST

Mask = NDArray[np.bool_]


class Equations(Protocol):
    """How R problems side by side are squared, and their damped equations solved."""

    def normal(self, residual: Real, jacobian: Real) -> tuple[Real, Real, Real]:
        """Objective (R,), half its gradient (R, p), and J J' as `bent` and `step` take it."""
        ...

    def bent(self, jtj: Real, step: Real) -> Real:
        """J J' times a step (R, p)."""
        ...

    def step(self, jtj: Real, downhill: Real, damping: Real, frozen: Mask) -> Real:
        """Solution (R, p) of the damped equations; none for what is frozen."""
        ...


class Whole:
    """All parameters together, of Jacobians (R, p, m)."""

    def normal(self, residual: Real, jacobian: Real) -> tuple[Real, Real, Real]:
        """With J J' as matrices (R, p, p)."""
        gradient: Real = np.matmul(jacobian, residual[:, :, None])[:, :, 0]
        return _cost(residual), gradient, np.matmul(jacobian, jacobian.transpose(0, 2, 1))

    def bent(self, jtj: Real, step: Real) -> Real:
        """By a product of matrices."""
        bent: Real = np.matmul(jtj, step[:, :, None])[:, :, 0]
        return bent

    def step(self, jtj: Real, downhill: Real, damping: Real, frozen: Mask) -> Real:
        """By one solution for all parameters."""
        matrix = jtj.copy()
        p = matrix.shape[-1]
        diagonal = matrix.reshape(-1, p * p)[:, :: p + 1]
        diagonal += _damped(diagonal, damping)
        if frozen.any():
            # Rows and columns of the unit matrix, which leave the other equations as they are.
            matrix[frozen] = 0.0
            matrix.transpose(0, 2, 1)[frozen] = 0.0
            diagonal[frozen] = 1.0
            downhill = np.where(frozen, 0.0, downhill)
        return _solved(matrix, downhill[:, :, None])[:, :, 0]


def _cost(residual: Real) -> Real:
    cost: Real = np.matmul(residual[:, None, :], residual[:, :, None])[:, 0, 0]
    return cost


def _damped(diagonal: Real, damping: Real) -> Real:
    """What damping adds to the diagonal (R, p)."""
    stiffest = diagonal.max(axis=1, keepdims=True)
    # A parameter that moves no residual has nothing on the diagonal: it is damped as if by a trace
    # of the stiffest.
    added: Real = damping[:, None] * np.maximum(diagonal, 1e-8 * stiffest) + SMALLEST
    return added


def _solved(matrix: Real, right: Real) -> Real:
    """Solutions (..., p, k) of matrices (..., p, p); zero where they are not finite."""
    try:
        solution: Real = np.asarray(np.linalg.solve(matrix, right), dtype=float)
    except np.linalg.LinAlgError:
        # One singular matrix refuses the whole batch: a shift that changes no other lets it pass.
        scale = np.trace(matrix, axis1=-2, axis2=-1)[..., None, None]
        shifted = matrix + 1e-14 * scale * np.eye(matrix.shape[-1])
        solution = np.asarray(np.linalg.solve(shifted, right), dtype=float)
    return np.where(np.isfinite(solution), solution, 0.0)


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the parameters of each level stand among all of them.

    Parameters
    ----------
    places : ndarray of int, shape (G, q)
        In theta, of each level.
    number : ndarray of int, shape (m,)
        Of the level that each row of the Jacobian is of.
    """

    places: NDArray[np.intp]
    number: NDArray[np.intp]

    @cached_property
    def is_own(self) -> Mask:
        """Which of a level's parameters (q,) are its own."""
        return np.asarray(np.not_equal(self.places[0], self.places[-1]))

    @cached_property
    def own(self) -> NDArray[np.intp]:
        """Where the own parameters of each level stand, (G, o)."""
        return self.places[:, self.is_own]

    @cached_property
    def shared(self) -> NDArray[np.intp]:
        """Where those stand that all levels have, (s,)."""
        shared: NDArray[np.intp] = self.places[0, ~self.is_own]
        return shared

    @cached_property
    def count(self) -> int:
        """How many parameters there are."""
        return int(self.places.max()) + 1

    @cached_property
    def rows(self) -> list[NDArray[np.intp]]:
        """Rows of each level."""
        return rows_of_levels(self.number, len(self.places))

    @cached_property
    def _cuts(self) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
        """Rows in the order of the levels, levels that have some, and where each begins."""
        present, starts = np.unique(np.sort(self.number), return_index=True)
        return np.concatenate(self.rows), present, starts

    def sums(self, terms: Real) -> Real:
        """Terms (..., m) summed over the rows of each level, (..., G)."""
        order, present, starts = self._cuts
        found: Real = np.zeros((*terms.shape[:-1], len(self.places)))
        found[..., present] = np.add.reduceat(terms[..., order], starts, axis=-1)
        return found

    def squared(self, jacobian: Real) -> Real:
        """J J' of each level, (..., G, q, q), of Jacobians (..., q, m)."""
        q = len(self.is_own)
        squared: Real = np.empty((*jacobian.shape[:-2], len(self.places), q, q))
        for i in range(q):
            row = self.sums(jacobian[..., i : i + 1, :] * jacobian[..., : i + 1, :])
            squared[..., i, : i + 1] = squared[..., : i + 1, i] = np.swapaxes(row, -1, -2)
        return squared

    def whole(self, parts: Real) -> Real:
        """Sums over levels (..., p) of what each has by its parameters, (..., G, q)."""
        found: Real = np.empty((*parts.shape[:-2], self.count))
        found[..., self.own] = parts[..., self.is_own]
        found[..., self.shared] = parts[..., ~self.is_own].sum(axis=-2)
        return found

    def dense(self, jacobian: Real) -> Real:
        """Jacobian (p, m) by all parameters, of that by those of the level of each row, (q, m)."""
        found: Real = np.zeros((self.count, len(self.number)))
        found[self.places[self.number].T, np.arange(len(self.number))] = jacobian
        return found

    def matrix(self, parts: Real) -> Real:
        """All of (p, p) that is told level by level, (G, q, q)."""
        found: Real = np.zeros((self.count, self.count))
        found[self.places[:, :, None], self.places[:, None, :]] = parts
        return found


@dataclass(frozen=True, eq=False)
class Arrow:
    """Levels with parameters of their own, of Jacobians (R, q, m) by those of the row's level."""

    layout: Layout

    def normal(self, residual: Real, jacobian: Real) -> tuple[Real, Real, Real]:
        """With J J' as the matrices of each level (R, G, q, q)."""
        gradient = np.swapaxes(self.layout.sums(jacobian * residual[:, None, :]), -1, -2)
        return _cost(residual), self.layout.whole(gradient), self.layout.squared(jacobian)

    def bent(self, jtj: Real, step: Real) -> Real:
        """By a product for each level."""
        return self.layout.whole(np.matmul(jtj, step[:, self.layout.places, None])[..., 0])

    def step(self, jtj: Real, downhill: Real, damping: Real, frozen: Mask) -> Real:
        """By the own ones of each level and the Schur complement of the shared ones."""
        own, shared, mask = self.layout.own, self.layout.shared, self.layout.is_own
        added = _damped(self.layout.whole(np.diagonal(jtj, axis1=-2, axis2=-1)), damping)
        blocks = _with(jtj[..., mask, :][..., mask], added[:, own], frozen[:, own])
        corner = jtj[..., ~mask, :][..., ~mask].sum(axis=1)
        corner = _with(corner, added[:, shared], frozen[:, shared])
        stopped = frozen[:, own][..., :, None] | frozen[:, None, None, shared]
        border = np.where(stopped, 0.0, jtj[..., mask, :][..., ~mask])
        right = np.where(frozen, 0.0, downhill)
        # Of each level: its own step, and by how much the shared parameters change it.
        alone = _solved(blocks, np.concatenate([border, right[:, own, None]], axis=-1))
        seen = np.matmul(np.swapaxes(border, -1, -2), alone).sum(axis=1)
        rest = right[:, shared, None] - seen[..., -1:]
        step = np.empty_like(downhill)
        step[:, shared] = common = _solved(corner - seen[..., :-1], rest)[..., 0]
        step[:, own] = alone[..., -1] - np.matmul(alone[..., :-1], common[:, None, :, None])[..., 0]
        return step


def _with(matrix: Real, added: Real, frozen: Mask) -> Real:
    """Matrices (..., p, p) with something added to the diagonal, and the unit one where frozen."""
    unit = np.eye(matrix.shape[-1])
    stopped = frozen[..., :, None] | frozen[..., None, :]
    return np.where(stopped, unit, matrix + added[..., None] * unit)
