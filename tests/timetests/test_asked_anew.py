"""Effects are asked anew from the data, and the model alone from where the best one has led it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.errors import ModelError
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

        starts = list

    anew = SimpleNamespace(left=SimpleNamespace(squares_left=310.0))
    monkeypatch.setattr(screening, "TimeSearch", Search)
    monkeypatch.setattr(screening, "_near_fit", lambda *given: anew)
    monkeypatch.setattr(screening, "_near", lambda each, best, before, noise: each is best)
    nearly = [tried("mode", 300.0), tried("slow", 500.0), tried("absent", 899.9)]
    nearly[0].left.misfit = misfit
    found = screening.from_the_data(TESTS, base, nearly, SimpleNamespace(squares_left=900.0))
    assert [each.left.squares_left for each in found] == told
    assert [next(name for name in one if name.endswith(".size")) for one in asked] == [
        f"{name}.size" for name in sought
    ]


def test_an_effect_to_which_the_exact_response_is_no_number_does_not_lead(monkeypatch):
    """It stood first of all, and none of the others was fitted exactly."""
    search = SimpleNamespace(
        near=lambda parts, begun: (CAUGHT, 1), theta=np.copy, model=MODEL, reference=1.0
    )
    left = SimpleNamespace(residuals=[np.array([0.0, np.nan])])
    monkeypatch.setattr(screening.FitResiduals, "by", lambda *_: left)
    with pytest.raises(ModelError, match="maxwell cannot be followed"):
        screening._near_fit(TESTS, tried("basset", 1.0).effect, search, [], [])
