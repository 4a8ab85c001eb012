"""The optimisation problem: a model, a measurement, an objective and a box to search in."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.points import Complex, Real

from .derivative import require_derivative
from .objective import Objective
from .space import SearchSpace, paper_box

BLOCK = 7000
"""Points times frequencies evaluated at once: arrays of about 100 kB stay in the cache."""


@dataclass
class Tally:
    """How many points were evaluated, by whomever."""

    points: int = 0


class Searched(ABC):
    """What an optimiser can be let loose upon: an objective in a box, with exact derivatives.

    Attributes
    ----------
    space : SearchSpace
        The box, and the map from it to the model's parameters.
    """

    space: SearchSpace

    @cached_property
    def tally(self) -> Tally:
        """Points evaluated so far.

        A run compares it with its record, past which nothing may be evaluated.
        """
        return Tally()

    @property
    def dimension(self) -> int:
        """Number d of searched parameters."""
        return len(self.space.parameters)

    @property
    def lower(self) -> Real:
        """Lower corner (d,) of the box."""
        return self.space.lower

    @property
    def upper(self) -> Real:
        """Upper corner (d,) of the box."""
        return self.space.upper

    @abstractmethod
    def evaluate(self, x: Real) -> Real:
        """Objective (...) at search points (..., d)."""

    @abstractmethod
    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """Residuals (..., m), whose squares sum to the objective, and derivative (..., m, d)."""

    def gradient(self, x: Real) -> tuple[Real, Real]:
        """Objective (...) and its exact gradient (..., d)."""
        residual, jacobian = self.residuals_and_jacobian(x)
        # From residuals and Jacobian, which are exact: no optimiser needs differences.
        slope: Real = 2.0 * np.matmul(residual[..., None, :], jacobian)[..., 0, :]
        return np.sum(residual * residual, axis=-1), slope


@dataclass(frozen=True, eq=False)
class Problem(Searched):
    """Minimise the objective over the box; eq. (44) to (47) of the paper in general form.

    Parameters
    ----------
    model : Model
        What is fitted.
    measurement : Measurement
        To what.
    objective : Objective
        How the misfit is measured.
    space : SearchSpace
        Where to search.

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.identification import Problem, default_objective
    >>> model = springpot.parse_model("kelvin")
    >>> data = springpot.Measurement([1.0, 2.0], [2.0 + 0.5j, 2.0 + 1.0j])
    >>> problem = Problem.of(model, data, default_objective(data))
    >>> problem.evaluate(np.array([[2.0, 0.5], [1.0, 0.5]])).round(3)
    array([0.   , 0.435])
    """

    model: Model
    measurement: Measurement
    objective: Objective
    space: SearchSpace

    @classmethod
    def of(
        cls,
        model: Model,
        measurement: Measurement,
        objective: Objective,
        stiffness_scale: float | None = None,
    ) -> Problem:
        """The problem in the paper's box.

        Raises
        ------
        ModelError
            If the model's derivative is wrong, or it gives no number.
        PluginError
            If the objective's weights are no numbers.
        """
        model = model.bound_to(measurement.points)
        space = paper_box(model, measurement, stiffness_scale)
        # A wrong derivative is told before anything is searched by it.
        with np.errstate(all="ignore"):
            inside = space.theta(space.repaired(space.lower + 0.4 * (space.upper - space.lower)))
        require_derivative(model, inside, measurement.points)
        made = cls(model, measurement, objective, space)
        made.weights  # noqa: B018  as are weights that are none
        return made

    @cached_property
    def weights(self) -> Complex:
        """The objective's weights for these data."""
        return self.objective.weighing(self.measurement)

    def residuals(self, x: Real) -> Real:
        """Weighted residuals (..., 2n) at search points (..., d)."""
        stiffness = self._stiffness(self.space.theta(x))
        return self.objective.residual(stiffness, self.measurement, self.weights)

    def evaluate(self, x: Real) -> Real:
        """Objective (...) at search points (..., d): the sum of squared residuals.

        Many points are taken in blocks that fit the processor's cache, whatever the number of
        measured ones.
        """
        theta, n = self.space.theta(x), len(self.measurement)
        lead, d = theta.shape[:-1], theta.shape[-1]
        # One point, and a few of them, go straight through: this is the hot path of every search.
        if theta.size // d * n <= BLOCK:
            return self._value(theta)
        rows, step = theta.reshape(-1, d), max(1, BLOCK // n)
        blocks = [self._value(rows[i : i + step]) for i in range(0, len(rows), step)]
        return np.concatenate(blocks).reshape(lead)

    def _value(self, theta: Real) -> Real:
        return self.objective.value(self._stiffness(theta), self.measurement, self.weights)

    def _stiffness(self, theta: Real) -> Complex:
        stiffness = self.model.network.respond(theta, self.measurement.points).value
        # Here, where every evaluation passes, whoever asked for it.
        self.tally.points += theta.size // theta.shape[-1]
        return stiffness

    def jacobian(self, x: Real) -> Real:
        """Exact derivative of the residuals, shape (..., 2n, d)."""
        return self.residuals_and_jacobian(x)[1]

    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """Residuals (..., 2n) and their derivative (..., 2n, d) in one evaluation."""
        response = self.model.network.respond(
            self.space.theta(x), self.measurement.points, GRADIENT
        )
        # A derivative comes with the value, and counts as one evaluation.
        self.tally.points += x.size // x.shape[-1]
        residual = self.objective.residual(response.value, self.measurement, self.weights)
        by_theta = self.objective.derivative(response.by_theta, response.value, self.weights)
        by_x = np.matmul(np.swapaxes(by_theta, -1, -2), self.space.jacobian(x))
        return residual, by_x


class _Watched(Problem):
    """A problem that hands every point to a watcher before it is evaluated."""

    def evaluate(self, x: Real) -> Real:
        self.__dict__["watcher"](x.reshape(-1, x.shape[-1]))
        return super().evaluate(x)

    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        self.__dict__["watcher"](x.reshape(-1, x.shape[-1]))
        return super().residuals_and_jacobian(x)


def watched(problem: Problem, watcher: Callable[[Real], None]) -> Problem:
    """The same problem, which shows `watcher` the points (m, d) before each evaluation."""
    copy = _Watched(problem.model, problem.measurement, problem.objective, problem.space)
    # A problem is frozen, and its watcher is no part of it.
    copy.__dict__["watcher"] = watcher
    return copy
