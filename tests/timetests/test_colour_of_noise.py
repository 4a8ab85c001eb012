"""Noise that swings, or is one over f, is noise: and what is missed beside it is still missed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from springpot.measurement import TimeTest
from springpot.misfit.coloured_noise import colour_of, period_test
from springpot.misfit.residual_scatter import MEMORIES, ResidualScatter, scatter_of
from springpot.registry import parse_model
from springpot.timetests import identify
from springpot.timetests.hypotheses import FitResiduals, chi_square_gain

N = 500
SEEDS = range(20)


def swinging(seed):
    """A channel that rings: poles of radius 0.85 at one radian a sample."""
    white = np.random.default_rng(seed).normal(size=N + 200)
    return lfilter([1.0], [1.0, -2.0 * 0.85 * np.cos(1.0), 0.85**2], white)[200:]


def one_over_f(seed):
    """White noise integrated by half an order, without the trend that a model would take."""
    count = 4 * N
    k = np.arange(1, count)
    response = np.concatenate([[1.0], np.cumprod((k - 0.5) / k)])
    white = np.random.default_rng(seed).normal(size=2 * count)
    noise = np.convolve(white, response)[count : count + N]
    slow = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, N), 2))[0]
    return noise - slow @ (slow.T @ noise)


def test_noise_that_is_one_over_f_is_seldom_a_misfit():
    # By a memory of one sample alone three of four are.
    assert np.mean([scatter_of(one_over_f(seed)).misfit for seed in SEEDS]) <= 0.35


@pytest.mark.soak_cases("one_over_f")
@pytest.mark.parametrize("noise", [swinging, one_over_f])
def test_what_is_missed_beside_it_is_told(noise):
    bump = 8.0 * np.exp(-0.5 * ((np.arange(N) - 300.0) / 15.0) ** 2)
    seen = [scatter_of(noise(seed) + bump * np.std(noise(seed))).misfit for seed in SEEDS]
    assert np.mean(seen) >= 0.9


@pytest.mark.parametrize("noise", [swinging, one_over_f])
def test_whitened_noise_is_as_large_at_all_frequencies(noise):
    white = []
    for seed in SEEDS:
        if (colour := colour_of(noise(seed), MEMORIES)) is not None:
            white.append(ResidualScatter(1.0, 0.0, 0.0, 1.0, colour=colour).whitened(noise(seed)))
    # By octaves of the cosine transform: what a memory of one sample leaves is 3 to 20 there.
    squares = np.mean(np.array(white) ** 2, axis=0)
    octaves = [squares[2**k : 2 ** (k + 1)].mean() for k in range(4, 8)]
    assert len(white) >= 10
    assert 0.6 < min(octaves) <= max(octaves) < 1.6


def test_a_memory_of_one_sample_and_a_random_walk_have_none():
    rng = np.random.default_rng(2)
    alike = lfilter([1.0], [1.0, -0.5], rng.normal(size=N))
    walk = rng.normal(size=N) + 0.2 * np.cumsum(rng.normal(size=N))
    assert colour_of(alike, MEMORIES) is None
    assert scatter_of(walk).misfit


def test_a_story_may_have_noise_of_its_own_for_the_price_of_a_wider_one():
    residual = swinging(3)
    white = ResidualScatter(1.0, 0.0, 0.0, 1.0)
    own = ResidualScatter(2.0, 0.0, 0.0, 1.0, colour=colour_of(residual, MEMORIES))
    wider = max(np.sum(np.log(own.spectrum(N))) + own.colour.count * np.log(N), 0.0)
    assert white.squares(residual, own) == pytest.approx(own.deviance(residual) + wider)
    assert white.squares(residual, own) < white.deviance(residual)
    # So it may where another fit of the same test leaves it.
    assert white.squares(residual, white, own) == white.squares(residual, own)
    # That of a misfit is no excuse for it.
    missed = ResidualScatter(own.size, own.memory, 1e3, 1.0, colour=own.colour)
    assert white.squares(residual, missed) == white.deviance(residual)


def test_noise_that_excuses_one_fit_excuses_one_that_leaves_less():
    """Of a colour that one of them tells: what is less by a tenth is no worse by thousands."""
    residual = swinging(3)
    own = ResidualScatter(2.0, 0.0, 0.0, 1.0, colour=colour_of(residual, MEMORIES))
    missed = ResidualScatter(2.0, 0.0, 1e3, 1.0)
    none = np.zeros((0, N)), np.zeros(N)
    excused, better = (
        FitResiduals(3, (share * residual,), (told,), none[:1], none[1:])
        for share, told in ((1.0, own), (0.9, missed))
    )
    noise = [ResidualScatter(0.2, 0.0, 0.0, 1.0)]
    assert 0.0 < chi_square_gain(excused, better, noise) < N
    assert chi_square_gain(better, excused, noise) == -chi_square_gain(excused, better, noise)


@pytest.mark.parametrize("memory", [0.0, 0.9, 0.99])
def test_noise_of_any_memory_rarely_repeats_with_a_motion(memory):
    rng = np.random.default_rng(3)
    drawn = lfilter([1.0], [1.0, -memory], rng.normal(size=(600, 700)))[:, 200:]
    chances = np.array([period_test(each, (2, 25))[0] for each in drawn])
    assert np.mean(chances < 0.05) < 0.075
    assert np.mean(chances < 1e-3) < 0.006


def test_what_repeats_with_a_motion_is_no_noise():
    """A damper of dry friction, fitted without it: its loop is no noise with a memory."""
    t = 0.0277 * np.arange(192)
    turned = 2.0 * np.pi * t / (24 * 0.0277)
    force = 13.0 * np.sign(np.cos(turned - 1.0)) + 2.0 * np.sin(turned)
    force = force + 0.2 * np.random.default_rng(2).normal(size=len(t))
    test = TimeTest.of_history(t, 16.0 * np.sin(turned), force, "mm", "N", control="displacement")
    (told,) = identify(test, parse_model("kelvin")).tests
    assert told.noise_floor == pytest.approx(0.2 / np.sqrt(np.mean(force**2)), rel=0.15)
    assert told.over_floor > 25.0


def test_noise_behind_a_low_pass_filter_is_noise():
    white = np.random.default_rng(1).normal(size=(20, 700))
    rows = lfilter(*butter(2, 0.25), white)[:, 100:]
    assert np.mean([scatter_of(row).misfit for row in rows]) <= 0.15


def test_a_mean_over_five_samples_is_noise():
    rows = np.random.default_rng(1).normal(size=(20, 604))
    misses = [scatter_of(np.convolve(row, np.full(5, 0.2), "valid")).misfit for row in rows]
    assert np.mean(misses) <= 0.15
