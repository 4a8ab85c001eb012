"""The accuracy gate.

A worse constant is named, noise is not, and what cannot be compared is said in one line.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from soaked import soaked
from springpot import Measurement, Units, parse_model, plugins
from springpot.benchmark import Store, Study, load_study, run_study
from springpot.benchmark.gate.baseline import read_baseline
from springpot.benchmark.gate.regression import check, compare, known_scripts, update
from springpot.errors import StudyError

pytest_plugins = ["pytester"]

ROOT = Path(__file__).resolve().parents[2]
GATE, BASELINE = ROOT / "studies" / "gate.py", ROOT / "results" / "gate" / "baseline.json"
NOISE = int(os.environ.get("SPRINGPOT_NOISE", "3"))
"""Repetitions with other seeds; 200 were run once, see docs/ci.md."""
MAXWELL = "artificial-fractional-maxwell"


def made(name, **options):
    found = plugins().find("optimiser", name)
    return replace(found() if isinstance(found, type) else found, **options)


def quick(**changes):
    """The gate without what is slow."""
    given = {"datasets": ["artificial-springpot", MAXWELL], "optimisers": ["pso-paper", "native"]}
    return replace(load_study(GATE), **{**given, **changes})


@pytest.fixture(scope="module")
def baseline(tmp_path_factory):
    return update(quick(), out=tmp_path_factory.mktemp("results"))


@pytest.mark.soak_cases("20")
@pytest.mark.parametrize("repeats", [3, 20])
def test_the_committed_baseline_is_kept(monkeypatch, repeats):
    monkeypatch.chdir(ROOT)
    gate = check(load_study(GATE).with_options(repeats=repeats), BASELINE)
    assert gate.cells == 12
    assert gate.regressions == ()


def test_the_baseline_is_small_sorted_and_made_to_be_compared(baseline):
    text = baseline.read_text()
    found = json.loads(text)
    assert set(found) == {"schema", "study", "script", "settings", "problems", "cells"}
    assert found["script"] == ""
    keys = [
        line.split('"')[1]
        for line in text.splitlines()
        if " | pso-paper" in line or " | native" in line
    ]
    assert keys == sorted(found["cells"])
    assert len(keys) == 4
    assert len(text) < 4000
    assert read_baseline(baseline).to_text() == text
    assert len(BASELINE.read_text()) < 8000


def test_the_same_seed_gives_the_same_baseline(baseline, tmp_path):
    assert update(quick(), tmp_path / "again.json").read_text() == baseline.read_text()


@pytest.mark.soak
def test_costs_are_those_of_the_trials(baseline, tmp_path):
    outcome = run_study(quick(), engine="serial", out=tmp_path, quiet=True)
    kept = read_baseline(baseline)
    with Store(outcome.store) as store:
        labels = {cell.id: cell for cell in store.cells()}
        for number, rows in store.trials():
            cell = labels[number]
            name = f"{cell.problem.dataset} | {cell.problem.model} | paper"
            goal, sample = kept.goals[name], kept.samples[f"{name} | {cell.label}"]
            assert sample.measure == "evaluations"
            hits = []
            for row in rows:
                evaluations, values = row.improvements()
                reached = evaluations[values <= goal.target]
                hits.append(float(reached[0]) if len(reached) else float("inf"))
            assert list(sample.values) == sorted(hits)


@pytest.mark.soak_cases("pso-paper-worse0")
@pytest.mark.parametrize(
    ("name", "worse"),
    [
        ("pso-paper", {"inertia_first": 1.0, "inertia_last": 1.0}),
        soaked("pso-paper", {"inertia_last": 0.9}),
        soaked("cma-es", {"population": 40}),
    ],
)
def test_a_worse_constant_fails_with_the_right_name(name, worse, tmp_path):
    entrants = {"good": ["native", name], "bad": ["native", (name, made(name, **worse))]}
    # Each is run once: what a store holds is compared as what has just been run.
    good, bad = (
        run_study(
            quick(optimisers=each, repetitions=16), engine="serial", out=tmp_path / way, quiet=True
        ).store
        for way, each in entrants.items()
    )
    gate = check(bad, update(good, tmp_path / "baseline.json"))
    assert gate.regressions
    assert all(line.startswith(f"{name} on artificial-") for line in gate.regressions)
    assert any(
        f"{name} on {MAXWELL} (model fractional-maxwell, objective paper) got worse: "
        "evaluations to target" in line
        for line in gate.regressions
    )
    assert all(" before, " in line and " after (p = " in line for line in gate.regressions)
    back = check(good, update(bad, tmp_path / "bad.json"))
    assert back.passed
    assert any(f"{name} on {MAXWELL}" in note and "got better" in note for note in back.notes)


@pytest.mark.soak
def test_noise_alone_passes(baseline, tmp_path):
    """Another seed is another sample of the same optimisers: no alarm, however often."""
    before = read_baseline(baseline)
    for seed in range(1000, 1000 + NOISE):
        study = replace(quick(), seed=seed)
        outcome = run_study(
            study, engine="serial", out=tmp_path / str(seed), quiet=True, tables=False
        )
        with Store(outcome.store) as store:
            assert compare(before, store, baseline).regressions == (), f"seed {seed}"


@pytest.mark.soak
def test_another_seed_is_compared_too(baseline):
    assert check(quick(), baseline, seed=2).regressions == ()


@pytest.mark.soak
def test_too_few_trials_are_said(tmp_path):
    path = update(quick(repetitions=3), tmp_path / "baseline.json")
    gate = check(quick(repetitions=3), path, seed=5)
    assert gate.passed
    assert any("4 of 4 comparisons have too few trials" in note for note in gate.notes)


@pytest.mark.soak
def test_what_came_and_what_went_is_said(baseline):
    gate = check(quick(optimisers=["pso-paper", "nlopt-crs"]), baseline)
    assert [line.partition(" (")[0] for line in gate.regressions] == [
        f"native on {MAXWELL}",
        "native on artificial-springpot",
    ]
    assert all(line.endswith("is in the baseline but was not run") for line in gate.regressions)
    assert any(
        note.startswith("nlopt-crs") and "is not in the baseline" in note for note in gate.notes
    )


@pytest.mark.soak
def test_what_cannot_be_compared_is_one_line(baseline, tmp_path, monkeypatch):
    other = update(quick(budget=700), tmp_path / "other.json")
    text = baseline.read_text()
    moved = tmp_path / "moved.json"
    moved.write_text(text.replace('"reference": 3', '"reference": 4'))
    broken = tmp_path / "broken.json"
    broken.write_text(text[:300])
    newer = tmp_path / "newer.json"
    newer.write_text(text.replace("springpot.baseline/2", "springpot.baseline/9"))
    for path, message in [
        (
            tmp_path / "none.json",
            r"there is no baseline .*none\.json: make it with springpot regression update",
        ),
        (other, "made with a budget of 700, the study has 6000: make it again"),
        (moved, "the data, the objective or the box of .* changed since the baseline"),
        (broken, "is no accuracy baseline"),
        (newer, "has schema springpot.baseline/9"),
    ]:
        with pytest.raises(StudyError, match=message) as caught:
            check(quick(), path)
        assert "\n" not in str(caught.value)
    with pytest.raises(StudyError, match="there is no baseline under"):
        known_scripts(tmp_path)


@pytest.mark.soak
def test_a_store_is_compared_as_it_is(baseline, tmp_path):
    outcome = run_study(quick(), engine="serial", out=tmp_path, quiet=True)
    assert check(outcome.store, baseline).passed
    with Store(outcome.store) as store:
        assert compare(read_baseline(baseline), store, baseline).cells == 4


@dataclass(frozen=True)
class Tired(type(made("native"))):
    """The native solver, giving up in a part of its trials."""

    gives_up: float = 0.0

    name = "tired"

    def minimise(self, problem, budget, rng):
        if rng.random() < self.gives_up:
            problem(problem.lower)
            return
        super().minimise(problem, budget, rng)


@dataclass(frozen=True)
class Biased(type(made("native"))):
    """The native solver, ending beside the best point."""

    beside: float = 0.0

    name = "biased"

    def minimise(self, problem, budget, rng):
        if not self.beside:
            super().minimise(problem, budget, rng)
            return
        problem(np.array([100.0 * (1.0 + self.beside), 0.36, 0.5]))


MINE_AT_BEST = np.array([100.0, 60.0, 0.5])
MODEL = "fractional-kelvin"


def mine():
    """A user's own data: their truth is known to nobody."""
    omega = 2 * np.pi * np.geomspace(0.1, 10.0, 12)
    stiffness = parse_model(MODEL).stiffness(MINE_AT_BEST, omega)
    return Measurement(omega, stiffness, units=Units("N/m"), name="mine")


def tired(share, **changes):
    """Two problems of twenty trials."""
    return quick(optimisers=[("tired", Tired(gives_up=share))], **changes)


@pytest.mark.soak
def test_an_optimiser_that_gives_up_in_every_third_trial_fails(tmp_path):
    path = update(tired(0.0), tmp_path / "baseline.json")
    gate = check(tired(0.35), path)
    assert not gate.passed
    assert all(line.startswith("tired o") for line in gate.regressions)
    assert any("target reached in" in line for line in gate.regressions)


@pytest.mark.soak
def test_any_drop_of_success_is_noted(tmp_path):
    path = update(tired(0.0), tmp_path / "baseline.json")
    gate = check(tired(0.08), path)
    assert gate.passed
    assert any(
        "target reached in 20 of 20 trials before, in 1" in note
        and "fewer, but not for certain" in note
        for note in gate.notes
    )


@pytest.mark.soak
def test_the_smallest_change_that_a_baseline_sees_is_told(baseline):
    gate = check(quick(), baseline)
    assert [line.partition(",")[0] for line in gate.seen] == ["native", "pso-paper"]
    assert all(
        "in 80 % of cases: costs x1." in line and " over its 2" in line for line in gate.seen
    )


def test_what_a_study_requires_is_held_whatever_was_before(tmp_path):
    """A baseline with the same fault does not excuse it."""
    study = tired(0.3, datasets=["artificial-springpot"])
    path = update(study, tmp_path / "baseline.json")
    assert check(study, path).passed
    required = {"min_success": 0.95, "max_parameter_error": 1e-30, "max_seconds": 1e-9}
    gate = check(replace(study, **required), path)
    for line, (name, limit) in zip(gate.regressions, required.items(), strict=True):
        assert f"{name} is {limit:g}" in line


@pytest.mark.soak
def test_identified_parameters_of_own_data_are_held(tmp_path):
    """One repetition, no known truth: the baseline's parameters are what is right."""

    def study(beside, **required):
        return Study(
            "own",
            [mine()],
            [MODEL],
            ["relative"],
            [("fit", Biased(beside=beside))],
            repetitions=1,
            budget=2000,
            **required,
        )

    path = update(study(0.0), tmp_path / "baseline.json")
    [goal] = read_baseline(path).goals.values()
    assert list(goal.parameters.values()) == pytest.approx(MINE_AT_BEST.tolist(), rel=1e-6)
    assert check(study(0.0, max_parameter_error=0.01), path).passed
    assert check(study(0.005, max_parameter_error=0.01), path).passed
    [line] = [
        line
        for line in check(study(0.02, max_parameter_error=0.01), path).regressions
        if "max_parameter" in line
    ]
    assert "fit on mine" in line
    assert "off by up to 0.02" in line
    assert "max_parameter_error is 0.01" in line
    assert "k 102.0 for 100.0" in line


@pytest.mark.parametrize(
    ("required", "words"),
    [
        ({"min_success": 95}, "min_success must be a share of at most 1, not 95"),
        ({"min_success": 0}, "min_success must be a positive number, not 0"),
        (
            {"max_parameter_error": "1 %"},
            "max_parameter_error must be a positive number, not '1 %'",
        ),
        ({"max_seconds": float("nan")}, "max_seconds must be a positive number, not nan"),
    ],
)
def test_a_requirement_that_cannot_be_meant_is_refused(required, words):
    with pytest.raises(StudyError, match=words):
        quick(**required)


PLUGIN = """
from pathlib import Path
from dataclasses import replace
from springpot.benchmark import load_study
study = replace(load_study({gate!r}), datasets=["artificial-springpot"], optimisers={optimisers})

def test_accuracy(accuracy_gate):
    accuracy_gate(study, baseline=Path("baseline.json"))
"""


@pytest.mark.soak
def test_the_fixture_updates_passes_and_fails_with_a_sentence(pytester):
    def run(optimisers, *options):
        (pytester.path / "test_mine.py").write_text(
            PLUGIN.format(gate=str(GATE), optimisers=optimisers)
        )
        return pytester.runpytest_inprocess(
            "-q", "-p", "no:cacheprovider", "-p", "no:benchmark", *options
        )

    good = '["pso-paper"]'
    bad = (
        '[("pso-paper", __import__("springpot_plugins.optimisers.swarm", fromlist=["x"])'
        ".PaperSwarm(inertia_first=1.0, inertia_last=1.0))]"
    )
    missing = run(good)
    assert missing.ret == 1
    assert "there is no baseline baseline.json: make it with" in missing.stdout.str()
    assert run(good, "--springpot-update").ret == 0
    assert run(good).ret == 0
    worse = run(bad)
    assert worse.ret == 1
    assert (
        "pso-paper on artificial-springpot (model springpot, objective paper) got worse"
        in worse.stdout.str()
    )
    assert "Traceback" not in worse.stdout.str()


def test_the_pytest_plugin_is_light():
    script = (
        "import sys, springpot.benchmark.gate.pytest_plugin; "
        "print('numpy' in sys.modules or 'click' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"
