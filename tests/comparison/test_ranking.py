"""Models ranked without being named: the simplest that does what any material can comes first."""

import json
import pickle

import numpy as np
import pytest

import springpot
from springpot.comparison import Ranking, comparing, rank
from springpot.comparison.comparing import chance_beside, spends_most
from springpot.comparison.result import grouped
from springpot.errors import DataError
from springpot.measurement import Measurement, Units
from springpot.misfit.floor import beyond_floor
from springpot.report.text import jsonable
from springpot.report.told import told
from springpot.thresholds import COMPARISON, SEARCH

OMEGA = 2.0 * np.pi * np.geomspace(0.3, 30.0, 25)
SMALL = [
    springpot.parse_model(name)
    for name in (
        "kelvin",
        "springpot",
        "fractional-maxwell",
        "fractional-zener",
        "prony-3",
        "fractional-maxwell + friction",
        "kelvin + time-delay",
    )
]


def measured(expression, theta, seed=3, level=0.005, omega=OMEGA):
    model = springpot.parse_model(expression)
    exact = model.stiffness(np.array(theta), omega)
    rng = np.random.default_rng(seed)
    scatter = rng.normal(size=len(omega)) + 1j * rng.normal(size=len(omega))
    return Measurement(omega, exact * (1 + level * scatter), units=Units("kN/m", "mm"), name="made")


def ranked(data, installed=SMALL, effects=("inertia", "time-delay"), seed=0):
    library = [springpot.registry.plugins().effect(name) for name in effects]
    return rank(data, installed, library, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def heavy():
    return ranked(measured("fractional-maxwell + inertia", [400.0, 60.0, 0.55, 6e-3]))


def test_the_truth_comes_first_with_what_no_material_can_do_without(heavy):
    assert heavy.best.model.name == "fractional-maxwell + inertia"
    assert heavy.best.parameters["inertia.m"].value == pytest.approx(6.0, rel=0.1)
    sizes = [len(one.refit.theta) for one in heavy.adequate]
    assert sizes == sorted(sizes)
    names = {one.model.name for one in heavy.judgements}
    # Without the effect only what no material does by itself.
    assert {"kelvin + inertia", "kelvin + time-delay", "kelvin + time-delay + inertia"} <= names
    assert "kelvin" not in names
    assert not {"kelvin + inertia", "springpot + inertia"} & {
        one.model.name for one in heavy.adequate
    }
    assert min(one.delta_bic for one in heavy.judgements) == 0.0


@pytest.mark.soak
def test_a_ranking_is_kept_drawn_and_told(heavy, tmp_path):
    again = pickle.loads(pickle.dumps(heavy))
    assert jsonable(again) == jsonable(heavy)
    assert str(again) == told(heavy)
    path = tmp_path / "ranking.json"
    path.write_text(json.dumps(heavy.to_dict(), allow_nan=False), encoding="utf-8")
    loaded = springpot.load(path)
    assert loaded.to_dict() == heavy.to_dict()
    assert (repr(loaded), str(loaded)) == (repr(heavy), str(heavy))
    pytest.importorskip("matplotlib")
    assert heavy.plot(tmp_path / "ranking.svg").stat().st_size > 1000


def test_a_richer_model_of_the_same_curve_stands_with_the_simple_one(heavy):
    first = [one.model.name for one in heavy.groups[0]]
    assert first[0] == "fractional-maxwell + inertia"
    assert "fractional-zener + inertia" in first
    assert grouped(heavy.adequate) == heavy.groups
    leaders = [group[0].refit for group in heavy.groups]
    gaps = [
        np.abs((one.stiffness - two.stiffness) / one.noise.sd.real).max() * np.sqrt(2 * len(OMEGA))
        for i, one in enumerate(leaders)
        for two in leaders[:i]
    ]
    assert all(gap >= COMPARISON.alike for gap in gaps)


def test_every_adequate_model_is_as_good_as_any_material(heavy):
    floor = heavy.ladder.steps[-1].case.search.base
    for one in heavy.judgements:
        as_good = chance_beside(one.refit, floor) >= COMPARISON.chance
        outdone = any(
            other.delta_bic < one.delta_bic - SEARCH.decisive
            and len(other.refit.theta) > len(one.refit.theta)
            for other in heavy.judgements
        )
        assert (one in heavy.adequate) == (as_good and not outdone and not beyond_floor(one.refit))


def test_models_that_need_what_was_not_measured_are_named_and_left_out(heavy):
    [one] = [one for one in heavy.skipped if one.model == "fractional-maxwell + friction"]
    assert one.reason == "needs the column amplitude"
    few = measured("kelvin", [1.0, 0.1], omega=OMEGA[:6])
    reasons = {
        one.model: one.reason
        for one in ranked(few, [springpot.parse_model("prony-6"), *SMALL[:2]]).skipped
    }
    assert reasons["prony-6"] == "13 parameters for 6 points"


@pytest.mark.soak
def test_a_passive_material_needs_no_effect():
    ranking = ranked(measured("fractional-zener", [300.0, 200.0, 30.0, 0.4]))
    assert [step.accepted for step in ranking.ladder.steps] == [None]
    assert ranking.best.model.name == "fractional-zener"
    assert {one.model.name for one in ranking.judgements} <= {model.name for model in SMALL}


@pytest.mark.soak
def test_where_nothing_holds_the_nearest_comes_first_and_is_called_so():
    ranking = ranked(measured("fractional-zener", [300.0, 200.0, 30.0, 0.4]), SMALL[:2])
    assert ranking.adequate == ()
    assert ranking.best.delta_bic == 0.0
    assert ranking.says.startswith("no installed model follows these data")
    assert "not enough" in told(ranking)
    assert ranking.shown


def test_the_members_of_a_family_end_where_one_more_says_nothing():
    family = next(
        item for item in springpot.registry.plugins().items("model") if item.name == "prony-N"
    )
    ranking = ranked(measured("zener-2", [100.0, 80.0, 8.0, 120.0, 1.0]), [family])
    assert ranking.best.model.name == "prony-2"
    assert [one.model.name for one in ranking.judgements] == ["prony-2"]


@pytest.mark.soak
def test_members_of_a_family_are_tried_up_to_six_while_each_says_more():
    family = next(
        item for item in springpot.registry.plugins().items("model") if item.name == "prony-N"
    )
    omega = np.geomspace(1e-3, 1e3, 20)
    ranking = ranked(measured("springpot", [100.0, 0.5], omega=omega, level=1e-4), [family], ())
    names = {one.model.name for one in ranking.judgements}
    assert names == {f"prony-{number}" for number in range(2, 7)}


@pytest.mark.soak
def test_the_answer_is_plain_data_and_the_same_for_the_same_seed(heavy):
    row = jsonable(heavy)
    assert row["schema"] == "springpot.comparison/2"
    assert row["best"] == "fractional-maxwell + inertia"
    ranking = row["ranking"]
    assert ranking["accepted"] == ["inertia"]
    assert ranking["adequate"][0] == ranking["classes"][0][0] == row["best"]
    assert ranking["material"]["material_floor"] == pytest.approx(
        row["models"][0]["error"]["material_floor"]
    )
    assert len(row["models"]) == len(heavy.judgements) == 5 + 2
    assert all(0.0 <= model["error"]["material_chance"] <= 1.0 for model in row["models"])
    again = ranked(measured("fractional-maxwell + inertia", [400.0, 60.0, 0.55, 6e-3]))
    assert jsonable(again) == row


def test_the_material_floor_of_a_model_is_that_with_its_own_effects(heavy):
    floors = {one.model.effects: set() for one in heavy.judgements}
    for one in heavy.judgements:
        floors[one.model.effects].add(one.error.material_floor)
    assert all(len(each) == 1 for each in floors.values())
    [bare] = next(found for effects, found in floors.items() if effects[0].name == "time-delay")
    assert bare > 5.0 * heavy.best.error.material_floor
    assert all(one.error.relative_rms >= one.error.material_floor for one in heavy.judgements)


def test_the_text_tells_both_floors_and_the_first_model(heavy):
    text = told(heavy)
    first, _, floors = text.splitlines()[:3]
    assert first == f"made: {heavy.says}"
    assert floors.startswith("noise floor 0.")
    assert "(estimated); material floor 0." in floors
    assert floors.endswith("% without")
    assert "fractional-maxwell + inertia cannot be told from fractional-zener" in text
    assert "  inertia.m = " in text


@pytest.mark.soak
def test_the_error_of_a_model_far_off_is_searched_for_where_it_is_asked_for():
    found = ranked(measured("fractional-maxwell", [400.0, 60.0, 0.55]))
    far = found.judgements[-1]
    assert "error" not in vars(far)
    assert "identified" not in vars(far.refit)
    # Nor is any material: its floor lies below what such a model leaves at least.
    assert far.refit.least_error < far.error.relative_rms
    assert far.error.material_floor < far.refit.least_error


def test_stages_are_told():
    told = []
    library = [springpot.registry.plugins().effect("inertia")]
    data = measured("kelvin", [1.0, 0.1])
    found = rank(data, SMALL[:2], library, np.random.default_rng(0), told.append)
    assert isinstance(found, Ranking)
    assert told[0] == "looking for what is missing from any material"
    assert told[1].startswith("step 0: ")
    assert told[-2:] == ["fitting model 1 of 2: kelvin", "fitting model 2 of 2: springpot"]


def test_data_that_judge_no_model_are_refused():
    few = measured("kelvin", [1.0, 0.1], omega=OMEGA[:3])
    with pytest.raises(DataError, match="points"):
        ranked(few, [springpot.parse_model("prony-6")])


def switched(noise=0.01):
    """A magnetorheological damper at three currents, whose loss alone follows the current."""
    rng = np.random.default_rng(6)
    current, omega = (
        np.repeat([0.0, 1.0, 2.0], 8),
        np.tile(2.0 * np.pi * np.geomspace(0.3, 30.0, 8), 3),
    )
    exact = 20.0 + 1j * omega * 0.5 * (1.0 + 4.0 * current)
    scatter = rng.normal(size=24) + 1j * rng.normal(size=24)
    return Measurement(
        omega,
        exact * (1 + noise * scatter),
        conditions={"current": current},
        units=Units("N/mm", "mm"),
        name="mr",
    )


@pytest.fixture(scope="module")
def mixed():
    return ranked(switched())


@pytest.mark.soak
def test_what_no_material_follows_to_the_noise_makes_no_model_adequate(mixed):
    """It read: the simplest model is kelvin, adequate, 16 x the noise floor."""
    assert mixed.adequate == ()
    assert mixed.near
    assert all(beyond_floor(one.refit) for one in mixed.near)
    assert mixed.best is mixed.near[0]
    says = (
        "is as near as any linear material, but not at the noise: "
        "what is missing is no part of the material"
    )
    assert mixed.says == f"{mixed.best.model.name} {says}"
    text = told(mixed)
    assert "as any material" in text
    assert "adequate  " not in text
    assert jsonable(mixed)["ranking"]["near"] == [one.model.name for one in mixed.near]


@pytest.mark.soak
def test_rows_of_several_tests_are_compared_one_by_one(mixed):
    assert mixed.one_test == "current=0"
    assert any("choose one by '@current=0'" in note for note in mixed.notes)
    given = springpot.compare(switched(), ["kelvin"])
    assert given.one_test == jsonable(given)["one_test"] == "current=0"
    assert any("choose one by '@current=0'" in note for note in given.notes)
    one = switched()
    alone = springpot.compare(
        one.subset(np.flatnonzero(one.conditions["current"] == 0.0)), ["kelvin"]
    )
    assert alone.one_test == ""
    assert not alone.best.fails


@pytest.mark.soak
def test_why_one_test_is_chosen_is_said_where_no_column_is_to_blame(monkeypatch):
    """The ladder has told only how."""
    monkeypatch.setattr(comparing, "column_behind", lambda frame: None)
    found = ranked(switched(), SMALL[:1], ())
    why = "rows of several tests stand together, told apart by current"
    assert any(note.startswith(why) for note in found.notes)


GEL = """
    0.05 66.23 65.21; 0.09978 93.07 86.99; 0.1991 127.9 122.1; 0.3974 180.5 168.4;
    0.7931 244.9 236.6; 1.583 354.7 317.7; 3.159 485.5 461.7; 6.304 686.1 643.9;
    12.58 961 881.9; 25.11 1304 1192; 50.11 1793 1707; 100 2500 2286
"""
"""Omega in rad/s, G' and G'' in Pa: a power law with 1.5 % of artificial noise."""


@pytest.mark.soak
def test_few_numbers_are_not_followed_by_as_many_parameters():
    """It read: the simplest model is kelvin-6, with 13 parameters on 24 numbers."""
    omega, storage, loss = np.array([row.split() for row in GEL.split(";")], dtype=float).T
    data = Measurement(omega, storage + 1j * loss, units=Units("Pa", "-"), name="gel")
    family = next(
        item for item in springpot.registry.plugins().items("model") if item.name == "kelvin-N"
    )
    ranking = ranked(data, [*SMALL, family], effects=("inertia",))
    assert ranking.best.model.name == "springpot"
    assert ranking.best in ranking.adequate
    assert not spends_most(ranking.best.refit)
