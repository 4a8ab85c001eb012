"""Statistics of a residual's noise: against their definitions, covariances and simulated noise."""

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import toeplitz

from springpot.distributions import spectrum_of
from springpot.misfit.coloured_noise import fisher_test
from springpot.misfit.frame import chance_of_squares
from springpot.misfit.residual_scatter import (
    FEWEST,
    LEVEL,
    PARTS,
    TENFOLD,
    ResidualScatter,
    _fitted,
    _log_likelihood,
    _standardised,
    _unrepeated,
    powers,
    rougher,
    scatter_of_sweep,
    times_noise,
)
from springpot.thresholds import SIGNALS
from springpot.timetests.disturbances import _jumps, likeliest_jump, periodogram


def noise(rng, n, memory, size=1.0):
    new = rng.normal(size=n) * size * np.sqrt(1.0 - memory**2)
    found = np.empty(n)
    found[0] = size * rng.normal()
    for i in range(1, n):
        found[i] = memory * found[i - 1] + new[i]
    return found


@pytest.mark.parametrize("memory", [0.0, 0.4, 0.7])
def test_whitened_by_the_covariance_of_an_autoregression(rng, memory):
    scatter = ResidualScatter(2.0, memory, 0.0, 1.0)
    residual = rng.normal(size=12)
    covariance = 4.0 * toeplitz(memory ** np.arange(12.0))
    white = scatter.whitened(residual)
    assert white @ white == pytest.approx(residual @ np.linalg.solve(covariance, residual))
    turned = np.column_stack([scatter.whitened(e) for e in np.eye(12)])
    np.testing.assert_allclose(turned @ covariance @ turned.T, np.eye(12), atol=1e-12)


def test_the_spectrum_of_an_autoregression_sums_to_its_covariances():
    omega = 2.0 * np.pi * np.arange(4096) / 4096
    spectrum = spectrum_of(omega, 3.0, 0.6)
    for lag in (0, 1, 2, 5):
        assert np.mean(spectrum * np.cos(lag * omega)) == pytest.approx(9.0 * 0.6**lag)


def test_the_powers_of_white_noise_are_its_variance_and_hold_all_samples(rng):
    drawn = [2.0 * rng.normal(size=64) for _ in range(2000)]
    found = [powers(each)[0] for each in drawn]
    np.testing.assert_allclose(powers(np.zeros(64))[1], np.pi * np.arange(64) / 64)
    # Of each frequency the scatter of the mean is 4 sqrt(2 / 2000).
    np.testing.assert_allclose(np.mean(found, axis=0), 4.0, rtol=0.15)
    # Nothing is faded: as many squares as the samples have, wherever they are.
    for power, each in zip(found[:9], drawn, strict=False):
        assert power.sum() == pytest.approx(each @ each)


def test_a_periodogram_has_the_variance_of_white_noise_whatever_its_mean(rng):
    found = [periodogram(2.0 * rng.normal(size=64) + 5.0)[0] for _ in range(2000)]
    omega = periodogram(np.zeros(64))[1]
    np.testing.assert_allclose(omega, 2.0 * np.pi * np.arange(1, 33) / 64)
    # Of each frequency but the last, which is real, the scatter of the mean is 4 / sqrt(2000).
    np.testing.assert_allclose(np.mean(found, axis=0)[2:], 4.0, rtol=0.15)


def test_size_and_memory_are_read_from_aspectrum_of(rng):
    residual = noise(rng, 4000, 0.4, size=3.0)
    size, memory = _fitted(powers(residual)[0])
    assert (size, memory) == (pytest.approx(3.0, rel=0.05), pytest.approx(0.4, abs=0.05))
    # The likelihood is largest there.
    power, omega = powers(residual)
    best = _log_likelihood(power, spectrum_of(omega, size, memory))
    for other in ((1.02 * size, memory), (0.98 * size, memory), (size, memory + 0.04)):
        assert _log_likelihood(power, spectrum_of(omega, *other)) < best


def test_chances_are_those_of_f_and_chi_square():
    assert chance_of_squares(1.7 * 12.0, 12.0, 30.0) == pytest.approx(stats.f.sf(1.7, 12, 30))
    assert chance_of_squares(1.7 * 12.0, 12.0, np.inf) == pytest.approx(stats.chi2.sf(1.7 * 12, 12))
    assert chance_of_squares(1.7 * 12.0, 12.0, 0.3) == pytest.approx(stats.f.sf(1.7, 12, 1))


@pytest.mark.parametrize(
    ("excess", "local", "chance"),
    [(0.0, 1.0, 1.0), (-5.0, 1.0, 1.0), (2 * TENFOLD, 1.0, 0.01), (TENFOLD, 0.003, 0.003)],
)
def test_the_chance_of_noise_alone_is_the_smaller_one(excess, local, chance):
    scatter = ResidualScatter(1.0, 0.0, excess, local)
    assert scatter.chance == pytest.approx(chance)
    assert (scatter.misfit, scatter.doubtful) == (chance < 1e-3, chance < 1e-2)


def test_deviance_is_chi_square_or_that_of_student():
    residual = np.full(10, 2.0)
    known = ResidualScatter(1.0, 0.0, 0.0, 1.0)
    assert known.deviance(residual) == pytest.approx(40.0)
    # What is less than the noise is no likelier than it.
    assert known.deviance(0.1 * residual) == pytest.approx(10.0)
    told = ResidualScatter(1.0, 0.0, 0.0, 1.0, worth=5.0)
    assert told.deviance(residual) == pytest.approx(15.0 * np.log(1.0 + 40.0 / 5.0))


def test_a_sample_that_repeats_the_last_one_has_no_noise():
    moving = np.arange(FEWEST, dtype=float)
    stuck = np.append(moving, np.full(20, moving[-1]))
    assert np.count_nonzero(_unrepeated(stuck)) == FEWEST
    assert _unrepeated(stuck[1:]).all()
    wanted = np.sqrt(np.sum(stuck**2) / FEWEST) / 2.0
    assert times_noise(stuck, 2.0) == pytest.approx(wanted)


def test_noise_of_a_rough_part_is_evened_to_that_of_the_rest():
    residual = np.where(np.arange(400) % 2, 1.0, -1.0)
    residual[100:140] *= 20.0
    times, even = rougher(residual), _standardised(residual)
    assert times[110:130] == pytest.approx(20.0)
    assert np.all(times[np.r_[:90, 150:400]] == 1.0)
    assert np.abs(even[np.r_[:90, 110:130, 150:400]]) == pytest.approx(1.0)
    # Few samples, or such of which most repeat each other, tell nothing of it.
    for few in (residual[95:130], np.repeat([0.0, 1.0], 40)):
        assert np.all(rougher(few) == 1.0)


def test_a_sample_far_off_is_no_larger_than_the_tails_of_its_noise(rng):
    residual = rng.normal(size=400)
    residual[7] = -1e6
    even = _standardised(residual)
    assert even[7] == pytest.approx(-3.0, rel=0.15)
    calm = [np.all(rougher(residual)[max(i - 7, 0) : i + 8] == 1.0) for i in range(400)]
    near = (np.abs(residual) < 2.5) & calm
    assert even[near] == pytest.approx(residual[near])


@pytest.mark.parametrize("known", [True, False])
def test_of_a_sweep_noise_alone_is_rarely_missed(rng, known):
    found = [scatter_of_sweep(rng.normal(size=60), known) for _ in range(400)]
    assert np.mean([each.local < 0.05 for each in found]) < 0.1
    assert np.median([each.size for each in found]) == pytest.approx(1.0, abs=0.05)
    assert all(np.isinf(each.worth) for each in found if each.local >= SIGNALS.ruled_out)


def test_a_ripple_or_twice_the_noise_is_told(rng):
    n = 30
    ripple = 2.0 * np.cos(2.0 * np.pi * 6.0 * np.arange(n) / n)
    both = np.concatenate([ripple, ripple])
    chance, omega = fisher_test((rng.normal(size=2 * n) + both).reshape(2, -1))
    assert chance < 1e-3
    assert omega == pytest.approx(2.0 * np.pi * 6.0 / n, abs=0.5 * np.pi / n)
    assert fisher_test(np.zeros((2, n)))[0] == 1.0
    assert fisher_test(both.reshape(2, -1)[:, :11])[0] == 1.0
    chances = [fisher_test(rng.normal(size=(2, n)))[0] for _ in range(500)]
    assert np.mean(np.array(chances) < 0.2) < 0.25
    assert scatter_of_sweep(2.0 * rng.normal(size=60), True).local < SIGNALS.ruled_out
    assert scatter_of_sweep(2.0 * rng.normal(size=60), False).local >= SIGNALS.ruled_out


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_a_jump_takes_what_a_refit_with_it_takes(rng, memory):
    n, scatter = 40, ResidualScatter(1.5, memory, 0.0, 1.0)
    weight = rng.uniform(0.5, 2.0, n)
    slopes = rng.normal(size=(n, 3))
    residual = noise(rng, n, memory) + 6.0 * weight * (np.arange(n) >= 23)
    white = scatter.whitened(residual)
    known = np.column_stack([scatter.whitened(column) for column in slopes.T])
    basis = np.linalg.qr(known)[0]
    drops, column = _jumps(weight, scatter, white - basis @ (basis.T @ white), basis)

    def left(*more):
        every = np.column_stack([known, *more])
        return np.sum((white - every @ np.linalg.lstsq(every, white)[0]) ** 2)

    edge = max(LEVEL, n // PARTS)
    for k in range(n):
        jump = scatter.whitened(weight * (np.arange(n) >= k))
        np.testing.assert_allclose(column(k), jump, atol=1e-12)
        wanted = left() - left(jump)
        if k < edge or k > n - edge:
            wanted = 0.0
        assert drops[k] == pytest.approx(wanted, abs=1e-9)
    found = likeliest_jump([(residual, slopes)], [weight], [scatter])
    assert (found.number, found.row, found.places) == (0, int(np.argmax(drops)), n)
    assert np.sum(scatter.whitened(found.left[0]) ** 2) == pytest.approx(left() - drops.max())
    # One whose samples do not follow one another has no jump.
    none = likeliest_jump([(residual, slopes)], [None], [scatter])
    assert none.places == 0
    assert np.sum(scatter.whitened(none.left[0]) ** 2) == pytest.approx(left())
