"""From glass to rubber without a model: what is missing is the shift, and nothing beside it.

From -27.5 degC: below it these constants shift by more than any law of a material does.
"""

import numpy as np
import pytest

import springpot
from springpot.diagnosis import diagnose
from wide_sweeps import C1, C2, NOISE, spectrum

EFFECTS = (
    "wlf-shift",
    "arrhenius-shift",
    "vertical-shift",
    "time-delay",
    "inertia",
    "specimen-inertia-fixed",
)


@pytest.fixture(scope="module")
def found():
    effects = [springpot.plugins().effect(name) for name in EFFECTS]
    data = spectrum(np.random.default_rng(1), force_held=True)
    data = data.subset(data.conditions["temperature"] > -30.0)
    return diagnose(data, springpot.parse_model("material"), effects, np.random.default_rng(0))


@pytest.mark.soak
def test_the_shift_alone_is_named(found):
    assert found.verdict == "effect-missing"
    assert found.leading == ("wlf-shift",)
    assert "beside it" not in found.says
    assert [row.effect for row in found.candidates if row.verdict == "missing"] == ["wlf-shift"]


@pytest.mark.soak
def test_its_constants_are_the_true_ones_and_take_the_error_to_the_noise(found):
    shift = found.best
    assert shift.parameters["C1"].value == pytest.approx(C1, rel=0.05)
    assert shift.parameters["C2"].value == pytest.approx(C2, rel=0.05)
    assert shift.error_after < 1.1 * NOISE


@pytest.mark.soak
def test_its_floor_is_the_noise(found):
    assert NOISE / 1.5 < found.error.noise_floor < 1.7 * NOISE
