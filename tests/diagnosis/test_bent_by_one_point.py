"""A bad point at the end of a sweep bends every model, and hides the physics of all others."""

import numpy as np
import pytest
from hidden_data import KELVIN, design, exact, measured

import springpot
from springpot.misfit.outliers import pulling
from springpot.rheology import Model, parallel, spring

AT = design(30, 0.05, 50.0)
NOISE = 0.003
PHASE = 0.04


def with_an_end_that_is_off(shift, seed=0):
    """A phase error on all points, and at the highest frequency whatever `shift` adds beside it."""
    k = exact(KELVIN, AT) * np.exp(1j * PHASE)
    k[-1] *= 1.0 + shift
    return measured(AT, k, seed, NOISE, known=True)


@pytest.mark.soak
def test_a_bad_point_at_the_end_is_set_aside_and_the_effect_of_all_others_is_named():
    diagnosis = springpot.diagnose(with_an_end_that_is_off(0.08 - 0.15j), "material")
    assert any("50 Hz" in note and "outlier" in note for note in diagnosis.notes)
    assert "phase-error" in diagnosis.classes[0]
    # A material follows a good part of a constant phase. With the bad point the error would be that
    # of it alone, 0.17 / sqrt(30), and more.
    assert 0.5 * PHASE < diagnosis.error.relative_rms < 0.7 * PHASE
    assert diagnosis.best.error_after < 1.1 * diagnosis.error.noise_floor


@pytest.mark.soak
def test_a_mass_that_begins_at_the_end_is_no_outlier():
    k = exact(KELVIN, AT)
    heavy = 0.15 * np.abs(k[-1]) / AT.omega.max() ** 2
    diagnosis = springpot.diagnose(measured(AT, k - heavy * AT.omega**2, level=NOISE), KELVIN.name)
    assert diagnosis.verdict == "effect-missing"
    assert "inertia" in diagnosis.classes[0]
    assert not any("outlier" in note for note in diagnosis.notes)


def frame_of(stiffness):
    fit = springpot.misfit.floor.fitted_to_floor
    data = springpot.Measurement(AT.omega, stiffness, sd=0.01 * np.abs(stiffness) * (1 + 1j))
    return fit(Model("spring", parallel(spring())), data).frame()


def test_the_row_that_carries_most_of_the_misfit_is_found():
    rng = np.random.default_rng(2)
    noise = 0.01 * (rng.normal(size=30) + 1j * rng.normal(size=30))
    assert len(pulling([frame_of(100.0 * (1.0 + noise))])) == 0
    noise[29] += 0.3
    assert pulling([frame_of(100.0 * (1.0 + noise))]).tolist() == [29]


def test_without_an_alarm_it_carries_what_chance_does_not():
    rng = np.random.default_rng(2)
    noise = 0.01 * (rng.normal(size=30) + 1j * rng.normal(size=30))
    for shift, found in ((0.04, []), (0.3, [29])):
        off = noise + shift * (np.arange(30) == 29)
        assert pulling([frame_of(100.0 * (1.0 + off))], False).tolist() == found


@pytest.mark.soak
@pytest.mark.parametrize("row", [-1, -2])
def test_of_a_dozen_points_a_bad_one_at_the_end_is_set_aside(row):
    at = design(12, 0.5, 50.0)
    k = exact(KELVIN, at)
    k[row] *= 0.88
    diagnosis = springpot.diagnose(measured(at, k, level=0.006), KELVIN.name)
    assert diagnosis.verdict == "adequate"
    assert any("outlier" in note and f"row {12 + row + 1} " in note for note in diagnosis.notes)
    assert diagnosis.error.noise_floor < 0.01


@pytest.mark.soak
def test_a_slider_that_never_slips_is_not_named():
    """A fluid track beside a rubber: a resonance, and a spring behind it."""
    at = design(20, 1.0, 40.0, amplitudes=(0.1, 1.0))
    s = 1j * at.omega
    track = 150.0 * s**2 / (s**2 + 2.0 * 0.25 * 70.0 * s + 70.0**2)
    data = measured(at, 300.0 + 30.0 * s**0.3 + track, level=0.008)
    diagnosis = springpot.diagnose(data, "fractional-kelvin")
    assert "elasto-sliding" not in diagnosis.says
    assert "hysteresis" not in diagnosis.says
    assert any("the amplitude does not matter" in note for note in diagnosis.notes)
