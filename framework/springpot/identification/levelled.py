"""Levels with parameters of their own, each evaluated by the model that it has for itself.

All parameters at once would make a derivative that is nearly everywhere zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Points, Real

from .coordinates import Coordinates
from .normal import Arrow, Layout


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
