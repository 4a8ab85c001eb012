"""Shifts that no material could have: two sweeps with moduli in common must meet."""

import numpy as np
import pytest

from springpot.identification.known_factors import Allowed

LEVELS = np.array([0.0, 10.0, 20.0, 30.0])
WIDE = np.log(100.0)


def allowed(overlapping=True):
    ends = np.zeros(4), np.full(4, WIDE)
    return Allowed("temperature", LEVELS, *ends, np.full((4, 4), overlapping))


@pytest.mark.parametrize("pair", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_of_any_two_neighbours_a_shift_wider_than_their_sweep_is_told_with_both(pair, sign):
    log_a = sign * 1.5 * WIDE * (np.arange(4) > pair)
    says = allowed().broken_by(log_a)
    cold, hot = LEVELS[pair : pair + 2]
    assert f"{cold:g} degC and {hot:g} degC apart by 3 decades" in says
    assert "sweeps of 2 decades" in says
    assert allowed(overlapping=False).broken_by(log_a) == ""


def test_a_shift_as_wide_as_the_sweeps_is_allowed_and_an_endless_one_is_not():
    assert allowed().broken_by(WIDE * np.arange(4.0)) == ""
    assert "endless" in allowed().broken_by(np.array([0.0, 1.0, np.inf, 3.0]))
