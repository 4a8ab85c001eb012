"""Tests in time, small ones: fitted, diagnosed, foretold, as numbers and as words."""

from functools import cache

import numpy as np
import pytest

import springpot
from springpot.api import library
from springpot.measurement import Measurement, TimeTest, Units
from springpot.registry import parse_model
from springpot.timetests.diagnosis import examine

MODEL = parse_model("kelvin")
MAXWELL = parse_model("fractional-maxwell")
THETA, SOFT = MODEL.theta(k=40.0, c=6.0), MAXWELL.theta(k=400.0, c=60.0, alpha=0.5)
STEPS, CLOCK = np.geomspace(0.02, 50.0, 30), np.linspace(0.0, 8.0, 120)
WAY = np.sin(2.0 * CLOCK) * np.minimum(CLOCK / 3.0, 1.0)
OMEGA = np.geomspace(0.5, 30.0, 10)


def noise(count, seed):
    return np.random.default_rng(seed).normal(size=count)


def relaxed(seed=1, drift=0.0):
    exact = MAXWELL.relaxation(SOFT, STEPS)
    return TimeTest.of_relaxation(
        STEPS, exact * (1.0 + 0.01 * noise(30, seed)) + drift * STEPS, "kPa", name="relaxed"
    )


def crept(by=1.0):
    exact = by * MAXWELL.creep(SOFT, STEPS) * (1.0 + 0.01 * noise(30, 2))
    return TimeTest.of_compliance(STEPS, exact, "kPa", name="crept")


def shaken(force=0.0, mass=0.0):
    grown = MODEL + "friction" + "inertia"
    exact = grown.respond(np.append(THETA, [force, mass]), CLOCK, WAY)
    return TimeTest.of_history(CLOCK, WAY, exact + 0.5 * noise(120, 3), "mm", "N", name="shaken")


def swept():
    k = MAXWELL.stiffness(SOFT, OMEGA) * (1.0 + 0.01 * (noise(10, 4) + 1j * noise(10, 5)))
    return Measurement(OMEGA, k, units=Units("kPa", "-"), name="swept")


FITS = {
    "relaxed": (lambda: relaxed(), MAXWELL),
    "crept": (lambda: crept(), MAXWELL),
    "shaken": (lambda: shaken(), MODEL),
    "both": (lambda: [relaxed(), crept()], MAXWELL),
    "swept too": (lambda: [relaxed(), swept()], MAXWELL),
    "too simple": (lambda: relaxed(), "maxwell"),
    "of material": (lambda: relaxed(), "material"),
    "both of material": (lambda: [relaxed(), crept()], "material"),
}


def without_time(answer):
    return {name: part for name, part in answer.to_dict().items() if name != "seconds"}


@cache
def fitted(case):
    """A fit, which other tests look into as well."""
    data, model = FITS[case]
    return springpot.identify(data(), model)


@pytest.mark.parametrize("case", list(FITS))
def test_fit_in_time(case, stays):
    found = fitted(case)
    foretold = springpot.predict(found, crept(1.05) if case != "shaken" else shaken(3.0))
    stays({"fit": without_time(found), "foretold": without_time(foretold)}, within=1e-3)


DIAGNOSES = {
    "drift": (lambda: relaxed(drift=1.5), MAXWELL, ["force-drift", "finite-ramp"]),
    "adequate": (lambda: crept(), MAXWELL, ["force-drift", "series-spring"]),
    "friction": (lambda: shaken(force=9.0), MODEL, ["friction", "inertia", "force-offset"]),
    "mass": (lambda: shaken(mass=4.0), MODEL, ["friction", "inertia", "force-offset"]),
    "with a sweep": (lambda: [relaxed(drift=1.5), swept()], MAXWELL, ["force-drift", "time-delay"]),
}


@cache
def examined(case):
    """All that a diagnosis finds, which other tests look into as well."""
    data, model, names = DIAGNOSES[case]
    return examine(data(), model, library(only=names))


@pytest.mark.parametrize("case", list(DIAGNOSES))
def test_diagnosis_in_time(case, stays):
    stays(examined(case).diagnosis.to_dict(), within=1e-3)


def test_comparison_in_time(stays):
    found = springpot.compare(relaxed(), ["fractional-maxwell", "maxwell", "maxwell-2"])
    stays(found.to_dict(), within=1e-3)
