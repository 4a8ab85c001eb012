"""Whether repeats differ by chance alone."""

import numpy as np
import pytest

from springpot.diagnosis.battery import repeats_structure
from springpot.diagnosis.policy import BATTERY
from springpot.measurement import Measurement, average_repeats


def repeated(seed=3):
    """Eight points, some measured twice and some three times, in no order."""
    point, repeat = np.repeat(np.arange(8), [2, 3] * 4), np.concatenate([np.arange(c) for c in [2, 3] * 4])
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(point))
    k = 100.0 + rng.standard_normal(20) + 1j * (10.0 + rng.standard_normal(20))
    return average_repeats(Measurement(1.0 + point[order], k, repeat=repeat[order]))


def test_simulated_repeats_lose_their_own_means(monkeypatch):
    """By hand with the same draws: the chance of the drift of the deviations, each point's mean taken away."""
    data, n = repeated(), 20
    noise = np.random.default_rng(7).standard_normal((BATTERY.draws, 2, n))
    for point in range(8):
        rows = data.group == point
        noise[:, :, rows] -= noise[:, :, rows].mean(axis=-1, keepdims=True)
    off = data.deviations()
    sample = np.concatenate([np.array([[off.real, off.imag]]), noise])
    sample /= np.sqrt(np.mean(sample**2, axis=-1, keepdims=True))
    slow, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, n), 4))
    size = np.sum((sample @ slow) ** 2, axis=(1, 2))

    def one_by_one(*given):
        raise AssertionError("thousands of simulated rows are summed together, not in a loop")

    monkeypatch.setattr(np, "apply_along_axis", one_by_one)
    found = repeats_structure(data, np.random.default_rng(7))
    assert found.parts["drift"] == pytest.approx(np.mean(size >= size[0]), abs=2e-3)
