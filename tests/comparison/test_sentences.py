"""What is said of a model, and of a ranking, in each case."""

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.comparison import Ranking
from springpot.comparison.result import Judgement
from springpot.measurement import Measurement, Units
from springpot.misfit.error import Error
from springpot.misfit.floor import beyond_floor

NAMED = SimpleNamespace(name="zener")


@pytest.fixture
def says(monkeypatch):
    """The sentence on a model, by its errors and by what its tests found."""
    monkeypatch.setattr(Judgement, "refit", property(lambda self: self.fitted))

    def said(relative_rms, floor, fails=False, dof=40, source="estimated", **known):
        fit = SimpleNamespace(dof=dof, measurement=[0.0] * 20)
        noise = SimpleNamespace(dof=40, source=source)
        found = SimpleNamespace(relative_rms=relative_rms, floor=max(floor, 1e-18), fit=fit)
        found.error = relative_rms
        found.noise, found.error_dof = noise, dof
        told = {"model": NAMED, "fails": fails} | known
        return Judgement.told(found, Error(relative_rms, floor, source), 0.0, told).says

    return said


def test_a_model_is_told_by_its_error_and_by_what_is_left(says):
    assert says(0.01, 0.01) == "error 1 x the noise floor; nothing is left but noise"
    assert says(0.01, 0.01, dof=2) == (
        "error 1 x the noise floor; what is left has no pattern:"
        " these data cannot tell whether something is missing"
    )
    assert says(0.05, 0.01) == (
        "error 5 x the noise floor; what is left has no pattern:"
        " these data cannot tell whether something is missing"
    )
    assert says(0.5, 0.5) == (
        "error 1 x the noise floor; nothing is left but noise,"
        " but noise of 50 % is no good measurement: repeat it"
    )
    assert says(1.5, 0.5).startswith("error 3 x the noise floor; what is left has no pattern")
    assert says(0.02, 0.0).startswith("error 2 %, without a noise floor; ")
    assert says(1e-15, 1e-16).endswith(": that of arithmetic, and nothing is missing")


def test_one_that_fails_is_told_by_three_places_or_by_its_surest_test(says):
    places = [SimpleNamespace(says=f"place {number}") for number in range(4)]
    assert says(0.02, 0.01, True, where=places) == (
        "error 2 x the noise floor; place 0; place 1; place 2"
    )
    tests = [
        SimpleNamespace(says="no", found=False),
        SimpleNamespace(says="scatter", found=True),
        SimpleNamespace(says="runs", found=True),
    ]
    assert says(0.02, 0.01, True, where=(), findings=tests) == (
        "error 2 x the noise floor; scatter"
    )


def test_a_model_that_does_not_fail_fails_nowhere():
    assert Judgement.told(None, Error(0.1, 0.1, "given"), 0.0, {"fails": False}).where == ()


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize("relative_rms", [0.01, 0.05])
def test_adequate_is_an_error_of_noise_in_size_and_in_pattern(says, relative_rms, fails):
    fit = SimpleNamespace(dof=40, measurement=[0.0] * 20)
    found = SimpleNamespace(relative_rms=relative_rms, floor=0.01, fit=fit)
    found.noise, found.error_dof = SimpleNamespace(dof=40, source="estimated"), 40
    one = Judgement.told(found, Error(relative_rms, 0.01, "estimated"), 0.0, {"fails": fails})
    assert one.adequate is (relative_rms == 0.01 and not fails)
    assert one.unclear is (relative_rms == 0.05 and not fails)


def judged(name, relative_rms=0.01, source="estimated"):
    fit, noise = SimpleNamespace(dof=40), SimpleNamespace(dof=40)
    refit = SimpleNamespace(relative_rms=relative_rms, floor=min(relative_rms, 0.01), fit=fit)
    refit.noise, refit.error_dof = noise, 40
    if source == "large":
        refit.floor = relative_rms
    error = Error(relative_rms, refit.floor, "estimated")
    return SimpleNamespace(
        model=SimpleNamespace(name=name), beyond=beyond_floor(refit), error=error,
        says="a pattern", name=name,
    )  # fmt: skip


def ranking(judgements, adequate=0, near=0):
    return Ranking(
        "made",
        tuple(judgements),
        (),
        (),
        "",
        None,
        tuple(judgements[:adequate]),
        tuple(judgements[adequate : adequate + near]),
        (),
    )


def test_a_ranking_is_told_by_its_first_model():
    quiet, far, loud = judged("a"), judged("b", 0.05), judged("c", 0.5, "large")
    assert ranking([quiet, far], 1, 1).says == (
        "the simplest model that follows these data as well as any material does is a"
    )
    assert ranking([far, quiet], 0, 1).says == (
        "b is as near as any linear material, but not at the noise:"
        " what is missing is no part of the material"
    )
    assert ranking([loud], 0, 1).says == (
        "c is as near as any linear material, but noise of 50 % is no good measurement: repeat it"
    )
    assert ranking([quiet], 0, 1).says == "a is as near as any linear material: a pattern"
    for nearest in (loud, quiet):
        assert ranking([nearest]).says == (
            "no installed model follows these data as well as any material does;"
            f" the nearest is {nearest.name}"
        )


def test_beside_the_first_of_each_group_three_further_curves_are_shown():
    rows = [judged(name) for name in "abcdefgh"]
    for level, row in enumerate(rows):
        row.ranked = SimpleNamespace(curve=np.array([10.0 * level]))
    rows[1].ranked, rows[5].ranked = rows[0].ranked, rows[4].ranked
    found = ranking(rows, 2, 1)
    assert [[one.name for one in group] for group in found.groups] == [["a", "b"], ["c"]]
    assert [one.name for one in found.next] == ["d", "e", "g"]
    assert [one.name for one in found.shown] == ["a", "c", "d", "e", "g"]


def sweep(count, **given):
    rng, omega = np.random.default_rng(2), np.geomspace(1.0, 100.0, count)
    scatter = 0.01 * (rng.normal(size=count) + 1j * rng.normal(size=count))
    stiffness = (400.0 + 5j * omega) * (1.0 + scatter)
    return Measurement(omega, stiffness, units=Units("N/m", "m"), name="made", **given)


def test_points_are_counted_where_not_all_were_compared():
    assert springpot.compare(sweep(20), ["kelvin"]).notes == ()


def test_as_many_numbers_as_parameters_judge_no_model():
    with pytest.raises(springpot.errors.DataError) as told:
        springpot.compare(sweep(1), ["kelvin"])
    assert str(told.value) == (
        "made: 1 points cannot judge kelvin, which has 2 parameters; measure at more frequencies"
    )
    assert springpot.compare(sweep(2), ["zener"]).best.degrees_of_freedom == 1
