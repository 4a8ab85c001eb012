"""The optimisation problem: a model, a measurement, an objective and a box to search in.

Every objective is a weighted sum of squares in one plane, so that one exact Jacobian serves them
all. A model's derivative is checked along one direction when the model is first used: the contract
tests of `springpot.testing` look at every parameter, but who uses a plugin's model need not have
run them, and a fit by a wrong derivative ends in a wrong place without a word.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError, PluginError, owned
from springpot.measurement.measurement import Measurement
from springpot.rheology.nodes import GRADIENT, Node
from springpot.rheology.points import Complex, Points, Real

from ..numerics import ALIKE
from .space import SearchSpace, paper_box

if TYPE_CHECKING:
    from springpot.measurement.opening import Test
    from springpot.rheology.model import Model

STEPS = (1e-3, 1e-4, 1e-5)
"""Of the central difference, relative to each parameter.

Its error falls with the square of the step and rises, by
rounding, with its inverse; the best of three is about 1e-8."""
WRONG = 1e-5
"""Deviation from the difference at its best step, relative to the sum of all shares, that no
rounding explains: 2e-10 was the largest among the 76 installed models and effects.
"""
ELSEWHERE = (3.0, 0.2, 7.0)
"""Factors by which parameters are moved before a deviation is believed."""
_checked: set[object] = set()


def require_derivative(model: Model, theta: Real, points: Points) -> None:
    """Compare dK/dtheta of a model with differences, once for each network.

    Parameters
    ----------
    model : Model
        What is about to be fitted.
    theta : ndarray, shape (p,)
        Where; anywhere in the interior.
    points : Points
        The measured points.

    Raises
    ------
    ModelError
        If the derivative is wrong, with the parameter where it is most so; if the model gives
        another stiffness with it than without; or no number at a point, whatever its parameters.
    """
    # Once is enough: a derivative does not change, and a fit must not pay for it each time.
    if model.network in _checked:
        return
    places = [theta, *(_elsewhere(model, theta, factor) for factor in ELSEWHERE)]
    _require_numbers(model, places, points)
    with np.errstate(all="ignore"):
        apart = _least_apart(model, places, points)
    if apart > WRONG:
        raise ModelError(
            f"the stiffness of {model.name} is another by {100 * apart:.2g} % where its derivative"
            " is asked for too: nothing is fitted with it; the plugin's author finds the rest with"
            " springpot.testing"
        )
    _checked.add(model.network)
    with np.errstate(all="ignore"):
        # At the kink of a slider, say, no difference is right; a wrong derivative is wrong
        # everywhere.
        for place in places:
            direction = _direction(model, place)
            if not _deviation(model, place, points, direction) > WRONG:
                return
        deviations = [_deviation(model, places[-1], points, alone) for alone in np.diag(direction)]
    _checked.discard(model.network)
    worst = int(np.argmax(np.nan_to_num(deviations)))
    raise ModelError(
        f"the derivative of {model.name} by {model.names[worst]} is wrong by"
        f" {100 * deviations[worst]:.2g} %: nothing is fitted with it; the plugin's author finds"
        " the rest with springpot.testing"
    )


def _require_numbers(model: Model, places: Sequence[Real], points: Points) -> None:
    """Tell of a model that gives no number, and of the effect that is why, before a fit."""
    never = _never(model.network, places, points)
    if not np.any(never):
        return
    what = owned("model", model.base)
    for effect in model.effects:
        own = [i for i, name in enumerate(model.names) if name.startswith(f"{effect.name}.")]
        alone = [place[own] for place in places]
        if len(own) == len(effect.element.parameters) and np.any(
            _never(effect.element, alone, points)
        ):
            what = owned("effect", effect.name)
    where = f"at {np.sum(never)} of {len(never)} points, whatever its parameters"
    raise ModelError(f"the {what} gives no number (nan) {where}: nothing is fitted with it")


def _never(node: Node, places: Sequence[Real], points: Points) -> NDArray[np.bool_]:
    """Points (n,) at which it gives no number at any of the places.

    Infinity is one, of a place that is absurd.
    """
    with np.errstate(all="ignore"):
        values = [node.respond(place, points).value for place in places]
    never: NDArray[np.bool_] = np.all(np.isnan(values), axis=0)
    return never


def _least_apart(model: Model, places: Sequence[Real], points: Points) -> float:
    """How far the stiffnesses with and without derivatives differ.

    At the first place where they do not agree, or where they differ least.
    """
    least = np.inf
    # Where a balance of two nonlinear parts has no single solution rounding decides: a wrong way
    # errs everywhere.
    for place in places:
        least = min(least, _apart(model, place, points))
        if least <= WRONG:
            break
    return least


def _apart(model: Model, theta: Real, points: Points) -> float:
    """Largest relative difference of K with and without derivatives, where both are finite."""
    # Two ways of one model, the quick one of them written apart: a search goes by one and a descent
    # by the other.
    alone, beside = (
        model.network.respond(theta, points).value,
        model.network.respond(theta, points, GRADIENT).value,
    )
    apart = np.abs(beside - alone) / np.abs(alone)
    return float(np.max(apart[np.isfinite(apart)], initial=0.0))


def _elsewhere(model: Model, theta: Real, factor: float) -> Real:
    """Other parameters inside the bounds, neighbours in theta moved in opposite directions."""
    moved = theta * factor ** ((-1.0) ** np.arange(len(theta)))
    lower, upper = (
        np.array([getattr(p, end) for p in model.parameters]) for end in ("lower", "upper")
    )
    inside = (moved > lower) & (moved < upper)
    return np.where(inside, moved, theta)


def _direction(model: Model, theta: Real) -> Real:
    """A step of every parameter, none of them alike and all inside their bounds."""
    share = 1.0 + 0.3 * np.sin(1.0 + np.arange(len(theta)))
    size = np.where(theta == 0.0, 0.01, np.abs(theta))
    upper = model.box[1]
    # From the upper half downwards, as no step may leave the bounds.
    direction: Real = share * size * np.where(np.isfinite(upper) & (theta > 0.5 * upper), -1.0, 1.0)
    return direction


def _deviation(model: Model, theta: Real, points: Points, direction: Real) -> float:
    """Median over the points of the smallest deviation at any step.

    No number where nothing is finite.
    """
    response = model.network.respond(theta, points, GRADIENT)
    # Along one direction in which no two parameters are alike: no error of one can cancel
    # another's.
    shares = response.by_theta * direction[:, None]
    size = np.sum(np.abs(shares), axis=0)
    off = np.abs(_differences(model, theta, points, direction) - shares.sum(axis=0)) / size
    least = np.min(off, axis=0)
    least = least[np.isfinite(least)]
    if not least.size:
        return float("nan")
    # Single points may lie at a kink, or show nothing but rounding.
    return float(np.median(least))


def _differences(model: Model, theta: Real, points: Points, direction: Real) -> Complex:
    """Central differences (steps, n) along a direction.

    One call for all, as each costs about as much.
    """
    steps = np.array(STEPS)[:, None]
    ends = np.concatenate([theta + steps * direction, theta - steps * direction])
    ahead, behind = np.split(model.network.respond(ends, points).value, 2)
    return (ahead - behind) / (2.0 * steps)


@dataclass(frozen=True)
class Objective:
    """A weighted sum of squared differences of K' and K'' (or of ln|K| and the phase).

    Parameters
    ----------
    name : str
        What users type.
    summary : str
        One sentence with the formula.
    weights : callable
        Measurement to complex weights (..., n): the real part weighs K', the imaginary part K''.
    logarithmic : bool
        Compare ln K instead of K.
    citation : str
        Source of the formula.
    turn : ndarray of complex, shape (n,), optional
        Unit numbers by which differences of K are multiplied before their parts are weighed, as of
        errors that go along K and across it.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.identification import default_objective
    >>> data = Measurement([1.0], [3.0 + 4.0j])
    >>> objective = default_objective(data)
    >>> round(float(objective.value(np.array([3.0 + 4.5j]), data, objective.weights(data))), 6)
    0.01
    """

    name: str
    summary: str
    weights: Callable[[Measurement], Complex]
    logarithmic: bool = False
    citation: str = ""
    turn: Complex | None = field(default=None, compare=False)

    def weighing(self, measurement: Measurement) -> Complex:
        """The weights for a measurement, checked.

        Raises
        ------
        PluginError
            If one of them is no finite number: nothing could be compared by it.
        """
        weights = np.asarray(self.weights(measurement), dtype=np.complex128)
        if not np.all(np.isfinite(weights)):
            raise PluginError(
                f"the {owned('objective', self.name)} weighs points of {measurement.name} by what"
                " is no finite number"
            )
        return weights

    def residual(self, stiffness: Complex, measurement: Measurement, weights: Complex) -> Real:
        """Weighted residuals, shape (..., 2n).

        Those of the real part, then those of the imaginary part.
        """
        if self.logarithmic:
            return weighted(np.log(stiffness / measurement.stiffness), weights)
        return weighted(stiffness - measurement.stiffness, weights, self.turn)

    def value(self, stiffness: Complex, measurement: Measurement, weights: Complex) -> Real:
        """Sum of squared residuals, shape (...), without laying their parts side by side."""
        if self.logarithmic:
            error = np.log(stiffness / measurement.stiffness)
            storage, loss = error.real * weights.real, error.imag * weights.imag
        elif self.turn is not None:
            error = (stiffness - measurement.stiffness) * self.turn
            storage, loss = error.real * weights.real, error.imag * weights.imag
        else:
            return self.value_of_parts(stiffness.real, stiffness.imag, measurement, weights)
        return _squares(storage, loss)

    def value_of_parts(
        self, storage: Real, loss: Real, measurement: Measurement, weights: Complex
    ) -> Real:
        """The same of K' and K'' (..., n), where their differences are what is weighed."""
        # Each is read once, and what is made of it lies side by side.
        storage, loss = storage - measurement.stiffness.real, loss - measurement.stiffness.imag
        storage *= weights.real
        loss *= weights.imag
        return _squares(storage, loss)

    def derivative(self, by_theta: Complex, stiffness: Complex, weights: Complex) -> Real:
        """Derivative of `residual`, shape (..., p, 2n), from dK/dtheta of shape (..., p, n)."""
        # d ln K = dK / K.
        if self.logarithmic:
            by_theta = by_theta / stiffness[..., None, :]
        return weighted(by_theta, weights, self.turn)


def weighted(values: Complex, weights: Complex, turn: Complex | None = None) -> Real:
    """Real and imaginary parts side by side, each times its own weight.

    With a `turn` (n,) those of the values times these unit numbers.
    """
    if turn is not None:
        values = values * turn
    return np.concatenate([values.real * weights.real, values.imag * weights.imag], axis=-1)


def numbers_of(weights: Complex) -> int:
    """How many numbers count: K' and K'' of each point, but none that has no weight."""
    return int(np.count_nonzero(weights.real) + np.count_nonzero(weights.imag))


def _squares(storage: Real, loss: Real) -> Real:
    """Sum of the squares of both (..., n), which it writes over."""
    storage *= storage
    loss *= loss
    storage += loss
    return total(storage)


def total(terms: Real) -> Real:
    """Sum of (..., n) over its last axis, term after term.

    A sum by halves would depend on how the terms lie in memory, and so a run on what is evaluated
    beside it.
    """
    if terms.ndim == 2 and terms.strides[0] < terms.strides[1] and len(terms) > 1:
        # Whole columns are added: each row's terms come one after another, and all rows side by
        # side.
        columns: Real = np.add.reduce(terms, axis=-1)
        return columns
    return np.add.accumulate(terms, axis=-1)[..., -1]


def sizes(measurement: Measurement) -> Real:
    """|K| (n,) by which differences are divided."""
    size = measurement.magnitude
    # A point of nearly no stiffness, as at an antiresonance, must not divide by zero and decide
    # alone.
    return np.asarray(np.maximum(size, ALIKE * size.max()), dtype=np.float64)


def relative_objective() -> Objective:
    """The differences of K' and K'' over |K|: the objective where none is asked for."""
    return Objective("relative", "the differences of K' and K'' over |K|", _over_magnitude)


def _over_magnitude(measurement: Measurement) -> Complex:
    return np.asarray((1.0 + 1.0j) / sizes(measurement), dtype=np.complex128)


def _over_sd(measurement: Measurement) -> Complex:
    sd = measurement.sd
    assert sd is not None
    return np.asarray(1.0 / sd.real + 1.0j / sd.imag, dtype=np.complex128)


def default_objective(measurement: Measurement) -> Objective:
    """Weighted by the given standard deviations, or relative where none are given.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.identification import default_objective
    >>> default_objective(Measurement([1.0], [3.0 + 4.0j], sd=[0.1 + 0.1j])).name
    'weighted'
    """
    if measurement.sd is None:
        return relative_objective()
    return Objective("weighted", "the differences over their given standard deviations", _over_sd)


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

    def evaluate(self, x: Real) -> Real:
        """Objective (...) at search points (..., d)."""
        return np.asarray(np.sum(self.residuals(x) ** 2, axis=-1))

    @abstractmethod
    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """Residuals (..., m), whose squares sum to the objective, and derivative (..., m, d)."""

    def residuals(self, x: Real) -> Real:
        """Residuals (..., m) alone, for searches by models of them without derivatives."""
        return self.residuals_and_jacobian(x)[0]

    def gradient(self, x: Real) -> tuple[Real, Real]:
        """Objective (...) and its exact gradient (..., d)."""
        residual, jacobian = self.residuals_and_jacobian(x)
        # From residuals and Jacobian, which are exact: no optimiser needs differences.
        slope: Real = 2.0 * np.matmul(residual[..., None, :], jacobian)[..., 0, :]
        return np.sum(residual * residual, axis=-1), slope


class SpecimenProblem(Searched):
    """A model on the tests of a specimen, which may have been others.

    Attributes
    ----------
    model : Model
        What is fitted.
    """

    model: Model

    @property
    @abstractmethod
    def nothing(self) -> float:
        """Objective of no response at all; no number where that has none."""

    @abstractmethod
    def with_tests(self, tests: Sequence[Test]) -> Self:
        """The same, weights and box and all, on other numbers of the same tests."""


@dataclass(frozen=True, eq=False)
class Problem(SpecimenProblem):
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

    @property
    def nothing(self) -> float:
        """Objective of no stiffness, which has no logarithm."""
        none = np.zeros_like(self.measurement.stiffness)
        return float(self.objective.value(none, self.measurement, self.weights))

    def with_tests(self, tests: Sequence[Test]) -> Problem:
        """The same on the numbers of one other sweep; its weights are made of these."""
        (sweep,) = tests
        assert isinstance(sweep, Measurement)
        return replace(self, measurement=sweep)

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
        if theta.ndim == 2 and not self.objective.logarithmic and self.objective.turn is None:
            self.tally.points += len(theta)
            parts = self.model.network.parts(theta, self.measurement.points)
            return self.objective.value_of_parts(*parts, self.measurement, self.weights)
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


class _Watching:
    """Hands every point to a watcher before a problem evaluates it."""

    def evaluate(self, x: Real) -> Any:
        self.__dict__["watcher"](x.reshape(-1, x.shape[-1]))
        return super().evaluate(x)  # type: ignore[misc]

    def residuals_and_jacobian(self, x: Real) -> Any:
        self.__dict__["watcher"](x.reshape(-1, x.shape[-1]))
        return super().residuals_and_jacobian(x)  # type: ignore[misc]


S = TypeVar("S", bound=Searched)


@cache
def _watching(kind: type[S]) -> type[S]:
    """The kind of problem that is watched: one class, however many trials there are."""
    return type(kind.__name__, (_Watching, kind), {})


def watched(problem: S, watcher: Callable[[Real], None]) -> S:
    """The same problem, which shows `watcher` the points (m, d) before each evaluation."""
    watching: S = object.__new__(_watching(type(problem)))
    # A problem may be frozen, and its watcher is no part of it; what it evaluates it counts anew.
    watching.__dict__.update(problem.__dict__ | {"watcher": watcher, "tally": Tally()})
    return watching
