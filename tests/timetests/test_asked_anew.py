"""Effects are asked anew from where the best one has led the model, and so is the model alone.

Beside the best one they are asked what of its noise is theirs.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.identification.result import Identification
from springpot.registry import parse_model
from springpot.timetests import diagnosis, screening
from springpot.timetests.discovery import TimeSets
from springpot.timetests.hypotheses import AskedTests

MODEL = parse_model("maxwell")
CAUGHT, LED = np.array([1.0, 1e9]), np.array([5.0, 7.0])
"""Where the model's own fit was caught, a parameter at its end, and where an effect has led it."""

TESTS = AskedTests([], [], [], None, [], {})


def tried(name, squares, theta=LED):
    """An effect with what it leaves, and the model's parameters beside it."""
    names = [*MODEL.names, f"{name}.size"]
    grown = SimpleNamespace(named=lambda theta: dict(zip(names, theta.tolist(), strict=True)))
    left = SimpleNamespace(squares_left=squares, misfit=False)
    return SimpleNamespace(
        effect=SimpleNamespace(name=name),
        model=grown,
        theta=np.r_[theta, 2.0],
        left=left,
        leaves=300.0,
    )


@pytest.fixture
def base():
    fields = dict.fromkeys(Identification.__dataclass_fields__)
    return Identification(**fields | {"model": MODEL, "theta": CAUGHT, "reference": 1.0})


@pytest.fixture(autouse=True)
def plain_weights(monkeypatch):
    for room in (screening, diagnosis):
        monkeypatch.setattr(room, "bic_of", lambda left: left.squares_left)
        monkeypatch.setattr(room, "noise_of_best", lambda before, best: None)
        monkeypatch.setattr(
            room,
            "delta_bic",
            lambda before, left, noise: before.squares_left - left.squares_left,
        )


def asked_anew(monkeypatch, base, first, better, promised=None):
    """Effects asked anew, each with the parameters from which it was asked."""
    scanned = [*first, *better]
    asked = []

    def fitted(tests, there, leading, before):
        names = [entries[0].effect.name for entries in leading]
        asked.extend((name, there.theta.tolist()) for name in names)
        return [each for each in better if each.effect.name in names]

    monkeypatch.setattr(screening, "TimeScan", lambda there, quick: SimpleNamespace(entries=list))
    monkeypatch.setattr(screening.FitResiduals, "by", lambda *given: None)
    monkeypatch.setattr(
        screening, "leading_of_scan", lambda found, left: [[each] for each in scanned]
    )
    monkeypatch.setattr(screening, "approximately_fitted", fitted)
    before = SimpleNamespace(squares_left=900.0)
    found = screening.from_the_best(TESTS, base, first, before, promised)
    return asked, [each.effect.name for each in found]


def test_what_a_parameter_at_its_end_hid_is_found_where_the_best_one_led(monkeypatch, base):
    asked, found = asked_anew(
        monkeypatch, base, [tried("mode", 400.0)], [tried("friction", 340.0, LED)]
    )
    assert found == ["friction"]
    assert asked[0] == ("friction", LED.tolist())


@pytest.mark.parametrize(("before", "names"), [(301.0, ["slow"]), (300.0, [])])
def test_what_had_promised_as_much_is_not_fitted_again(monkeypatch, base, before, names):
    first = [tried("mode", 400.0), tried("slow", 500.0)]
    promised = {"slow": [SimpleNamespace(leaves=before)]}
    asked, _ = asked_anew(monkeypatch, base, first, [], promised)
    assert [name for name, _ in asked] == names


def test_each_effect_is_asked_anew_once(monkeypatch, base):
    asked, _ = asked_anew(monkeypatch, base, [tried("mode", 400.0)], [tried("drift", 850.0)])
    assert [name for name, _ in asked] == ["drift"]


def test_nothing_is_asked_anew_where_no_effect_explains_anything(monkeypatch, base):
    asked, _ = asked_anew(monkeypatch, base, [tried("mode", 899.0)], [tried("drift", 850.0)])
    assert asked == []


@pytest.mark.parametrize(
    ("alone", "better"),
    [
        ([895.0], True),
        ([900.0], False),
        # One test against another is no other minimum.
        ([600.0, 150.0], True),
        ([500.0, 201.0], False),
    ],
)
def test_the_model_alone_is_fitted_from_where_an_effect_led_it(monkeypatch, base, alone, better):
    begun = []

    def identify(tests, model, *, seeds, thorough, noise):
        begun.extend(seed.tolist() for seed in seeds)
        return base

    def left(*squares):
        residuals = tuple(np.array([np.sqrt(each)]) for each in squares)
        return SimpleNamespace(squares_left=sum(squares), residuals=residuals)

    monkeypatch.setattr(diagnosis, "identify", identify)
    monkeypatch.setattr(diagnosis.FitResiduals, "by", lambda *given: left(*alone))
    before = left(*[900.0, 200.0][: len(alone)])
    found = diagnosis._better_start(TESTS, base, before, [tried("friction", 700.0)])
    assert begun == [LED.tolist()]
    assert (found is not None) == better


@pytest.mark.parametrize(("there", "chosen"), [(50.0, 50.0), (150.0, 100.0)])
def test_a_smaller_set_stands_where_the_larger_led_it_if_that_is_better(monkeypatch, there, chosen):
    a, b = SimpleNamespace(name="a"), SimpleNamespace(name="b")
    sets = TimeSets(None, None)
    sets.add(SimpleNamespace(key=("a",), effects=(a,), cost=100.0, fit="caught"))
    left = SimpleNamespace(key=("a",), effects=(a,), cost=there, fit=None)
    monkeypatch.setattr(TimeSets, "_left_there", lambda self, best, effect: left)
    assert sets._without(SimpleNamespace(effects=(a, b)), b).cost == chosen


@pytest.mark.parametrize(
    ("best", "misfit", "beside", "told"),
    [
        # Friction explains what passed for noise beside a mass.
        (400.0, False, 300.0, 300.0),
        (400.0, False, 395.0, 400.0),
        # Of a misfit that is seen, and where nothing explains anything, the noise is told already.
        (400.0, True, 300.0, 400.0),
        (895.0, False, 300.0, 895.0),
    ],
)
def test_what_another_effect_explains_is_no_noise(monkeypatch, base, best, misfit, beside, told):
    first, second = tried("inertia", best), tried("friction", beside)
    first.left.misfit = misfit
    monkeypatch.setattr(screening, "TimeScan", lambda there, quick: SimpleNamespace(entries=list))
    monkeypatch.setattr(screening, "leading_of_scan", lambda found, left: [[second]])
    monkeypatch.setattr(screening, "approximately_fitted", lambda *given, starts: [second])
    before = SimpleNamespace(squares_left=900.0)
    assert screening.least_left(TESTS, base, [first], before).squares_left == told


def test_without_an_effect_the_model_itself_tells_the_noise(base):
    before = SimpleNamespace(squares_left=900.0)
    assert screening.least_left(TESTS, base, [], before) is before


@pytest.mark.parametrize(
    ("misfit", "told", "sought"),
    [(False, [300.0, 310.0, 899.9], ["slow"]), (True, [300.0, 500.0, 899.9], [])],
)
def test_what_helps_less_than_an_explanation_is_sought_from_the_data(
    monkeypatch, base, misfit, told, sought
):
    """Where nothing explains the tests no rival is held back, and what does not help stays so."""
    asked = []

    class Search:
        def __init__(self, model, parts, reference, seeds):
            asked.append(model.named(seeds[0]))

        starts, theta = list, staticmethod(lambda u: u)
        near = staticmethod(lambda parts, starts: (LED, 1))

    monkeypatch.setattr(screening, "TimeSearch", Search)
    monkeypatch.setattr(screening, "_near", lambda each, best, before, noise: each is best)
    monkeypatch.setattr(
        screening.FitResiduals, "by", lambda *given: SimpleNamespace(squares_left=310.0)
    )
    monkeypatch.setattr(
        screening, "replace", lambda each, **new: SimpleNamespace(**{**vars(each), **new})
    )
    nearly = [tried("mode", 300.0), tried("slow", 500.0), tried("absent", 899.9)]
    nearly[0].left.misfit = misfit
    found = screening.from_the_data(TESTS, base, nearly, SimpleNamespace(squares_left=900.0))
    assert [each.left.squares_left for each in found] == told
    assert [next(name for name in one if name.endswith(".size")) for one in asked] == [
        f"{name}.size" for name in sought
    ]
