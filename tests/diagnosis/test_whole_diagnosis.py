"""Diagnoses of small sweeps, whole: what is weighed, named, refitted and said."""

from functools import cache

import numpy as np
import pytest

import springpot
from springpot.api import library
from springpot.diagnosis.examination import examine
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model

MODEL = parse_model("kelvin")
THETA = MODEL.theta(k=400.0, c=6.0)
OMEGA = 2.0 * np.pi * np.geomspace(0.2, 20.0, 12)
EXACT = MODEL.stiffness(THETA, OMEGA)
FEW = ("inertia", "time-delay", "friction", "series-spring", "parallel-springpot")


def made(*parts, level=0.005, **more):
    k, n = np.concatenate(parts), len(parts)
    scatter = np.random.default_rng(len(k)).normal(size=(2, len(k)))
    values = k * (1.0 + level * (scatter[0] + 1j * scatter[1]))
    return Measurement(np.tile(OMEGA, n), values, units=Units("kN/m", "mm"), name="made", **more)


def amplitudes():
    x = np.repeat([0.1, 0.4, 1.6], 12)
    return made(*(EXACT + 40j / each for each in (0.1, 0.4, 1.6)), conditions={"amplitude": x})


def heated():
    celsius = np.repeat([10.0, 30.0], 12)
    cold = MODEL.stiffness(THETA, 3.0 * OMEGA)
    return made(cold, EXACT, conditions={"temperature": celsius})


def again():
    late = 0.97 * EXACT - 0.01 * OMEGA**2
    return made(EXACT - 0.01 * OMEGA**2, late, level=0.002, repeat=np.repeat([1, 2], 12))


CASES = {
    "adequate": (lambda: made(EXACT), FEW),
    "inertia": (lambda: made(EXACT - 0.02 * OMEGA**2), FEW),
    "delay": (lambda: made(EXACT * np.exp(-3e-3j * OMEGA)), FEW),
    "friction": (amplitudes, FEW),
    "temperature": (heated, ("arrhenius-shift", "vertical-shift", "inertia")),
    "repeats": (again, FEW),
    "given": (lambda: made(EXACT - 0.02 * OMEGA**2, sd=0.005 * np.abs(EXACT) * (1 + 1j)), FEW),
    "nothing known": (lambda: made(EXACT * (1 + 0.1 / (1 + (OMEGA - 30) ** 2))), FEW[:2]),
}


@cache
def examined(case):
    """All that a diagnosis finds, which other tests look into as well."""
    data, names = CASES[case]
    data = data()
    return examine(data, MODEL, library(only=names, data=data), np.random.default_rng(0))


@pytest.mark.parametrize("case", list(CASES))
def test_diagnosis_of(case, stays):
    stays(examined(case).diagnosis.to_dict(), within=1e-3)


@pytest.mark.soak
def test_ladder_of_two(stays):
    both = made((EXACT - 0.02 * OMEGA**2) * np.exp(-3e-3j * OMEGA))
    found = springpot.discover(both, MODEL, only=FEW[:3])
    stays(found.to_dict(), within=1e-3)
