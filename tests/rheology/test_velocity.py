"""The speed that a dashpot feels, from the samples of a motion."""

import numpy as np
import pytest

from springpot.rheology.motion import velocity

T = 0.01 * np.arange(200)


@pytest.mark.parametrize("t", [T, np.cumsum(0.01 + 0.003 * np.cos(np.arange(200)))])
def test_a_sine_of_25_samples_a_cycle_has_its_speed_within_a_thousandth(t):
    omega = 2.0 * np.pi / 0.25
    missed = velocity(t, np.sin(omega * t)) / omega - np.cos(omega * t)
    assert np.abs(missed[1:-1]).max() < 3e-3
    assert np.sqrt(np.mean(missed[1:-1] ** 2)) < 1e-3
    assert np.abs(missed).max() < 0.04


@pytest.mark.parametrize("turns", [0.9032, 0.905, 0.9078])
def test_where_a_motion_turns_between_samples_each_has_the_speed_of_its_side(turns):
    moved = velocity(T, np.abs(T - turns))
    assert moved == pytest.approx(np.sign(T - turns), abs=1e-9)


def test_a_corner_at_a_sample_and_noise_are_no_corners_between_samples(rng):
    assert velocity(T, np.abs(T - T[90]))[90] == pytest.approx(0.0, abs=1e-9)
    noise = rng.normal(size=20_000)
    t = np.arange(20_000.0)
    # A central difference of white noise has half its variance; one of five samples, 0.90.
    assert 0.5 < np.var(velocity(t, noise)) < 0.9


def test_of_a_few_samples_there_are_plain_differences():
    assert velocity(T[:3], T[:3] ** 2) == pytest.approx(np.gradient(T[:3] ** 2, T[:3]))
