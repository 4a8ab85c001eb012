"""The answer of an identification: parameters as they are printed, residuals, predictions.

Parameters as they are printed, in the model's own form and in its published search form.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.drawing import draw, text_of
from springpot.errors import ModelError
from springpot.markup import table, tag
from springpot.measurement.covered import Covered
from springpot.measurement.units import Units
from springpot.plain_data import number
from springpot.rheology.continuum import EQUILIBRIUM, VISCOSITY
from springpot.rheology.forms import SearchForm
from springpot.rheology.model import Model
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Complex, Real

from .estimate import Estimate
from .kept import fit_of, kept, uncertainty_of
from .material import is_material
from .part_result import PartResult
from .prediction import Prediction, predict
from .problem import Objective, sizes
from .regularisation import SmoothSpectrum, regularised
from .uncertainty import ends, lost_and_known, spread_of
from .value import Value

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def printed(
    parameters: Sequence[Parameter], values: Real, low: Real, high: Real, units: Units
) -> dict[str, Value]:
    """Parameters with their intervals in printed units.

    Lines of a spectrum are told as a whole and left out.

    Parameters
    ----------
    parameters : sequence of Parameter
        Length p.
    values, low, high : ndarray, shape (p,)
        In the units of the measurement.
    units : Units
        Those of the measurement.
    """
    rows = {}
    for i, parameter in enumerate(parameters):
        # Lines of a spectrum are told as a whole elsewhere: a list of fifty weights tells nobody
        # anything.
        if parameter.detail:
            continue
        factor, label = units.of(parameter.unit)
        value, below, above = (factor * float(column[i]) for column in (values, low, high))
        rows[parameter.name] = Value(value, below, above, label)
    return rows


def all_parameters(
    model: Model, theta: Real, low: Real, high: Real, units: Units
) -> dict[str, Value]:
    """All parameters of a fit, those that were held in their places; see `printed`."""
    free = printed(model.parameters, theta, low, high, units)
    held = model.held
    if not held:
        return free
    rows = {}
    for parameter in model.released().parameters:
        name = parameter.name
        if name in held:
            factor, label = units.of(parameter.unit)
            value = factor * held[name]
            rows[name] = Value(value, value, value, label, fixed=True)
        elif name in free:
            rows[name] = free[name]
    return rows


def search_parameters(estimate: Estimate) -> dict[str, Value]:
    """The parameters in the model's published search form, by linear propagation.

    None where it has no such form.
    """
    form = estimate.model.search
    if form is None:
        return {}
    q = len(form.parameters)
    with np.errstate(all="ignore"):
        # The elements come first in theta; what follows are effects, which the published form does
        # not know.
        x = form.from_elements(estimate.theta[:q])
        reach = _reach(estimate, form, x)
        log = np.array([p.scale == "log" for p in form.parameters])
        bounds = (
            np.array([p.lower for p in form.parameters]),
            np.array([p.upper for p in form.parameters]),
        )
        low, high = ends(x, np.where(np.isfinite(reach), reach, np.inf), log, bounds)
        # A slope tells nothing of a step away from a bound: there the ends themselves are carried
        # over.
        for moved in _at_ends(estimate, q):
            other = np.nan_to_num(form.from_elements(moved), nan=np.inf)
            low, high = (
                np.fmax(np.fmin(low, other), bounds[0]),
                np.fmin(np.fmax(high, other), bounds[1]),
            )
    for i, j in _shared(estimate, form, x):
        low[i], high[i] = estimate.low[j], estimate.high[j]
    return printed(form.parameters, x, low, high, estimate.measurement.units)


def _at_ends(estimate: Estimate, q: int) -> list[Real]:
    """The parameters of the form, those at a bound put at both ends of their interval in turn."""
    moved = []
    at_bound = estimate.uncertainty.at_bound[:q]
    for i in np.flatnonzero(at_bound).tolist():
        # An upper end is often infinite, where the form has limits that its formulas do not reach.
        places = [estimate.low[i]]
        if at_bound[i] < 0:
            places.append(estimate.high[i])
        for place in places:
            theta = estimate.theta[:q].copy()
            theta[i] = place
            moved.append(theta)
    return moved


def _shared(estimate: Estimate, form: SearchForm, x: Real) -> list[tuple[int, int]]:
    """Places (in the form, in the model) of parameters that both have.

    These have one interval, not two.
    """
    names = estimate.model.names[: len(form.parameters)]
    places = [(i, names.index(p.name)) for i, p in enumerate(form.parameters) if p.name in names]
    return [(i, j) for i, j in places if np.isclose(x[i], estimate.theta[j], rtol=1e-12)]


def _reach(estimate: Estimate, form: SearchForm, x: Real) -> Real:
    """Half the width of the intervals of ln x (logarithmic parameters) or x."""
    known, coordinates = estimate.uncertainty, estimate.fit.task.coordinates
    q = len(form.parameters)
    turn = coordinates.slopes(estimate.theta, coordinates.size[0])[:q]
    by_theta = form.jacobian(x)
    # Where several values of the form give the same elements, the data say nothing of its
    # parameters.
    if not np.all(np.isfinite(by_theta)) or np.linalg.matrix_rank(by_theta) < q:
        return np.full(q, np.inf)
    by_u: Real = np.asarray(np.linalg.solve(by_theta, turn), dtype=float)
    log = np.array([p.scale == "log" for p in form.parameters])
    by_u /= np.where(log, x, 1.0)[:, None]
    return known.quantile * spread_of(by_u, known.covariance)


SCHEMA = "springpot.identification/2"


@dataclass(frozen=True)
class Standing:
    """The error of a model beside what noise alone leaves and what any material reaches.

    Attributes
    ----------
    noise_floor : float
        Relative error that noise alone leaves.
    noise_source : {"given", "repeats", "estimated"}
        Where the noise comes from.
    material_floor : float
        The least relative error that any linear passive material reaches beside the model's
        effects.
    good_enough : bool
        Whether nothing but noise is left.
    says : str
        The same in one sentence.
    """

    noise_floor: float
    noise_source: str
    material_floor: float
    good_enough: bool
    says: str


@dataclass(frozen=True, eq=False)
class Identification(Estimate):
    """The parameters of a model identified from a measurement.

    Attributes
    ----------
    fit : Fit
        The fit, in the units of the measurement.
    low, high : ndarray, shape (p,)
        Ends of the 95 % intervals of theta; infinite where the data give none.
    uncertainty : Uncertainty
        What the Jacobian says.
    optimiser, status : str
        Who searched, and how it ended.
    evaluations : int
        Model evaluations of the search.
    seconds : float
        Time taken in all.
    notes : tuple of str
        Plain sentences on what the numbers do not say.
    seed : int
        Of the noise behind the band of a spectrum.
    judge : callable, optional
        Finds the noise floor and the material floor when they are first asked for.

    Examples
    --------
    >>> import springpot
    >>> fit = springpot.identify("artificial-hidden", "fractional-maxwell + inertia + time-delay")
    >>> print(fit["inertia.m"])
    0.5985 [0.5912, 0.6059] kg
    >>> fit.predict(frequency=[0.0, 10.0]).storage.round(1)
    array([  0. , 219.1])
    """

    optimiser: str
    status: str
    evaluations: int
    seconds: float
    notes: tuple[str, ...] = ()
    seed: int = 0
    judge: Callable[[Identification], Standing | None] | None = None

    @cached_property
    def parameters(self) -> Mapping[str, Value]:
        """All parameters by name, with value, low, high and unit as they are printed.

        Those that were held too.
        """
        return all_parameters(self.model, self.theta, self.low, self.high, self.measurement.units)

    @cached_property
    def search_parameters(self) -> Mapping[str, Value]:
        """The same in the model's published search form, if it has one."""
        return search_parameters(self)

    def __getitem__(self, name: str) -> Value:
        """One parameter, of the model or of its search form.

        Raises
        ------
        ModelError
            If there is none of that name, with those that there are.
        """
        # A name that both forms have is the element's own, which was fitted.
        for known in (self.parameters, self.search_parameters):
            if name in known:
                return known[name]
        raise ModelError(
            f"{self.model.name} has no parameter '{name}': it has {', '.join(self.parameters)}"
        )

    @cached_property
    def covariance(self) -> Real:
        """Covariance (p, p) of the free parameters in printed units, ordered as ``model.names``.

        Infinite where the data do not determine a parameter, zero where it rests on a bound.
        """
        fit, known = self.fit, self.uncertainty.covariance
        turn = fit.task.coordinates.slopes(fit.theta, fit.task.coordinates.size[0])
        # In the units of the values: a covariance in others would fit none of the printed numbers.
        factor = np.array([self.measurement.units.of(p.unit)[0] for p in self.model.parameters])
        lost, finite = lost_and_known(known)
        covariance: Real = factor[:, None] * (turn @ finite @ turn.T) * factor
        # What hangs on a direction that the data do not determine is not determined either.
        touched = np.any(np.abs(turn[:, lost]) > 0.0, axis=1)
        covariance[touched, touched] = np.inf
        return covariance

    @property
    def residuals(self) -> Complex:
        """Measured minus fitted complex stiffness, shape (n,), in the unit of the data."""
        # Measured less fitted, as a missing effect would add to the model.
        return self.measurement.stiffness - self.model.stiffness(
            self.theta, self.measurement.points
        )

    @property
    def relative_rms(self) -> float:
        """Root mean square of |K_model - K| / |K|."""
        # Relative at each point, so that soft and stiff ends of a sweep count alike.
        share = np.abs(self.residuals) / sizes(self.measurement)
        return float(np.sqrt(np.mean(share**2)))

    @cached_property
    def standing(self) -> Standing | None:
        """How the error stands against noise and any material.

        None where the data are too few to tell.
        """
        # Rooms below the diagnosis fit as well, and know no floors to judge by.
        if self.judge is None:
            return None
        return self.judge(self)

    @property
    def noise_floor(self) -> float:
        """Relative error that noise alone leaves; nan where the data are too few to tell."""
        if self.standing is None:
            return float("nan")
        return self.standing.noise_floor

    @cached_property
    def spectrum(self) -> SmoothSpectrum | None:
        """The smoothest spectrum that the data allow, where these choose it.

        None for a network of elements.
        """
        if not is_material(self.model):
            return None
        # The band is from simulated noise: with the seed that was kept, a file that is taken up
        # shows the same.
        return regularised(self.fit, np.random.default_rng(self.seed))

    @cached_property
    def covered(self) -> Covered:
        """What was measured: beyond it predictions rest on the model alone."""
        return Covered.of([self.measurement])

    def predict(
        self,
        frequency: ArrayLike | None = None,
        *,
        omega: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
        amplitude: ArrayLike | None = None,
        level: float = 0.95,
        **columns: ArrayLike,
    ) -> Prediction:
        """What the model says of another test, with a band.

        Parameters
        ----------
        frequency : array_like, shape (n,), optional
            In Hz; zero gives the limit at rest. Without it and `omega` the measured ones.
        omega : array_like, shape (n,), optional
            Angular frequency in rad/s instead.
        temperature : array_like, one or (n,), optional
            In degC; constants of shifts refer to the reference temperature of the fit.
        amplitude : array_like, one or (n,), optional
            In the amplitude unit of the data.
        level : float
            Probability of the band.
        **columns : array_like, one or (n,)
            Other conditions by name.

        Returns
        -------
        Prediction
            With omega, storage, loss, low and high, in the unit of the data.

        Raises
        ------
        DataError
            If the columns cannot be, or one that the model needs is missing.
        ModelError
            If the model knows nothing of a condition whose change is asked for.
        """
        return predict(
            self.uncertainty,
            frequency,
            omega,
            level,
            temperature=temperature,
            amplitude=amplitude,
            **columns,
        )

    def plot(
        self, path: str | Path | None = None, *, ax: Axes | None = None
    ) -> Figure | Axes | Path:
        """Data and fit, and the residuals below.

        See `Measurement.plot` for the arguments and what is returned.
        """
        return draw(self, path, ax)

    def __str__(self) -> str:
        return text_of(self)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} {row.value:.4g} {row.unit}" for name, row in self.parameters.items()
        )
        error = f"error {100 * self.relative_rms:.3g} %"
        return f"<Identification {self.model.name} of {self.measurement.name}: {values}; {error}>"

    def _repr_html_(self) -> str:
        rows = []
        for name, row in self.parameters.items():
            # A parameter that was held has no interval: it is told apart from one that is known
            # exactly.
            unit = row.unit
            if row.fixed:
                unit = f"{unit} (fixed)"
            rows.append((name, f"{row.value:.4g}", *_interval(row), unit))
        error = f"error {100 * self.relative_rms:.3g} % of |K|"
        if self.standing is not None:
            error += (
                f", noise floor {100 * self.standing.noise_floor:.3g} %"
                f" ({self.standing.noise_source})"
            )
        return tag(
            "div",
            tag("p", tag("b", f"{self.model.name} of {self.measurement.name}")),
            table(("parameter", "value", "low", "high", "unit"), rows),
            tag("p", f"{error}, {self.optimiser}, {self.status}"),
            tag("ul", *(tag("li", note) for note in self.notes)),
        )

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data, schema ``springpot.identification/2``.

        It holds all that `springpot.load` needs.
        """
        spectrum: dict[str, Any] = {}
        if self.spectrum is not None:
            spectrum = {"spectrum": self._spectrum(self.spectrum)}
        floors: dict[str, Any] = {}
        if self.standing is not None:
            floors = {"error": {"relative_rms": self.relative_rms, **vars(self.standing)}}
        return {
            "schema": SCHEMA,
            "model": self.model.name,
            "data": self.measurement.name,
            "parameters": {name: value.to_dict() for name, value in self.parameters.items()},
            "search_parameters": {
                name: value.to_dict() for name, value in self.search_parameters.items()
            },
            "objective": {"name": self.fit.objective.name, "value": self.fit.cost},
            "relative_rms": self.relative_rms,
            "tests": [test.to_dict() for test in self.tests],
            "measured": self.covered.to_dict(),
            **floors,
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "optimiser": self.optimiser,
            "status": self.status,
            "notes": list(self.notes),
            **spectrum,
            "kept": kept(self, self.seed),
        }

    @property
    def tests(self) -> tuple[PartResult, ...]:
        """The sweep that was fitted, beside its noise floor."""
        data, error = self.measurement, self.relative_rms
        return (PartResult.of_sweep(data.name, len(data), error, self.noise_floor),)

    @classmethod
    def from_dict(
        cls,
        answer: Mapping[str, Any],
        model: Model,
        objective: Objective,
        judge: Callable[[Identification], Standing | None],
    ) -> Identification:
        """What `to_dict` gave: whole again, so that it predicts and draws as before.

        Parameters
        ----------
        answer : mapping
            The plain data.
        model : Model
            The one that its expression names.
        objective : Objective
            The one that it names.
        judge : callable
            Finds the floors when they are asked for, as those of a fit that was just made.
        """
        kept, evaluations = answer["kept"], int(answer["evaluations"])
        if kept["seed"] < 0:
            raise ValueError("a seed is below zero")
        fit = fit_of(kept, model, objective, number(answer["objective"]["value"]), evaluations)
        uncertainty, low, high = uncertainty_of(kept, fit)
        return cls(
            fit,
            low,
            high,
            uncertainty,
            optimiser=str(answer["optimiser"]),
            status=str(answer["status"]),
            evaluations=evaluations,
            seconds=float(answer["seconds"]),
            notes=tuple(answer["notes"]),
            seed=int(kept["seed"]),
            judge=judge,
        )

    def _spectrum(self, spectrum: SmoothSpectrum) -> dict[str, Any]:
        """K = equilibrium + viscosity s + sum of weight s / (s + rate), as printed, with a band."""
        units = self.measurement.units
        (size, unit), (flow, flow_unit) = units.of(EQUILIBRIUM.unit), units.of(VISCOSITY.unit)
        weight = size * spectrum.step
        return {
            "rates": spectrum.rates.tolist(),
            "weights": (weight * spectrum.density).tolist(),
            "low": (weight * spectrum.low).tolist(),
            "high": (weight * spectrum.high).tolist(),
            "unit": unit,
            "equilibrium": {"value": size * spectrum.equilibrium, "unit": unit},
            "viscosity": {"value": flow * spectrum.viscosity, "unit": flow_unit},
            "seen": list(spectrum.seen),
        }


def _interval(row: Value) -> tuple[str, str]:
    """The ends of an interval, or that there is none."""
    if row.fixed:
        return "-", "-"
    if not row.determined:
        return "not", "determined"
    return f"{row.low:.4g}", f"{row.high:.4g}"
