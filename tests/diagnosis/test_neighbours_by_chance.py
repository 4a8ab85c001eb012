"""How likely chance puts points that stand out beside each other: by counting all ways."""

from itertools import combinations, pairwise
from math import comb

import numpy as np
import pytest
from hidden_data import KELVIN, design, exact, measured

from springpot.diagnosis.verdict import _chance_of_pairs, _standing_out
from springpot.misfit.floor import fitted_to_floor
from springpot.registry import parse_model


@pytest.mark.parametrize("m", [1, 2, 4, 7, 9])
def test_the_chance_is_the_share_of_all_ways_to_deal_them_out(m):
    n = 9
    seen = [
        sum(later == earlier + 1 for earlier, later in pairwise(ways))
        for ways in combinations(range(n), m)
    ]
    for pairs in range(m):
        wanted = sum(each >= pairs for each in seen) / comb(n, m)
        assert _chance_of_pairs(n, m, pairs) == wanted


def test_of_many_points_it_is_no_quotient_of_infinities():
    assert 0.0 < _chance_of_pairs(5000, 2500, 1350) < 1e-3


@pytest.mark.suite_cases("1.0")
@pytest.mark.parametrize("width", [0.0, 1.0])
def test_beside_the_furthest_point_of_a_notch_its_neighbours_stand_out(width):
    """Of a single bad point none does."""
    sweep = design(24)
    place = np.arange(24) - 12
    notch = 0.3 / (1.0 + 1j * place / width) if width else 0.3 * (place == 0)
    data = measured(sweep, exact(KELVIN, sweep) * (1.0 - notch), level=0.01, known=False)
    outside = _standing_out(fitted_to_floor(parse_model(KELVIN.name), data))
    assert outside[12]
    assert (outside[11] and outside[13]) == bool(width)
