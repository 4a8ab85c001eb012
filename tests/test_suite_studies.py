"""The studies on springpot-60 beside the main one: what they compare, and by which rules."""

from __future__ import annotations

import ast
import csv
import html
import importlib
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.benchmark import Table
from springpot.benchmark.statistics import Interval
from springpot_plugins.optimisers.swarm import PaperSwarm, ScalarSwarm

STUDIES = str(Path(__file__).parents[1] / "studies")


@pytest.fixture(autouse=True)
def beside(monkeypatch):
    monkeypatch.syspath_prepend(STUDIES)
    yield
    others = ("budgets", "tuned", "swarm", "choice", "repeated", "portfolio", "race", "pages")
    for name in ("suite", "drawn_problems", *(f"suite_{each}" for each in others)):
        sys.modules.pop(name, None)


def ranked(*means):
    return SimpleNamespace(labels=("a", "b", "c"), means=np.array(means, dtype=float))


def test_who_overtakes_whom_is_said_at_the_budget_where_it_happens():
    import suite_budgets

    early, then, late = ranked(1, 2, 3), ranked(2, 1, 3), ranked(2, 1, 1)
    steps = [(50, 200, early, then), (200, 1000, then, late)]
    found = [each[:4] for each in suite_budgets.overtaken(steps)]
    # Level with another is not ahead of it.
    assert found == [(50, 200, "b", "a"), (200, 1000, "c", "a")]


@pytest.mark.parametrize(
    ("places", "spread"),
    [
        ([1, 1, 5], [0.5, 1.5, 5]),
        # What is moved apart may touch the next.
        ([1, 1, 1.9, 2.6], [0.125, 1.125, 2.125, 3.125]),
        ([1, 2, 4], [1, 2, 4]),
    ],
)
def test_names_at_the_ranks_do_not_overlap(places, spread):
    from suite_budgets import apart

    assert apart(places, 1.0) == pytest.approx(spread)


def test_every_method_has_as_many_settings_to_try_its_defaults_first():
    import suite_tuned

    for name in suite_tuned.SPACES:
        tried = suite_tuned.settings(name, 5)
        assert [label for label, _ in tried][:2] == [name, f"{name} #1"]
        assert suite_tuned._changed(tried[0][1]) == "defaults"
        assert len({repr(optimiser) for _, optimiser in tried}) == 5
        assert tried == suite_tuned.settings(name, 5)


def test_all_readings_of_the_swarm_are_raced():
    from suite_swarm import READINGS

    swarms = list(READINGS.values())
    schedules = {(each.inertia_first, each.inertia_last) for each in swarms}
    assert len(schedules) == 7
    assert len({each.clamp for each in swarms}) == 3
    assert {type(each) for each in swarms} == {PaperSwarm, ScalarSwarm}
    assert len(set(map(repr, swarms))) == len(swarms) == 12


def test_descents_in_turn_take_what_one_by_one_is_expected_of_them():
    from suite_choice import Bank, Rules

    # Of the first kind half of the descents meet the target at 10, the others end at 20 without.
    curves = np.tile(np.geomspace(50.0, 1e-3, 40), (2, 2, 2, 1))
    hits = np.array([[[10.0, np.inf], [np.inf, np.inf]], [[np.inf] * 2] * 2])
    bank = Bank(curves, hits, np.array([[[10.0, 20.0], [5.0, 5.0]], [[4.0, 4.0]] * 2]))

    def time(order, longest=100, **changes):
        told = {"patience": 5, "progress": 1.0, "rounds": (0,)} | changes
        return Rules(order, longest, **told).time(bank)

    assert time((0,)) == 15.0 / 0.5
    assert time((0, 1)) == (15.0 + 0.5 * 5.0) / 0.5
    # All kinds once from points of the one scale, and then from those of the other.
    assert time((0, 1), rounds=(0, 1)) == (15.0 + 0.5 * (5.0 + 4.0 + 4.0)) / 0.5
    # One that is cut short misses, and costs no more than that.
    assert time((0,), 8) == np.inf
    assert time((0,), 15) == 12.5 / 0.5
    # Each falls by a fifth at every evaluation; whoever wants more gives up after six.
    assert time((0,), progress=0.1) == np.inf
    assert time((0,), progress=0.5) == 15.0 / 0.5


def test_a_drawn_problem_hangs_on_its_seed_and_number_alone():
    from drawn_problems import drawn, place, searched

    known = drawn(5, 1)
    again = drawn(5, 1)
    assert (known.summary, dict(known.truth)) == (again.summary, dict(again.truth))
    problem = searched(known)
    inside = place(known, problem)
    assert np.all((inside >= problem.lower) & (inside <= problem.upper))
    assert problem.evaluate(inside) < problem.nothing


def test_two_share_a_budget_as_each_alone_would_have_gone_on():
    from suite_portfolio import Schedule

    never, both = np.array([np.inf]), Schedule(100, 0.8, "b")
    assert both.time(np.array([60.0]), np.array([1.0])) == 60.0
    # Beyond its hundred the first goes on at four fifths of the pace, the second at one fifth.
    assert both.time(np.array([180.0]), never) == pytest.approx(200.0)
    assert both.time(np.array([180.0]), np.array([10.0])) == pytest.approx(150.0)
    assert both.time(never, np.array([1600.0])) == 80_000.0


def test_the_page_tells_what_the_table_says():
    """Its intervals are those of the archives, by tests/benchmark/recomputed_suite.py."""
    import suite_repeated

    with (suite_repeated.FOLDER / "judged.csv").open(newline="", encoding="utf-8") as stream:
        _, *rows = csv.reader(stream)
    values = [[Interval(*map(float, row[i : i + 3])) for i in range(1, 19, 3)] for row in rows]
    text = suite_repeated.PAGE.read_text(encoding="utf-8")
    assert suite_repeated.page(text, SimpleNamespace(rows=values)) == text


def test_a_page_tells_what_a_problem_is_and_who_arrives():
    import suite_pages
    from springpot import plugins
    from springpot.benchmark import Study

    suite = plugins().find("suite", "springpot-60")
    (case,) = (
        Study("one", [name := f"{suite.name}/mass-and-delay"], ["own"], ["own"], ["native"])
        .plan()
        .cases
    )
    hits = {"slow": [(np.array([900.0]), np.array([900])), (np.array([np.inf]), np.array([2000]))]}
    hits["lost"] = [(np.array([np.inf]), np.array([8000]))]
    told = suite_pages._page(suite, suite.problem(name), case, hits)
    assert told.startswith(f"# {name}\n")
    assert "| `inertia.m` | 1000 kg | 2e-06 | 2000 | 0.0004 |" in told
    assert f'default_rng(list(b"{name}"))' in told
    assert "## How hard it is: deceptive" in told
    # A trial in vain costs what it spent.
    assert "| `slow` | 1 of 2 | 2,900 | 900 |" in told
    assert "In no trial: `lost`." in told


def test_names_of_problems_and_the_map_lead_to_their_pages():
    import suite
    import suite_pages

    files = SimpleNamespace(src_uri="suite.md")
    text = suite.PAGE.read_text(encoding="utf-8")
    turned = suite_pages.on_page_markdown(
        text, page=SimpleNamespace(file=files), config=None, files=None
    )
    assert turned.count("](suite/") == 60 + 20 + 20
    assert 'xlink:href="suite/shear-wave.html"' in turned


@pytest.mark.parametrize(
    ("script", "table"),
    [
        ("suite_repeated", "suite_repeated/judged"),
        ("suite_choice", "suite_choice/judged"),
        ("suite_portfolio", "suite_repeated/portfolio"),
        ("suite_budgets", "suite_budgets/ranks_by_budget"),
        ("suite_tuned", "suite_tuned/tuned"),
        ("expensive", "expensive/expensive"),
        ("bias", "bias/bias"),
        ("random_starts", "random_starts/random_starts"),
        ("certificates", "certificates/covered"),
        ("certificates", "certificates/decided"),
        ("certificates", "certificates/risked"),
        ("populations", "populations/covered"),
        ("populations", "populations/judged"),
        ("populations", "populations/costs"),
        ("real_sets/answers", "real_data/real_data"),
        ("real_sets/published", "real_data/published"),
        ("real_sets/unseen", "real_data/unseen"),
        ("real_sets/without_model", "real_data/without_model"),
        ("master_curves", "master_curves/summary"),
        ("master_curves", "master_curves/factors"),
        ("master_curve_coverage", "master_curves/coverage"),
        ("master_curve_coverage", "master_curves/temperatures"),
        ("nameless", "nameless/README"),
        ("time_and_frequency", "time_and_frequency/README"),
        ("structure_drift", "structure_drift/README"),
        ("gate_power", "gate/power"),
        ("hidden_effects/report", "hidden_effect/README"),
        ("hidden_effects/report", "hidden_effect_several/README"),
        ("hidden_effects/report", "hidden_effect_strata/README"),
        ("hidden_effects/report", "hidden_effect_seeds/README"),
        ("hidden_effects/report", "hidden_effect_measured/README"),
        ("hidden_effects_time/tables", "hidden_effect_time/README"),
        ("hidden_effects_time/tables", "hidden_effect_read/README"),
        ("hidden_effects_time/joint_report", "hidden_effect_joint/README"),
        ("hidden_effects_time/several", "hidden_effect_time_several/README"),
    ],
)
def test_a_table_says_first_what_its_script_asks(script, table):
    from paper.asking import question

    asks = question(ast.get_docstring(ast.parse((Path(STUDIES) / f"{script}.py").read_text())))
    assert all(word in asks for word in ("Measure: ", "What would answer it: "))
    assert first_of(table) == asks


@pytest.mark.parametrize(
    ("script", "table"),
    [
        ("suite_race", "suite_race/parts"),
        ("suite_swarm", "suite_swarm/readings"),
        ("swarm_claim", "swarm_claim/swarm_overview"),
        ("optimiser_comparison", "optimiser_comparison/ranking"),
    ],
)
def test_a_table_of_a_study_says_first_what_that_asks(script, table):
    from paper.asking import asked

    study = importlib.import_module(script).study
    assert first_of(table) == asked(study, Table("", (), ())).asks


@pytest.mark.parametrize("script", ["suite_race", "optimiser_comparison"])
def test_a_report_of_a_study_says_first_what_that_asks(script):
    asks = importlib.import_module(script).study.asks
    report = (Path(STUDIES).parent / "results" / script / "report.html").read_text("utf-8")
    head = html.unescape(re.sub(r"<[^>]+>", "", report.partition('class="verdict"')[0]))
    assert all(sentence in head for sentence in asks)


def first_of(table):
    """What a table of the results says before its rows."""
    page = (Path(STUDIES).parent / "results" / f"{table}.md").read_text(encoding="utf-8")
    return page.split("\n\n")[1]
