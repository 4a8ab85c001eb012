"""The answer of an identification: parameters as they are printed, residuals, predictions.

Parameters as they are printed, in the model's own form and in its published search form.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from springpot.distributions import student
from springpot.errors import ModelError
from springpot.lazy import Drawn, Printed, draw, draw_view
from springpot.measurement.covered import Covered
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test, together
from springpot.measurement.units import Units
from springpot.numerics import rms
from springpot.plain_data import as_declared, json_number, jsonable
from springpot.rheology.elements import EQUILIBRIUM, VISCOSITY
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real
from springpot.thresholds import INTERVAL

from .calibration import Calibration
from .fitted_quantities import in_short
from .kept import (
    bounds_of,
    coordinates_of,
    ends_of,
    fitted_model,
    measurement_of,
    measurement_to_dict,
    rates_of,
    words_in,
)
from .material import is_material
from .native import Fit
from .normal import Bordered, Covariance, carried, matrix_of, told_of
from .population import Population, populations, specimens_of
from .prediction import Known
from .problem import Objective, sizes
from .regularisation import SmoothSpectrum, regularised
from .robust import kept_of, objective_again
from .uncertainty import Uncertainty, search_parameters, slopes_of, tied_values
from .value import PartResult, Quantities, Value, all_parameters, parts_of, spare

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SCHEMA = "springpot.identification/2"


@dataclass(frozen=True)
class Standing:
    """The error of a model beside what noise alone leaves and what any material reaches.

    Attributes
    ----------
    noise_floor : float
        Relative error that noise alone leaves.
    noise_source : {"given", "repeats", "estimated", "residual", "signal"}
        Where the noise comes from; see `springpot.misfit.error.Error`.
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

    @classmethod
    def judge_of(cls, answer: Mapping[str, Any]) -> Callable[[object], Standing | None]:
        """What an `Identification` asks for it, where it was written to a file."""
        row = answer.get("error")
        standing = None
        if row is not None:
            floors = [json_number(row[name]) for name in ("noise_floor", "material_floor")]
            source, says = row["noise_source"], row["says"]
            standing = as_declared(cls(floors[0], source, floors[1], row["good_enough"], says))
        return lambda fit: standing


def known_of_sweep(known: Uncertainty) -> Known:
    """What a fit of a sweep that stands alone knows of other tests."""
    fit = known.fit
    data = fit.measurement
    # Relative at each point, so that soft and stiff ends of a sweep count alike.
    missed = np.abs(data.stiffness - fit.model.stiffness(fit.theta, data.points)) / sizes(data)
    dof = known.freedom
    if known.specimens is not None:
        dof = known.specimens.count - 1
    return Known(
        model=fit.model,
        theta=fit.theta,
        slopes=slopes_of(fit),
        spread=known.covariance,
        leanings=known.leanings,
        units=data.units,
        reference=data.reference_temperature,
        misfit=rms(missed),
        dof=dof,
        covered=Covered.of([data]),
        sweep=data,
        words=words_in(data),
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Identification(Known, Drawn, Printed):
    """The parameters of a model identified from tests of one specimen, of any kind.

    Attributes
    ----------
    low, high : ndarray, shape (p,)
        Ends of the 95 % intervals of theta; infinite where the data give none.
    data : tuple of Measurement or TimeTest
        The tests, in common units; of tests in time a file does not hold them.
    parts : tuple of PartResult
        Each test beside its noise floor, where one in time is among them.
    objective : str
        By what points or samples weigh among each other.
    cost : float
        The objective at the end.
    optimiser, status : str
        Who searched, and how it ended.
    converged : bool
        Whether the search came to rest.
    evaluations : int
        Model evaluations of the search.
    seconds : float
        Time taken in all.
    notes : tuple of str
        Plain sentences on what the numbers do not say.
    seed : int
        Of the noise behind the band of a spectrum.
    uncertainty : Uncertainty, optional
        Of a sweep that stands alone: its fit, and what the Jacobian says.
    judge : callable, optional
        Finds the noise floor and the material floor when they are first asked for.
    calibration : Calibration, optional
        What the instrument promises, where the intervals hold it.
    verdicts : tuple of str
        Of intervals by profile, whether the data tell each parameter (p,); see `identifiable`.

    Examples
    --------
    >>> import springpot
    >>> fit = springpot.identify("artificial-hidden", "fractional-maxwell + inertia + time-delay")
    >>> print(fit["inertia.m"])
    0.5985 [0.5912, 0.6059] kg
    >>> fit.predict(frequency=[0.0, 10.0]).storage.round(1)
    array([  0. , 219.1])
    """

    low: Real
    high: Real
    data: tuple[Test, ...] = ()
    parts: tuple[PartResult, ...] = ()
    objective: str
    cost: float
    optimiser: str
    status: str
    converged: bool
    evaluations: int
    seconds: float
    notes: tuple[str, ...] = ()
    seed: int = 0
    uncertainty: Uncertainty | None = None
    judge: Callable[[Identification], Standing | None] | None = None
    calibration: Calibration | None = None
    verdicts: tuple[str, ...] = ()

    @classmethod
    def of_sweep(
        cls, known: Uncertainty, low: Real, high: Real, optimiser: str, status: str, **told: Any
    ) -> Identification:
        """That of a sweep which stands alone, by its fit and the ends of the intervals (p,)."""
        fit = known.fit
        return cls(
            **vars(known_of_sweep(known)),
            low=low,
            high=high,
            data=(fit.measurement,),
            objective=fit.objective.name,
            cost=fit.cost,
            optimiser=optimiser,
            status=status,
            converged=fit.converged,
            uncertainty=known,
            **told,
        )

    @property
    def fit(self) -> Fit:
        """The fit of a sweep that stands alone, in the units of the measurement."""
        return self._alone.fit

    @property
    def measurement(self) -> Measurement:
        """The sweep that stands alone."""
        return self._alone.fit.measurement

    @property
    def _alone(self) -> Uncertainty:
        if self.uncertainty is None:
            raise ModelError(f"{self.model.name} was fitted to tests in time: see `data`, `tests`")
        return self.uncertainty

    @cached_property
    def parameters(self) -> Mapping[str, Value]:
        """All parameters by name, with value, low, high and unit as they are printed.

        Those that were held too.
        """
        ends, quantile = (self.low, self.high), student(INTERVAL, self.dof)
        tied = tied_values(self.model, self.theta, ends, self._by_theta, quantile, self.units)
        return all_parameters(self.model, self.theta, *ends, self.units, tied)

    @cached_property
    def search_parameters(self) -> Mapping[str, Value]:
        """The same in the model's published search form, if it has one and a sweep stands alone."""
        if self.uncertainty is None:
            return {}
        return search_parameters(self.uncertainty, self.low, self.high)

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
        return matrix_of(self._printed)

    @cached_property
    def _printed(self) -> Covariance:
        """The same, of levels with parameters of their own by its blocks."""
        # In the units of the values: a covariance in others would fit none of the printed numbers.
        factor, known = self._factors, self._by_theta
        if isinstance(known, Bordered):
            return known.scaled(factor)
        return factor[:, None] * known * factor

    @property
    def _by_theta(self) -> Covariance:
        """Covariance (p, p) of theta, infinite where the data do not determine a parameter."""
        return carried(self.spread, self.slopes)

    @property
    def budget(self) -> dict[str, dict[str, float]]:
        """Standard uncertainty of each parameter by its source, as printed; none without one."""
        if self.calibration is None:
            return {}
        budget = self.calibration.budget(self.model.names, self._factors)
        return {name: budget[name] for name in self.parameters if name in budget}

    @property
    def identifiable(self) -> dict[str, str]:
        """By parameter ``identifiable``, ``practically not`` or ``not at all``, by its profile.

        Of other intervals nothing is told; see `springpot.identification.intervals.Path.profile`.
        """
        return dict(zip(self.model.names, self.verdicts, strict=False))

    @cached_property
    def populations(self) -> dict[str, Population]:
        """Of parameters that specimens have for themselves: their mean and scatter; else none."""
        values = self._factors * self.theta
        known = self.model, values, self._printed, self.units, self.words
        return populations(*known, self.sweep)

    @cached_property
    def quantities(self) -> Quantities:
        """Crossover, plateau, moduli, viscosity, loss factor ... of its material, with intervals.

        Where nothing else is asked for; see `springpot.quantities`.
        """
        return in_short(self, self.name, self.data)

    def values_by_level(self, name: str) -> list[Value]:
        """What each level has of a parameter of its own, in the order of the levels."""
        pairs = list(zip(self.model.names, self.model.origins, strict=True))
        pairs += [(each.parameter.name, each.origin) for each in self.model.followers(self.theta)]
        return [self.parameters[each] for each, origin in pairs if origin == name]

    @property
    def _factors(self) -> Real:
        """From own to printed units (p,)."""
        return np.array([self.units.of(each.unit)[0] for each in self.model.parameters])

    def calibrated(self, calibration: Calibration, *, widen: bool = True) -> Self:
        """The same, uncertain by what all points have in common too.

        Its intervals as well, unless they hold that already.
        """
        found = replace(self, calibration=calibration)
        if isinstance(self.spread, Bordered):
            # In the parameters themselves, and as further columns that all levels share.
            known = self.spread.carried(self.slopes)
            columns = np.column_stack([known.columns, *calibration.moved.values()])
            unit = np.broadcast_to(np.eye(self.slopes.shape[-1]), self.slopes.shape)
            found = replace(found, slopes=unit, spread=replace(known, columns=columns))
            return found if not widen else found._widened(calibration)
        turn = np.linalg.pinv(self.slopes)
        shared = turn @ calibration.shared @ turn.T
        if self.uncertainty is not None:
            found = replace(found, uncertainty=replace(self.uncertainty, shared=shared))
        found = replace(found, spread=self.spread + shared)
        return found if not widen else found._widened(calibration)

    def _widened(self, calibration: Calibration) -> Self:
        """The same with intervals that hold what the instrument promises."""
        low, high = calibration.widened(self.model, self.theta, self.low, self.high)
        return replace(self, low=low, high=high)

    @property
    def residuals(self) -> Complex:
        """Measured minus fitted complex stiffness of a sweep, shape (n,), in its unit."""
        # Measured less fitted, as a missing effect would add to the model.
        return self.measurement.stiffness - self.model.stiffness(
            self.theta, self.measurement.points
        )

    @property
    def relative_rms(self) -> float:
        """Root mean square of the residual over the signal, of a sweep of |K_model - K| / |K|.

        Of several tests that of the worst.
        """
        return self.misfit

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
        if self.uncertainty is None or not is_material(self.model):
            return None
        # The band is from simulated noise: with the seed that was kept, a file that is taken up
        # shows the same.
        return regularised(self.fit, np.random.default_rng(self.seed))

    @cached_property
    def tests(self) -> tuple[PartResult, ...]:
        """Each test beside its noise floor, together and alone."""
        if self.parts:
            return self.parts
        data = self.measurement
        return (PartResult.of_sweep(data.name, len(data), self.relative_rms, self.noise_floor),)

    @property
    def name(self) -> str:
        """Names of the tests."""
        return together(test.name for test in self.parts or self.data)

    @property
    def on_sweeps(self) -> tuple[str, ...]:
        """Names of the effects that only the sweeps have."""
        return tuple(effect.name for effect in self.model.effects if not effect.in_time)

    def plot(
        self, path: str | Path | None = None, *, ax: Axes | None = None, view: str | None = None
    ) -> Figure | Axes | Path:
        """Data and fit, and what is left of each test.

        See `springpot.lazy.Drawn.plot` for the arguments and what is returned. A `view` of the
        one sweep, alone or among tests in time, 84 mm wide as a journal's column is:
        ``storage-loss``, ``loss-factor``, ``cole-cole``, ``black``, ``van-gurp-palmen``,
        ``residual``.
        """
        if view is not None:
            return draw_view(self, view, path, ax)
        return draw(self, path, ax)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} {row.value:.4g} {row.unit}" for name, row in self.parameters.items()
        )
        error = f"error {100 * self.relative_rms:.3g} %"
        return f"<Identification {self.model.name} of {self.name}: {values}; {error}>"

    @property
    def magnitude(self) -> str:
        """What errors are shares of."""
        if self.uncertainty is None:
            return "the signal"
        return self.units.magnitude

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data, schema ``springpot.identification/2``.

        It holds all that `springpot.load` needs.
        """
        answer = {
            "schema": SCHEMA,
            "model": self.model.name,
            "data": self.name,
            "parameters": self.parameters,
            "search_parameters": self.search_parameters,
            "objective": {"name": self.objective, "value": self.cost},
            "relative_rms": self.relative_rms,
            "tests": self.tests,
            "measured": self.covered,
            "covariance": told_of(self._printed, self.model.names),
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "optimiser": self.optimiser,
            "status": self.status,
            "notes": self.notes,
            "kept": self._kept(),
        }
        if self.standing is not None:
            answer["error"] = {"relative_rms": self.relative_rms, **vars(self.standing)}
        if len(self.quantities):
            answer["quantities"] = self.quantities.rows
        if self.spectrum is not None:
            answer["spectrum"] = self._spectrum(self.spectrum)
        if self.verdicts:
            answer["identifiable"] = self.identifiable
        if self.calibration is not None:
            answer["budget"] = self.budget
        if self.populations:
            answer["population"] = self.populations
            answer["specimens"] = specimens_of(self.populations)
        return dict(jsonable(answer))

    def _kept(self) -> dict[str, Any]:
        """What people need not read: all in the units of the tests, and a sweep that is alone."""
        kept = {
            "theta": self.theta,
            "low": self.low,
            "high": self.high,
            "units": asdict(self.units),
            "reference": self.reference,
            "converged": self.converged,
            "seed": self.seed,
            "held": self.model.held,
            "bounds": bounds_of(self.model),
            "own": self.model.own,
            "only_sweeps": self.on_sweeps,
            "rates": rates_of(self.model),
        }
        if self.model.ties:
            kept["ties"] = list(self.model.ties)
        if self.model.own and self.uncertainty is None:
            kept |= {"levels": self.model.level_values, "words": self.words}
        if self.calibration is not None:
            kept["calibration"] = self.calibration.to_dict()
        if self.uncertainty is not None:
            absolute = self.uncertainty.absolute
            kept |= {"absolute": absolute, "measurement": measurement_to_dict(self.measurement)}
            kept |= kept_of(self.uncertainty)
        return kept

    @classmethod
    def from_dict(
        cls,
        answer: Mapping[str, Any],
        model: Model,
        objective_of: Callable[[str, Measurement], Objective],
    ) -> Identification:
        """What `to_dict` gave: whole again, so that it predicts and draws as before.

        Parameters
        ----------
        answer : mapping
            The plain data.
        model : Model
            The one that its expression names.
        objective_of : callable
            Finds the objective of that name for a sweep.
        """
        kept = answer["kept"]
        model, theta = fitted_model(model, kept)
        told: dict[str, Any] = {name: answer[name] for name in ("optimiser", "status")}
        told |= {"seconds": float(answer["seconds"]), "notes": tuple(answer["notes"])}
        told |= {"seed": int(kept["seed"]), "judge": Standing.judge_of(answer)}
        told["verdicts"] = tuple(map(str, answer.get("identifiable", {}).values()))
        told["evaluations"], cost = int(answer["evaluations"]), float(answer["objective"]["value"])
        if told["seed"] < 0 or not cost >= 0.0:
            raise ValueError("the seed or the objective has no value that it can have")
        low, high = ends_of(kept, len(theta))
        objective = str(answer["objective"]["name"])
        if "measurement" in kept:
            data = measurement_of(kept["measurement"])
            by, spread = objective_again(kept, objective, data, objective_of)
            spent, converged = told["evaluations"], bool(kept["converged"])
            fit = Fit(model, data, by, theta, cost, spent, converged)
            known = replace(Uncertainty.of(fit), absolute=bool(kept["absolute"]), spread=spread)
            return _as_kept(cls.of_sweep(known, low, high, **told), kept)
        units, tests = Units(**kept["units"]), parts_of(answer["tests"])
        slopes, covariance = coordinates_of(answer["covariance"], model, units)
        found = cls(
            model=model,
            theta=theta,
            slopes=slopes,
            spread=covariance,
            units=units,
            reference=float(kept["reference"]),
            misfit=json_number(answer["relative_rms"]),
            dof=spare(tests, theta),
            covered=Covered.read(answer["measured"]),
            words=kept.get("words", {}),
            low=low,
            high=high,
            parts=tests,
            objective=objective,
            cost=cost,
            converged=bool(kept["converged"]),
            **told,
        )
        return _as_kept(found, kept)

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


def _as_kept(found: Identification, kept: Mapping[str, Any]) -> Identification:
    """A fit with the calibration that its intervals hold, if they hold one."""
    if "calibration" not in kept:
        return found
    calibration = Calibration.read(kept["calibration"], len(found.theta))
    # Of tests in time the covariance was kept as it is.
    if found.uncertainty is None:
        return replace(found, calibration=calibration)
    return found.calibrated(calibration, widen=False)
