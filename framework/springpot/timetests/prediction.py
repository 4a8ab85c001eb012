"""Another test of the same specimen: what a fitted model says of it, with a band, and whether it holds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.errors import DataError
from springpot.identification import Identification, Prediction, require_conditions
from springpot.identification.prediction import require_known
from springpot.identification.uncertainty import student
from springpot.measurement import (
    AMPLITUDE_UNITS,
    KELVIN,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    Covered,
    Measurement,
    TimeTest,
    Units,
    material_of,
    noise_of,
    one_modulus,
)
from springpot.rheology import Continuum, Model, Points, Real

from .parts import SweepPart, Test
from .predicted import predicted
from .result import TimeIdentification
from .sizes import rms

SCHEMA = "springpot.prediction-in-time/1"
ENDLESS = 1e12
"""Variance of a search coordinate that the data do not determine: a million natural sizes."""
MOST_POINTS = 2**53
"""Samples of all tests together: what a float counts exactly."""
VAGUE = 0.5
"""Expected error from which a fit says nothing of a test: it may be off by its own size."""
NEAR = 2.0
"""Factor by which a time may lie beyond those that a fit saw and still be one of them."""
HOLDS = 2.0
"""Error over what was to be expected up to which a prediction holds: nineteen of twenty of a normal error do."""


@dataclass(frozen=True, eq=False)
class Known:
    """A model with its parameters and how well they are known.

    Attributes
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters, in `units`.
    covariance : ndarray, shape (p, p)
        Of these parameters.
    units : Units
        Of the test that they were fitted to.
    reference : float
        Temperature in kelvin at which shifts are one.
    misfit : float
        Relative error that the fit itself has.
    dof : float
        Degrees of freedom behind the covariance.
    covered : Covered
        What the fitted tests measured.
    """

    model: Model
    theta: Real
    covariance: Real
    units: Units
    reference: float
    misfit: float
    dof: float
    covered: Covered = field(default_factory=Covered)

    @classmethod
    def of(cls, identified: TimeIdentification | Identification) -> Known:
        """From a fit to tests in time, or to a sweep."""
        if isinstance(identified, TimeIdentification):
            # Samples whose misses are alike were counted once in the covariance already.
            points = sum(test.points for test in identified.tests)
            # What a test did itself, such as a drift, does not go into another one.
            material = material_of(identified.model)
            turn = identified.slopes[: len(material.parameters)]
            return cls(
                material,
                identified.theta[: len(material.parameters)],
                turn @ identified.covariance @ turn.T,
                identified.units,
                identified.reference,
                identified.relative_rms,
                max(points - len(identified.theta), 1),
                identified.covered,
            )
        coordinates, data = identified.fit.task.coordinates, identified.measurement
        # An endless variance times a slope of zero would be no number.
        covariance = np.nan_to_num(identified.uncertainty.covariance, nan=0.0, posinf=ENDLESS)
        turn = coordinates.slopes(identified.theta, coordinates.size[0])
        return cls(
            identified.model,
            identified.theta,
            turn @ covariance @ turn.T,
            data.units,
            data.reference_temperature,
            identified.relative_rms,
            max(identified.fit.dof, 1),
            identified.covered,
        )

    @classmethod
    def read(cls, answer: dict[str, Any], model: Model) -> Known:
        """From the JSON of an identification from tests in time."""
        kept, count = answer["kept"], len(model.parameters)
        # Lines of a spectrum lie where the tests put them: the name of the model does not tell them.
        if "rates" in kept:
            model = replace(model, material=Continuum(tuple(map(float, kept["rates"]))))
            count = len(model.parameters)
        # Nor does it tell which effects are of the rig of the sweeps that stood beside tests in time.
        alone = set(kept.get("only_sweeps", ()))
        effects = [replace(each, only_sweeps=each.name in alone) for each in model.effects]
        model = replace(model, effects=tuple(effects))
        points = sum(int(test["points"]) for test in answer["tests"])
        theta = np.array(kept["theta"], dtype=float)[:count]
        covariance = np.array(kept["covariance"], dtype=float)[:count, :count]
        # A file may have been changed by hand: numbers that cannot be would fail anywhere.
        within = all(p.lower <= value <= p.upper for p, value in zip(model.parameters, theta.tolist(), strict=True))
        if not within or covariance.shape != (count, count) or not 0 < points < MOST_POINTS:
            raise ValueError(f"theta, covariance or points cannot be those of {model.name}")
        return cls(
            model,
            theta,
            covariance,
            Units(**kept["units"]),
            float(kept["reference"]),
            float(answer["relative_rms"]),
            max(points - len(model.parameters), 1),
            # Older files hold the frequencies alone.
            Covered.read(answer.get("measured", {"omega": kept["seen"]})),
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
        """K at frequencies in Hz or angular frequencies in rad/s, with a band; see `Identification.predict`.

        Raises
        ------
        DataError
            If there are no such frequencies, or the model needs a temperature (degC) or an amplitude.
        """
        if (frequency is None) == (omega is None):
            raise DataError("give frequency [Hz] or omega [rad/s]")
        if frequency is not None:
            omega = 2.0 * np.pi * np.asarray(frequency, dtype=float)
        omega = np.atleast_1d(np.asarray(omega, dtype=float))
        if not (np.all(np.isfinite(omega)) and np.all(omega > 0.0)):
            raise DataError("frequencies are a list of numbers, finite and above zero")
        given = {"temperature": temperature, "amplitude": amplitude}
        conditions = {name: np.full(len(omega), value) for name, value in given.items() if value is not None}
        for name in sorted(self.model.needs - set(conditions)):
            raise DataError(f"{self.model.name} needs {name}: give it")
        for name, column in conditions.items():
            require_known(self.model, self.covered, name, column)
        kelvin = None
        if temperature is not None:
            kelvin = conditions["temperature"] + KELVIN
        points = Points(np.log(omega), conditions.get("amplitude"), kelvin, self.reference)
        value, slopes = self.model.stiffness(self.theta, points), self.model.jacobian(self.theta, points)
        quantile = student(level, self.dof)
        real, imaginary = (quantile * _reach(part, self.covariance) for part in (slopes.real, slopes.imag))
        wide = real + 1j * imaginary
        low, high = value - wide, value + wide
        return Prediction(self.model.name, omega, value, low, high, conditions, self.units, level, self.covered)


def _reach(slopes: Real, covariance: Real) -> Real:
    """Standard deviation (m,) of something whose derivatives by the parameters are `slopes` (m, p)."""
    variance: Real = np.einsum("mi,ij,mj->m", slopes, covariance, slopes)
    # Rounding takes a variance of nothing below zero.
    return np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True, eq=False)
class TestPrediction:
    """What a model says of a test that it was not fitted to.

    Attributes
    ----------
    model, test : str
        Their names.
    kind : str
        Of the test; ``sweep`` for one at frequencies.
    at : ndarray, shape (m,)
        Time in s, or frequency in Hz for K' and again for K''.
    value, low, high : ndarray, shape (m,)
        Prediction and its band, from the uncertainty of the parameters alone.
    measured : ndarray, shape (m,)
        What the test gave.
    error : float
        Root mean square of the difference over that of the signal.
    expected : float
        The same as it was to be expected: from the parameters, the misfit of the fit itself and the test's noise.
    bias : float
        Mean difference over the size of the signal: above zero where the model says too much.
    inside : float
        Share of the samples at times (or frequencies) that the fitted tests saw.
    error_inside : float
        The error of these alone; nan where there are none.
    unit : str
        Of the value.
    judged : bool
        Whether the test was measured; otherwise there is nothing to judge by.
    outside : ndarray of bool, shape (m,)
        Which samples lie outside of what the fitted tests saw.
    notes : tuple of str
        What else one should know.
    quantity : str
        What the value is: force or displacement, stress or strain; of a sweep storage and then loss.
    clock : {"Hz", "rad/s"}
        In which frequencies of a sweep are told.
    """

    __test__ = False  # pytest takes it for a test otherwise

    model: str
    test: str
    kind: str
    at: Real
    value: Real
    low: Real
    high: Real
    measured: Real
    error: float
    expected: float
    bias: float
    inside: float
    error_inside: float
    unit: str
    outside: NDArray[np.bool_]
    notes: tuple[str, ...] = ()
    judged: bool = True
    quantity: str = "value"
    clock: str = "Hz"

    @property
    def verdict(self) -> str:
        """``holds``, ``fails``, ``vague`` where the fit hardly says anything of this test, or ``not-judged``."""
        if not self.judged:
            return "not-judged"
        # First: an error beyond even a wide expectation is a failure, not a vague prediction.
        if self.error > HOLDS * self.expected:
            return "fails"
        if self.expected > VAGUE:
            return "vague"
        return "holds"

    @property
    def holds(self) -> bool:
        """Whether the fit says something of this test, and the difference is no larger than was to be expected."""
        return self.verdict == "holds"

    @property
    def says(self) -> str:
        """One sentence."""
        if not self.judged:
            wide = rms(0.5 * (self.high - self.low)) / max(rms(self.value), 1e-300)
            return f"{self.test} is predicted to within {100 * wide:.2g} % by the uncertainty of the parameters"
        size = f"{100 * self.error:.2g} % off, where {100 * self.expected:.2g} % was to be expected"
        beyond = ""
        if self.inside < 1.0:
            beyond = f"; {100 * (1.0 - self.inside):.0f} % of it lies beyond what the fitted tests saw"
            if self.inside > 0.0:
                beyond += f", {100 * self.error_inside:.2g} % off within"
        if self.verdict == "vague":
            return f"the fit hardly says anything of {self.test}: {size}{beyond}"
        if self.holds:
            return f"the prediction of {self.test} holds: {size}{beyond}"
        way = "too little"
        if self.bias > 0:
            way = "too much"
        worst = self.at[int(np.argmax(np.abs(self.value - self.measured)))]
        place = f"{worst:.3g} s"
        if self.kind == "sweep":
            place = Units(clock=self.clock).at(worst)
        mean = f"{100 * abs(self.bias):.2g} % {way} on average, worst at {place}"
        return f"the prediction of {self.test} does not hold: {size}; {mean}{beyond}"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.prediction-in-time/1``."""
        clock = "time"
        if self.kind == "sweep":
            clock = "frequency"
        columns = (self.at, self.value, self.low, self.high, self.measured, self.outside)
        names = (clock, "value", "low", "high", "measured", "outside_measured")
        rows = zip(*(column.tolist() for column in columns), strict=True)
        points = [dict(zip(names, row, strict=True)) for row in rows]
        # JSON has no nan: what was not judged, or not seen, is null.
        error = expected = bias = error_inside = None
        if self.judged:
            error, expected, bias = self.error, self.expected, self.bias
        if self.inside > 0.0:
            error_inside = self.error_inside
        return {
            "schema": SCHEMA,
            "model": self.model,
            "data": self.test,
            "kind": self.kind,
            "unit": self.unit,
            "verdict": self.verdict,
            "holds": self.holds,
            "error": error,
            "expected_error": expected,
            "bias": bias,
            "inside": self.inside,
            "error_inside": error_inside,
            "says": self.says,
            "points": points,
            "notes": list(self.notes),
        }


def predict_test(known: Known | TimeIdentification | Identification, test: Test) -> TestPrediction:
    """Predict a test and judge the prediction.

    Parameters
    ----------
    known : Known, TimeIdentification or Identification
        A fit to other tests of the specimen.
    test : TimeTest or Measurement
        The test.

    Returns
    -------
    TestPrediction
        In the units of the fit where both are of one kind.

    Raises
    ------
    SpringpotError
        If the model needs a condition that the test lacks, or one is of a stiffness and the other of a modulus.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.timetests import identify, predict_test
    >>> model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.01, 100.0, 60)
    >>> theta = model.theta(k=400.0, c=60.0, alpha=0.5)
    >>> scatter = 1.0 + 0.01 * np.random.default_rng(1).normal(size=60)
    >>> fit = identify(springpot.TimeTest.of_relaxation(t, scatter * model.relaxation(theta, t), "kPa"), model)
    >>> predict_test(fit, springpot.TimeTest.of_compliance(t, scatter * model.creep(theta, t), "kPa")).holds
    True
    """
    if not isinstance(known, Known):
        known = Known.of(known)
    if isinstance(test, Measurement):
        require_conditions(known.model, test)
    elif "temperature" in known.model.needs and test.temperature is None:
        raise DataError(f"{test.name}: {known.model.name} needs its temperature: add '?temperature=25[degC]'")
    # The fit is brought to the test, and not the test to the fit: what is printed is in the units that were measured.
    theta, covariance = _in_units_of(known, test.units)
    if isinstance(test, TimeTest):
        compared = _in_time(test, known, theta)
        kind, unit, judged = test.kind, test.response_unit, test.measured
        quantity, clock = test.words[1], "Hz"
    else:
        compared = _at_frequencies(test, known, theta)
        kind, unit, judged = "sweep", test.units.stiffness, True
        quantity, clock = "storage and loss", test.units.clock
    # Relative to the signal, so that tests in different units and of different kinds are judged alike.
    share = (compared.value - compared.measured) / compared.size
    reach = _reach(compared.by_theta, covariance)
    wide = student(0.95, known.dof) * reach
    # Independent reasons to be off: what the parameters leave open and the noise of the test.
    known_error = np.hypot(reach, compared.noise) / compared.size
    # One over a time is a frequency only nearly: what lies near the ends was seen.
    asked = compared.rate, _settings(test, compared, known.units)
    inside = ~known.covered.outside(*asked, NEAR)
    remark = known.covered.remark(*asked, known.units, NEAR)
    error_inside = float("nan")
    if inside.any():
        error_inside = rms(share[inside])
    return TestPrediction(
        known.model.name,
        test.name,
        kind,
        compared.at,
        compared.value,
        compared.value - wide,
        compared.value + wide,
        compared.measured,
        rms(share),
        float(np.hypot(rms(known_error), known.misfit)),
        # "Too much" is larger in size, whatever the sign of the response.
        float(np.mean(share * np.sign(compared.measured))),
        float(np.mean(inside)),
        error_inside,
        unit,
        ~inside,
        tuple(filter(None, [remark])),
        judged,
        quantity,
        clock,
    )


def _settings(test: Test, compared: _Compared, units: Units) -> dict[str, Real]:
    """Temperature of each sample, or all conditions of each point of a sweep, amplitudes in the units of the fit."""
    if isinstance(test, Measurement):
        settings = {name: np.tile(column, 2) for name, column in test.conditions.items()}
        if "amplitude" in settings:
            settings["amplitude"] *= AMPLITUDE_UNITS[test.units.amplitude] / AMPLITUDE_UNITS[units.amplitude]
        return settings
    if test.warmth is not None:
        return {"temperature": np.interp(compared.at, test.time, test.warmth)}
    if test.temperature is not None:
        return {"temperature": np.full(len(compared.at), test.temperature)}
    return {}


def _in_units_of(known: Known, units: Units) -> tuple[Real, Real]:
    """Parameters and their covariance in the units of a test."""
    own = known.units
    if (own.stiffness in PRESSURE_UNITS) != (units.stiffness in PRESSURE_UNITS):
        raise DataError(
            f"the fit is in {own.stiffness} and the test in {units.stiffness}: a stiffness is no modulus; "
            "convert one of them by its geometry"
        )
    one_modulus([("the fit", own), ("the test", units)])
    stiffer = MODULUS_UNITS[own.stiffness] / MODULUS_UNITS[units.stiffness]
    longer = AMPLITUDE_UNITS[own.amplitude] / AMPLITUDE_UNITS[units.amplitude]
    # Time is in s everywhere: it needs no factor.
    powers = [(parameter.unit.stiffness, parameter.unit.amplitude) for parameter in known.model.parameters]
    factors = np.array([stiffer**stiffness * longer**amplitude for stiffness, amplitude in powers])
    _require_same_model(known, factors, stiffer, longer, units)
    return known.theta * factors, known.covariance * np.outer(factors, factors)


def _require_same_model(known: Known, factors: Real, stiffer: float, longer: float, units: Units) -> None:
    """Check that converted parameters are the same model: the force of a power law has no whole power of a length.

    Raises
    ------
    DataError
        If they are not.
    """
    if longer == 1.0 or "amplitude" not in known.model.needs:
        return
    # Two frequencies: one could agree by chance.
    rates, one = np.log(np.array([1.0, 10.0])), np.ones(2)
    kelvin = np.full(2, known.reference)
    here = Points(rates, amplitude=one, temperature=kelvin, reference_temperature=known.reference)
    there = replace(here, amplitude=longer * one)
    before = stiffer * known.model.stiffness(known.theta, here)
    after = known.model.stiffness(known.theta * factors, there)
    if not np.allclose(after, before, rtol=1e-6):
        raise DataError(
            f"{known.model.name} cannot be converted from {known.units.amplitude} to {units.amplitude}: the unit of "
            f"a parameter depends on another parameter; give the test in {known.units.amplitude}"
        )


class _Compared(NamedTuple):
    """A test and its prediction, sample by sample, and the size that differences are shares of.

    The rate is the angular frequency, or one over the time since the load moved.
    """

    at: Real
    rate: Real
    value: Real
    by_theta: Real
    measured: Real
    noise: Real
    size: Real


def _in_time(test: TimeTest, known: Known, theta: Real) -> _Compared:
    answer = predicted(known.model, theta, test, known.reference)
    # At the very instant of a step the answer may be endless, and no instrument reads it.
    seen = ~np.isin(test.time, test.loading.jumps[0])
    time, value = test.time[seen], answer.value[seen]
    # A test that was not measured is its own prediction: nothing is missed, and nothing judged.
    measured, noise = value, np.zeros(len(value))
    if test.measured:
        measured, noise = test.response[seen], noise_of(test).sd[seen]
    # After a step each instant tells of its own rate; where the load keeps moving, all samples tell of all rates.
    if test.kind in ("relaxation", "creep"):
        rate = 1.0 / np.maximum(time - test.start, 1e-300)
    else:
        rate = np.full(len(time), float(np.sqrt(np.prod(test.seen))))
    size = np.full(len(time), rms(measured))
    return _Compared(time, rate, value, answer.by_theta[seen], measured, noise, size)


def _at_frequencies(test: Measurement, known: Known, theta: Real) -> _Compared:
    """K' and then K'', each point a share of its |K|."""
    at = replace(test, reference=known.reference).points
    value, slopes = known.model.stiffness(theta, at), known.model.jacobian(theta, at)
    sd = SweepPart(test).sd
    return _Compared(
        np.tile(test.frequency, 2),
        np.tile(test.omega, 2),
        np.concatenate([value.real, value.imag]),
        np.concatenate([slopes.real, slopes.imag]),
        np.concatenate([test.storage, test.loss]),
        np.concatenate([sd.real, sd.imag]),
        # So that K' and K'' of a point together weigh as one relative error of K.
        np.tile(test.magnitude, 2) / np.sqrt(2.0),
    )
