"""A load that is held, at one level or several, is known without the noise of its transducer."""

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.measurement.imposed import levels
from springpot.measurement.steady_start import still


def _crept(steps, count, noise_of_force, seed=1):
    """Time, strain and stress of a Kelvin specimen of 1 kPa under equal steps of its stress."""
    draw = np.random.default_rng(seed).normal(size=(2, count))
    time = np.linspace(0.0, 10.0, count)
    since = time[:, None] - np.arange(steps) * 10.0 / steps
    strain = np.sum((1.0 - 0.7 * np.exp(-np.maximum(since, 0.0))) * (since >= 0.0), axis=1)
    stress = np.sum(since >= 0.0, axis=1) * (1.0 + 0.0 * time)
    return time, strain * (1.0 + 0.005 * draw[0]), stress + noise_of_force * draw[1]


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.02], ids="noise {}".format)
@pytest.mark.parametrize("steps", [1, 4], ids="{} steps".format)
def test_what_is_held_was_imposed_and_stepped_to(steps, noise):
    time, strain, stress = _crept(steps, 400, noise)
    test = TimeTest.of_history(time, strain, stress, "-", "Pa")
    assert test.control == "force"
    assert len(np.unique(test.loading.value)) == steps + 1
    assert test.loading.value[[0, 1, -1]] == pytest.approx([0.0, 1.0, steps], abs=0.01)
    assert ("white noise" in test.provenance.get("motion", "")) == (noise > 0.0)


def test_a_ramp_of_few_samples_to_what_is_held_is_a_line_too():
    t, noise = np.arange(200.0), 0.002 * np.random.default_rng(3).normal(size=(2, 200))
    ramp = np.minimum(t / 8.5, 1.0)
    moved, _ = still(t, ramp + noise[0], np.exp(-t / 50.0) + noise[1])
    assert np.abs(np.diff(moved[:9], 2)).max() < 1e-12 < np.abs(np.diff(moved[7:11], 2)).max()
    assert moved == pytest.approx(ramp, abs=0.004)
    # What is bent more than the noise stays.
    bent = ramp + 0.05 * np.sin(np.pi * ramp)
    assert np.ptp(still(t, bent + noise[0], np.exp(-t / 50.0) + noise[1])[0][:8] - bent[:8]) > 0.0


def test_noise_that_the_specimen_felt_stays():
    time, strain, stress = _crept(1, 400, 0.02)
    felt, _ = still(time, stress, strain + 0.5 * (stress - 1.0))
    assert felt is stress


def test_a_ramp_in_coarse_digits_is_at_no_levels():
    assert levels(np.round(np.linspace(0.0, 1.0, 2000), 2))[1] == []


def test_a_load_that_drifts_beyond_its_noise_is_held_at_no_level():
    time, strain, stress = _crept(1, 400, 0.001)
    drifting = stress + np.linspace(0.0, 0.01, 400)
    assert still(time, drifting, strain)[0] is drifting
