"""How models are sorted out, each rule at both sides of its edge, on judgements by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.comparison import comparing, result
from springpot.thresholds import COMPARISON, SEARCH, VERDICT


def judged(name, bic=0.0, size=2, adequate=True, beside=1.0, rms=0.01, floor=0.01, points=20):
    """A judgement of a model, and the chance of what a spectrum gains on it."""
    ranked = SimpleNamespace(
        theta=np.zeros(size), beside=beside, floor=floor, least_error=0.0, relative_rms=1.0,
        numbers=2 * points,
    )  # fmt: skip
    error = SimpleNamespace(relative_rms=rms, noise_floor=floor)
    return SimpleNamespace(
        name=name, delta_bic=bic, adequate=adequate, at_noise=adequate, computed=False,
        ranked=ranked, error=error,
    )  # fmt: skip


@pytest.fixture
def sort(monkeypatch):
    """Sorts judgements beside a floor of any material that is adequate or not."""

    def sorted_out(rows, material=True, far=False):
        monkeypatch.setattr(comparing, "chance_beside", lambda found, floor: found.beside)
        rest = VERDICT.small_rest * 0.01
        error = SimpleNamespace(relative_rms=rest if far else 0.99 * rest)
        ranked = SimpleNamespace(floor=0.01)
        whole = SimpleNamespace(adequate=material, error=error, ranked=ranked)
        order = comparing.in_order(rows, whole)
        names = [[one.name for one in kind] for kind in order[:3]]
        return (*names, order.outgrown)

    return sorted_out


def test_the_simplest_adequate_comes_first_and_of_alike_the_likelier(sort):
    rows = [judged("rich", 0.0, 5), judged("late", 3.0, 2), judged("early", 1.0, 2)]
    assert sort(rows) == (["early", "late", "rich"], [], [], False)


def test_inadequate_ones_are_near_where_any_material_is_inadequate_too(sort):
    rows = [judged("a", adequate=False), judged("b", 1.0, beside=0.0)]
    assert sort(rows, material=False) == ([], ["a"], ["b"], False)
    assert sort(rows, material=True) == ([], [], ["a", "b"], True)
    # Where any material is far beyond the floor, no smaller noise is to blame.
    assert sort(rows, material=True, far=True) == ([], [], ["a", "b"], False)


def test_a_chance_of_its_own_is_as_near(sort):
    edge = COMPARISON.chance
    assert sort([judged("a", beside=edge)])[0] == ["a"]
    assert sort([judged("a", beside=0.99 * edge)])[2] == ["a"]


def test_the_floor_is_outgrown_where_simpler_ones_are_beyond_it(sort):
    rows = [judged("simple", 1.0, 2, False, rms=0.05), judged("rich", 0.0, 3)]
    assert sort(rows, material=False) == (["rich"], ["simple"], [], True)
    # As many parameters as half of the numbers, or more.
    most = int(COMPARISON.most_spent * 2 * 20)
    assert sort([judged("a", size=most)])[3] is False
    assert sort([judged("a", size=most + 1)])[3] is True


def test_a_richer_model_outdoes_one_where_it_is_decisively_better():
    one = judged("one", SEARCH.decisive, 2)
    others = {
        "better": judged("b", -0.01, 3),
        "not decisive": judged("b", 0.0, 3),
        "as simple": judged("b", -9.0, 2),
        "spends most": judged("b", -9.0, 30),
    }
    found = {name: comparing._outdone(one, [other]) for name, other in others.items()}
    assert found == {
        "better": True, "not decisive": False, "as simple": False, "spends most": False,
    }  # fmt: skip
    # Of one that is not at the noise, what it misses may be more than noise.
    one.at_noise = False
    assert comparing._outdone(one, [others["spends most"]])
    one.computed = True
    assert not comparing._outdone(one, [others["better"]])


def test_simpler_and_nearer_is_by_the_error_over_the_floor():
    one = judged("one", size=3, rms=0.02, floor=0.01)
    for other, both in (
        (judged("o", size=3, rms=0.04, floor=0.02), True),
        (judged("o", size=4, rms=0.01, floor=0.02), False),
        (judged("o", size=2, rms=0.041, floor=0.02), False),
        (judged("o", size=2, rms=0.01, floor=0.0), False),
        (judged("o", size=2, rms=0.0, floor=0.0), True),
    ):
        assert comparing._is_simpler_and_nearer(other, one) == both


@pytest.mark.parametrize(
    ("rss", "dof", "floor_rss", "floor_dof", "squares", "spare"),
    [
        (30.0, 20, 10.0, 15, 20.0, 5),
        (30.0, 20, 30.0, 15, 0.0, 5),
        (10.0, 20, 30.0, 15, 0.0, 5),
        (90.0, 20, 30.0, 15, 30.0, 5),
        (90.0, 15, 30.0, 15, 30.0, 1),
        (90.0, 3, 30.0, 0, 2.0, 3),
    ],
)
def test_what_a_spectrum_gains_is_told_in_units_of_what_it_leaves(
    rss, dof, floor_rss, floor_dof, squares, spare, monkeypatch
):
    asked = []
    monkeypatch.setattr(comparing, "chance_of_squares", lambda *given: asked.append(given))
    found = SimpleNamespace(rss=rss, dof=dof, noise_dof=7.0)
    floor = SimpleNamespace(rss=floor_rss, dof=floor_dof)
    comparing.chance_beside(found, floor)
    assert asked == [(pytest.approx(squares), spare, 7.0)]


def test_curves_are_grouped_by_the_first_of_each(monkeypatch):
    monkeypatch.setattr(result, "_distance", lambda one, other: abs(one.at - other.at))
    step = 0.6 * COMPARISON.alike
    rows = [SimpleNamespace(at=i * step) for i in range(4)]
    found = result.grouped(rows)
    assert [[round(one.at / step) for one in group] for group in found] == [[0, 1], [2, 3]]
    edge = [SimpleNamespace(at=0.0), SimpleNamespace(at=COMPARISON.alike)]
    assert len(result.grouped(edge)) == 2


def test_members_of_a_family_are_tried_until_one_lacks_nothing_or_gains_nothing(monkeypatch):
    def tried(evidence, chances, largest=9):
        monkeypatch.setattr(comparing, "chance_beside", lambda found, floor: found.chance)

        def one(number, effects):
            i = number - 2
            yield SimpleNamespace(number=number, log_evidence=evidence[i], chance=chances[i])

        family = SimpleNamespace(name="a", largest=largest, build=lambda number: number)
        floor = SimpleNamespace(model=SimpleNamespace(effects=()))
        found = comparing.fits_of([family], floor, one, lambda told: None)
        return [each.number for each in found]

    low, edge = [0.0] * 5, COMPARISON.chance
    assert tried([1.0, 2.0, 3.0, 4.0, 5.0], low) == [2, 3, 4, 5, 6]
    assert tried([1.0, 2.0, 3.0, 4.0, 5.0], low, 4) == [2, 3, 4]
    assert tried([1.0, 2.0, 2.0, 4.0, 5.0], low) == [2, 3, 4]
    assert tried([1.0, 2.0, 3.0, 4.0, 5.0], [0.0, edge, 0.0, 0.0, 0.0]) == [2, 3]


@pytest.mark.parametrize(
    ("one_test", "course", "told"), [("3", None, "why"), ("3", 1.0, ""), ("", None, "")]
)
def test_one_test_is_told_unless_the_ladder_told_what_goes_with_the_time(
    one_test, course, told, monkeypatch
):
    monkeypatch.setattr(comparing, "column_behind", lambda frame: "temperature")
    monkeypatch.setattr(comparing, "one_test_of", lambda raw, column: ("3", f"why {column}"))
    best = SimpleNamespace(data=SimpleNamespace(raw=None), frame=lambda: None)
    case = SimpleNamespace(course=course, naming=SimpleNamespace(best=best))
    steps = [SimpleNamespace(case=None), SimpleNamespace(case=case)]
    ladder = SimpleNamespace(steps=steps, diagnosis=SimpleNamespace(one_test=one_test))
    assert comparing._of_one_test(ladder) == (told and f"{told} temperature")
