"""Eleven points with little noise, of which nothing is missing.

No test is alarmed, so nothing is called missing.
"""

import re

import numpy as np
import pytest

import springpot
from springpot.thresholds import VERDICT

RIDDLE = re.compile(r"takes it to (0\.\d+|1(\.[01]\d*)?) x, and something is missing beside it")


def sweep(rng, count=11, bend=0.0):
    """A fractional Zener element, 0.05 % noise; with a `bend` its gain grows along the sweep."""
    omega = 2.0 * np.pi * np.geomspace(0.1, 50.0, count)
    power = (1j * omega * 0.03) ** 0.62
    gain = 1.0 + bend * np.linspace(0.0, 1.0, count) ** 2
    real, imaginary = 5e-4 * rng.normal(size=(2, count))
    stiffness = gain * (120.0 + 440.0 * power / (1.0 + power)) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(omega, stiffness, units=springpot.Units("kN/m", "mm"))


@pytest.fixture(scope="module", params=[0, 3, 5, 12, 41, 53], ids="seed {}".format)
def whole(request):
    return springpot.diagnose(sweep(np.random.default_rng(request.param)))


@pytest.mark.soak_cases("seed 41", "seed 53", "seed 0", "seed 12", "seed 3", "seed 5")
def test_without_an_alarm_nothing_is_called_missing_or_unexplained(whole):
    assert min(whole.evidence["p_library"], whole.evidence["p_structure"]) > VERDICT.structure_alarm
    assert whole.verdict == "adequate"


@pytest.mark.soak_cases("seed 0", "seed 12", "seed 3", "seed 5", "seed 53")
def test_nor_is_something_unknown_likelier_than_nothing(whole):
    """It was called likelier than 0.999.

    Of 22 numbers the spectrum leaves few by which to judge another shape.
    """
    assert whole.evidence["unknown"] < 0.5


@pytest.mark.soak
def test_what_an_effect_takes_to_the_noise_has_nothing_missing_beside_it():
    found = springpot.diagnose(sweep(np.random.default_rng(8), 12, bend=0.003))
    assert found.verdict == "unexplained"
    assert not RIDDLE.search(found.says)
