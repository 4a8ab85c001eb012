"""A free spectrum under a shift of 55 decades.

The same answer, whether the shift is sought or given.
"""

import numpy as np
import pytest

import springpot
from wide_sweeps import C1, C2, NOISE, spectrum

MODEL = "material + wlf-shift"
SHIFT = {"wlf-shift.C1": C1, "wlf-shift.C2": C2}


@pytest.fixture(scope="module")
def data():
    return spectrum(np.random.default_rng(1))


def test_the_true_shift_held_leaves_the_noise(data):
    held = springpot.identify(data, MODEL, fix=SHIFT)
    assert 0.7 * NOISE < held.relative_rms < 1.1 * NOISE


@pytest.mark.soak
def test_the_shift_is_found_and_leaves_no_more_than_the_true_one(data):
    free = springpot.identify(data, MODEL)
    found = dict(zip(free.model.names, free.theta, strict=True))
    assert found["wlf-shift.C1"] == pytest.approx(C1, rel=0.03)
    assert found["wlf-shift.C2"] == pytest.approx(C2, rel=0.03)
    assert free.relative_rms < 1.001 * springpot.identify(data, MODEL, fix=SHIFT).relative_rms
