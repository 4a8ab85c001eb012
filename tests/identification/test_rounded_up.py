"""Ends of a search box are round numbers."""

import pytest

from springpot.identification.space import rounded_up


@pytest.mark.parametrize("power", [-7, -1, 0, 3, 12])
def test_what_is_round_stays_and_all_else_goes_up_to_the_next_of_one_two_and_five(power):
    for step in (1.0, 2.0, 5.0):
        value = step * 10.0**power
        assert rounded_up(value) == pytest.approx(value, rel=1e-9)
        assert rounded_up(0.99 * value) == pytest.approx(value, rel=1e-9)
        assert rounded_up(1.01 * value) > 1.9 * value
