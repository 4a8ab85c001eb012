"""Noise that is dealt out anew stays in the part it was told of."""

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.misfit.frame import NoiseFrame


def draws(stiffness, storage, loss, off):
    """Draws of the noise of an exact fit whose storage and loss are so far off."""
    n = len(stiffness)
    frame = NoiseFrame(
        Measurement(np.geomspace(1.0, 100.0, n), stiffness + off, name="made"),
        stiffness,
        1.0 / storage + 1j / loss,
        np.zeros((0, n), dtype=complex),
        estimated=True,
    )
    return np.abs(frame.draws(50, np.random.default_rng(2)))


def test_a_larger_noise_of_the_loss_does_not_become_one_of_the_storage():
    """From 5 to 85 degrees of phase: turned with K, storage and loss would change places."""
    n, rng = 60, np.random.default_rng(1)
    stiffness = np.exp(1j * np.radians(np.linspace(5.0, 85.0, n)))
    storage, loss = np.full(n, 0.002), np.full(n, 0.02)
    # Of sizes that show where a number comes from: all storages 1, all losses 2 deviations off.
    off = storage * rng.choice([-1.0, 1.0], n) + 2j * loss * rng.choice([-1.0, 1.0], n)
    drawn = draws(stiffness, storage, loss, off)
    assert np.allclose(drawn[:, n:] / drawn[:, :n], 2.0, rtol=1e-4)


def test_noise_of_each_part_keeps_its_size_at_every_loss_factor():
    """Proportional to K' and to K'' each: dealt to another loss factor, it has their size there."""
    n, rng = 60, np.random.default_rng(2)
    stiffness = np.exp(1j * np.radians(np.linspace(1.0, 60.0, n)))
    storage, loss = 0.01 * stiffness.real, 0.01 * stiffness.imag
    off = storage * rng.choice([-1.0, 1.0], n) + 1j * loss * rng.choice([-1.0, 1.0], n)
    drawn = draws(stiffness, storage, loss, off)
    assert np.allclose(drawn / drawn.mean(axis=1, keepdims=True), 1.0, rtol=1e-4)
