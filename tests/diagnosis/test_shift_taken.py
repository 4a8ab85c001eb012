"""Sweeps at temperatures too far apart to overlap.

The shift is taken all the same, though something is left.
"""

import numpy as np
import pytest

import springpot

TEMPERATURES = np.repeat([-30.0, -12.0, 6.0, 24.0, 45.0], 11)
OMEGA = np.tile(np.geomspace(0.3, 30.0, 11), 5)


def foam(rng):
    """A Huet-Sayegh material that follows WLF, with its own gain and phase at each temperature."""
    reduced = OMEGA * 10.0 ** (-35.0 * (TEMPERATURES + 10.0) / (130.0 + TEMPERATURES + 10.0))
    x = 30j * reduced
    stiffness = 0.3 + 90.0 / (1.0 + 1.5 * x**-0.32 + 0.2 * x**-0.08)
    phase, gain = 0.01 * np.repeat(rng.normal(size=(2, 5)), 11, axis=1)
    real, imaginary = 0.0008 * rng.normal(size=(2, len(OMEGA)))
    stiffness = stiffness * np.exp(1j * phase) * (1.0 + gain) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(
        OMEGA,
        stiffness,
        conditions={"temperature": TEMPERATURES},
        units=springpot.Units("MPa", "-"),
    )


@pytest.fixture(scope="module")
def ladder():
    return springpot.discover(foam(np.random.default_rng(3)))


@pytest.mark.soak
def test_what_takes_nearly_all_of_the_misfit_stays(ladder):
    assert ladder.steps[1].accepted in ("wlf-shift", "arrhenius-shift")
    assert ladder.steps[-1].relative_rms < 0.02 < 0.5 < ladder.steps[0].relative_rms


@pytest.mark.soak
def test_the_first_step_is_the_one_that_the_headline_names(ladder):
    assert ladder.steps[1].accepted == ladder.steps[0].case.diagnosis.leading[0]


@pytest.mark.soak
def test_one_of_two_laws_that_cannot_be_told_apart_is_for_a_user_to_choose():
    diagnosis = springpot.diagnose(foam(np.random.default_rng(4)))
    assert set(diagnosis.leading) == {"wlf-shift", "arrhenius-shift"}
    assert "takes it to" in diagnosis.says
