"""Many data sets on one grid, ready to be fitted by one model.

Levels that have parameters of their own are each evaluated by the model that they have for
themselves: all parameters at once would make a derivative that is nearly everywhere zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.nodes import GRADIENT
from springpot.rheology.parameters import Coordinates
from springpot.rheology.points import Complex, Points, Real

from ..numerics import ALIKE
from .leastsquares import FLAT, WHOLE, Evaluate, Rows, Solution, levenberg_marquardt
from .normal import Arrow, Equations, Layout
from .problem import require_derivative
from .starts import (
    Branches,
    Grid,
    branches_of,
    interleaved,
    plane_data,
    project,
    shapes_of,
    thinned,
)

if TYPE_CHECKING:
    from springpot.rheology.model import Model


@dataclass(frozen=True, eq=False)
class Levelled:
    """A model whose levels have parameters of their own, at points.

    Parameters
    ----------
    model : Model
        The model, with the levels of the data.
    points : Points
        The n points.
    coordinates : Coordinates
        Search coordinates of all parameters.
    """

    model: Model
    points: Points
    coordinates: Coordinates

    @cached_property
    def layout(self) -> Layout:
        """Where the parameters of each level stand, and the level of each point."""
        return Layout(self.model.places, self.model.levels(self.points))

    @cached_property
    def arrow(self) -> Arrow:
        """The normal equations, of the two parts of each point in turn."""
        return Arrow(Layout(self.layout.places, np.repeat(self.layout.number, 2)))

    @cached_property
    def one(self) -> Model:
        """The model that each level has."""
        return self.model.of_any_level

    @cached_property
    def _coordinates(self) -> Coordinates:
        """Search coordinates of the parameters of one level."""
        known = self.coordinates
        one = Coordinates.of(self.one.parameters, known.log_omega, np.ones(1), known.amplitude)
        # Where all are plain, so they are here.
        return one if known.pairs else replace(one, pairs=())

    @cached_property
    def _alike(self) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """Levels (k,) measured at the same points, and where these stand, (k, m)."""
        needs, groups = self.one.network.needs, dict[tuple[bytes, ...], list[int]]()
        columns = [self.points.log_omega, *map(self.points.need, sorted(needs))]
        for level, rows in enumerate(self.layout.rows):
            if len(rows):
                key = tuple(column[rows].tobytes() for column in columns)
                groups.setdefault(key, []).append(level)
        return [
            (np.array(levels), np.array([self.layout.rows[i] for i in levels]))
            for levels in groups.values()
        ]

    def respond(self, theta: Real, size: Real) -> tuple[Complex, Complex]:
        """K (r, n), and its slopes (r, q, n) by the search coordinates of the level of each point.

        Parameters
        ----------
        theta, size : ndarray, shape (r, p)
            All parameters, and the natural sizes of all.
        """
        places, count = self.layout.places, len(self.layout.number)
        value: Complex = np.empty((len(theta), count), dtype=np.complex128)
        slopes: Complex = np.empty((len(theta), places.shape[1], count), dtype=np.complex128)
        for levels, rows in self._alike:
            # All levels that were measured alike are settings of one model, side by side.
            own = theta[:, places[levels]]
            shape, flat = own.shape[:2], own.reshape(-1, places.shape[1])
            part = self.one.network.respond(flat, self.points.some(rows[0]), GRADIENT)
            value[:, rows] = np.broadcast_to(part.value, (len(flat), rows.shape[1])).reshape(
                *shape, -1
            )
            # A copy, as it is carried over in place.
            whole = (len(flat), *part.by_theta.shape[-2:])
            by_theta = np.array(np.broadcast_to(part.by_theta, whole))
            by_u = self._coordinates.carry(
                by_theta.reshape(*shape, *by_theta.shape[1:]), own, size[:, places[levels]]
            )
            slopes[:, :, rows] = np.moveaxis(by_u, 1, 2)
        return value, slopes

    def slopes(self, theta: Real, size: Real) -> Real:
        """Derivative of the parameters of each level by their coordinates, (G, q, q)."""
        own = theta[self.layout.places]
        unit = np.tile(np.eye(own.shape[1]), (len(own), 1, 1))
        return np.swapaxes(self._coordinates.carry(unit, own, size[self.layout.places]), 1, 2)

    def derivative(self, theta: Real, i: int) -> Complex:
        """dK/dtheta (n,) by one parameter itself; zero at the points of levels that lack it."""
        found: Complex = np.zeros(len(self.layout.number), dtype=np.complex128)
        for level, place in np.argwhere(self.layout.places == i).tolist():
            rows, own = self.layout.rows[level], theta[self.layout.places[level]]
            found[rows] = self.one.jacobian(own, self.points.some(rows))[:, place]
        return found


SCAN_POINTS = 64
"""Points at which shapes are scanned: a start need only lie in the right valley."""
ROUNDING = 1e-28
"""Objective, relative to that of the data, at which only rounding is left."""
NEARLY = 1e-20
"""The same at which the search for shapes hands over."""
FLAT_SHAPES = 1e-10
"""Predicted drop, over the objective, at which it does so too.

The last digits are left to all parameters.
"""


@dataclass(frozen=True, eq=False)
class Task:
    """Many data sets on one grid, ready to be fitted by one model.

    Parameters
    ----------
    model : Model
        What is fitted.
    points : Points
        The n points.
    stiffness, weights : ndarray of complex, shape (B, n)
        Data, and weights of their real and imaginary parts.
    logarithmic : bool
        Compare ln K rather than K.
    given : Coordinates, optional
        Search coordinates of a task that this one is a part of.
    turn : ndarray of complex, shape (n,), optional
        See `Objective`.
    """

    model: Model
    points: Points
    stiffness: Complex
    weights: Complex
    logarithmic: bool = False
    given: Coordinates | None = None
    turn: Complex | None = None

    @cached_property
    def coordinates(self) -> Coordinates:
        """Search coordinates, sized by the mean of ln|K| of each data set."""
        if self.given is not None:
            return self.given
        amplitude = 1.0
        if self.points.amplitude is not None:
            amplitude = float(np.mean(self.points.amplitude))
        return Coordinates.of(
            self.model.parameters, float(np.mean(self.points.log_omega)), self.scale, amplitude
        )

    @cached_property
    def levels(self) -> Levelled | None:
        """The levels that have parameters of their own; None where all parameters are shared."""
        if not self.model.own:
            return None
        return Levelled(self.model, self.points, self.coordinates)

    @property
    def level_count(self) -> int:
        """Levels that have parameters of their own; one where all parameters are shared."""
        return 1 if self.levels is None else len(self.levels.layout.places)

    @property
    def equations(self) -> Equations:
        """How the derivative of `evaluator` is squared."""
        return WHOLE if self.levels is None else self.levels.arrow

    @property
    def count(self) -> int:
        """Number of points."""
        return int(self.stiffness.shape[1])

    @cached_property
    def scale(self) -> Real:
        """Typical |K| of each data set, shape (B,)."""
        size = np.abs(self.stiffness)
        # A point without stiffness has no logarithm.
        scale: Real = np.exp(np.mean(np.log(np.maximum(size, 1e-12 * size.max())), axis=1))
        return scale

    @cached_property
    def floor(self) -> Real:
        """Objective (B,) at which nothing but rounding is left."""
        # Differences of logarithms do not grow with the data.
        if self.logarithmic:
            return np.asarray(ROUNDING * np.sum(np.abs(self.weights) ** 2, axis=1))
        # What rounding leaves of a residual is a share of the weighted data.
        size = interleaved(self.weights) * interleaved(self.stiffness)
        floor: Real = ROUNDING * np.sum(size * size, axis=1)
        return floor

    def _require_derivative(self) -> None:
        """Notice a wrong derivative before anything is fitted by it."""
        log, size = self.coordinates.log, self.coordinates.size
        inside = self.coordinates.theta(np.where(log, 0.2, 0.45), size[0])
        lower, upper = (
            np.array([getattr(p, end) for p in self.model.parameters]) for end in ("lower", "upper")
        )
        model, theta = self.model, np.clip(inside, lower, upper)
        if self.levels is not None:
            model, theta = self.levels.one, theta[self.levels.layout.places[0]]
        require_derivative(model, theta, self.points)

    @cached_property
    def branches(self) -> Branches:
        """The branches whose gains are linear."""
        return branches_of(self.model)

    @cached_property
    def _plane_weights(self) -> Complex:
        """Weights (B, n) of differences of K that match the objective to first order."""
        weights = self.weights
        # d ln K = dK / K: near the data a difference of logarithms is a relative one.
        if self.logarithmic:
            weights = weights / np.abs(self.stiffness)
        if self.turn is not None:
            # The scan mixes the parts: both get the mean of their weights.
            weights = (1.0 + 1.0j) * np.abs(weights) / np.sqrt(2.0)
        return np.broadcast_to(weights, self.stiffness.shape)

    @cached_property
    def shape_floor(self) -> Real:
        """Objective (B,) of the shapes at which the search in all parameters takes over."""
        at, weight = self._plane
        return np.asarray(NEARLY * np.sum((at * weight) ** 2, axis=1))

    @cached_property
    def _plane(self) -> tuple[Real, Real]:
        return plane_data(self.stiffness, self._plane_weights, self.branches.compliance)

    @cached_property
    def _target(self) -> Real:
        return interleaved(self._turned(self.stiffness))

    def _turned(self, values: Complex) -> Complex:
        """Values (..., n) as their parts are weighed."""
        if self.turn is None:
            return values
        return values * self.turn

    @cached_property
    def _weight(self) -> Real:
        return interleaved(np.broadcast_to(self.weights, self.stiffness.shape))

    def rows(self, which: Rows) -> Task:
        """Some of the data sets."""
        return replace(
            self,
            stiffness=self.stiffness[which],
            weights=self.weights[which],
            given=self.coordinates.rows(which),
        )

    def thin(self, most: int) -> Task:
        """The data at no more than `most` of the points."""
        if self.stiffness.shape[1] <= most:
            return self
        # The coordinates stay those of all points, so that what the few find holds for all.
        pick = thinned(self.points.log_omega, most)
        points = replace(
            self.points.mapped(lambda column: column[pick]), log_omega=self.points.log_omega[pick]
        )
        return replace(
            self,
            points=points,
            stiffness=self.stiffness[:, pick],
            weights=self.weights[:, pick],
            given=self.coordinates,
            turn=None if self.turn is None else self.turn[pick],
        )

    def _data_sets(self, owner: Rows, rows: Rows) -> Rows | slice:
        """The data set of each of some rows."""
        # A single one stands for all rows as it is, and need not be copied for each.
        if len(self.stiffness) == 1:
            return slice(None)
        return owner[rows]

    def evaluator(self, owner: Rows) -> Evaluate:
        """Residuals (r, 2n) and derivative (r, p, 2n) of rows, row i of data set `owner[i]`.

        Where levels have parameters of their own, the derivative by those of the level of each.
        """
        self._require_derivative()
        coordinates, network, levels = self.coordinates, self.model.network, self.levels

        def evaluate(u: Real, rows: Rows) -> tuple[Real, Real]:
            which = self._data_sets(owner, rows)
            size, weight = coordinates.size[which], self._weight[which]
            theta = coordinates.theta(u, size)
            if levels is None:
                value, slopes, _ = network.respond(theta, self.points, GRADIENT)
            else:
                value, slopes = levels.respond(theta, np.broadcast_to(size, theta.shape))
            if self.logarithmic:
                # The logarithm of the ratio, not a difference of two: this would jump by a turn
                # where one phase passes 180 degrees.
                residual = interleaved(np.log(value / self.stiffness[which]))
                slopes = slopes / value[:, None, :]
            else:
                residual = interleaved(self._turned(value)) - self._target[which]
                slopes = self._turned(slopes)
            jacobian = interleaved(slopes) * weight[:, None, :]
            if levels is None:
                jacobian = coordinates.carry(jacobian, theta, size)
            return residual * weight, jacobian

        return evaluate

    def shape_evaluator(self, owner: Rows) -> Evaluate:
        """The same for shapes (r, d).

        Residuals with the gains projected out, and Kaufman's derivative of them.
        """
        self._require_derivative()
        coordinates, branches = self.coordinates, self.branches
        at, weight = self._plane
        target = at * weight

        def evaluate(v: Real, rows: Rows) -> tuple[Real, Real]:
            which = self._data_sets(owner, rows)
            size, scale = coordinates.size[which], weight[which][:, None, :]
            theta, value, by_theta, shares = self._unit_gain(v, size)
            basis = interleaved(shares) * scale
            # For each shape the best gains are known in closed form: the search is left with the
            # shapes alone.
            gains, residual, inverse = project(basis, target[which])
            slopes = by_theta * self._by_owner(gains, shares)
            if branches.compliance:
                # d(1/K) = -dK / K^2.
                slopes /= -(value * value)[:, None, :]
            jacobian = coordinates.carry(interleaved(slopes) * scale, theta, size)[:, branches.free]
            # What the gains make up for is no slope of the shapes.
            inside = np.matmul(np.matmul(jacobian, basis.transpose(0, 2, 1)), inverse)
            jacobian -= np.matmul(inside, basis)
            return residual, jacobian

        return evaluate

    def _unit_gain(self, v: Real, size: Real) -> tuple[Real, Complex, Complex, Complex]:
        """Parameters, K, dK/dtheta and the branches' shares of shapes (r, d) at unit gain."""
        theta = self.coordinates.theta(self.branches.shaped(v, self.coordinates.log), size)
        response = self.model.network.respond(theta, self.points, GRADIENT)
        return theta, response.value, response.by_theta, self.branches.shares(theta, *response[:2])

    def _by_owner(self, gains: Real, shares: Complex) -> Complex | Real:
        """Factor by which the gains change the derivative by each parameter, (r, p, n or 1)."""
        owner = self.branches.owner
        factor: Real = gains[:, owner][:, :, None]
        if owner.min() >= 0:
            return factor
        # What stands outside the branches, such as a delay, acts on their sum: it grows as that sum
        # does.
        common = np.matmul(gains[:, None, :], shares) / np.sum(shares, axis=1, keepdims=True)
        return np.where(owner[:, None] < 0, common, factor)

    def shaped(self, u: Real) -> Real:
        """Shapes (..., d) of search coordinates (..., p)."""
        return self.branches.shape(u, self.coordinates.log)

    def full(self, v: Real) -> Real:
        """Search coordinates (B, s, p) of shapes (B, s, d), with the best gains."""
        count, starts, d = v.shape
        owner = np.repeat(np.arange(count), starts)
        at, weight = self._plane
        with np.errstate(all="ignore"):
            *_, shares = self._unit_gain(v.reshape(count * starts, d), self.coordinates.size[owner])
            gains = project(interleaved(shares) * weight[owner][:, None, :], (at * weight)[owner])[
                0
            ]
        return self._scaled(v, self._log_gain(gains).reshape(count, starts, -1))

    def _log_gain(self, gains: Real) -> Real:
        """Logarithms of the gains of stiffnesses."""
        log_gain: Real = np.log(gains)
        # In the plane of compliances they are gains of these.
        if self.branches.compliance:
            log_gain = -log_gain
        return log_gain

    def solve_shapes(
        self, v: Real, iterations: int = 60, flat: float = FLAT_SHAPES, alike: float = ALIKE
    ) -> Solution:
        """Descend from shapes (B, s, d) with the gains projected out.

        Rows run over data sets, then starts.
        """
        count, starts, d = v.shape
        owner = np.repeat(np.arange(count), starts)
        lower, upper = (bound[:, self.branches.free] for bound in self.coordinates.bounds)
        return levenberg_marquardt(
            self.shape_evaluator(owner),
            v.reshape(count * starts, d),
            lower[owner],
            upper[owner],
            floor=self.shape_floor[owner],
            flat=flat,
            team=_team(owner, starts),
            iterations=iterations,
            alike=alike,
        )

    def solve(
        self,
        u: Real,
        iterations: int = 100,
        damping: float = 1e-2,
        flat: float = FLAT,
        alike: float = ALIKE,
    ) -> Solution:
        """Descend from search coordinates (B, s, p).

        Rows of the result run over data sets, then starts.
        """
        count, starts, p = u.shape
        owner = np.repeat(np.arange(count), starts)
        lower, upper = self.coordinates.bounds
        return levenberg_marquardt(
            self.evaluator(owner),
            u.reshape(-1, p),
            lower[owner],
            upper[owner],
            floor=self.floor[owner],
            team=_team(owner, starts),
            iterations=iterations,
            damping=damping,
            flat=flat,
            alike=alike,
            equations=self.equations,
        )

    def starts(self, keep: int, offset: float = 0.0) -> tuple[Real, Real]:
        """Shapes (B, s, d) read off the data, best first, search points (B, s, p) and gains."""
        # Hundreds of shapes are scanned: with a few points each costs next to nothing.
        thin = self.thin(SCAN_POINTS)
        shapes = shapes_of(self.model, Grid(thin.points, self.coordinates), offset)
        v, gains = shapes.best(thin.stiffness, thin._plane_weights, keep)
        # The scan's gains are in the unit of the data, search coordinates relative to their size.
        log_gain = self._log_gain(gains) - np.log(self.scale)[:, None, None]
        return v, self._scaled(v, log_gain)

    def _scaled(self, v: Real, log_gain: Real) -> Real:
        return self.branches.scaled(
            self.branches.shaped(v, self.coordinates.log), log_gain, self.coordinates.log
        )


def _team(owner: Rows, starts: int) -> Rows | None:
    """The data set of each row, whose starts end one another.

    None where each data set has one start.
    """
    if starts <= 1:
        return None
    return owner
