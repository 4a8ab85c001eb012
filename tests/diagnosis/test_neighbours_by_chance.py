"""How likely chance puts points that stand out beside each other: by counting all ways."""

from itertools import combinations, pairwise
from math import comb

import pytest

from springpot.diagnosis.verdict import _chance_of_pairs


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
