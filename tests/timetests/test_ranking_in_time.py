"""Installed models of tests in time in order: with what any material needs, the simplest first."""

import json

import numpy as np
import pytest

import springpot
from springpot.comparison import Ranking
from springpot.errors import DataError
from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests.comparing import rank

NAMES = ("spring", "maxwell", "zener", "fractional-zener", "fractional-maxwell", "material")
FAMILIES = [each for each in plugins().items("model") if each.name == "maxwell-N"]
INSTALLED = [*map(parse_model, NAMES), *FAMILIES]


def ramped(rise=0.4, noise=0.006):
    """Relaxation of a standard solid after a ramp: exact means of 200 + 500 exp(-t / 3 s) kPa."""
    t = np.concatenate([np.linspace(0.05, 0.4, 8), np.geomspace(0.45, 60.0, 32)])

    def area(t):
        t = np.maximum(t, 0.0)
        return 200.0 * t + 1500.0 * (1.0 - np.exp(-t / 3.0))

    stress = (area(t) - area(t - rise)) / rise if rise else 200.0 + 500.0 * np.exp(-t / 3.0)
    scatter = 1.0 + noise * np.random.default_rng(7).normal(size=len(t))
    return TimeTest.of_relaxation(t, stress * scatter, "kPa", name="ramped")


@pytest.fixture(scope="module")
def plain():
    return rank([ramped(rise=0.0)], INSTALLED, [])


@pytest.mark.soak
def test_the_simplest_that_does_what_any_material_does_comes_first(plain):
    assert plain.best.model.name == "zener"
    assert [one.model.name for one in plain.adequate][1:] == ["fractional-zener", "maxwell-2"]
    assert {one.model.name for one in plain.next} == {"spring", "maxwell", "fractional-maxwell"}
    assert plain.says.endswith("as well as any material does is zener")
    assert min(one.delta_bic for one in plain.judgements) == 0.0
    assert plain.best.error.material_floor <= plain.best.error.relative_rms
    # Any material is what the others are held against.
    assert "material" not in {one.model.name for one in plain.judgements}


def test_curves_that_the_noise_cannot_tell_apart_are_one_group(plain):
    assert [[one.model.name for one in group] for group in plain.groups] == [
        ["zener", "fractional-zener", "maxwell-2"]
    ]


def test_a_ranking_is_kept_and_told_again(plain, tmp_path):
    path = tmp_path / "ranking.json"
    path.write_text(json.dumps(plain.to_dict(), allow_nan=False), encoding="utf-8")
    again = springpot.load(path)
    assert isinstance(again, Ranking)
    assert (str(again), again.to_dict()) == (str(plain), plain.to_dict())


@pytest.mark.soak
def test_what_no_material_does_is_found_first_and_stands_beside_all():
    found = rank([ramped()], INSTALLED[1:3], [plugins().effect("finite-ramp")])
    assert found.best.model.name == "zener + finite-ramp"
    assert found.best.parameters["finite-ramp.rise"].value == pytest.approx(0.4, rel=0.02)
    assert all("finite-ramp" in one.model.name for one in found.judgements)


def test_what_cannot_be_fitted_is_named_as_skipped():
    found = rank([ramped(rise=0.0)], [parse_model("zener + arrhenius-shift"), INSTALLED[2]], [])
    [skipped] = found.skipped
    assert skipped.model == "zener + arrhenius-shift"
    assert "temperature" in skipped.reason


def test_a_handful_of_samples_makes_no_model_adequate():
    few = TimeTest.of_relaxation([1.0, 2.0, 3.0], [5.0, 4.0, 3.5], "kPa", name="few")
    with pytest.raises(DataError, match="few: 3 samples judge no model"):
        rank([few], INSTALLED[:3], [])
    [alone] = springpot.compare(few, "spring").judgements
    assert alone.unclear
    assert "cannot tell" in alone.says
    t = np.array([0.1, 0.3, 1.0, 3.0, 10.0])
    short = TimeTest.of_relaxation(t, 5.0 + 3.0 * np.exp(-t), "kPa")
    assert rank([short], INSTALLED[:3], []).adequate == ()
