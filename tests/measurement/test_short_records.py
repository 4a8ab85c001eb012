"""The frequency of a record of few cycles, whose peak is not where its line is."""

import numpy as np
import pytest

from springpot.measurement.steady import MendedSignals, coarse_frequency, steady_part

DURATION = 8.0
LINE = 2.0 * np.pi / DURATION
"""What one cycle in all is, in rad/s."""


@pytest.mark.parametrize("phase", [0.0, 0.8, 1.6, 2.4])
@pytest.mark.parametrize("cycles", [1.3, 1.71, 2.37, 3.1, 5.53])
def test_of_few_cycles_the_frequency_is_good_to_an_eightieth_of_a_cycle(cycles, phase):
    time = np.linspace(0.0, DURATION, 600)
    moved = np.sin(cycles * LINE * time + phase) + 0.4 * time + 2.0
    found = coarse_frequency(MendedSignals(time, moved, moved, "short"))
    # Half of what lies between two of the frequencies that are tried, one and a half lines to
    # either side.
    assert abs(found / LINE - cycles) < 1.0 / 79.0


@pytest.mark.parametrize("cycles", [1.7, 2.3, 3.4])
def test_only_a_record_of_less_than_two_cycles_is_said_to_be_one(cycles):
    time = np.linspace(0.0, DURATION, 600)
    moved = np.sin(cycles * LINE * time)
    found = steady_part(MendedSignals(time, moved, 2.0 * moved, "short"), cycles * LINE)
    assert any("fewer than two cycles" in note for note in found.notes) == (cycles < 2.0)
    assert (found.start, found.stop) == pytest.approx((0.0, DURATION), abs=0.3 * DURATION / cycles)
