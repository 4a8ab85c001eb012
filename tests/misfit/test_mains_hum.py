"""A point at the frequency of the mains is called so, one beside it is not."""

import numpy as np
import pytest

import springpot
from springpot.diagnosis import diagnose
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.outliers import Outlier
from springpot.misfit.residual_tests import _hum_in_words
from springpot.rheology import Model, parallel, spring


@pytest.mark.parametrize("hertz", [50.0, 60.0, 99.0, 120.0, 150.0, 180.0, 50.4])
def test_the_mains_and_twice_and_three_times_as_much_hum(hertz):
    assert Outlier(hertz, 30.0, 0.1 + 0j, "", 1.0 + 0j).at_mains


@pytest.mark.parametrize("hertz", [47.0, 53.0, 25.0, 75.0, 200.0, 5.0])
def test_other_frequencies_do_not(hertz):
    assert not Outlier(hertz, 30.0, 0.1 + 0j, "", 1.0 + 0j).at_mains


def disturbed(hertz, rng):
    """A sweep in which one point is a tenth off."""
    frequency = np.sort(np.r_[np.geomspace(0.5, 150.0, 24), hertz])
    s = 2j * np.pi * frequency
    stiffness = 60.0 + 1.0 / (1.0 / 400.0 + 1.0 / (40.0 * s**0.5))
    real, imaginary = 0.002 * rng.normal(size=(2, len(frequency)))
    stiffness *= 1.0 + real + 1j * imaginary
    stiffness[frequency == hertz] *= 1.0 + 0.1 * np.exp(1j)
    return springpot.Measurement(s.imag, stiffness, units=springpot.Units("kN/m", "mm"))


@pytest.mark.soak
@pytest.mark.parametrize(("hertz", "hums"), [(50.0, True), (47.0, False)])
def test_the_note_on_a_point_that_was_set_aside_speaks_of_it(hertz, hums):
    effects = [
        springpot.plugins().effect(name) for name in ("inertia", "time-delay", "phase-error")
    ]
    data = disturbed(hertz, np.random.default_rng(1))
    found = diagnose(data, springpot.parse_model("material"), effects, np.random.default_rng(0))
    (note,) = [note for note in found.notes if "set aside" in note]
    assert f"{hertz:g} Hz" in note
    assert ("mains hum" in note) == hums


@pytest.mark.parametrize("level", [0.0, 0.05])
def test_how_far_points_at_the_mains_stand_off_is_told_as_a_multiple_of_the_others(level):
    """Of 0.2 % of noise, and 5 % more at 50, 100 and 150 Hz."""
    rng = np.random.default_rng(3)
    mains = [50.0, 100.0, 150.0]
    frequency = np.sort(
        np.r_[np.geomspace(1.0, 45.0, 60), 55.0, 70.0, 85.0, 110.0, 140.0, 165.0, mains]
    )
    n = len(frequency)
    stiffness = 100.0 * (1.0 + 0.002 * (rng.normal(size=n) + 1j * rng.normal(size=n)))
    stiffness[np.isin(frequency, mains)] *= 1.0 + level
    data = springpot.Measurement(2.0 * np.pi * frequency, stiffness, sd=np.full(n, 0.2 + 0.2j))
    ratio, says = _hum_in_words(fitted_to_floor(Model("spring", parallel(spring())), data).frame())
    if level:
        assert ratio > 10.0
        assert "50 Hz, 100 Hz, 150 Hz" in says
    else:
        assert 0.1 < ratio < 4.0
