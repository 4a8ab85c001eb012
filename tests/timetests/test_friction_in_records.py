"""Dry friction in a record, whose sign nobody knows at the samples where the motion turns."""

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose, identify

T = np.arange(600) / 100.0


def record(hertz, sign):
    """A Kelvin damper with 6 N of friction; `sign` is that of the speed, as somebody knew it."""
    w = 2.0 * np.pi * hertz
    x, v = 0.005 * np.sin(w * T), 0.005 * w * np.cos(w * T)
    noise = 0.4 * np.random.default_rng(8).normal(size=len(T))
    force = 2e4 * x + 800.0 * v + 6.0 * sign(x, v) + noise
    return TimeTest.of_history(T, x, force, "m", "N", control="displacement")


SIGNS = {
    "of the exact speed": lambda x, v: np.sign(v),
    "of differences": lambda x, v: np.sign(np.gradient(x, T)),
    "rounded off": lambda x, v: np.tanh(v / 1e-3),
}


@pytest.mark.soak_cases("of differences", "of the exact speed", "rounded off")
@pytest.mark.parametrize("sign", SIGNS)
def test_friction_is_named_first_whoever_knew_the_sign(sign):
    """At 1.25 Hz each turn falls upon a sample."""
    test = record(1.25, SIGNS[sign])
    names = ("friction", "power-law-damper", "inertia", "elasto-sliding")
    library = [plugins().effect(name) for name in names]
    found = diagnose(test, "kelvin", library)
    assert (found.verdict, found.leading[0]) == ("effect-missing", "friction")
    # As stiff a slider as this is friction by another name.
    assert "elasto-sliding" not in found.leading
    assert found.best.over_floor == pytest.approx(1.0, abs=0.1)


def test_its_size_is_that_of_the_truth_and_a_turn_leaves_nothing():
    fit = identify(record(1.25, SIGNS["of the exact speed"]), parse_model("kelvin + friction"))
    assert fit.theta == pytest.approx([2e4, 800.0, 6.0], rel=0.01)
    [test] = fit.tests
    assert test.over_floor == pytest.approx(1.0, abs=0.1)
