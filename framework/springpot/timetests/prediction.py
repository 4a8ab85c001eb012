"""Another test of the same specimen.

What a fitted model says of it, with a band, and whether it holds.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import student
from springpot.errors import DataError
from springpot.identification.prediction import Known
from springpot.identification.uncertainty import spread_of
from springpot.measurement.opening import Test
from springpot.measurement.units import (
    AMPLITUDE_UNITS,
    Units,
    one_modulus,
)
from springpot.rheology.points import Points, Real
from springpot.thresholds import INTERVAL

from ..numerics import rms
from .residuals_of_tests import TestPart, part_of
from .specimen import require_its_conditions
from .where import TestPrediction

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
    require_its_conditions(known.model, test)
    # The fit is brought to the test, and not the test to the fit: what is printed is in the units
    # that were measured.
    theta, factors = _in_units_of(known, test.units)
    part = part_of(test)
    rows = np.flatnonzero(part.sure)
    answer = part.answer(known.model, theta, known.reference, rows)
    value, measured, noise, size = answer.value, part.measured[rows], part.sd[rows], part.size[rows]
    # A test that was not measured is its own prediction: nothing is missed, and nothing judged.
    if not part.judged:
        measured, noise, size = value, np.zeros(len(rows)), np.full(len(rows), rms(value))
    # Relative to the signal, so that tests in different units and of any kind are judged alike.
    share, counted = (value - measured) / size, part.counted[rows]
    by_theta = answer.by_theta * factors
    down, up = known.ways(spread_of(by_theta, known.theta_covariance), by_theta)
    times, known_sd = student(level, known.dof), np.maximum(down, up)
    # Independent reasons to be off: what the parameters leave open and the noise of the test.
    known_error = np.hypot(known_sd, noise) / size
    # One over a time is a frequency only nearly: what lies near the ends was seen.
    asked = part.rate[rows], _settings(part, rows, known.units)
    inside = ~known.covered.outside(*asked, NEAR)
    return TestPrediction(
        model=known.model.name,
        test=test.name,
        kind=test.kind,
        at=part.at[rows],
        value=value,
        low=value - times * down,
        high=value + times * up,
        measured=measured,
        error=rms(share[counted]),
        expected=float(np.hypot(rms(known_error[counted]), known.misfit)),
        # "Too much" is larger in size, whatever the sign of the response.
        bias=float(np.mean((share * np.sign(measured))[counted])),
        inside=float(np.mean(inside)),
        error_inside=rms(share[inside & counted]) if inside.any() else float("nan"),
        unit=part.unit,
        outside=~inside,
        covered=known.covered,
        notes=tuple(filter(None, [known.covered.remark(*asked, known.units, NEAR)])),
        judged=part.judged,
        quantity=part.quantity,
        clock=test.units.clock,
        level=level,
    )


def _settings(part: TestPart, rows: NDArray[np.intp], units: Units) -> dict[str, Real]:
    """All conditions of some numbers of a test, amplitudes in the units of the fit."""
    settings = {name: column[rows] for name, column in part.conditions.items()}
    if "amplitude" in settings:
        longer = AMPLITUDE_UNITS[part.test.units.amplitude] / AMPLITUDE_UNITS[units.amplitude]
        settings["amplitude"] = settings["amplitude"] * longer
    return settings


def _in_units_of(known: Known, units: Units) -> tuple[Real, Real]:
    """Parameters in the units of a test, and by what factors."""
    own = known.units
    stiffer = own.factor_to(units, "the fit", "the test")
    one_modulus([("the fit", own), ("the test", units)])
    longer = AMPLITUDE_UNITS[own.amplitude] / AMPLITUDE_UNITS[units.amplitude]
    # Time is in s everywhere: it needs no factor.
    powers = [
        (parameter.unit.stiffness, parameter.unit.amplitude) for parameter in known.model.parameters
    ]
    factors = np.array([stiffer**stiffness * longer**amplitude for stiffness, amplitude in powers])
    _require_same_model(known, factors, stiffer, longer, units)
    return known.theta * factors, factors


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
