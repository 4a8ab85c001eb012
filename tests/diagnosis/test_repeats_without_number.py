"""Sweeps of several specimens in one table, with no column that tells them apart."""

import numpy as np
import pytest

import springpot

FREQUENCY = np.geomspace(0.1, 100.0, 20)


def swept(gains, seed=3):
    """Each frequency once for each gain; the noise is half a percent."""
    rng = np.random.default_rng(seed)
    s = 2j * np.pi * FREQUENCY
    stiffness = 1e4 * (1.0 + 0.5 * s**0.3)
    rows = []
    for gain in gains:
        noise = rng.normal(size=s.size) + 1j * rng.normal(size=s.size)
        rows.append(gain * stiffness * (1.0 + 0.005 * noise))
    return springpot.Measurement(
        np.tile(2.0 * np.pi * FREQUENCY, len(gains)), np.concatenate(rows), name="gel"
    )


@pytest.mark.soak
def test_specimens_that_differ_are_no_missing_effect():
    found = springpot.diagnose(swept([0.97, 1.0, 1.03]))
    assert found.verdict == "unexplained"
    assert "rows measured under the same conditions differ by 3." in found.says
    assert "no effect of the library" not in found.says
    assert any("number the sweeps in a column repeat" in note for note in found.notes)
    # Nothing has to be measured before they are numbered.
    assert found.next_experiment is None


@pytest.mark.soak
def test_equal_specimens_are_told_of_nothing():
    found = springpot.diagnose(swept([1.0, 1.0, 1.0]))
    assert found.verdict == "adequate"
    assert not any("same conditions" in note for note in found.notes)


@pytest.mark.soak
def test_a_misfit_that_all_specimens_share_is_not_laid_to_them():
    found = springpot.diagnose(swept([1.0, 1.0, 1.0]), "spring")
    assert "same conditions" not in found.says
