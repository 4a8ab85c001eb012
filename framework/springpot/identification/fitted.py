"""A model fitted to a measurement: what it leaves, its slopes, what of the data it has followed.

The places of a spectrum's lines follow some of a measurement too, beside the weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.measurement import Measurement
from springpot.numerics import ROUNDING, Tangent
from springpot.rheology.elements import Continuum
from springpot.rheology.points import Real

from .leastsquares import Trial
from .material import FINE, SpectrumSearch, is_material, own_parameters
from .normal import Layout, LevelSlopes
from .problem import Objective, numbers_of
from .space import Expected
from .task import Task

if TYPE_CHECKING:
    from springpot.rheology.model import Model


class FittedModel(Protocol):
    """A fitted model."""

    @property
    def model(self) -> Model:
        """The model."""

    @property
    def theta(self) -> Real:
        """Its parameters (p,)."""

    @property
    def reference(self) -> float:
        """Temperature in kelvin at which shifts are one."""


def followed_by_places(search: SpectrumSearch, theta: Real, residual: Real, known: Real) -> float:
    """Numbers that the places of the lines of a fitted spectrum have followed, beside the weights.

    A line stands where one explains most. Had the noise been other it would stand elsewhere: it
    moves by what the slope of its curve finds in the noise, against the curvature of what is left
    there. So far its place is a parameter, and its share of one lies between 0 and 1: with S the
    map from noise to curve, a residual has lost tr(2 S - S S') numbers (Hastie and Tibshirani,
    Generalized Additive Models, 1990, sec. 3.5). Of two lines side by side the weights move them,
    and nothing is left for the places.

    Parameters
    ----------
    search : SpectrumSearch
        For the model with its lines, which is a `Continuum` with effects.
    theta : ndarray, shape (p,)
        The parameters.
    residual : ndarray, shape (m,)
        Predicted less measured, weighted.
    known : ndarray, shape (m, q)
        Its slopes by the parameters that follow the data, in whatever unit.
    """
    material, own = search.model.material, own_parameters(search.model)
    assert isinstance(material, Continuum)
    count = len(material.parameters)
    weights, rates = theta[:count], np.log(material.rates)
    carrying = _followed(rates, weights[2:])
    if not len(carrying):
        return 0.0
    places = np.concatenate([rates[carrying] + step for step in (-FINE, 0.0, FINE)])
    beside = Trial(
        search.u_of(theta[own]),
        np.concatenate([rates, places]),
        np.concatenate([weights, np.zeros(len(places))]),
        np.inf,
    )
    columns = search.respond(beside).by_theta[count : count + len(places)]
    before, at, after = search.weigh(columns).reshape(3, len(carrying), -1)
    weight = weights[2:][carrying, None]
    slopes = weight * (after - before) / (2.0 * FINE)
    left = (weight * (2.0 * at - before - after) / FINE**2) @ -residual
    # What the weights and the effects' parameters follow is no gain of the places.
    slopes = Tangent.of(known).left(slopes.T)
    stiff = np.diag(np.sqrt(np.maximum(left, 0.0)))
    spread, sizes, _ = np.linalg.svd(np.concatenate([slopes, stiff]), full_matrices=False)
    # By their shares: of what is seen of one combination of places, how much the data move.
    moved = spread[: len(slopes), sizes > ROUNDING * sizes[0]]
    share = np.linalg.svd(moved, compute_uv=False) ** 2
    return float(np.sum(2.0 * share - share**2))


def _followed(rates: Real, weights: Real) -> NDArray[np.int64]:
    """Numbers of the lines that carry weight with none beside them; rates in logarithms."""
    carrying = np.flatnonzero(weights > 0.0)
    carrying = carrying[np.argsort(rates[carrying])]
    apart = np.diff(rates[carrying], prepend=-np.inf, append=np.inf) > FINE
    return carrying[apart[1:] & apart[:-1]]


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to a measurement.

    Attributes
    ----------
    model, measurement, objective
        What was fitted to what, and how the misfit was measured.
    theta : ndarray, shape (p,)
        The parameters.
    cost : float
        The objective there: the sum of squared residuals.
    evaluations : int
        Model evaluations spent, those of the start scan included.
    converged : bool
        Whether the best start came to rest.
    seconds : float
        Time taken.
    confirmed : bool
        Whether nothing but rounding is left, or at least two starts ended there.
    expected : Expected, optional
        What was expected of the effects' parameters beside the data.
    """

    model: Model
    measurement: Measurement
    objective: Objective
    theta: Real
    cost: float
    evaluations: int = 0
    converged: bool = True
    seconds: float = 0.0
    confirmed: bool = True
    expected: Expected | None = None

    @property
    def reference(self) -> float:
        """Temperature in kelvin at which shifts are one."""
        return self.measurement.reference_temperature

    @cached_property
    def task(self) -> Task:
        """The data as a batch of one."""
        return task_of(self.model, self.measurement, self.objective)

    @cached_property
    def dof(self) -> float:
        """Degrees of freedom.

        The numbers measured less those that the parameters follow, and the places of a spectrum.
        """
        left = numbers_of(self.task.weights) - len(self.theta) + self.silent
        if not is_material(self.model):
            return left
        search = SpectrumSearch.of(self.model, self.measurement, self.objective)
        follows = np.ones(len(self.theta), dtype=bool)
        follows[: len(self.model.material.parameters)] = self._weights > 0.0
        placed = followed_by_places(search, self.theta, self.residual, self.jacobian_u[:, follows])
        # Of exact data the lines stand for numbers, of which no place can take more than there are.
        return max(left - placed, min(left, 1.0))

    @property
    def silent(self) -> int:
        """Weights of a spectrum that the data put at zero: these follow nothing.

        See Meyer and Woodroofe 2000, doi:10.1214/aos/1015956708.
        """
        if not is_material(self.model):
            return 0
        return int(np.sum(self._weights == 0.0))

    @property
    def _weights(self) -> Real:
        return self.theta[: len(self.model.material.parameters)]

    @cached_property
    def residual(self) -> Real:
        """Weighted residuals (2n,): those of the real part, then those of the imaginary part."""
        return in_parts(self._at_solution[0])

    @cached_property
    def jacobian_u(self) -> Real:
        """Derivative of the residuals by the search coordinates, shape (2n, p)."""
        if self.by_level is not None:
            return self.by_level.layout.dense(self.by_level.jacobian).T
        return in_parts(self._at_solution[1]).T

    @cached_property
    def by_level(self) -> LevelSlopes | None:
        """The same by the parameters of the level of each, where levels have their own."""
        if self.task.levels is None:
            return None
        known = self.task.levels.layout
        layout = Layout(known.places, np.tile(known.number, 2))
        return LevelSlopes(layout, in_parts(self._at_solution[1]))

    @cached_property
    def _at_solution(self) -> tuple[Real, Real]:
        evaluate = self.task.evaluator(np.zeros(1, dtype=np.intp))
        with np.errstate(all="ignore"):
            residual, jacobian = evaluate(self.u[None, :], np.zeros(1, dtype=np.intp))
        return residual[0], jacobian[0]

    @cached_property
    def u(self) -> Real:
        """The solution in search coordinates, shape (p,)."""
        return self.to_u(self.theta)

    def to_u(self, theta: Real) -> Real:
        """Search coordinates (..., p) of parameters (..., p)."""
        return self.task.coordinates.u(theta, self.task.coordinates.size[0])

    def from_u(self, u: Real) -> Real:
        """Parameters (..., p) of search coordinates (..., p)."""
        return self.task.coordinates.theta(u, self.task.coordinates.size[0])


def in_parts(interleaved_values: Real) -> Real:
    """Real parts, then imaginary parts, along the last axis."""
    return np.concatenate([interleaved_values[..., ::2], interleaved_values[..., 1::2]], axis=-1)


def task_of(model: Model, measurement: Measurement, objective: Objective) -> Task:
    """The data as a batch of one."""
    weights = objective.weighing(measurement)
    return Task(
        model,
        measurement.points,
        measurement.stiffness[None],
        weights[None],
        objective.logarithmic,
        turn=objective.turn,
    )
