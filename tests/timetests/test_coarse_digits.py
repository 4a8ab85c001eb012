"""A force channel of coarse digits: rounding that repeats itself is no effect."""

import numpy as np
import pytest

from springpot import parse_model
from springpot.measurement import Loading, TimeTest
from springpot.measurement.instrument import digit_of, roundings
from springpot.registry import plugins
from springpot.timetests import diagnose

TIME = 0.005 * np.arange(800)
STROKE = 2.0 * np.sin(3.0 * np.pi * TIME)
EFFECTS = ("friction", "time-delay")


def judged(digit, friction, seed=0):
    """A Zener element under a sine, its force written to a digit."""
    model = parse_model("zener + friction")
    theta = model.theta(k1=0.1, k2=0.1, c=0.01, **{"friction.F": friction})
    loading = Loading(TIME, STROKE)
    exact = model.respond(theta, TIME, STROKE)
    noise = 0.02 * digit * np.random.default_rng(seed).normal(size=len(TIME))
    force = digit * np.round((exact + noise) / digit)
    test = TimeTest(TIME, force, loading, control="displacement", name="record")
    effects = [plugins().effect(name) for name in EFFECTS]
    return diagnose([test], parse_model("zener"), effects)


@pytest.mark.soak
@pytest.mark.parametrize("digit", [0.02, 0.05])
def test_no_effect_is_found_in_rounding(digit):
    found = judged(digit, 1e-9)
    assert found.verdict == "adequate"
    assert found.leading == ()


@pytest.mark.soak
def test_friction_larger_than_a_digit_is_found_all_the_same():
    found = judged(0.05, 0.06)
    assert found.verdict == "effect-missing"
    assert found.leading[0] == "friction"


def test_a_digit_is_told_of_few_values_alone():
    exact = np.sin(TIME)
    written = np.round(exact / 0.03) * 0.03
    assert digit_of(written) == pytest.approx(0.03)
    assert digit_of(exact) == 0.0
    assert digit_of(np.sign(exact)) == pytest.approx(1.0)
    assert len(roundings(exact, exact)) == 0
    assert np.abs(roundings(exact, written)).max() <= 0.0150001
