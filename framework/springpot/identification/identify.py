"""Step two of the paper for a user who wants the answer: parameters, their intervals, and what to know about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import Any

import numpy as np

from springpot.errors import DataError, ModelError, OptionError
from springpot.markup import table, tag
from springpot.measurement import Measurement
from springpot.rheology import Levels, Model, Parameter, Real
from springpot.rheology.continuum import EQUILIBRIUM, VISCOSITY

from .guard import guarded
from .material import is_material
from .native import Fit, default_objective, fit, require_enough
from .notes import notes_on
from .objective import Objective
from .optimiser import Optimiser
from .problem import Problem
from .regularised import Spectrum, regularised
from .space import require_conditions
from .uncertainty import Uncertainty, bootstrap, ends, profile, spread_of

SCHEMA = "springpot.identification/1"
NATIVE = "native"
BUDGET = 8000
STARTS = 8
MORE_STARTS = 32
RESAMPLES = 400
INTERVALS = ("jacobian", "profile", "bootstrap")
NESTING = 1e-6
"""A richer model may be worse than one it contains by this fraction, from rounding."""


@dataclass(frozen=True, eq=False)
class Identification:
    """The parameters of a model identified from a measurement.

    Attributes
    ----------
    fit : Fit
        The fit.
    low, high : ndarray, shape (p,)
        Ends of the 95 % intervals; infinite where the data give none.
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
    """

    fit: Fit
    low: Real
    high: Real
    uncertainty: Uncertainty
    optimiser: str
    status: str
    evaluations: int
    seconds: float
    notes: tuple[str, ...] = ()
    seed: int = 0

    @cached_property
    def spectrum(self) -> Spectrum | None:
        """The smoothest spectrum that the data allow, where these choose it; None for a network of elements."""
        return regularised(self.fit, np.random.default_rng(self.seed)) if is_material(self.model) else None

    @property
    def model(self) -> Model:
        """The model."""
        return self.fit.model

    @property
    def measurement(self) -> Measurement:
        """The measurement."""
        return self.fit.measurement

    @property
    def theta(self) -> Real:
        """The parameters, shape (p,), in the units of the measurement."""
        return self.fit.theta

    @property
    def relative_rms(self) -> float:
        """Root mean square of |K - K_m| / |K_m|."""
        data = self.measurement
        error = np.abs(self.model.stiffness(self.theta, data.points) - data.stiffness)
        return float(np.sqrt(np.mean((error / np.maximum(data.magnitude, 1e-9 * data.magnitude.max())) ** 2)))

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {row['value']:.4g} {row['unit']}".rstrip() for name, row in self._rows().items())
        error = f"error {100 * self.relative_rms:.3g} %"
        return f"<Identification {self.model.name} of {self.measurement.name}: {values}; {error}>"

    def _repr_html_(self) -> str:
        rows = [
            (name, *("-" if row[key] is None else f"{row[key]:.4g}" for key in ("value", "low", "high")), row["unit"])
            for name, row in self._rows().items()
        ]
        return tag(
            "div",
            tag("p", tag("b", f"{self.model.name} of {self.measurement.name}")),
            table(("parameter", "value", "low", "high", "unit"), rows),
            tag("p", f"error {100 * self.relative_rms:.3g} % of |K|, {self.optimiser}, {self.status}"),
            tag("ul", *(tag("li", note) for note in self.notes)),
        )

    def _rows(self) -> dict[str, dict[str, Any]]:
        return self._printed(self.model.parameters, self.theta, self.low, self.high)

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data, schema ``springpot.identification/1``; an interval without an end has None."""
        spectrum = {} if self.spectrum is None else {"spectrum": self._spectrum(self.spectrum)}
        return {
            "schema": SCHEMA,
            "model": self.model.name,
            "data": self.measurement.name,
            "parameters": self._rows(),
            "search_parameters": self._search_parameters(),
            "objective": {"name": self.fit.objective.name, "value": self.fit.cost},
            "relative_rms": self.relative_rms,
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "optimiser": self.optimiser,
            "status": self.status,
            "notes": list(self.notes),
            **spectrum,
        }

    def _spectrum(self, found: Spectrum) -> dict[str, Any]:
        """K = equilibrium + viscosity s + sum of weight s / (s + rate), in printed units, with a band."""
        units = self.measurement.units
        (size, unit), (flow, flow_unit) = units.of(EQUILIBRIUM.unit), units.of(VISCOSITY.unit)
        weight = size * found.step
        return {
            "rates": found.rates.tolist(),
            "weights": (weight * found.density).tolist(),
            "low": (weight * found.low).tolist(),
            "high": (weight * found.high).tolist(),
            "unit": unit,
            "equilibrium": {"value": size * found.equilibrium, "unit": unit},
            "viscosity": {"value": flow * found.viscosity, "unit": flow_unit},
            "seen": list(found.seen),
        }

    def _printed(
        self, parameters: Sequence[Parameter], values: Real, low: Real, high: Real
    ) -> dict[str, dict[str, Any]]:
        """Each parameter in the unit in which it is printed."""
        orders = dict(zip((p.name for p in parameters), values.tolist(), strict=True))
        printed = {}
        for i, parameter in enumerate(parameters):
            if parameter.detail:
                continue
            time = parameter.unit.time
            order = orders.get(time) if isinstance(time, str) else None
            factor, label = self.measurement.units.of(parameter.unit, order)
            printed[parameter.name] = {
                "value": _finite(values[i] * factor),
                "low": _finite(low[i] * factor),
                "high": _finite(high[i] * factor),
                "unit": label,
            }
        return printed

    def _search_parameters(self) -> dict[str, dict[str, Any]]:
        """The same in the model's published search form, by linear propagation."""
        form = self.model.search
        if form is None:
            return {}
        q = len(form.parameters)
        with np.errstate(all="ignore"):
            x = form.from_elements(self.theta[:q])
            reach = self._search_reach(x, q)
            log = np.array([p.scale == "log" for p in form.parameters])
            bounds = np.array([p.lower for p in form.parameters]), np.array([p.upper for p in form.parameters])
            low, high = ends(x, np.where(np.isfinite(reach), reach, np.inf), log, bounds)
            for moved in self._at_ends(q):
                other = np.nan_to_num(form.from_elements(moved), nan=np.inf)
                low, high = np.fmax(np.fmin(low, other), bounds[0]), np.fmin(np.fmax(high, other), bounds[1])
        for i, j in self._shared(x, q):
            low[i], high[i] = self.low[j], self.high[j]
        return self._printed(form.parameters, x, low, high)

    def _at_ends(self, q: int) -> list[Real]:
        """The parameters of the form, those at a bound moved in turn to the ends of their one-sided interval."""
        moved = []
        for i in np.flatnonzero(self.uncertainty.at_bound[:q]).tolist():
            # An upper end is often infinite, where the form has limits that its formulas do not reach.
            for end in (self.low[i], self.high[i]) if self.uncertainty.at_bound[i] < 0 else (self.low[i],):
                theta = self.theta[:q].copy()
                theta[i] = end
                moved.append(theta)
        return moved

    def _shared(self, x: Real, q: int) -> list[tuple[int, int]]:
        """Places (in the form, in the model) of parameters that both have: these have one interval, not two."""
        assert self.model.search is not None
        names = self.model.names[:q]
        places = [(i, names.index(p.name)) for i, p in enumerate(self.model.search.parameters) if p.name in names]
        return [(i, j) for i, j in places if np.isclose(x[i], self.theta[j], rtol=1e-12)]

    def _search_reach(self, x: Real, q: int) -> Real:
        """Half the width of the intervals of ln x (logarithmic parameters) or x."""
        known, coordinates = self.uncertainty, self.fit.task.coordinates
        assert self.model.search is not None
        turn = coordinates.slopes(self.theta, coordinates.size[0])[:q]
        by_theta = self.model.search.jacobian(x)
        if not np.all(np.isfinite(by_theta)) or np.linalg.matrix_rank(by_theta) < q:
            return np.full(q, np.inf)
        by_u: Real = np.asarray(np.linalg.solve(by_theta, turn), dtype=float)
        log = np.array([p.scale == "log" for p in self.model.search.parameters])
        by_u /= np.where(log, x, 1.0)[:, None]
        return known.quantile * spread_of(by_u, known.covariance)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def identify(
    measurement: Measurement,
    model: Model,
    *,
    optimiser: Optimiser | None = None,
    objective: Objective | None = None,
    budget: int | None = None,
    restarts: int | None = None,
    seed: int | None = None,
    intervals: str = "jacobian",
    simpler: Sequence[Model] = (),
) -> Identification:
    """Identify the parameters of a model.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        What is fitted.
    optimiser : Optimiser, optional
        Who searches; the native solver by default.
    objective : Objective, optional
        How the misfit is measured; by default weighted by given standard deviations, else relative.
    budget : int, optional
        Evaluations of each restart of an optimiser; 8000 by default. The native solver ends by itself.
    restarts : int, optional
        Independent restarts of which the best counts, 1 by default; the native solver takes as many times its starts.
    seed : int, optional
        Seed of all randomness; without it the native solver's starts are its fixed ones.
    intervals : {"jacobian", "profile", "bootstrap"}
        Where the intervals come from.
    simpler : sequence of Model
        Models that this one contains: if one fits better, the search has failed and is repeated.

    Returns
    -------
    Identification
        Parameters, intervals and notes.

    Raises
    ------
    ModelError
        If the data lack a column that the model needs, or an optimiser is to search a material, whose spectrum is no
        search.
    DataError
        If there is one point only, or if there are more unknowns than data.
    OptionError
        If the optimiser fails: it raises, crashes, hangs, or no value was finite.
    """
    began = perf_counter()
    require_conditions(model, measurement)
    model = model.bound_to(measurement.points)
    if len(measurement) < 2:
        raise DataError(f"{measurement.name}: one point identifies no model; measure at two frequencies or more")
    require_enough(model, measurement)
    objective = default_objective(measurement) if objective is None else objective
    if optimiser is None or optimiser.name == NATIVE:
        found, status, notes = _by_native(model, measurement, objective, restarts or 1, seed, simpler)
        name = NATIVE
    elif is_material(model):
        raise ModelError(f"{model.name}: the spectrum of a material is no search; leave out the optimiser")
    else:
        problem = Problem.of(model, measurement, objective)
        found, status, notes = _by_optimiser(problem, optimiser, budget or BUDGET, restarts or 1, seed or 0)
        name = optimiser.name
    known = Uncertainty.of(found)
    low, high = _interval(known, intervals, seed or 0)
    notes = [*notes, *_references(model), *notes_on(known, low, high)]
    spent = perf_counter() - began
    return Identification(found, low, high, known, name, status, found.evaluations, spent, tuple(notes), seed or 0)


def _references(model: Model) -> list[str]:
    """Where the factors of levels are one."""
    elements = [(effect.name, effect.element) for effect in model.effects if isinstance(effect.element, Levels)]
    return [f"{name}: the factor is 1 at {each.column} {each.shown[each.reference]:.6g}" for name, each in elements]


def _by_native(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    restarts: int,
    seed: int | None,
    simpler: Sequence[Model],
) -> tuple[Fit, str, list[str]]:
    """The native fit, checked against the simpler models that it contains."""
    rng = None if seed is None else np.random.default_rng(seed)
    found = fit(model, measurement, objective, starts=STARTS * restarts, rng=rng)
    notes: list[str] = []
    if is_material(model):
        return found, "converged" if found.converged else "not converged", notes
    if not (found.converged and found.confirmed):
        found = _better(found, fit(model, measurement, objective, starts=MORE_STARTS, seeds_theta=[found.theta]))
    inner = [fit(part, measurement, objective, starts=STARTS) for part in (*_without_effects(model), *simpler)]
    best = min(inner, key=lambda other: other.cost, default=None)
    if best is not None and best.cost < found.cost * (1.0 - NESTING) - found.task.floor[0]:
        seeds = [*_grown(best, model), found.theta]
        found = _better(found, fit(model, measurement, objective, starts=MORE_STARTS, seeds_theta=seeds))
        if best.cost < found.cost * (1.0 - NESTING) - found.task.floor[0]:
            notes.append(f"the simpler {best.model.name} fits better than {model.name}: the search has failed")
    if not found.converged:
        notes.append("the search did not come to rest: the parameters may be improved by more restarts")
    return found, "converged" if found.converged else "not converged", notes


def _better(one: Fit, other: Fit) -> Fit:
    return other if other.cost <= one.cost else one


def _without_effects(model: Model) -> list[Model]:
    """The models that lack one of the effects."""
    return [model - effect for effect in dict.fromkeys(e.name for e in model.effects)]


def _grown(part: Fit, model: Model) -> list[Real]:
    """Starts of `model` at the fit of a model that it contains: what is new is small, middling or large."""
    known = dict(zip(part.model.names, part.theta.tolist(), strict=True))
    coordinates = part.task.coordinates
    sizes = coordinates.of(model.parameters, coordinates.log_omega, part.task.scale, coordinates.amplitude).size[0]
    starts = []
    for share in (1e-4, 1.0, 1e4):
        values = [known.get(p.name, share * size) for p, size in zip(model.parameters, sizes, strict=True)]
        starts.append(np.clip(values, [p.lower for p in model.parameters], [p.upper for p in model.parameters]))
    return starts


def _by_optimiser(
    problem: Problem, optimiser: Optimiser, budget: int, restarts: int, seed: int
) -> tuple[Fit, str, list[str]]:
    """The best of several supervised runs."""
    rngs = np.random.default_rng(seed).spawn(restarts)
    runs = [guarded(optimiser, problem, budget, rng) for rng in rngs]
    best = min(runs, key=lambda one: (one.failed, one.best))
    failed = [one.status.removeprefix("failed: ") for one in runs if one.failed]
    if best.failed:
        raise OptionError(f"the optimiser {optimiser.name} found nothing: {failed[0]}; try another one")
    found = Fit(
        problem.model,
        problem.measurement,
        problem.objective,
        best.theta,
        best.best,
        sum(one.evaluations for one in runs),
        best.status != "budget",
        sum(one.seconds for one in runs),
    )
    notes = [f"{len(failed)} of {restarts} restarts failed, the first: {failed[0]}"] if failed else []
    return found, best.status, notes


def _interval(known: Uncertainty, kind: str, seed: int) -> tuple[Real, Real]:
    if kind == "profile":
        pairs = [profile(known.fit, name, known.level) for name in known.fit.model.names]
        return np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    if kind == "bootstrap":
        drawn = bootstrap(known.fit, RESAMPLES, np.random.default_rng([seed, 1]))
        tail = 50.0 * (1.0 - known.level)
        low, high = np.percentile(drawn, [tail, 100.0 - tail], axis=0)
        # Of a parameter as good as zero no two fits stop at the same tiny number: its interval begins at the bound.
        bounds = np.array([[p.lower, p.upper] for p in known.fit.model.parameters]).T
        low = np.where(known.at_bound < 0, bounds[0], np.minimum(low, known.fit.theta))
        high = np.where(known.at_bound > 0, bounds[1], np.maximum(high, known.fit.theta))
        return low, high
    return known.interval()
