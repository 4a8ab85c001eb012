"""Frequencies that were measured several times in a row are repeats, though no column says so."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.errors import SpringpotError

FREQUENCIES = np.geomspace(0.1, 50.0, 12)


def written(tmp_path, frequency):
    """A file of these rows, which scatter by a hundredth."""
    frequency = np.asarray(frequency)
    parts = np.random.default_rng(1).normal(size=(2, len(frequency)))
    k = (1e4 + 3e3 * (2j * np.pi * frequency) ** 0.35) * (1.0 + 0.01 * (parts[0] + 1j * parts[1]))
    rows = [f"{f:.6g},{z.real:.6g},{z.imag:.6g}" for f, z in zip(frequency, k, strict=True)]
    path = tmp_path / "rows.csv"
    path.write_text("\n".join(["frequency [Hz],storage [N/m],loss [N/m]", *rows]))
    return path


def test_rows_of_one_frequency_after_another_are_numbered(tmp_path):
    data = springpot.read(written(tmp_path, np.repeat(FREQUENCIES, 3)))
    assert data.repeat.tolist() == [1, 2, 3] * 12
    assert "measured 3 times in a row" in str(data.provenance)
    assert "number the sweeps" not in str(data.provenance)
    found = springpot.diagnose(data, "fractional-kelvin", only=["inertia"])
    assert (found.error.noise_source, found.verdict) == ("repeats", "adequate")


@pytest.mark.parametrize(
    "frequency",
    [np.tile(FREQUENCIES, 2), np.append(FREQUENCIES, FREQUENCIES[-1]), np.full(12, 1.0)],
    ids=["two sweeps", "one row twice", "one frequency"],
)
def test_what_may_be_meant_otherwise_is_asked(tmp_path, frequency):
    with pytest.raises(SpringpotError, match="repeat"):
        springpot.read(written(tmp_path, frequency))
