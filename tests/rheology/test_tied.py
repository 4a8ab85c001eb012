"""What a tie leaves of a parameter's room: all that keeps what follows it within its own bounds."""

from __future__ import annotations

import re

import numpy as np
import pytest

from derivatives import check_derivatives
from springpot.errors import ModelError
from springpot.registry import parse_model
from springpot.rheology.levels import owned
from springpot.rheology.points import Points
from springpot.rheology.tied import followers, part_of, started, ties_in, ties_of, untied


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


MAXWELLS = {"k1": 3.0, "tau1": 10.0, "k2": 6.0, "tau2": 0.1}
AT = Points.at(np.geomspace(0.1, 10.0, 5))
TIES = [
    ["k2 = 2*k1"],
    ["tau2 < tau1"],
    ["tau1 > tau2"],
    ["tau2 < 0.5*tau1"],
    ["tau2 < tau1", "k2 = 2*k1 + tau2"],
    ["k1 = k2*exp(-tau2/tau1)", "tau1 = sqrt(k2) + tau2^1.5"],
]


def tied_model(*ties):
    return parse_model("maxwell-2").tying(ties)


@pytest.mark.parametrize("ties", TIES)
def test_a_tied_model_is_the_free_one_where_the_ties_are_kept(ties):
    model, free = tied_model(*ties), parse_model("maxwell-2")
    theta = np.array([{**MAXWELLS, "tau2/tau1": 0.2, "tau2/(0.5*tau1)": 0.2}[each.name]
                      for each in model.parameters])  # fmt: skip
    known = dict(zip((each.name for each in model.parameters), theta, strict=True))
    told = followers(model.material, theta)
    known |= {each.parameter.name: each.value for each in told}
    assert [each.text for each in told] == [
        tie for name in free.names for tie in ties if _of(tie) == name
    ]
    exact = free.stiffness(free.vector({name: known[name] for name in free.names}), AT)
    assert model.stiffness(theta, AT) == pytest.approx(exact)
    check_derivatives(model.material, theta, AT)
    for each in told:
        moved = theta * (1.0 + 1e-7)
        [after] = [one for one in followers(model.material, moved) if one.origin == each.origin]
        assert (after.value - each.value) / 1e-7 == pytest.approx(each.slopes @ theta, rel=1e-5)


def _of(tie):
    return re.split("[=<>]", tie)[0].strip()


def test_an_order_holds_its_smaller_one_by_a_share_of_the_larger_one():
    for tie, follows, larger in (
        ("tau2 < tau1", "tau2", "tau1"),
        ("tau1 > tau2", "tau1", "tau2"),
    ):
        node = tied_model(tie).material
        share = next(each for each in node.parameters if each.name == "tau2/tau1")
        assert (share.lower, share.upper, share.scale) == (0.0, 1.0, "log")
        names = [each.name for each in node.parameters]
        theta = np.array([{"tau2/tau1": 0.25, larger: 8.0}.get(name, 3.0) for name in names])
        [told] = followers(node, theta)
        assert (told.origin, told.text) == (follows, tie)
        assert told.value == pytest.approx({"tau2": 2.0, "tau1": 32.0}[follows])


@pytest.mark.parametrize(
    ("tau", "share"), [((10.0, 2.0), 0.2), ((10.0, 20.0), 1.0), ((0.0, 0.0), 0.5)]
)
def test_a_start_that_keeps_no_order_begins_at_its_edge(tau, share):
    for tie in ("tau2 < tau1", "tau1 > tau2"):
        node = tied_model(tie).material
        first = started(node, np.array([[3.0, tau[0], 6.0, tau[1]]]))[0]
        known = dict(zip((each.name for each in node.parameters), first, strict=True))
        assert known.pop("tau2/tau1") == share
        assert known == {"k1": 3.0, "k2": 6.0, tie[-4:]: tau[int(tie[-1]) - 1]}


def test_what_a_bound_holds_no_longer_follows():
    node = parse_model("fractional-maxwell-general").tying(["alpha = 2*beta*c1"]).material
    names = [each.name for each in node.parameters]
    for c1, value, slope in ((0.5, 0.4, 0.8), (4.0, 1.0, 0.0)):
        theta = np.array([{"c1": c1, "beta": 0.4}.get(name, 1.0) for name in names])
        [told] = followers(node, theta)
        assert told.value == pytest.approx(value)
        assert told.slopes[names.index("c1")] == pytest.approx(slope)


@pytest.mark.parametrize(
    ("text", "taken", "found"),
    [
        ("a = b", (), [("a", "=", "")]),
        ("a < b < c", (), [("a", "<", "a/b"), ("b", "<", "b/c")]),
        ("a > b > c", (), [("a", ">", "b/a"), ("b", ">", "c/b")]),
        # Of a parameter that is tied already the other one follows.
        ("a < b", ("a",), [("b", ">", "a/b")]),
        ("2 * a < b", (), [("b", ">", "(2*a)/b")]),
        ("a < 2 * b", (), [("a", "<", "a/(2*b)")]),
    ],
)
def test_an_order_is_read_from_either_side(text, taken, found):
    ties = ties_of(text, ["a", "b", "c"], taken)
    assert [(tie.name, tie.sign, tie.share) for tie in ties] == found


@pytest.mark.parametrize(
    "text", ["a = b = c", "a < b > c", "a = ", "a", "a = 2", "a = d", "a = i*b"]
)
def test_what_is_no_tie_is_refused(text):
    with pytest.raises(ModelError):
        list(ties_of(text, ["a", "b", "c"]))


@pytest.mark.parametrize(
    ("ties", "told"),
    [
        (["k1 = k2", "k2 = k1"], "circle"),
        (["k1 = k2", "k1 = 2*k2"], "tied already"),
        (["k1 < tau1"], "different units"),
    ],
)
def test_ties_that_leave_nothing_free_or_compare_units_are_refused(ties, told):
    with pytest.raises(ModelError, match=told):
        tied_model(*ties)


def test_ties_of_a_part_are_those_that_name_it():
    assert part_of("m.a = 2*m.b", ["m", "n"]) == "m"
    assert part_of("k = 2*c", ["m", "n"]) == ""
    assert part_of("m.a = pi*exp(m.b)", ["m", "n"]) == "m"
    for text in ("m.a = 2*n.b", "m.a = 2*k"):
        with pytest.raises(ModelError, match="several parts"):
            part_of(text, ["m", "n"])


def test_each_level_follows_its_own():
    node = owned(tied_model("k2 = 2*k1").material, ["k1"], "temperature")
    node = node.bound_to(Points.at(np.ones(2), temperature=[10.0, 30.0]))
    names = [each.name for each in node.parameters]
    theta = np.array([{"k1_10": 3.0, "k1_30": 4.0}.get(name, 1.0) for name in names])
    told = followers(node, theta)
    assert [(each.parameter.name, each.value) for each in told] == [("k2_10", 6.0), ("k2_30", 8.0)]
    for each, name in zip(told, ("k1_10", "k1_30"), strict=True):
        # By the parameters of its own level, and by no other one's.
        mine = [names[i] for i in each.at.tolist()]
        assert len(mine) == len(names) - 1
        assert each.slopes.tolist() == [2.0 * (other == name) for other in mine]
        assert each.follow(5.0 * theta[each.at]) == 5.0 * each.value
    assert ties_in(node) == ("k2 = 2*k1",)
    assert ties_in(untied(node)) == ()


def test_a_tie_of_what_is_held_moves_by_what_is_free():
    model = tied_model("k2 = 2*k1").holding({"tau1": 5.0})
    [told] = followers(model.material, np.array([3.0, 0.1]))
    assert (told.value, told.slopes.tolist()) == (6.0, [2.0, 0.0])
    assert started(model.material, np.array([3.0, 5.0, 9.0, 0.1])).tolist() == [3.0, 0.1]


def test_the_unit_of_a_constant_names_the_order_that_is_left():
    node = parse_model("fractional-maxwell-general").tying(["alpha = beta"]).material
    assert {each.unit.time for each in node.parameters if each.name.startswith("c")} == {"beta"}
