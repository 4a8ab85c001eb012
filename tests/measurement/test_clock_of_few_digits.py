"""Times that were sampled evenly are even, however few digits a file gives them."""

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.measurement.instrument import even_clock
from springpot.registry import parse_model
from springpot.timetests import recorded

EVEN = 0.0104206651 * np.arange(400)


def test_written_times_are_as_even_as_they_were_sampled():
    found = even_clock(EVEN.round(5))
    assert found == pytest.approx(EVEN, abs=1e-5)
    assert np.ptp(np.diff(found)) < 1e-12


@pytest.mark.parametrize(
    "clock",
    [
        EVEN,
        np.geomspace(0.05, 1e3, 60).round(4),
        np.delete(EVEN.round(5), 200),
        # Of digits as coarse as the steps nobody knows whether a sample is missing.
        np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0]),
        np.array([0.0, 0.4]),
    ],
    ids=["as they are", "in decades", "one missing", "coarse", "two"],
)
def test_other_times_stay_to_the_bit(clock):
    assert even_clock(clock).tobytes() == clock.tobytes()


def test_a_mass_does_not_feel_the_digits_of_the_clock():
    moved = np.sin(11.0 * EVEN)
    mass = parse_model("kelvin + inertia")
    theta = mass.vector({"k": 1.0, "c": 0.001, "inertia.m": 0.1})
    exact, written = (
        recorded(mass, theta, TimeTest.of_history(clock, moved, moved, "m", "N")).value
        for clock in (EVEN, EVEN.round(5))
    )
    assert written[2:-2] == pytest.approx(exact[2:-2], abs=1e-4 * np.ptp(exact))
