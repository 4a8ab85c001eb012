"""Noise as an axis of a study, and a first point that all optimisers share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmark_fakes import Walk, artificial, small_study

from springpot import plugins
from springpot.benchmark import Findings, Store, run_study
from springpot.benchmark.exporting import trial_columns
from springpot.benchmark.gate.baseline import baseline_of
from springpot.benchmark.plan import WorkOrder, drawn
from springpot.benchmark.standings import study_tables
from springpot.benchmark.study_report import study_html
from springpot.benchmark.trial import TwinProblem, Workshop
from springpot.errors import StudyError
from springpot.identification import run


def noisy_study(**changes):
    """One artificial data set at three levels of noise."""
    told = {"datasets": [artificial()], "models": ["own"], "noise": [0.03, 0, 0.01]}
    return small_study(**told | changes)


@pytest.mark.parametrize("noise", [[1.0], [-0.1], [0.01, 0.01], "0.01", [np.nan], 0.01])
def test_levels_of_noise_are_different_numbers_below_one(noise):
    with pytest.raises(StudyError, match="noise must be a list of different levels"):
        noisy_study(noise=noise)
    with pytest.raises(StudyError, match="x0 must be 'own' or 'common'"):
        noisy_study(x0="mine")


def test_every_repetition_has_a_draw_that_levels_and_models_share():
    plan = noisy_study(models=["own", "springpot"]).plan()
    assert [case.source.name for case in plan.cases[::2]] == ["kelvin", "kelvin+1%", "kelvin+3%"]
    exact, one, three = (
        [drawn(plan, case, r).source.sweep.stiffness for r in range(3)] for case in plan.cases[::2]
    )
    assert all(np.array_equal(data, exact[0]) for data in exact)
    assert len({data.tobytes() for data in one}) == 3
    # Eq. (53) is nearly linear in its level: three times the noise is three times the same draw.
    for small, large in zip(one, three, strict=True):
        np.testing.assert_allclose((large - exact[0]) / (small - exact[0]), 3.0, rtol=0.1)
    other_model = drawn(plan, plan.cases[3], 1).source.sweep.stiffness
    assert np.array_equal(other_model, one[1])
    other_seed = replace(noisy_study(), seed=2).plan()
    again = drawn(other_seed, other_seed.cases[1], 1).source.sweep.stiffness
    assert not np.array_equal(again, one[1])


def test_the_box_is_the_same_for_all_draws():
    plan = noisy_study(noise=[0.3]).plan()
    boxes = {TwinProblem(drawn(plan, plan.cases[0], r)).problem.upper.tobytes() for r in range(5)}
    assert len(boxes) == 1


def test_data_without_a_known_truth_keep_the_noise_that_they_have():
    unknown = replace(artificial(0.02, "lab"), truth={}, model="")
    plan = noisy_study(datasets=[unknown], models=["springpot"]).plan()
    assert [case.noise for case in plan.cases] == [None]
    assert plan.cases[0].source.digest == unknown.open().digest()


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A study with noise and a common start, by one worker and by two."""
    study = noisy_study(
        optimisers=[Walk(), "native", "nlopt-direct-l", "pso-paper"],
        repetitions=3,
        budget=150,
        x0="common",
        target=1e-6,
        stop_at_target=True,
    )
    made = []
    for settings in ({"engine": "serial"}, {"workers": 2}):
        folder = tmp_path_factory.mktemp("noise")
        made.append(run_study(study, out=folder, quiet=True, tables=False, **settings).store)
    return made


TIMES = ("seconds", "processor", "processor_batched")


def test_the_same_bits_come_of_any_number_of_workers(stores):
    found = []
    for path in stores:
        with Store(path) as store:
            columns = trial_columns(store)
        found.append({name: each for name, each in columns.items() if name not in TIMES})
    assert found[0] == found[1]
    assert len(set(found[0]["reference"])) == 1 + 2 * 3


def test_each_trial_is_judged_by_its_own_data(stores):
    with Store(stores[0]) as store:
        columns = trial_columns(store)
        findings = Findings.of(store)
    told = zip(*(columns[n] for n in ("best", "target", "hit", "f_best")), strict=True)
    for best, target, hit, f_best in told:
        assert f_best < target
        assert (hit is not None) == (best <= target)
    # Native ends at the target of each draw, though they differ.
    native = [s for s in findings.scores if s.cell.label == "native"]
    assert [np.isfinite(s.hits).all() for s in native] == [True] * 3
    assert all((s.values[:, -1] <= 1.001e-6).all() for s in native)


def test_the_table_judges_by_regret_parameters_and_intervals(stores):
    with Store(stores[0]) as store:
        table = dict(study_tables(store))["noise"]
        html = study_html(Findings.of(store))
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    assert [(row["noise [%]"]) for row in rows] == [0.0] * 4 + [1.0] * 4 + [3.0] * 4
    assert {row["intervals with the truth"] for row in rows[:4]} == {None}
    native = [row for row in rows if row["optimiser"] == "native"]
    regrets = [row["noise-free regret"] for row in native]
    assert regrets[0] < 1e-6 < regrets[1] < regrets[2]
    assert sum(row["rank by parameter error"] for row in rows[:4]) == 10.0
    assert "First point: common" in html
    assert "1, 3" in html
    with Store(stores[0]) as store, pytest.raises(StudyError, match="a gate needs the same data"):
        baseline_of(store)


@pytest.mark.soak
def test_intervals_hold_the_truth_as_often_as_they_say():
    """95 % of them, by least squares on noise of one size; 90 % of the level would show."""
    plan = noisy_study(
        objectives=["relative"], optimisers=["native"], noise=[0.01], repetitions=60, budget=60
    ).plan()
    shop = Workshop(plan)
    covered = []
    for r in range(60):
        [[result]] = shop.run([WorkOrder(0, (r,))])
        covered.append(result.covered)
    assert 0.9 <= np.mean(covered) <= 0.99


def test_the_first_evaluation_is_the_common_point_of_every_optimiser(stores):
    with Store(stores[0]) as store:
        first: dict[tuple[int, int], set[float]] = {}
        for cell in store.cells():
            for row in dict(store.trials())[cell.id]:
                evaluations, values = row.improvements()
                assert evaluations[0] == 1
                first.setdefault((cell.problem.id, row.repetition), set()).add(values[0])
    assert {len(values) for values in first.values()} == {1}
    assert len(set.union(*first.values())) == len(first)


@pytest.mark.parametrize("name", [n for n in plugins().names("optimiser") if "NAME" not in n])
def test_who_says_so_begins_at_the_common_point(name):
    """What it evaluates next hangs on that point, and else on nothing but its random numbers."""
    optimiser = plugins().find("optimiser", name)()
    problem = TwinProblem(noisy_study(noise=[]).plan().cases[0]).problem
    seen = []
    for start in (np.full(3, 0.3), np.full(3, 0.6)):
        rng = np.random.default_rng(5)
        done = run(optimiser, problem, 24, rng, diary=True, start=start)
        pages = [np.atleast_2d(page) for page, _ in done.diary]
        np.testing.assert_allclose(pages[0][0], problem.lower + start * problem.upper, rtol=1e-6)
        seen.append(np.concatenate(pages)[1:])
    assert len(seen[0]) <= 23
    assert (not np.array_equal(*seen)) == optimiser.card.started
