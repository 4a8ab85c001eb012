"""springpot-60: sixty problems that never change, measured, and raced like any data set."""

from __future__ import annotations

from hashlib import sha256
from importlib import import_module
from importlib.resources import files
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.benchmark import Study, run_study
from springpot.benchmark.plan import problem_of, reference_of
from springpot.benchmark.store import Store
from springpot.benchmark.traits import Features, features_of, parts_of
from springpot.errors import DataError
from springpot.measurement import TimeTest

ROOT = Path(__file__).parents[2]
DESCRIPTION = "2436458add12480f4b77a565a1e3429887717d2a28dd0cf79da44f8f6f8d92d5"

DRAWN = "cd1af1aa4e69183ade9bfde61a96847fae30dc58e2694dc3d083da42349f82fe"
RUGGED = "119fc7389fe411a99d5a0a7f6cd00bfdbf32ed7c666f8df160a97958b001e786"


@pytest.fixture(scope="module")
def suite():
    return springpot.plugins().find("suite", "springpot-60")


@pytest.fixture(scope="module")
def plan():
    return Study("suite", ["springpot-60"], ["own"], ["own"], ["random-search"]).plan()


def problem(case):
    return problem_of(case.source, case.source.model_of(case.model), case.objective)


def test_a_suite_of_that_name_never_changes():
    text = files("springpot_plugins.suites").joinpath("springpot-60.toml").read_bytes()
    assert sha256(text).hexdigest() == DESCRIPTION, "give a changed suite another name"


@pytest.mark.parametrize(
    ("name", "script", "digest", "number"),
    [
        ("springpot-hard-20", "suite_hard", DRAWN, 185),
        ("springpot-rugged-20", "suite_rugged", RUGGED, 1086),
    ],
)
def test_a_drawn_suite_is_what_its_seed_draws_and_what_no_descent_solves(
    name, script, digest, number, monkeypatch
):
    monkeypatch.syspath_prepend(ROOT / "studies")
    study, drawn = import_module(script), import_module("drawn_problems")
    text = files("springpot_plugins.suites").joinpath(f"{name}.toml").read_bytes()
    assert sha256(text).hexdigest() == digest, "give a changed suite another name"
    suite = springpot.plugins().find("suite", name)
    assert {each.features["modality"] for each in suite.measured.values()} == {1.0}
    assert len(suite.problems) == 20
    known = suite.problem(f"{name}/drawn-{number}")
    told, again = drawn.described(known.name, study.SEED, number, study.PROTOCOLS)
    assert study.demanding(told)
    assert (told["model"], told["truth"]) == (known.model, dict(known.truth))
    assert known.tests()[0].digest() == again.tests()[0].digest()


def test_descents_of_every_kind_are_made_until_one_arrives(plan, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "studies")
    import suite_rugged as study

    (case,) = (each for each in plan.cases if each.source.name == "springpot-60/maxwell-exact")
    here, best = problem(case), case.source.best
    goal = best + 1e-6 * (reference_of(here) - best)
    few = list(islice(study.ends(here, goal), 2))
    assert min(few) <= goal
    start = here.lower + 0.5 * (here.upper - here.lower)
    assert study.by_parameters(here, start, goal) <= goal
    assert study.by_parameters(here, start, -np.inf) < goal


def test_sixty_problems_from_two_to_fourteen_parameters(suite, plan):
    sizes = [problem(case).dimension for case in plan.cases]
    assert len(suite.problems) == len({p.name for p in suite.problems}) == 60
    assert (min(sizes), max(sizes)) == (2, 14)
    assert [int(suite.measured[p.name].features["parameters"]) for p in suite.problems] == sizes


def test_tests_of_every_kind_are_in_it(suite):
    tests = {p.name.partition("/")[2]: p.tests() for p in suite.problems}
    in_time = [name for name, each in tests.items() if any(isinstance(t, TimeTest) for t in each)]
    kinds = {t.kind for each in tests.values() for t in each if isinstance(t, TimeTest)}
    columns = {c for each in tests.values() for t in each for c in t.conditions}
    assert len(in_time) == 8
    assert kinds == {"relaxation", "creep", "history"}
    assert columns >= {"amplitude", "specimen", "temperature"}
    assert sum(len(each) > 1 for each in tests.values()) == 2


def test_the_truth_lies_in_the_box_and_is_no_better_than_the_best_known(plan):
    for case in plan.cases:
        if case.known is None:
            continue
        here, truth = problem(case), case.source.truth
        x = here.space.from_theta(here.model.vector(dict(truth)))
        assert np.all(x >= 0.0), case.source.name
        assert np.all(x <= here.upper * (1.0 + 1e-12)), case.source.name
        assert case.source.best <= case.known + 1e-12 * case.reference, case.source.name


def test_a_data_set_of_the_same_name_has_the_same_bits(suite):
    for name in ("springpot-60/prony-5-noisy", "springpot-60/record-jenkins"):
        first, second = (suite.problem(name).tests()[0].digest() for _ in range(2))
        assert first == second
    noisy = suite.problem("springpot-60/sweep-and-relaxation").tests()
    assert len({test.digest() for test in noisy}) == 2


def test_parts_follow_from_the_measured_features(suite):
    told = {
        name: Features(int(each.features["parameters"]), *list(each.features.values())[1:])
        for name, each in suite.measured.items()
    }
    assert parts_of(told) == {name: each.part for name, each in suite.measured.items()}
    assert sum(part == "easy" for part in parts_of(told).values()) == 30


def test_features_that_are_measured_again_are_those_of_the_table(suite, plan):
    case = next(c for c in plan.cases if c.source.name == "springpot-60/shear-wave")
    here = problem(case)
    optimum = here.space.from_theta(here.model.vector(dict(case.source.truth)))
    best = case.source.best
    target = best + 1e-6 * (reference_of(here) - best)
    found = features_of(here, optimum, best, target).to_dict()
    # The last digits of descents are the processor's own.
    assert found == pytest.approx(suite.measured[case.source.name].features, abs=0.05)


def test_the_page_is_what_the_suite_says(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "studies")
    import suite as study

    assert study.page() == study.PAGE.read_text(encoding="utf-8"), "python studies/suite.py --page"


def test_tests_in_time_are_raced_and_judged_as_sweeps_are(tmp_path):
    names = ["springpot-60/relaxation-zener", "springpot-60/wlf"]
    study = Study(
        "two", names, ["own"], ["own"], ["least-squares", "cma-es"], 1, 60, stop_at_target=True
    )
    outcome = run_study(study, engine="serial", out=tmp_path, quiet=True)
    assert outcome.failed == 0
    with Store(outcome.store) as store:
        rows = {cell.problem.dataset: rows for cell, rows in store.raced() if cell.label[0] == "l"}
    relaxation = rows["springpot-60/relaxation-zener"][0]
    assert str(relaxation.status) == "target"
    # What was found on noisy data errs by the noise; judged by the data without it, it errs less.
    assert relaxation.parameter_error < 0.02
    assert relaxation.oracle < relaxation.best


def test_what_is_no_problem_of_the_suite_is_told_with_a_proposal(suite):
    with pytest.raises(DataError, match="did you mean springpot-60/prony-4"):
        suite.problem("springpot-60/prony4")
    with pytest.raises(DataError, match="no single sweep"):
        springpot.open_measurement("springpot-60/creep-burgers")
    assert springpot.read("springpot-60/wlf").name
