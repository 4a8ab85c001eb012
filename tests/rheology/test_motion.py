"""A motion between its samples: smooth, with corners, and of noise."""

import numpy as np
import pytest

from springpot import TimeTest
from springpot.measurement import Loading
from springpot.rheology import Model, dashpot, parallel, series, spring
from springpot.rheology.motion import Between, _smooth
from springpot.rheology.terms import driven
from springpot.timetests import recorded

T = np.linspace(0.0, 6.0, 301)
FINE = np.linspace(0.0, 6.0, 300 * 40 + 1)
JEFFREYS = Model("jeffreys", parallel(dashpot("c1"), series(spring("k"), dashpot("c2"))))


def triangle(t):
    return 4.0 * np.abs((0.7 * t + 0.13) % 1.0 - 0.5)


def wave(t):
    return np.sin(6.0 * t) ** 2 * np.sin(4.0 * t)


def force(t, x):
    test = TimeTest.of_history(t, x, 0.0 * t, "mm", "N", control="displacement")
    return recorded(JEFFREYS, np.array([0.2, 1.0, 0.03]), test).value


@pytest.mark.parametrize("moved", [wave, triangle])
def test_the_force_is_that_of_a_record_of_forty_times_as_many_samples(moved):
    unsure = np.isin(T, Loading(T, moved(T), sampled=True).unsure(judged=False))
    assert np.count_nonzero(unsure) <= 10
    exact = force(FINE, moved(FINE))[::40]
    missed = np.abs(force(T, moved(T)) - exact)[~unsure]
    assert missed[2:-2].max() < 2e-3 * np.abs(exact).max()


def test_a_corner_in_the_last_step_but_one_is_seen_and_the_samples_beside_it_are_not_counted():
    x = np.abs(T - T[-3] - 0.3 * T[1])
    motion = Between.of(T, x)
    assert motion.unsure == pytest.approx([T[-3]])
    assert len(motion.time) == len(T) + 1
    assert motion.value.min() == pytest.approx(0.0, abs=1e-9)
    assert Between.of(T, np.abs(T - T[1])).unsure == pytest.approx(T[:2])


def test_a_motion_turns_where_it_went_one_way_and_goes_the_other_and_noise_does_not(rng):
    t = np.linspace(0.0, 12.0, 1200, endpoint=False)
    x = np.sin(2.5 * np.pi * t)
    turns = 0.2 + 0.4 * np.arange(30)
    assert Between.of(t, x).turning == pytest.approx(turns)
    assert Between.of(t, x + 1e-4 * rng.normal(size=1200)).turning == pytest.approx(turns, abs=0.02)
    assert len(Between.of(t, rng.normal(size=1200)).turning) < 30
    # The last sample, when the motion has just turned.
    assert Between.of(t[:22], x[:22]).turning == pytest.approx([0.2])
    assert Between.of(t[:21], x[:21] + 1e-4 * t[:21]).turning.size == 0
    falling = np.cos(2.0 * np.pi * (t[:14] - 0.128))
    assert Between.of(t[:14], falling).turning == pytest.approx([0.13])


def test_noise_steps_and_polylines_stay_straight(rng):
    for x in (rng.normal(size=301), np.where(T > 3.0, 1.0, 0.0), np.round(wave(T), 1)):
        motion = Between.of(T, x)
        straight = np.diff(motion.value) / np.diff(motion.time)
        bent = np.abs(motion.leaving - straight) > 1e-9
        assert np.mean(bent) < 0.1
    assert Between.of(T[:4], T[:4] ** 2).changes[:, 1:] == pytest.approx(0.0, abs=1e-12)


def test_new_knots_leave_the_course_as_it_is():
    motion = Between.of(T, wave(T))
    finer = motion.at(T[:-1] + 0.3 * T[1])
    assert finer.value[np.isin(finer.time, T)] == pytest.approx(motion.value)
    again = finer.at(T[:-1] + 0.6 * T[1])
    assert np.abs(again.value - wave(again.time))[9:-9].max() < 1e-4
    assert np.abs(finer.impulse[np.isin(finer.time, T)] - motion.impulse).max() < 1e-12
    beyond = motion.at(np.array([7.0]))
    assert (beyond.value[-1], beyond.speed[-1]) == (pytest.approx(wave(T)[-1]), 0.0)


@pytest.mark.parametrize("count", [300, 5000])
def test_what_modes_take_of_a_bent_step_is_its_integral_and_has_its_slope(rng, count):
    steps, changes = np.full(count, 0.01), rng.normal(size=(count, 3))
    rates, one, none = np.array([1e-3, 30.0, 180.0, 4e3]), np.ones((4, 1)), np.zeros((4, 1))
    u, weight = np.polynomial.legendre.leggauss(40)
    found = driven(rates, steps, changes, one, none)[:, 0]
    shapes = np.stack([np.ones_like(u), u, 1.5 * u**2 - 0.5])
    gains = 0.5 * (np.exp(-0.005 * np.outer(rates, 1.0 - u)) * weight) @ shapes.T
    q, exact = np.zeros(4), np.zeros(count)
    for i in range(count):
        q = q * np.exp(-0.01 * rates) + gains @ changes[i]
        exact[i] = q.sum()
    assert found == pytest.approx(exact, rel=1e-7, abs=1e-9)
    h = 1e-5
    more, less = (driven(rates * (1.0 + s * h), steps, changes, one, none) for s in (1, -1))
    slope = driven(rates, steps, changes, none, rates[:, None])
    assert slope == pytest.approx((more - less) / (2.0 * h), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(("samples", "off"), [(12, 0.002), (8, 0.01), (6, 0.03)])
def test_a_sine_of_few_samples_a_cycle_is_no_polygon(samples, off):
    """Between its samples straight lines would be off by 3, 7 and 13 % of it."""
    t = np.arange(6 * samples + 1) / samples
    fine = Between.of(t, np.sin(2.0 * np.pi * t + 0.3)).at(np.linspace(1.0, 5.0, 401))
    inner = (fine.time >= 1.0) & (fine.time <= 5.0)
    expected = np.sin(2.0 * np.pi * fine.time[inner] + 0.3)
    assert np.max(np.abs(fine.value[inner] - expected)) < off


def test_noise_is_no_smooth_motion():
    noise = np.random.default_rng(1).normal(size=2000)
    assert np.mean(_smooth(np.arange(2000.0), noise)) < 0.02
