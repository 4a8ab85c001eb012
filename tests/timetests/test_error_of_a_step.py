"""The error of the answer to a step, whose noise goes with a signal of many decades."""

from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.measurement.timetest import TimeTest
from springpot.misfit.residuals_of_tests import InTimePart

MODEL = springpot.parse_model("fractional-maxwell")
VIBRATING = Path(__file__).parents[3] / "shared/unseen/C0224_NVT_450K_1atm.gt"
T = np.geomspace(1e-3, 1e4, 120)
TRUTH = MODEL.theta(k=4e6, c=3e4, alpha=0.6)


@pytest.fixture(scope="module")
def relaxed():
    noise = 1.0 + 0.02 * np.random.default_rng(3).normal(size=len(T))
    return TimeTest.of_relaxation(T, MODEL.relaxation(TRUTH, T) * noise, "Pa")


def test_noise_that_goes_with_the_signal_makes_it_that_of_each_sample(relaxed):
    fit = springpot.identify(relaxed, MODEL)
    each = MODEL.relaxation(fit.theta, T) / relaxed.response - 1.0
    assert fit.relative_rms == pytest.approx(np.sqrt(np.mean(each**2)), rel=0.03)
    # The largest samples alone would tell of the first decade only.
    assert fit.noise_floor == pytest.approx(0.02, rel=0.15)


def test_constant_noise_makes_it_that_of_all_over_all(relaxed):
    part = InTimePart(relaxed, noise=np.full(len(T), 10.0))
    missed = part.sd * part.with_scale(1.0).residual(MODEL, TRUTH, 293.15).value
    error = np.sqrt(np.mean((missed / part.size) ** 2))
    assert error == pytest.approx(np.sqrt(np.mean(missed**2) / np.mean(relaxed.response**2)))


@pytest.mark.skipif(not VIBRATING.exists(), reason="the shared data are not here")
def test_fit_and_diagnosis_tell_the_same_error():
    """Of molecules that vibrate before they relax: what a model leaves there is no scatter."""
    test = springpot.registry.open_tests(VIBRATING)[0]
    fit = springpot.identify(test, "prony-2")
    told = springpot.diagnose(test, "prony-2", only=["parallel-springpot"])
    assert told.error.relative_rms == pytest.approx(fit.relative_rms, rel=1e-9)


def test_a_test_that_is_only_planned_has_no_size():
    planned = TimeTest.of_relaxation(T, np.zeros(len(T)), "Pa")
    assert not InTimePart(planned).size.any()


def test_a_spike_before_the_motion_makes_no_error_smaller():
    """As of a load cell that is switched on: the first sample is fifty times all others."""
    time = 0.1 * np.arange(60)
    pulled = 2.0 * time + np.random.default_rng(1).normal(0.0, 0.1, len(time))
    sizes = []
    for first in (0.0, 600.0):
        force = np.r_[first, pulled[1:]]
        test = TimeTest.of_history(time, 0.5 * time, force, "mm", "N", control="displacement")
        part = InTimePart(test, noise=np.full(len(time), 0.1))
        sizes.append(part.size[1:])
    np.testing.assert_allclose(sizes[1], sizes[0], rtol=0.01)
