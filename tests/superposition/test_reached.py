"""Which levels hang together: those whose sweeps overlap, directly or through others."""

import numpy as np

from springpot.measurement.independence import meeting, reached_from


def test_a_chain_of_overlaps_is_followed_to_its_end_and_not_over_a_gap():
    low, high = np.array([0.0, 1.0, 2.0, 5.0, 6.0]), np.array([1.2, 2.2, 3.0, 6.5, 8.0])
    touching = meeting(low, high)
    assert reached_from(0, touching).tolist() == [True, True, True, False, False]
    assert reached_from(4, touching).tolist() == [False, False, False, True, True]


def test_sweeps_that_meet_in_one_point_touch_and_room_is_for_gaps_as_wide():
    low, high = np.array([0.0, 1.0, 2.5]), np.array([1.0, 2.0, 3.0])
    assert meeting(low, high).tolist() == [
        [True, True, False],
        [True, True, False],
        [False, False, True],
    ]
    assert meeting(low, high, 0.5).all(axis=1).tolist() == [False, True, False]
    assert not meeting(low, high, -0.1)[0, 1]
