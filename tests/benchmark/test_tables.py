"""Tables: one rule for numbers, every format escaped, the summary a pure function of the store."""

import csv
import io
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from benchmark_fakes import OMEGA, TRUTH, artificial, moody_study, small_study

from springpot import parse_model
from springpot.benchmark import (
    FORMATS,
    Interval,
    Status,
    Store,
    Table,
    run_study,
    store_path,
    summarise,
    write_tables,
)
from springpot.errors import StudyError
from springpot.identification import Problem, fit
from springpot.report.page import number, text, to_csv, to_html, to_latex, to_markdown

NASTY = Table(
    "A & B <i>",
    ("na|me", "x_1 [%]", "rate"),
    [("<b>&\\|", 1.5, Interval(0.5, 0.25, math.inf)), ("[opt]", None, None)],
    "note <script>",
    "Question: is <script> run?",
)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0, "0"),
        (20, "20"),
        (123456, "123456"),
        (0.0, "0"),
        (1.0, "1"),
        (0.123456, "0.1235"),
        (99.99999, "100"),
        (1234.5, "1234"),
        (12345.6, "12346"),
        (1.5e6, "1.500e+06"),
        (1e-3, "0.001"),
        (9.99e-4, "9.990e-04"),
        (-2.5e-9, "-2.500e-09"),
        (math.inf, "∞"),
        (-math.inf, "-∞"),
        (math.nan, "–"),
    ],
)
def test_one_rule_for_numbers(value, shown):
    assert number(value) == shown


def test_entries_as_people_read_them():
    assert [text(entry) for entry in (None, "a", Interval(0.5, 0, 1), 3)] == [
        "–",
        "a",
        "0.5 [0, 1]",
        "3",
    ]


def test_markdown_keeps_its_columns():
    lines = to_markdown(NASTY).splitlines()
    rows = [line for line in lines if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)(?:\\\\)*\|", row)) for row in rows} == {4}
    assert "<" not in rows[2]
    assert rows[1] == "| --- | ---: | ---: |"


def test_what_is_asked_stands_above_the_table():
    for page, begins in ((to_markdown(NASTY), "\n| na"), (to_html(NASTY), "<table>")):
        assert 0 < page.index("Question: ") < page.index(begins)


def test_csv_reads_back_in_full():
    third = Table("t", ("a", "b"), [(1 / 3, Interval(0.1, 0.0, math.inf)), (None, None)])
    rows = list(csv.reader(io.StringIO(to_csv(third))))
    assert rows[0] == ["a", "b", "b low", "b high"]
    assert [float(value) for value in rows[1]] == [1 / 3, 0.1, 0.0, math.inf]
    assert rows[2] == ["", "", "", ""]
    assert next(csv.reader(io.StringIO(to_csv(NASTY).split("\n", 1)[1])))[0] == "<b>&\\|"


def test_latex_escapes_and_uses_booktabs():
    latex = to_latex(NASTY)
    assert r"x\_1 {[\%]}" in latex or r"x\_1 [\%]" in latex
    assert r"\textless{}b\textgreater{}\&\textbackslash{}\textbar{}" in latex
    assert r"{[opt]} & -- & -- \\" in latex
    assert [latex.count(rule) for rule in (r"\toprule", r"\midrule", r"\bottomrule")] == [1, 1, 1]


def test_html_escapes_everything():
    found = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            found.append(tag)

        def handle_data(self, data):
            found.append(data)

    Reader().feed(to_html(NASTY))
    assert "script" not in found
    assert "b" not in found
    assert "<b>&\\|" in found


@pytest.mark.soak
def test_all_formats_are_written_after_a_run(tmp_path):
    outcome = run_study(small_study(), engine="serial", out=tmp_path, quiet=True)
    stems = ("choice", "summary", "ranks", "pairs", "profiles", "progress", "timing", "failures",
             "anytime", "attainment", "sensitivity")  # fmt: skip
    names = {f"{stem}.{suffix}" for stem in stems for suffix, _ in FORMATS.values()}
    assert {path.name for path in outcome.tables} == names
    assert all(path.is_file() for path in outcome.tables)
    before = {path: path.read_bytes() for path in outcome.tables}
    assert write_tables(small_study(), ["csv"], tmp_path) == [
        p for p in outcome.tables if p.suffix == ".csv"
    ]
    assert write_tables(outcome.store) == list(outcome.tables)
    assert {path: path.read_bytes() for path in outcome.tables} == before


@pytest.mark.soak
def test_the_summary_says_what_the_trials_say(tmp_path):
    study = small_study(target=1e-3, accuracy=0.2, budget=800)
    outcome = run_study(study, engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        summaries = summarise(store)
        trials = dict(store.trials())
        bests = store.bests()
    assert len(summaries) == 8
    assert any(s.success.value > 0 for s in summaries)
    for summary in summaries:
        rows = trials[summary.cell.id]
        problem = summary.cell.problem
        best = bests[problem.id]
        goal = best + 1e-3 * (problem.reference - best)
        assert summary.success.value == np.mean([row.best <= goal for row in rows])
        assert summary.best == np.median([row.best for row in rows])
        if problem.model == "fractional-kelvin":
            errors = [max(abs(row.theta[k] / TRUTH[k] - 1) for k in TRUTH) for row in rows]
            assert [row.parameter_error for row in rows] == pytest.approx(errors)
            assert summary.accurate.value == np.mean([error <= 0.2 for error in errors])
        else:
            assert summary.accurate is None


def test_noisy_data_are_also_judged_without_their_noise(tmp_path):
    outcome = run_study(
        small_study(datasets=[artificial(0.05, "noisy")]), engine="serial", out=tmp_path, quiet=True
    )
    model = parse_model("fractional-kelvin")
    truth = model.stiffness(model.theta(**TRUTH), OMEGA)
    with Store(outcome.store) as store:
        own = {cell.id for cell in store.cells() if cell.problem.model == model.name}
        rows = [row for number, group in store.trials() if number in own for row in group]
    for row in rows:
        gap = model.stiffness(model.vector(dict(row.theta)), OMEGA) - truth
        assert row.oracle == pytest.approx(np.sum(np.abs(gap) ** 2), rel=1e-9)
        assert row.oracle != row.best


def test_failures_never_become_numbers(tmp_path):
    outcome = run_study(moody_study("throw"), engine="serial", out=tmp_path, quiet=True)
    rows = list(csv.DictReader((outcome.store.parent / "summary.csv").open()))
    bad = rows[0]
    assert (bad["failed"], bad["success"], bad["evaluations to target"]) == ("3", "0.0", "inf")
    assert (bad["objective reached"], bad["parameter error"], bad["parameters within 0.01"]) == (
        "",
        "",
        "0.0",
    )
    failures = list(csv.DictReader((outcome.store.parent / "failures.csv").open()))
    assert [(row["status"], row["trials"]) for row in failures] == [("error", "3")]


def test_stopping_at_the_target_where_the_truth_is_known(tmp_path):
    study = small_study(stop_at_target=True, target=0.05, models=["own"])
    outcome = run_study(study, engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        rows = [row for _, group in store.trials() for row in group]
    assert {str(row.status) for row in rows} >= {"target"}
    assert all(row.evaluations < 300 for row in rows if row.status == "target")


def test_noisy_data_stop_at_the_target_of_their_optimum(tmp_path):
    """The truth is no optimum of noisy data: who stops there has not arrived."""
    noisy = [artificial(0.05, "noisy")]
    study = small_study(
        datasets=noisy, stop_at_target=True, target=0.02, models=["own"], budget=600
    )
    case = study.plan().cases[0]
    assert case.optimum < 0.95 * case.known
    outcome = run_study(study, engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        rows = [row for _, group in store.trials() for row in group]
    stop = case.optimum + 0.02 * (case.reference - case.optimum)
    assert {str(row.status) for row in rows} >= {"target"}
    for row in rows:
        assert (row.status == "target") == (row.best <= stop)
        assert row.best >= case.optimum


@pytest.fixture
def tight():
    """Data whose stiffness scale is far too small: the optimum lies outside of the box."""
    return replace(artificial(), truth={}, stiffness_scale=1.0)


@pytest.mark.soak
def test_where_the_optimum_is_outside_of_the_box_trials_race_for_the_best_inside(tight, tmp_path):
    """The swarm may leave the box and find better.

    That does not move the target of those that may not.
    """
    study = small_study(
        datasets=[tight],
        models=["fractional-kelvin"],
        optimisers=["pso-paper", "cma-es"],
        stop_at_target=True,
    )
    case = study.plan().cases[0]
    assert (
        fit(parse_model("fractional-kelvin"), tight.open(), case.objective).cost
        < 1e-6 * case.optimum
    )
    outcome = run_study(study, engine="serial", budget=2000, out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        assert list(store.bests().values()) == [case.optimum]
        least = min(row.best for _, rows in store.trials() for row in rows)
        assert all(row.status == Status.TARGET for _, rows in store.trials() for row in rows)
        assert all(cell.success.value == 1.0 for cell in summarise(store))
    assert least < case.optimum


def test_no_trial_stops_where_descents_do_not_agree_on_the_optimum(tight, monkeypatch):
    monkeypatch.setattr(
        "springpot.benchmark.plan.minima_in_box", lambda problem: np.geomspace(1.0, 1e9, 32)
    )
    plan = small_study(datasets=[tight], stop_at_target=True, models=["fractional-kelvin"]).plan()
    assert plan.cases[0].optimum is None
    assert plan.stop_value(plan.cases[0]) == -math.inf


def test_progress_is_measured_from_a_scale_of_the_data_however_large_the_box():
    """An absurd centre of the box must not make the target lax."""
    case = (
        small_study(models=["fractional-kelvin + inertia"], datasets=[artificial(0.02)])
        .plan()
        .cases[0]
    )
    problem = Problem.of(parse_model(case.model), case.source.sweep, case.objective)
    centre = problem.evaluate(0.5 * (problem.lower + problem.upper))
    nothing = float(np.sum(case.source.sweep.magnitude**2))
    assert centre > 10 * nothing
    assert case.reference == pytest.approx(nothing)
    logarithmic = small_study(models=["own"], objectives=["log"]).plan().cases[0]
    assert np.isfinite(logarithmic.reference)


@pytest.mark.soak
def test_a_study_may_add_files_of_its_own(tmp_path):
    def finish(path, folder):
        with Store(path) as store:
            (folder / "names.json").write_text(
                json.dumps(sorted({cell.label for cell in store.cells()}))
            )

    run_study(small_study(finish=finish), engine="serial", out=tmp_path, quiet=True)
    assert json.loads((tmp_path / "small" / "names.json").read_text()) == ["walk", "walk-slow"]


def test_where_the_results_are(tmp_path):
    there = tmp_path / "small" / "small.sqlite"
    assert store_path(small_study(), tmp_path) == there
    assert store_path("small", tmp_path) == there
    assert store_path(there) == there
    there.parent.mkdir()
    assert store_path(there.parent) == there
    with pytest.raises(StudyError, match="there are no results at"):
        write_tables("small", out=tmp_path)
    with pytest.raises(StudyError, match="unknown table format 'docx'"):
        write_tables("small", ["docx"], tmp_path)
