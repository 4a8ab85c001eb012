"""What an identification from tests in time found.

Parameters, intervals, and each test beside its noise floor.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.distributions import student
from springpot.identification.coordinates import Coordinates
from springpot.identification.uncertainty import ends, spread_of
from springpot.measurement.covered import Covered
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units
from springpot.rheology.continuum import Continuum
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .sizes import rms

if TYPE_CHECKING:
    from .residuals_of_tests import Part

SCHEMA = "springpot.identification-in-time/1"
AGREE = 1.5
"""A test that the common parameters miss by this many times what its own would leave does not agree
with the others: with the fifty numbers of a usual test that is beyond a chance of 1e-3 (F test)."""
LOOSE = 100.0
"""Ratio of the ends of an interval from which a parameter is hardly determined.

A factor of ten either way.
"""
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


@dataclass(frozen=True)
class PartResult:
    """One test of an identification.

    Attributes
    ----------
    name, kind : str
        Of the test; ``sweep`` for one at frequencies.
    points : int
        Its samples.
    error, floor : float
        Root mean square of the residual and of the noise, each over that of the signal.
    ratio : float
        Root mean square of the residuals over their noise.
    alone : float
        The same with parameters of its own.
    """

    name: str
    kind: str
    points: int
    error: float
    floor: float
    ratio: float
    alone: float

    @classmethod
    def of(
        cls, part: Part, model: Model, theta: Real, reference: float, alone: float
    ) -> PartResult:
        """Judge one part at theta."""
        # By its noise alone, whatever it weighed in the fit.
        plain = part.with_scale(1.0)
        weighted = plain.residual(model, theta, reference).value
        ratio = rms(weighted)
        kind = part.test.kind if isinstance(part.test, TimeTest) else "sweep"
        error, floor = rms(weighted * part.relative_sd), rms(part.relative_sd)
        return cls(part.test.name, kind, len(part.test), error, floor, ratio, alone)

    @property
    def agrees(self) -> bool:
        """Whether the common parameters serve this test nearly as well as its own would."""
        # To leave less than the noise is chance: no test is asked for that.
        return self.ratio <= AGREE * max(self.alone, 1.0)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "data": self.name,
            "kind": self.kind,
            "points": self.points,
            "relative_rms": self.error,
            "noise_floor": self.floor,
            "over_floor": self.ratio,
            "over_floor_alone": self.alone,
            "agrees": self.agrees,
        }


@dataclass(frozen=True, eq=False)
class TimeIdentification:
    """Parameters identified from tests in time, alone or beside sweeps.

    Attributes
    ----------
    model : Model
        What was fitted.
    theta : ndarray, shape (p,)
        The parameters, in the units of the first test in time.
    covariance : ndarray, shape (p, p)
        Of the search coordinates.
    coordinates : Coordinates
        These coordinates.
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
    """

    model: Model
    theta: Real
    covariance: Real
    coordinates: Coordinates
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

    @cached_property
    def quantile(self) -> float:
        """Student's factor of a 95 % interval."""
        points = sum(test.points for test in self.tests)
        return student(INTERVAL, max(points - len(self.theta), 1))

    @cached_property
    def slopes(self) -> Real:
        """Derivative of theta by the search coordinates, shape (p, p)."""
        return self.coordinates.slopes(self.theta, self.coordinates.size[0])

    @cached_property
    def interval(self) -> tuple[Real, Real]:
        """Ends (p,) of the 95 % intervals: by factors for what is searched by its logarithm."""
        # The covariance is that of search coordinates: it is carried to what is printed.
        reach = self.quantile * spread_of(self.slopes, self.covariance)
        log = self.coordinates.log
        with np.errstate(all="ignore"):
            # What is searched by its logarithm reaches by a factor: d ln theta is d theta over
            # theta.
            reach = np.where(log, reach / np.where(log, self.theta, 1.0), reach)
        # What the tests do not determine reaches anywhere.
        reach = np.where(np.isfinite(reach), reach, np.inf)
        bounds = (
            np.array([p.lower for p in self.model.parameters]),
            np.array([p.upper for p in self.model.parameters]),
        )
        return ends(self.theta, reach, log, bounds)

    @property
    def relative_rms(self) -> float:
        """Error of the worst test: root mean square of the residual over that of the signal."""
        return max(test.error for test in self.tests)

    @property
    def power(self) -> float:
        """Sum of squares of the residuals over their noise."""
        return sum(test.points * test.ratio**2 for test in self.tests)

    @cached_property
    def printed(self) -> list[tuple[float, str]]:
        """Factor and unit in which each parameter is printed."""
        values = dict(zip(self.model.names, self.theta.tolist(), strict=True))
        factors = []
        for parameter in self.model.parameters:
            order = None
            # The unit of a springpot holds a power of s, which another parameter tells.
            if isinstance(parameter.unit.time, str):
                order = values.get(parameter.unit.time)
            factors.append(self.units.of(parameter.unit, order))
        return factors

    @cached_property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """Each parameter with value, interval and unit, as printed.

        Lines of a spectrum are left to it.
        """
        low, high = self.interval
        values = zip(self.theta.tolist(), low.tolist(), high.tolist(), self.printed, strict=True)
        rows = {}
        for parameter, (value, below, above, (factor, unit)) in zip(
            self.model.parameters, values, strict=True
        ):
            if not parameter.detail:
                rows[parameter.name] = {
                    "value": _finite(value * factor),
                    "low": _finite(below * factor),
                    "high": _finite(above * factor),
                    "unit": unit,
                }
        return rows

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
                notes.append(
                    f"{test.name} does not agree with the other tests: {test.ratio:.2g} x its noise"
                    f" floor with common parameters, {test.alone:.2g} x with its own"
                )
        if self.on_sweeps:
            names = ", ".join(self.on_sweeps)
            notes.append(f"{names}: of the rig of the sweeps; the tests in time are free of it")
        low, high = self.interval
        for parameter, value, below, above in zip(
            self.model.parameters, self.theta, low, high, strict=True
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
        """As plain data, schema ``springpot.identification-in-time/1``.

        An interval without an end has None.
        """
        return {
            "schema": SCHEMA,
            "model": self.model.name,
            "data": " + ".join(test.name for test in self.tests),
            "parameters": self.parameters,
            "search_parameters": {},
            "objective": {"name": "noise", "value": float(self.power)},
            "relative_rms": self.relative_rms,
            "measured": self.covered.to_dict(),
            "tests": [test.to_dict() for test in self.tests],
            "covariance": self.in_printed_units().tolist(),
            "kept": {
                "theta": self.theta.tolist(),
                "covariance": (self.slopes @ self.covariance @ self.slopes.T).tolist(),
                "units": asdict(self.units),
                "reference": self.reference,
                "seen": list(self.covered.rate),
                **_rates(self.model),
                **_on_sweeps(self.on_sweeps),
            },
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "optimiser": self.optimiser,
            "status": self.ended,
            "notes": list(self.notes),
        }

    def in_printed_units(self) -> Real:
        """Covariance (p, p) of the parameters as printed."""
        turn = self.slopes * np.array([factor for factor, _ in self.printed])[:, None]
        covariance: Real = turn @ self.covariance @ turn.T
        return covariance

    def __repr__(self) -> str:
        values = ", ".join(
            f"{n} {row['value']:.4g} {row['unit']}".rstrip() for n, row in self.parameters.items()
        )
        tests = ", ".join(f"{test.name} {test.ratio:.2g} x floor" for test in self.tests)
        return f"<TimeIdentification {self.model.name}: {values}; {tests}>"


def _finite(value: float) -> float | None:
    # JSON has neither inf nor nan.
    if not np.isfinite(value):
        return None
    return float(value)


def _on_sweeps(names: tuple[str, ...]) -> dict[str, Any]:
    """Effects that only the sweeps have; of other fits nothing."""
    if not names:
        return {}
    return {"only_sweeps": list(names)}


def _rates(model: Model) -> dict[str, Any]:
    """Those of the lines of any material; of another model nothing."""
    if not isinstance(model.material, Continuum):
        return {}
    return {"rates": list(model.material.rates)}
