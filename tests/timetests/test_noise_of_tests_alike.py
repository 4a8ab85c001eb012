"""Short tests of one kind tell their noise together, unless they are plainly unlike."""

import numpy as np
import pytest

from springpot import TimeTest
from springpot.measurement.timenoise import noise_of, noise_of_alike
from springpot.misfit.residuals_of_tests import parts_of_specimen

TIME = np.geomspace(0.1, 100.0, 16)


def relaxations(noises: list[float], seed: int, count: int = 16) -> list[TimeTest]:
    draw, time = np.random.default_rng(seed), np.geomspace(0.1, 100.0, count)
    return [
        TimeTest.of_relaxation(time, time**-0.3 * (1.0 + sd * draw.normal(size=count)), "kPa")
        for sd in noises
    ]


def error(tests: list[TimeTest], noises: list[float]) -> np.ndarray:
    """Told noise over the truth, of each test."""
    told = [noise.floor for noise in noise_of_alike(tests)]
    size = [np.sqrt(np.mean((sd * TIME**-0.3) ** 2)) for sd in noises]
    return np.array(told) / size


def test_ten_of_them_know_it_better_than_each():
    alone, together = [], []
    for seed in range(12):
        tests = relaxations([0.02] * 10, seed)
        together += error(tests, [0.02] * 10).tolist()
        alone += [noise_of(test).floor for test in tests]
    alone = np.array(alone) / np.sqrt(np.mean((0.02 * TIME**-0.3) ** 2))
    assert np.std(np.log(together)) < 0.4 * np.std(np.log(alone))
    assert np.median(together) == pytest.approx(1.0, abs=0.1)


def test_one_that_is_far_noisier_stands_by_itself():
    noises = [0.01] * 8 + [0.2]
    ratios = np.array([error(relaxations(noises, seed), noises) for seed in range(20)])
    assert np.median(ratios[:, :8]) == pytest.approx(1.0, abs=0.15)
    assert np.median(ratios[:, 8]) > 0.5


def test_a_residual_is_held_against_what_all_of_them_tell():
    tests = relaxations([0.02] * 10, 1)
    worth = [part.scatter(np.ones(len(TIME))).worth for part in parts_of_specimen(tests)]
    alone = parts_of_specimen(tests[:1])[0].scatter(np.ones(len(TIME))).worth
    assert min(worth) > 4.0 * alone
    # The very object that keeps what it has worked out.
    assert parts_of_specimen(tests)[0] is parts_of_specimen(tests)[0]


def test_a_long_test_tells_its_own():
    tests = relaxations([0.02] * 3, 2, count=200)
    told = [part.sd for part in parts_of_specimen(tests)]
    assert all(np.array_equal(sd, noise_of(test).sd) for sd, test in zip(told, tests, strict=True))
