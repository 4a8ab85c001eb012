"""What an identification from tests in time found.

Parameters, intervals, and each test beside its noise floor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.drawing import draw, html_of, text_of
from springpot.errors import ModelError
from springpot.identification.kept import bounds_of, constrained_as, ends_of
from springpot.identification.part_result import SWEEP, PartResult, parts_of
from springpot.identification.prediction import Prediction
from springpot.identification.result import all_parameters
from springpot.identification.value import Value
from springpot.measurement.covered import Covered
from springpot.measurement.opening import Test
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units
from springpot.plain_data import jsonable
from springpot.registry import parse_model
from springpot.rheology.continuum import Continuum
from springpot.rheology.effect import SWEEPS
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .known import Known
from .where import rms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .residuals_of_tests import Part

SCHEMA = "springpot.identification/2"
LOOSE = 100.0
"""Ratio of the ends of an interval from which a parameter is hardly determined.

A factor of ten either way.
"""
MOST_POINTS = 2**53
"""Samples of all tests together: what a float counts exactly."""
LIKENESS = 0.98
"""Largest correlation of neighbouring residuals that is believed.

Beyond, a test would be worth no sample at all.
"""


def sampled_scatter(residual: Real, part: Part) -> float:
    """Mean square of residuals times the number of samples that make up one independent one.

    For a first-order autoregression with the correlation r of neighbours that is (1 + r) / (1 - r)
    (Bayley & Hammersley 1946, doi:10.2307/2983560).
    """
    rows = residual
    # Of a sweep K' comes first and then K'': its neighbours are told by K' alone.
    if not hasattr(part.test, "response"):
        rows = residual[: len(residual) // 2]
    power = float(np.mean(rows**2))
    if len(rows) < 4 or power == 0.0:
        return float(np.mean(residual**2))
    # Misses that alternate would claim more than one independent number a sample.
    likeness = float(np.clip(np.mean(rows[1:] * rows[:-1]) / power, 0.0, LIKENESS))
    return float(np.mean(residual**2)) * (1.0 + likeness) / (1.0 - likeness)


def part_result(
    part: Part, model: Model, theta: Real, reference: float, alone: float
) -> PartResult:
    """How far a model with these parameters is off in one part.

    Parameters
    ----------
    part : Part
        The test.
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters.
    reference : float
        Temperature in kelvin at which shifts are one.
    alone : float
        Root mean square of the residuals over their noise with parameters of its own.
    """
    # By its noise alone, whatever it weighed in the fit.
    weighted = part.with_scale(1.0).residual(model, theta, reference).value
    kind = SWEEP
    if isinstance(part.test, TimeTest):
        kind = part.test.kind
    error, floor = rms(weighted * part.relative_sd), rms(part.relative_sd)
    return PartResult(part.test.name, kind, len(part.test), error, floor, rms(weighted), alone)


@dataclass(frozen=True, eq=False)
class TimeIdentification:
    """Parameters identified from tests in time, alone or beside sweeps.

    Attributes
    ----------
    model : Model
        What was fitted.
    theta : ndarray, shape (p,)
        The parameters, in the units of the first test in time.
    low, high : ndarray, shape (p,)
        Ends of the 95 % intervals; infinite where the tests give none.
    spread : ndarray, shape (p, p)
        Covariance of theta.
    tests : tuple of PartResult
        Each test beside its noise floor.
    reference : float
        Temperature in kelvin at which shifts are one.
    evaluations : int
        Of the model, with derivatives.
    converged : bool
        Whether the search came to rest.
    seconds : float
        Time taken.
    units : Units
        Those of the parameters.
    optimiser : str
        What searched.
    status : str
        How its search ended; empty where `converged` says it all.
    said : tuple of str
        What went wrong on the way.
    covered : Covered
        What the tests together measured.
    data : tuple of TimeTest or Measurement
        The tests, in common units; a file does not hold them.
    objective : str
        By what samples of a test weigh among each other.
    """

    model: Model
    theta: Real
    low: Real
    high: Real
    spread: Real
    tests: tuple[PartResult, ...]
    reference: float
    evaluations: int
    converged: bool
    seconds: float
    units: Units
    optimiser: str = "native"
    status: str = ""
    said: tuple[str, ...] = ()
    covered: Covered = field(default_factory=Covered)
    data: tuple[Test, ...] = ()
    objective: str = "noise"

    @property
    def relative_rms(self) -> float:
        """Error of the worst test: root mean square of the residual over that of the signal."""
        return max(test.relative_rms for test in self.tests)

    @property
    def power(self) -> float:
        """Sum of squares of the residuals over their noise."""
        return sum(test.points * test.over_floor**2 for test in self.tests)

    @cached_property
    def parameters(self) -> dict[str, Value]:
        """Each parameter with its interval, as printed, those that were held too.

        Lines of a spectrum are left to it.
        """
        return all_parameters(self.model, self.theta, self.low, self.high, self.units)

    def __getitem__(self, name: str) -> Value:
        """The parameter of that name.

        Raises
        ------
        ModelError
            If there is none, with those that there are.
        """
        if name not in self.parameters:
            raise ModelError(
                f"{self.model.name} has no parameter '{name}': it has {', '.join(self.parameters)}"
            )
        return self.parameters[name]

    @cached_property
    def known(self) -> Known:
        """The model without what the tests did themselves, and how well it is known."""
        # What a test did, such as a drift, does not go into another one.
        model = self.model.of_specimen
        count = len(model.parameters)
        return Known(
            model,
            self.theta[:count],
            self.spread[:count, :count],
            self.units,
            self.reference,
            self.relative_rms,
            # Samples whose misses are alike were counted once in the covariance already.
            max(sum(test.points for test in self.tests) - len(self.theta), 1),
            self.covered,
        )

    def predict(
        self,
        frequency: ArrayLike | None = None,
        *,
        omega: ArrayLike | None = None,
        temperature: float | None = None,
        amplitude: float | None = None,
        level: float = 0.95,
    ) -> Prediction:
        """K at other frequencies, with a band; see `Known.predict`."""
        return self.known.predict(
            frequency, omega=omega, temperature=temperature, amplitude=amplitude, level=level
        )

    @property
    def on_sweeps(self) -> tuple[str, ...]:
        """Names of the effects that only the sweeps have."""
        return tuple(effect.name for effect in self.model.effects if not effect.in_time)

    @property
    def ended(self) -> str:
        """How the search ended, in a word."""
        if self.status:
            return self.status
        if self.converged:
            return "converged"
        return "not converged"

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What the numbers do not say, the gravest first."""
        notes = list(self.said)
        if not self.converged:
            notes.append(
                "the search did not come to rest: the parameters may be improved by more data"
            )
        for test in self.tests:
            if not test.agrees:
                ratios = (
                    f"{test.over_floor:.2g} x its noise floor with common parameters,"
                    f" {test.over_floor_alone:.2g} x with its own"
                )
                notes.append(f"{test.name} does not agree with the other tests: {ratios}")
        if self.on_sweeps:
            names = ", ".join(self.on_sweeps)
            notes.append(f"{names}: of the rig of the sweeps; the tests in time are free of it")
        for parameter, value, below, above in zip(
            self.model.parameters, self.theta, self.low, self.high, strict=True
        ):
            if parameter.detail:
                continue
            if value in (parameter.lower, parameter.upper):
                notes.append(f"{parameter.name} ends at its bound {value:g}")
            elif not np.isfinite(above) or (
                parameter.scale == "log" and above > LOOSE * max(below, 1e-300)
            ):
                notes.append(f"{parameter.name} is hardly determined by these tests")
        return tuple(notes)

    def to_dict(self) -> dict[str, Any]:
        """As plain data, schema ``springpot.identification/2``.

        An interval without an end has None.
        """
        answer = {
            "schema": SCHEMA,
            "model": self.model.name,
            "data": " + ".join(test.name for test in self.tests),
            "parameters": self.parameters,
            "search_parameters": {},
            "objective": {"name": self.objective, "value": self.power},
            "relative_rms": self.relative_rms,
            "measured": self.covered,
            "tests": self.tests,
            "covariance": self.covariance,
            "kept": {
                "theta": self.theta,
                "low": self.low,
                "high": self.high,
                "covariance": self.spread,
                "units": asdict(self.units),
                "reference": self.reference,
                "converged": self.converged,
                "held": self.model.held,
                "bounds": bounds_of(self.model),
                "only_sweeps": self.on_sweeps,
                "rates": _rates(self.model),
            },
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "optimiser": self.optimiser,
            "status": self.ended,
            "notes": self.notes,
        }
        return dict(jsonable(answer))

    @classmethod
    def from_dict(cls, answer: Mapping[str, Any]) -> TimeIdentification:
        """What `to_dict` gave: whole again, so that it predicts as before."""
        kept, model = answer["kept"], _as_fitted(parse_model(answer["model"]), answer["kept"])
        tests, theta = parts_of(answer["tests"]), np.array(kept["theta"], dtype=float)
        covariance = np.array(kept["covariance"], dtype=float)
        # A file may have been changed by hand: numbers that cannot be would fail anywhere.
        within = all(
            p.lower <= value <= p.upper
            for p, value in zip(model.parameters, theta.tolist(), strict=True)
        )
        points = sum(test.points for test in tests)
        if not within or covariance.shape != (len(theta),) * 2 or not 0 < points < MOST_POINTS:
            raise ValueError(f"theta, covariance or points cannot be those of {model.name}")
        identified = cls(
            model,
            theta,
            *ends_of(kept, len(theta)),
            covariance,
            tests,
            float(kept["reference"]),
            int(answer["evaluations"]),
            bool(kept["converged"]),
            float(answer["seconds"]),
            Units(**kept["units"]),
            str(answer["optimiser"]),
            str(answer["status"]),
            covered=Covered.read(answer["measured"]),
            objective=str(answer["objective"]["name"]),
        )
        vars(identified).update(notes=tuple(answer["notes"]))
        return identified

    @property
    def covariance(self) -> Real:
        """Covariance (p, p) of the free parameters in printed units, as ``model.names``."""
        factors = np.array([self.units.of(each.unit)[0] for each in self.model.parameters])
        covariance: Real = self.spread * np.outer(factors, factors)
        return covariance

    def plot(self, path: str | Path | None = None) -> Figure | Axes | Path:
        """Each test with the fit and what it leaves; see `springpot.drawing.draw`."""
        return draw(self, path)

    def __str__(self) -> str:
        return text_of(self)

    def _repr_html_(self) -> str:
        return html_of(self)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} {row.value:.4g} {row.unit}" for name, row in self.parameters.items()
        )
        tests = ", ".join(f"{test.name} {test.over_floor:.2g} x floor" for test in self.tests)
        return f"<TimeIdentification {self.model.name}: {values}; {tests}>"


def _as_fitted(model: Model, kept: Mapping[str, Any]) -> Model:
    """A model of that name with what its name does not tell."""
    # Lines of a spectrum lie where the tests put them.
    if kept["rates"] is not None:
        model = replace(model, material=Continuum(tuple(map(float, kept["rates"]))))
    # Nor which effects are of the rig of the sweeps that stood beside tests in time.
    alone = set(kept["only_sweeps"])
    effects = [each.at(SWEEPS) if each.name in alone else each for each in model.effects]
    return constrained_as(replace(model, effects=tuple(effects)), kept)


def _rates(model: Model) -> list[float] | None:
    """Those of the lines of any material; of another model nothing."""
    if not isinstance(model.material, Continuum):
        return None
    return list(model.material.rates)
