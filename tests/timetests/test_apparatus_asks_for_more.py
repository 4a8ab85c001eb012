"""A fault of the apparatus asks for more evidence than what specimens do."""

import numpy as np
import pytest

import springpot
from springpot.registry import plugins
from springpot.thresholds import EVIDENCE
from springpot.timetests.diagnosis import diagnose
from springpot.timetests.hypotheses import prior_weight


@pytest.mark.parametrize("name", ["time-delay", "force-drift", "force-clipping", "thermal-growth"])
def test_what_lags_drifts_or_saturates_weighs_less(name):
    effect = plugins().effect(name)
    assert prior_weight(effect) == EVIDENCE.apparatus * effect.prior


@pytest.mark.parametrize("name", ["series-dashpot", "yielding", "slack", "finite-ramp"])
def test_what_specimens_do_weighs_what_it_is(name):
    effect = plugins().effect(name)
    assert prior_weight(effect) == effect.prior


def test_flow_is_not_drift():
    """A straight line in creep may be either; nobody services an instrument before he has asked."""
    t = np.geomspace(0.1, 100.0, 60)
    kelvin = springpot.parse_model("kelvin")
    exact = kelvin.creep(kelvin.vector({"k": 2.0, "c": 4.0}), t) + t / 300.0
    noise = 0.0005 * np.random.default_rng(5).normal(size=60)
    test = springpot.TimeTest.of_compliance(t, exact + noise, "kPa")
    effects = [plugins().effect(name) for name in ("displacement-drift", "series-dashpot")]
    found = diagnose(test, kelvin, effects)
    assert found.leading == ("series-dashpot", "displacement-drift")
    assert [row.verdict for row in found.candidates] == ["cannot-tell", "cannot-tell"]
    assert found.onward == "helps, but is no proof"


def test_in_units_of_what_is_missed_a_little_less_is_no_proof():
    """Over the noise of a digital record 27 % in place of 28 % was evidence of a thousand."""
    t = np.linspace(0.0, 6.0, 241)
    x = np.sin(2.0 * np.pi * t) + 0.4 * np.sin(5.1 * t)
    model = springpot.parse_model("kelvin")
    force = model.respond(model.vector({"k": 2.0, "c": 0.1}), t, x) + 4.0 * np.sign(np.cos(3.3 * t))
    noise = 1e-3 * np.random.default_rng(2).normal(size=len(t))
    test = springpot.TimeTest.of_history(t, x, force + noise, "mm", "N")
    effects = [plugins().effect(name) for name in ("force-drift", "time-delay", "cubic-stiffness")]
    found = diagnose(test, model, effects)
    assert found.error.relative_rms > 0.3
    assert all(row.delta_bic < 10.0 for row in found.candidates)
    assert found.on_shelf("helps") == () or found.leading == ()
