"""The normal equations of a step and their inverse: of all parameters at once, or level by level.

A row depends on the own parameters of its level and on those that all levels share: its Jacobian is
block-diagonal with a border. The own ones are eliminated level by level, by the Schur complement,
and leave a small system of the shared ones (Björck 1996, Numerical Methods for Least Squares
Problems, sec. 6.3, doi:10.1137/1.9781611971484).

Between two levels there is nothing but what the shared parameters bring: the covariance is
block-diagonal, plus a product of as many columns as there are shared parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import ALIKE, SMALLEST, projected_out, rows_of_levels

Mask = NDArray[np.bool_]


class Equations(Protocol):
    """How R problems side by side are squared, and their damped equations solved."""

    def normal(self, residual: Real, jacobian: Real) -> tuple[Real, Real, Real]:
        """Objective (R,), half its gradient (R, p), and J J' as `bent` and `step` take it."""

    def bent(self, jtj: Real, step: Real) -> Real:
        """J J' times a step (R, p)."""

    def step(self, jtj: Real, downhill: Real, damping: Real, frozen: Mask) -> Real:
        """Solution (R, p) of the damped equations; none for what is frozen."""


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


RANK = 1e-10
"""Directions with a singular value this small a share of the largest are undetermined."""
PART = 1e-3
"""Part in such a direction from which a parameter is lost with it.

Rounding mixes directions by 1e-16 / RANK.
"""


@dataclass(frozen=True, eq=False)
class Bordered:
    """A covariance (p, p): block-diagonal in the own parameters, plus a product of columns.

    Parameters
    ----------
    layout : Layout
        Where the parameters of each level stand.
    blocks : ndarray, shape (G, o, o)
        Of the own parameters of each level, where the shared ones are known.
    columns : ndarray, shape (p, k)
        Times their own transpose the rest of it.
    lost : ndarray of bool, shape (p,)
        Parameters whose variance is infinite; in blocks and columns it is zero.
    """

    layout: Layout
    blocks: Real
    columns: Real
    lost: Mask

    @cached_property
    def variance(self) -> Real:
        """Its diagonal (p,)."""
        variance: Real = np.einsum("ij,ij->i", self.columns, self.columns)
        variance[self.layout.own] += np.diagonal(self.blocks, axis1=1, axis2=2)
        variance[self.lost] = np.inf
        return variance

    @cached_property
    def of_levels(self) -> Real:
        """The part of the parameters of each level, (G, q, q); infinite on its diagonal if lost."""
        columns = self.columns[self.layout.places]
        parts: Real = np.matmul(columns, np.swapaxes(columns, 1, 2))
        own = np.flatnonzero(self.layout.is_own)
        parts[:, own[:, None], own] += self.blocks
        np.einsum("gii->gi", parts)[self.lost[self.layout.places]] = np.inf
        return parts

    @cached_property
    def _level(self) -> NDArray[np.intp]:
        """The level (p,) of each own parameter, -1 of a shared one."""
        level = np.full(self.layout.count, -1)
        level[self.layout.own] = np.arange(len(self.layout.own))[:, None]
        return level

    def part(self, at: NDArray[np.intp]) -> Real:
        """That of some parameters (k,), the own ones of which are of one level."""
        level = int(self._level[at].max(initial=-1))
        if level < 0:
            part: Real = self.columns[at] @ self.columns[at].T
            part[np.diag_indices(len(at))] += np.where(self.lost[at], np.inf, 0.0)
            return part
        places = self.layout.places[level].tolist()
        rows = [places.index(i) for i in at.tolist()]
        return np.asarray(self.of_levels[level][np.ix_(rows, rows)])

    def errors(self, at: NDArray[np.intp], slopes: Real) -> tuple[float, Real]:
        """Of what follows from parameters (k,) by slopes (k,): its own variance, the common part.

        The common part (c,) is by the columns that all levels have.
        """
        level = int(self._level[at].max(initial=-1))
        common: Real = slopes @ self.columns[at]
        if np.any(self.lost[at] & (slopes != 0.0)):
            return np.inf, common
        if level < 0:
            return 0.0, common
        by_place = dict(zip(at.tolist(), slopes.tolist(), strict=True))
        own = np.array([by_place[i] for i in self.layout.own[level].tolist()])
        return float(own @ self.blocks[level] @ own), common

    def dense(self) -> Real:
        """All of it, (p, p)."""
        whole: Real = self.columns @ self.columns.T
        own = self.layout.own
        whole[own[:, :, None], own[:, None, :]] += self.blocks
        whole[self.lost, self.lost] = np.inf
        return whole

    def times(self, vectors: Real) -> Real:
        """Its finite part times vectors (v, p)."""
        own = self.layout.own
        found: Real = (vectors @ self.columns) @ self.columns.T
        found[:, own] += np.matmul(self.blocks, vectors[:, own, None])[..., 0]
        return found

    def carried(self, turn: Real) -> Bordered:
        """That of what depends on these parameters, level by level, by slopes (G, q, q).

        Shared ones hang on shared ones only.
        """
        layout, mask = self.layout, self.layout.is_own
        finite: Mask = np.all(np.isfinite(turn), axis=2)
        moved = np.abs(turn) > ALIKE
        touched: Mask = np.any(moved & self.lost[layout.places][:, None, :], axis=2)
        turn = np.where(finite[..., None], turn, 0.0)
        inner, border = turn[:, mask][..., mask], turn[:, mask][..., ~mask]
        columns = np.empty_like(self.columns)
        columns[layout.shared] = turn[0][~mask][:, ~mask] @ self.columns[layout.shared]
        columns[layout.own] = (
            np.matmul(inner, self.columns[layout.own]) + border @ self.columns[layout.shared]
        )
        lost = np.zeros(layout.count, dtype=bool)
        np.logical_or.at(lost, layout.places, touched | ~finite)
        columns[lost] = 0.0
        blocks = np.matmul(np.matmul(inner, self.blocks), np.swapaxes(inner, 1, 2))
        return Bordered(layout, _without(blocks, lost[layout.own]), columns, lost)

    def scaled(self, factors: Real) -> Bordered:
        """That of the parameters times factors (p,)."""
        own = factors[self.layout.own]
        blocks = self.blocks * own[:, :, None] * own[:, None, :]
        return replace(self, blocks=blocks, columns=self.columns * factors[:, None])


Covariance = Real | Bordered


def variance_of(covariance: Covariance) -> Real:
    """The diagonal (p,) of a covariance."""
    if isinstance(covariance, Bordered):
        return covariance.variance
    return np.asarray(np.diag(covariance))


def matrix_of(covariance: Covariance) -> Real:
    """A covariance as a matrix (p, p)."""
    if isinstance(covariance, Bordered):
        return covariance.dense()
    return covariance


def among(covariance: Covariance, at: NDArray[np.intp]) -> Real:
    """A covariance of some parameters (k,), of levels those of one."""
    if isinstance(covariance, Bordered):
        return covariance.part(at)
    return covariance[np.ix_(at, at)]


def lost_and_known(covariance: Real) -> tuple[Mask, Real]:
    """Search coordinates (p,) that the data leave undetermined, covariance (p, p) of the others."""
    lost = np.isinf(np.diag(covariance))
    # Zero times infinity is no number: what is lost counts as certain here, and whoever asks puts
    # it back.
    return lost, np.where(lost[:, None] | lost[None, :], 0.0, covariance)


def spread_of(turn: Real, covariance: Real, least: Real | float = ALIKE) -> Real:
    """Standard deviations (n,) of what depends on coordinates by `turn` (n, p).

    Infinite where it depends by more than the least on one that the data leave undetermined.
    """
    lost, known = lost_and_known(covariance)
    spread = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", turn, known, turn), 0.0))
    touched = np.any((np.abs(turn) > least) & lost, axis=1) | ~np.all(np.isfinite(turn), axis=1)
    return np.where(touched, np.inf, spread)


def carried(spread: Covariance, slopes: Real) -> Covariance:
    """Covariance of what depends on coordinates by slopes (p, q), or by those of each level."""
    if isinstance(spread, Bordered):
        return spread.carried(slopes)
    lost, finite = lost_and_known(spread)
    covariance: Real = slopes @ finite @ slopes.T
    # What hangs on a direction that the data do not determine is not determined either.
    touched = np.any(np.abs(slopes[:, lost]) > 0.0, axis=1)
    covariance[touched, touched] = np.inf
    return covariance


def told_of(covariance: Covariance, names: Sequence[str]) -> Any:
    """As plain data: a matrix, or of levels that of the parameters of each beside their names."""
    if not isinstance(covariance, Bordered):
        return covariance
    return {"names": np.array(names)[covariance.layout.places], "levels": covariance.of_levels}


@dataclass(frozen=True, eq=False)
class LevelSlopes:
    """Slopes of residuals, by the parameters of the level of each only.

    Parameters
    ----------
    layout : Layout
        Where these stand among all, and the level of each residual.
    jacobian : ndarray, shape (q, m)
        The slopes.
    """

    layout: Layout
    jacobian: Real

    @cached_property
    def sizes(self) -> Real:
        """Norm of the slopes by each parameter, (p,)."""
        squares = np.swapaxes(self.layout.sums(self.jacobian**2), -1, -2)
        return np.sqrt(self.layout.whole(squares))

    def pulls(self, residual: Real, cluster: NDArray[np.intp], count: int) -> Real:
        """Slopes times residuals (m,), summed over the rows of each cluster, (count, p)."""
        pulls: Real = np.zeros((count, self.layout.count))
        places = self.layout.places[self.layout.number]
        np.add.at(pulls, (cluster[:, None], places), (self.jacobian * residual).T)
        return pulls

    def of_levels(self) -> Iterator[tuple[NDArray[np.intp], Real]]:
        """Levels (k,) of equally many rows, and their slopes (k, r, q)."""
        counts = np.array([len(rows) for rows in self.layout.rows])
        fewest = int(np.sum(self.layout.is_own))
        for count in np.unique(counts).tolist():
            levels = np.flatnonzero(counts == count)
            rows = np.array([self.layout.rows[i] for i in levels.tolist()], dtype=np.intp)
            slopes = np.moveaxis(self.jacobian[:, rows], 0, -1)
            # As many rows as columns at least, that all directions have a singular value.
            yield levels, np.pad(slopes, ((0, 0), (0, max(fewest - count, 0)), (0, 0)))


class _Part(NamedTuple):
    """Some levels of equally many rows, by the singular values of their own columns."""

    levels: NDArray[np.intp]
    size: Real
    followed: Real
    values: Real
    directions: Real
    along: Real
    rest: Real


@dataclass(frozen=True, eq=False)
class Eliminated:
    """The own parameters of each level eliminated from slopes (Björck 1996, sec. 6.3).

    Parameters
    ----------
    slopes : LevelSlopes
        The slopes.
    free : ndarray of bool, shape (p,)
        Parameters that are none of a bound.
    """

    slopes: LevelSlopes
    free: Mask

    @cached_property
    def _parts(self) -> list[_Part]:
        mask, own = self.slopes.layout.is_own, self.slopes.layout.own
        parts = []
        for levels, slopes in self.slopes.of_levels():
            inner = np.where(self.free[own[levels]][:, None, :], slopes[..., mask], 0.0)
            size = np.linalg.norm(inner, axis=1)
            size[size == 0.0] = 1.0
            # Of the Jacobian itself: its square would lose half of the digits that tell what is
            # determined.
            u, values, directions = np.linalg.svd(inner / size[:, None, :], full_matrices=False)
            u = np.where(_known(values)[:, None, :], u, 0.0)
            border = np.where(self.free[self.slopes.layout.shared], slopes[..., ~mask], 0.0)
            along = np.matmul(np.swapaxes(u, 1, 2), border)
            rest = border - np.matmul(u, along)
            parts.append(_Part(levels, size, u, values, directions, along, rest))
        return parts

    @cached_property
    def _rest(self) -> tuple[Real, Real, Real, Real]:
        """Sizes of the shared columns, and singular values of what no own parameter follows."""
        shared = self.slopes.layout.shared
        size = self.slopes.sizes[shared]
        size = np.where(self.free[shared] & (size > 0.0), size, 1.0)
        rest = np.concatenate([row for part in self._parts for row in part.rest])
        return size, *np.linalg.svd(rest / size, full_matrices=False)

    def covariance(self, scale: float) -> Bordered:
        """Covariance by residuals of a standard deviation; as by all columns at once."""
        layout, shared, own = self.slopes.layout, self.slopes.layout.shared, self.slopes.layout.own
        lost = np.zeros(layout.count, dtype=bool)
        blocks: Real = np.zeros((len(own), own.shape[1], own.shape[1]))
        follow: Real = np.zeros((*own.shape, len(shared)))
        for part in self._parts:
            spread = _inverse(part.values)[..., None] * part.directions / part.size[:, None, :]
            blocks[part.levels] = np.matmul(np.swapaxes(spread, 1, 2), spread)
            # By how much own parameters make up for a change of the shared ones.
            follow[part.levels] = -np.matmul(np.swapaxes(spread, 1, 2), part.along)
            open_ones = np.where(_known(part.values)[..., None], 0.0, part.directions)
            lost[own[part.levels]] = (np.abs(open_ones) > PART).any(axis=1)
        size, _, values, directions = self._rest
        columns: Real = np.zeros((layout.count, len(values)))
        columns[shared] = (_inverse(values)[:, None] * directions / size).T
        columns[own] = np.matmul(follow, columns[shared])
        # A direction without a trace in the data takes all along that have a part in it.
        for direction in directions[~_known(values)] / size:
            moved = np.zeros(layout.count)
            moved[shared], moved[own] = direction, follow @ direction
            moved *= np.where(self.slopes.sizes > 0.0, self.slopes.sizes, 1.0)
            lost |= np.abs(moved) > PART * np.linalg.norm(moved)
        # Endless scatter makes endless variances.
        lost = self.free & (lost | ~np.isfinite(scale))
        scale = scale if np.isfinite(scale) else 0.0
        columns[lost] = 0.0
        return Bordered(layout, scale**2 * _without(blocks, lost[own]), scale * columns, lost)

    def left(self, slope: Real) -> float:
        """Norm of a slope (m,) of residuals less what the free parameters can make up for."""
        rows, squares = self.slopes.layout.rows, 0.0
        _, axes, values, _ = self._rest
        axes = axes[:, _known(values)]
        parts, first, along = [], 0, np.zeros(axes.shape[1])
        for part in self._parts:
            last = first + part.rest.shape[0] * part.rest.shape[1]
            # Of a parameter of one level the slope is zero in all others.
            for k in [k for k, i in enumerate(part.levels.tolist()) if slope[rows[i]].any()]:
                u, own = part.followed[k], np.zeros(part.rest.shape[1])
                own[: len(rows[part.levels[k]])] = slope[rows[part.levels[k]]]
                mine = axes[first:last].reshape(*part.rest.shape[:2], axes.shape[1])[k]
                parts.append((projected_out(own, u), mine))
                along += mine.T @ parts[-1][0]
            first = last
        moved = float(along @ along)
        for own, mine in parts:
            seen = mine @ along
            moved -= float(seen @ seen)
            squares += float(np.sum((own - seen) ** 2))
        return float(np.sqrt(squares + max(moved, 0.0)))


def _without(blocks: Real, lost: Mask) -> Real:
    """Blocks (G, o, o) with nothing in the rows and columns of what is lost (G, o)."""
    return np.where(lost[:, :, None] | lost[:, None, :], 0.0, blocks)


def _known(values: Real) -> Mask:
    """Which singular values (..., k) of columns of norm one are of directions that data tell."""
    return np.asarray(values > RANK * max(float(np.max(values, initial=0.0)), 1.0))


def _inverse(values: Real) -> Real:
    known = _known(values)
    return np.where(known, 1.0 / np.where(known, values, 1.0), 0.0)
