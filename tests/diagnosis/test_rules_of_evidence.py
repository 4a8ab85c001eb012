"""Rules of evidence, of places and of further measurements, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis import answer, evidence, experiment, grown as growing, marginal
from springpot.measurement import Measurement
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

KEPT = 1.0 - EVIDENCE.other_shape
"""Of what may be of another shape."""


def weighed(*sets):
    """Evidence of sets of effects (names ..., chance)."""
    explanations = [SimpleNamespace(names=tuple(names), probability=p) for *names, p in sets]
    leader = explanations[0].names[0]
    rivals = {one.names[0]: one.probability for one in explanations if len(one.names) == 1}
    return SimpleNamespace(explanations=explanations, leader=leader, rivals=rivals)


@pytest.mark.parametrize(
    ("sets", "instead"),
    [
        ([("a", 0.5), ("b", "c", 0.4), ("d", 0.1)], ("b", "c")),
        ([("a", 0.5), ("a", "c", 0.4), ("d", 0.1)], ()),
        ([("a", 0.9), ("d", 0.06), ("b", "c", 0.04)], ()),
        ([("a", 0.5), ("e", 0.3), ("b", "c", 0.2)], ("b", "c")),
    ],
)
def test_several_effects_stand_in_place_of_fewer_where_they_hold_enough(sets, instead):
    """Another of as many is a rival, and none of several."""
    assert vars(evidence.Evidence)["instead"].func(weighed(*sets)) == instead


@pytest.mark.parametrize(
    ("verdict", "ripple", "bands", "told"),
    [
        ("unexplained", 0.9, 0, 1),
        ("unexplained", 1.1, 0, 0),
        ("unexplained", 0.9, 2, 2),
        ("effect-missing", 0.9, 0, 0),
        ("adequate", 0.9, 2, 0),
    ],
)
def test_what_only_a_period_shows_has_a_place_where_nothing_else_has(
    monkeypatch, verdict, ripple, bands, told
):
    monkeypatch.setattr(answer, "where", lambda frame: ["band"] * bands)
    monkeypatch.setattr(answer, "periodic", lambda frame: "period")
    parts = {"ripple": ripple * VERDICT.structure_alarm}
    search = SimpleNamespace(frame=None, structure=SimpleNamespace(parts=parts))
    point = SimpleNamespace(place="point")
    found = list(answer._places(search, [point], verdict))
    # The first is told beside the effect that explains it, which a point set aside is not.
    assert found == [*(["band"] * told if bands else ["period"] * told), "point"]


@pytest.mark.parametrize(("counts", "shapes"), [((4, 4, 4), 2), ((4, 4, 3), 0), ((9, 9), 0)])
def test_levels_have_shapes_of_their_own_where_each_has_four_points(counts, shapes):
    level = np.repeat(np.arange(len(counts)), counts)
    measured = SimpleNamespace(
        conditions={"water": level.astype(float)}, levels=lambda name: level, __len__=None
    )
    found = marginal._own_levels(SimpleNamespace(measurement=measured), "water")
    assert found.shape == (shapes, len(level))
    for i, shape in enumerate(found, 1):
        np.testing.assert_array_equal(shape, level == i)


@pytest.mark.parametrize(
    ("known", "named", "narrow", "other"),
    [
        ({}, {"a": 0.5, "b": 0.5, "c": 0.2}, 0.0, 0.0),
        ({"beside_material": True}, {"a": 0.5, "b": 0.3 + 0.2 * KEPT, "c": 0.2 * KEPT}, 0.0, 0.2),
        ({"one_frequency": True}, {"a": 0.5, "b": 0.3 + 0.2 * KEPT, "c": 0.2 * KEPT}, 0.0, 0.2),
        ({"moved": {"a"}}, {"a": 0.5 * KEPT, "b": 0.5, "c": 0.2}, 0.0, 0.5),
        ({"drift": "a"}, {"a": 0.5 * KEPT, "b": 0.5, "c": 0.2}, 0.0, 0.5),
        ({"untold": "a"}, {"a": 0.5 * KEPT, "b": 0.5, "c": 0.2}, 0.0, 0.5),
        ({"imitators": {"a"}}, {"a": 0.5 * KEPT, "b": 0.5, "c": 0.2}, 0.5, 0.0),
        (
            {"imitators": {"c"}, "leaning": {"b"}},
            {"a": 0.5, "b": 0.3 + 0.2 * KEPT, "c": 0.2 * KEPT},
            0.2,
            0.0,
        ),
        (
            # The same doubt is not charged twice.
            {"imitators": {"a"}, "moved": {"a"}},
            {"a": 0.5 * KEPT, "b": 0.5, "c": 0.2},
            0.0,
            0.5,
        ),
    ],
)
def test_what_may_be_of_another_shape_is_believed_less(monkeypatch, known, named, narrow, other):
    """A: 0.5, b: 0.3, b and c together: 0.2; what is doubted is something else."""
    sets = [(("a",), 0.5), (("b",), 0.3), (("b", "c"), 0.2)]
    explanations = tuple(
        SimpleNamespace(names=names, probability=p, twice=False, one_spectrum=False)
        for names, p in sets
    )
    monkeypatch.setattr(
        evidence, "at_one_frequency", lambda data: known.get("one_frequency", False)
    )
    search = SimpleNamespace(base=SimpleNamespace(fit=SimpleNamespace(measurement=None)))
    of = {
        name: SimpleNamespace(effect=known[name]) for name in ("drift", "untold") if name in known
    }
    of |= {name: frozenset(known.get(name, ())) for name in ("imitators", "leaning", "moved")}
    found = evidence.Evidence(
        search, 0.0, 0.0, explanations, beside_material="beside_material" in known, **of
    )
    assert found.effects == pytest.approx(named)
    assert found.narrow == pytest.approx(EVIDENCE.other_shape * narrow)
    assert found.other_shape == pytest.approx(EVIDENCE.other_shape * other)


@pytest.mark.parametrize(
    ("value", "vanishes", "limit"),
    [
        (8.0, 0.0, True),
        (8.0 * (1.0 - 0.9 * SEARCH.near_an_end), 0.0, True),
        (8.0 * (1.0 - 1.1 * SEARCH.near_an_end), 0.0, False),
        (2.0, 0.0, True),
        (2.0, 2.0, False),
        (2.0 * (1.0 + 0.9 * SEARCH.near_an_end), 8.0, True),
        (5.0, 0.0, False),
    ],
)
def test_a_size_rests_on_a_bound_at_which_it_does_not_vanish(monkeypatch, value, vanishes, limit):
    monkeypatch.setattr(growing, "size_of", lambda model, theta, effect: value)
    fitted = SimpleNamespace(model=None, theta=None)
    size = SimpleNamespace(lower=2.0, upper=8.0)
    effect = SimpleNamespace(element=SimpleNamespace(parameters=(size,)), vanishes_at=vanishes)
    assert growing.at_its_limit(fitted, effect) is limit
    size.upper = np.inf
    assert growing.at_its_limit(fitted, effect) is (limit and value < 5.0)


@pytest.mark.parametrize(
    ("hertz", "ends", "says"),
    [
        ([2.0], [(0.2, 20.0)], ["a sweep of frequencies: 20 points from 0.2 to 20 Hz"]),
        (
            [0.5, 1.0, 2.0],
            [(5.0, 20.0), (0.05, 0.2), (0.5, 2.0)],
            ["upwards: 20 points from 5 to 20 Hz", "downwards: 20 points from 0.05 to 0.2 Hz",
             "the same frequencies more densely: 12 points from 0.5 to 2 Hz"],
        ),
        (np.geomspace(0.5, 2.0, 400), [(5.0, 20.0), (0.05, 0.2)], ["upwards", "downwards"]),
    ],
)  # fmt: skip
def test_further_frequencies_are_a_decade_beyond_or_four_times_as_dense(hertz, ends, says):
    data = Measurement(2.0 * np.pi * np.array(hertz), np.full(len(hertz), 3.0 + 1.0j))
    found = list(experiment._frequencies(data))
    assert [words in each.says for each, words in zip(found, says, strict=True)] == [True] * len(
        says
    )
    for each, (low, high) in zip(found, ends, strict=True):
        asked = np.array(each.action["omega"]) / (2.0 * np.pi)
        assert (asked[0], asked[-1]) == pytest.approx((low, high))
        np.testing.assert_allclose(np.exp(each.points.log_omega), each.action["omega"])
    if len(found) == 3:
        # A dense one has nobody wait, and takes as long as it has points.
        assert found[2].effort == pytest.approx(experiment.TYPED_IN + 12 / 80)
        assert len(found[2].action["omega"]) == 12


def test_a_leader_stands_beside_itself_only_where_a_second_one_is_likely():
    found = weighed(("a", "b", 0.95))
    found.same_curve = lambda best: [["x"], ["a", "c"]]
    for partners, beside in (({"b": 0.9}, ["b", "c"]), ({"a": 0.9}, ["a", "c"])):
        found.partners = partners
        assert evidence.Evidence.beside.fget(found) == beside
