"""What a tie leaves of a parameter's room: all that keeps what follows it within its own bounds."""

from __future__ import annotations

import pytest

from springpot.errors import ModelError
from springpot.registry import parse_model


@pytest.mark.parametrize(
    ("tie", "room"),
    [
        ("alpha = 2*beta", (0.0, 0.5)),
        ("alpha = 1 - beta", (0.0, 1.0)),
        ("alpha = beta - 0.25", (0.25, 1.0)),
        # What bends keeps what follows within its bounds point by point.
        ("alpha = 2*beta^2", (0.0, 1.0)),
        ("alpha = 2*beta*c1", (0.0, 1.0)),
    ],
)
def test_a_straight_line_leaves_room_for_what_follows_it(tie, room):
    model = parse_model("fractional-maxwell-general").tying([tie])
    [beta] = [each for each in model.parameters if each.name == "beta"]
    assert (beta.lower, beta.upper) == pytest.approx(room)


@pytest.mark.parametrize("tie", ["alpha = beta + 1", "alpha = beta + 2"])
def test_a_tie_that_leaves_a_point_or_nothing_is_refused(tie):
    with pytest.raises(ModelError, match="leaves beta no room"):
        parse_model("fractional-maxwell-general").tying([tie])
