"""What profiles say of a parameter: identifiable, practically not, or not at all."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot

OMEGA = np.geomspace(1.0, 100.0, 15)
YES, PRACTICALLY, NEVER = "identifiable", "practically not", "not at all"


@pytest.fixture(scope="module")
def damper() -> springpot.Measurement:
    """A spring beside a dashpot, with 1 % noise."""
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, 15))
    return springpot.Measurement(OMEGA, (100.0 + 2j * OMEGA) * (1.0 + noise[0] + 1j * noise[1]))


@pytest.mark.parametrize(
    ("model", "told"),
    [
        ("kelvin", {"k": YES, "c": YES}),
        # Two springs beside one another: their sum alone is known.
        ("kelvin + parallel-spring", {"k": NEVER, "c": YES, "parallel-spring.k": NEVER}),
        # A spring in series with the dashpot is stiff, how stiff is open.
        ("zener", {"k1": YES, "k2": PRACTICALLY, "c": YES}),
        # Of a mode faster than the data its viscosity is known, k1 tau1; one that holds longer is
        # a spring.
        ("maxwell-2", {"k1": NEVER, "tau1": NEVER, "k2": YES, "tau2": PRACTICALLY}),
    ],
)
def test_a_parameter_is_told_as_far_as_its_profile_rises(damper, model, told):
    assert springpot.identify(damper, model, intervals="profile").identifiable == told


def test_an_order_at_its_end_is_told(damper):
    found = springpot.identify(damper, "fractional-kelvin", intervals="profile")
    assert found["alpha"].high == 1.0
    assert set(found.identifiable.values()) == {YES}


def test_it_stands_in_text_and_json_and_opens_again(damper, tmp_path):
    found = springpot.identify(damper, "zener", intervals="profile")
    assert "profile     identifiable: k1, c; practically not: k2" in str(found)
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(found.to_dict()))
    assert springpot.load(path).identifiable == found.identifiable
    assert "identifiable" not in springpot.identify(damper, "kelvin").to_dict()


@pytest.mark.soak
def test_tests_in_time_are_told_too():
    time = np.geomspace(0.01, 10.0, 40)
    noise = 1.0 + 0.01 * np.random.default_rng(2).standard_normal(40)
    stress = (3.0 + 5.0 * np.exp(-time)) * noise
    test = springpot.TimeTest.of_relaxation(time, stress)
    for model, told in (("zener", YES), ("zener + parallel-spring", NEVER)):
        found = springpot.identify(test, model, intervals="profile").identifiable
        assert found["k1"] == told
        assert found["c"] == YES
