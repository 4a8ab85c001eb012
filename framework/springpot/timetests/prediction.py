"""Another test of the same specimen.

What a fitted model says of it, with a band, and whether it holds.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from springpot.distributions import student
from springpot.errors import DataError
from springpot.identification.prediction import Known
from springpot.identification.space import require_columns
from springpot.measurement.measurement import Measurement
from springpot.measurement.timenoise import noise_of
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import (
    AMPLITUDE_UNITS,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    Units,
    one_modulus,
)
from springpot.rheology.model import Model
from springpot.rheology.points import Points, Real
from springpot.thresholds import INTERVAL

from .recording import predicted
from .residuals_of_tests import SweepPart, Test
from .where import TestPrediction, rms

NEAR = 2.0
"""Factor by which a time may lie beyond those that a fit saw and still be one of them."""


def predict_test(known: Known, test: Test, level: float = INTERVAL) -> TestPrediction:
    """Predict a test and judge the prediction.

    Parameters
    ----------
    known : Identification or Known
        A fit to other tests of the specimen.
    test : TimeTest or Measurement
        The test.
    level : float
        Probability of the band.

    Returns
    -------
    TestPrediction
        In the units of the fit where both are of one kind.

    Raises
    ------
    SpringpotError
        If the model needs a condition that the test lacks, or one is of a stiffness and the other
        of a modulus.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.timetests import identify, predict_test
    >>> model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.01, 100.0, 60)
    >>> theta = model.theta(k=400.0, c=60.0, alpha=0.5)
    >>> scatter = 1.0 + 0.01 * np.random.default_rng(1).normal(size=60)
    >>> relaxed, crept = scatter * model.relaxation(theta, t), scatter * model.creep(theta, t)
    >>> fit = identify(springpot.TimeTest.of_relaxation(t, relaxed, "kPa"), model)
    >>> predict_test(fit, springpot.TimeTest.of_compliance(t, crept, "kPa")).holds
    True
    """
    known = known.of_specimen
    _require_its_conditions(known.model, test)
    # The fit is brought to the test, and not the test to the fit: what is printed is in the units
    # that were measured.
    theta, covariance = _in_units_of(known, test.units)
    if isinstance(test, TimeTest):
        compared = _in_time(test, known, theta)
        kind, unit, judged = test.kind, test.response_unit, test.measured
        quantity, clock = test.words[1], "Hz"
    else:
        compared = _at_frequencies(test, known, theta)
        kind, unit, judged = "sweep", test.units.stiffness, True
        quantity, clock = "storage and loss", test.units.clock
    # Relative to the signal, so that tests in different units and of any kind are judged alike.
    share = (compared.value - compared.measured) / compared.size
    known_sd = _reach(compared.by_theta, covariance)
    wide = student(level, known.dof) * known_sd
    # Independent reasons to be off: what the parameters leave open and the noise of the test.
    known_error = np.hypot(known_sd, compared.noise) / compared.size
    # One over a time is a frequency only nearly: what lies near the ends was seen.
    asked = compared.rate, _settings(test, compared, known.units)
    inside = ~known.covered.outside(*asked, NEAR)
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
        _rms_of(share[inside]),
        unit,
        ~inside,
        known.covered,
        tuple(filter(None, [known.covered.remark(*asked, known.units, NEAR)])),
        judged,
        quantity,
        clock,
        level,
    )


def _reach(slopes: Real, covariance: Real) -> Real:
    """Standard deviation (m,) of what has the derivatives `slopes` (m, p) by the parameters."""
    variance: Real = np.einsum("mi,ij,mj->m", slopes, covariance, slopes)
    # Rounding takes a variance of nothing below zero.
    return np.sqrt(np.maximum(variance, 0.0))


def _rms_of(share: Real) -> float:
    """The root mean square; nan of nothing."""
    if not len(share):
        return float("nan")
    return rms(share)


def _require_its_conditions(model: Model, test: Test) -> None:
    """Refuse a test without a condition that the model needs."""
    if isinstance(test, Measurement):
        require_columns(model.had_by(test)[0], test)
    elif "temperature" in model.needs and test.temperature is None:
        raise DataError(
            f"{test.name}: {model.name} needs its temperature: add '?temperature=25[degC]'"
        )


def _settings(test: Test, compared: _Compared, units: Units) -> dict[str, Real]:
    """Temperature of each sample, or all conditions of each point of a sweep.

    Amplitudes are in the units of the fit.
    """
    if isinstance(test, Measurement):
        settings = {name: np.tile(column, 2) for name, column in test.conditions.items()}
        if "amplitude" in settings:
            settings["amplitude"] *= (
                AMPLITUDE_UNITS[test.units.amplitude] / AMPLITUDE_UNITS[units.amplitude]
            )
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
            f"the fit is in {own.stiffness} and the test in {units.stiffness}: a stiffness is no"
            " modulus; convert one of them by its geometry"
        )
    one_modulus([("the fit", own), ("the test", units)])
    stiffer = MODULUS_UNITS[own.stiffness] / MODULUS_UNITS[units.stiffness]
    longer = AMPLITUDE_UNITS[own.amplitude] / AMPLITUDE_UNITS[units.amplitude]
    # Time is in s everywhere: it needs no factor.
    powers = [
        (parameter.unit.stiffness, parameter.unit.amplitude) for parameter in known.model.parameters
    ]
    factors = np.array([stiffer**stiffness * longer**amplitude for stiffness, amplitude in powers])
    _require_same_model(known, factors, stiffer, longer, units)
    return known.theta * factors, known.theta_covariance * np.outer(factors, factors)


def _require_same_model(
    known: Known, factors: Real, stiffer: float, longer: float, units: Units
) -> None:
    """Check that converted parameters are the same model.

    The force of a power law has no whole power of a length.

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
            f"{known.model.name} cannot be converted from {known.units.amplitude} to"
            f" {units.amplitude}: the unit of a parameter depends on another parameter; give the"
            f" test in {known.units.amplitude}"
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
    # After a step each instant tells of its own rate; where the load keeps moving, all samples tell
    # of all rates.
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
