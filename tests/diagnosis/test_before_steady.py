"""A slow oscillation whose first points were taken before a period had passed.

They are no course of the specimen.
"""

import numpy as np
import pytest

import springpot

HERTZ, SPACING, ROWS = 0.03, 4.0, 40


def record(transient, drift=0.0, hertz=HERTZ, spacing=SPACING, seed=1):
    """A gel in one swinging, told every few seconds.

    At first it has not moved yet, as the stress is held.
    """
    time = 4000.0 + spacing * np.arange(ROWS)
    since = (time - time[0]) * hertz
    size = (1.0 - transient * np.exp(-since / 0.15)) * (1.0 + drift * since / since[-1])
    real, imaginary = 0.01 * np.random.default_rng(seed).normal(size=(2, ROWS))
    stiffness = (115.0 + 15.0j) * size * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(
        np.full(ROWS, 2.0 * np.pi * hertz),
        stiffness,
        conditions={"time": time, "amplitude": 3.8 / np.abs(stiffness)},
        units=springpot.Units("Pa", "-"),
        provenance={"unit time": "s"},
    )


@pytest.fixture(scope="module")
def found():
    return springpot.diagnose(record(transient=0.9))


@pytest.mark.soak
def test_the_start_is_told_as_such(found):
    assert found.verdict == "unexplained"
    assert "the first 9 points stand within one period of the start" in found.says
    assert "the specimen changes" not in " ".join([found.says, *found.notes])


@pytest.mark.soak
def test_the_next_step_leaves_it_out(found):
    assert found.one_test == "time=4036..4156"
    later = springpot.measurement.select(record(transient=0.9), {"time": "4036..4156"})
    assert springpot.diagnose(later).verdict == "adequate"


@pytest.mark.soak
def test_a_specimen_that_goes_on_changing_is_told_of_all_the_same():
    found = springpot.diagnose(record(transient=0.0, drift=2.0))
    assert "the specimen changes with time" in found.says


@pytest.mark.soak
def test_points_that_are_periods_apart_have_no_such_start():
    found = springpot.diagnose(record(transient=0.9, hertz=1.0, spacing=1.1))
    assert "within one period" not in found.says
