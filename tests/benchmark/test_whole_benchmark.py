"""All that is told of made-up studies: tables, report, exports, baseline and gate, to the number.

No optimiser runs: the trials are written by hand, so that only what is made of them is looked at.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import ClassVar
from zlib import crc32

import numpy as np
import pytest
from benchmark_fakes import TRUTH, Walk, artificial, measurement

from springpot.benchmark import Findings, Store, Study
from springpot.benchmark.comparison import with_truth
from springpot.benchmark.exporting import WRITERS, trace_columns, trial_columns
from springpot.benchmark.gate import baseline, regression
from springpot.benchmark.standings import study_tables
from springpot.benchmark.study_report import study_html
from springpot.benchmark.summary import TrialRow
from springpot.benchmark.trial import Status, TrialResult, pack, pack_values
from springpot.measurement import DataSet

BUDGET = 2500
FACTS = {"command": "springpot run made", "started": "2024-05-06T07:08:09", "python": "3"}


@dataclass(frozen=True)
class Made(Walk):
    """An entrant by number; it is never run."""

    number: int = field(default=0)

    name: ClassVar[str] = "made"


def study(problems, entrants, repetitions, objectives=("paper",)):
    data = [artificial(), artificial(0.02, "noisy"), DataSet("own", "of a laboratory", unknown)]
    made = [(f"made-{i}", Made(number=i)) for i in range(entrants)]
    return Study(
        "made", data[:problems], ["own", "springpot"][:1] if problems < 3 else ["springpot"],
        list(objectives), made, repetitions, BUDGET, target=1e-3,
    )  # fmt: skip


def unknown():
    return measurement(0.01, "own")


def trial(cell, repetition, rate, rng, noisy, known):
    """A search whose excess falls the faster the higher its rate; some fail or give up."""
    fate = rng.random()
    if fate < 0.1:
        status = (Status.ERROR, Status.TIMEOUT, Status.CRASH)[repetition % 3]
        return TrialResult(cell, repetition, status, f"reason {repetition % 2}", seconds=0.5)
    last = int(BUDGET * rng.uniform(0.4, 1.0))
    steps = np.unique(np.geomspace(1, last, 25).astype(np.int64))
    values = 50.0 * np.exp(-rate * np.cumsum(rng.uniform(0.0, 1.0, len(steps))))
    clean = values * rng.uniform(0.8, 1.2, len(steps))
    best = float(values[-1])
    alone = repetition % 2 == 0
    return TrialResult(
        cell, repetition, Status.CONVERGED if last < BUDGET // 2 else Status.BUDGET,
        best=best,
        theta={name: value * (1.0 + rate * rng.normal() * 0.02) for name, value in TRUTH.items()},
        parameter_error=0.01 * best if known else None,
        oracle=float(clean[-1]) if known else None,
        evaluations=last, gradients=last // 3 if cell % 2 else 0, batched=last // 5,
        seconds=1e-5 * last, processor=2e-5 * last * rate if alone else None,
        processor_batched=None if alone else 1e-6 * last,
        trace=pack(list(zip(steps.tolist(), values.tolist(), strict=True))),
        recommended=None if not known else pack_values(clean) if noisy else b"",
        seen=None if not known else
        pack(list(zip(steps.tolist(), np.minimum.accumulate(clean).tolist(), strict=True)))
        if noisy else b"",
    )  # fmt: skip


def filled(path, plan, seed=5):
    """A store with trials of a plan."""
    rng = np.random.default_rng(seed)
    with Store(path, write=True) as store:
        numbers = store.register(plan, FACTS)
        for cell in plan.cells:
            case = plan.cases[cell.case]
            rate = (0.25, 0.5, 0.55, 0.1)[cell.entrant % 4]
            noisy, known = case.source.name == "noisy", case.source.name != "own"
            rows = [
                trial(cell.index, repetition, rate, rng, noisy, known)
                for repetition in range(plan.repetitions)
            ]
            store.add(rows, numbers)
    return path


STUDIES = {
    "many": (3, 4, 6),
    "two": (2, 2, 12),
    "one": (1, 3, 5),
    "alone": (1, 1, 3),
    "criteria": (2, 2, 4, ("paper", "log")),
}


@pytest.fixture(scope="module", params=list(STUDIES))
def store(request, tmp_path_factory):
    plan = study(*STUDIES[request.param]).plan()
    with Store(filled(tmp_path_factory.mktemp("made") / "made.sqlite", plan)) as opened:
        yield opened


NUMBER = re.compile(r"(?<![\w#])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def told(text):
    """The words of a text by their sum, and its numbers."""
    numbers = [float(number) for number in NUMBER.findall(text)]
    return [crc32(NUMBER.sub("#", text).encode()), np.array(numbers)]


def test_tables(store, stays):
    tables = dict(study_tables(store))
    stays(
        {
            name: {"columns": table.columns, "note": table.note, "rows": table.rows}
            for name, table in tables.items()
        }
    )


def test_report(store, stays):
    page = study_html(Findings.of(store))
    parts = re.split(r"(?=<h2>|<svg|<table)", str(page).partition("</style>")[2])
    assert len(parts) > 5
    stays([told(part) for part in parts], within=1e-8)


@pytest.mark.soak_cases("many-ioh", "many-coco", "many-csv")
@pytest.mark.parametrize("kind", ["ioh", "coco", "csv"])
def test_files_for_other_tools(store, kind, stays, tmp_path):
    export = WRITERS[kind](store, tmp_path)
    files = {}
    for path in export.files:
        name = path.relative_to(tmp_path).as_posix()
        files[name] = told(path.read_text(encoding="utf-8"))
    counts = [export.trials, export.left_out, export.hint.replace(str(tmp_path), "FOLDER")]
    stays({"counts": counts, **files}, within=1e-8)


def test_columns(store, stays):
    both = {"trials": trial_columns(store), "traces": trace_columns(store)}
    stays(
        {name: {key: told(str(column)) for key, column in of.items()} for name, of in both.items()}
    )


def finite(value):
    """An array with -1 for what is endless, of which no sum tells anything."""
    return np.where(np.isfinite(value), value, -1.0) if isinstance(value, np.ndarray) else value


def test_scores_of_each_cell(store, stays):
    found = Findings.of(store)
    trials = {cell.id: rows for cell, rows in store.raced()}
    whole = [with_truth(each, trials[each.cell.id]) for each in found.scores]
    stays(
        {
            "targets": found.scale.targets,
            "grid": found.scale.grid,
            "marks": found.scale.marks,
            "scores": [
                {name: finite(value) for name, value in vars(each).items() if name != "cell"}
                for each in whole
            ],
            "summaries": [
                replace(each, cell=each.cell.label, reasons=sorted(each.reasons.items()))
                for each in found.summaries
            ],
        }
    )


def test_baseline_and_what_changed_since(store, stays, tmp_path):
    before = baseline.baseline_of(store, "made.py")
    worse = filled(tmp_path / "worse.sqlite", study(2, 2, 12).plan(), seed=9)
    answer = {
        "goals": before.goals,
        "settings": before.settings,
        "text": told(before.to_text()),
        "samples": before.samples,
    }
    with Store(worse) as later:
        if before.samples.keys() <= baseline.baseline_of(later).samples.keys():
            after = baseline.samples_like(later, before)
            found = regression.changes_since(before, after, 0.05, 1.5)
            answer["changes"] = [
                [
                    each.who,
                    each.worse,
                    each.better,
                    each.sentence("worse"),
                    each.sentence("better"),
                    each.doubtful(),
                ]
                for each in found
            ]
    answer["seen"] = list(regression._seen(before, 0.05, 1.5))
    stays(answer)


def samples():
    """Costs before, of ten trials, and after: dearer by a factor, or missed by some."""
    rng = np.random.default_rng(2)
    before = np.exp(rng.normal(5.0, 0.3, 10))
    yield "same", before, before
    for factor in (1.2, 1.6, 3.0, 0.3):
        yield f"x{factor}", before, factor * np.exp(rng.normal(5.0, 0.3, 10))
    for missed in (1, 4, 10):
        yield f"{missed} missed", before, np.r_[before[missed:], np.full(missed, np.inf)]
    yield "three of each", before[:3], 9.0 * before[:3]
    yield "one of each", before[:1], 9.0 * before[:1]
    yield "none before", np.full(4, np.inf), before[:4]


COUNTS = ((10, 10, 10, 10), (10, 10, 5, 10), (10, 10, 0, 10), (0, 10, 9, 10), (2, 3, 0, 3))
"""Successes and trials before and after."""


def test_verdicts_on_costs_and_counts(stays):
    pairs = {name: (before, after) for name, before, after in samples()}
    counts = [
        (baseline.Successes(a, n), baseline.Successes(b, m))
        for a, n, b, m in (
            (10, 10, 10, 10),
            (10, 10, 5, 10),
            (10, 10, 0, 10),
            (0, 10, 9, 10),
            (2, 3, 0, 3),
        )
    ]
    every = list(pairs.values())
    stays(
        {
            "together": baseline.verdicts(every, 0.05, 1.25, counts),
            "alone": {name: baseline.verdicts([pair], 0.05, 1.25) for name, pair in pairs.items()},
            "strict": {name: baseline.verdicts([pair], 0.001, 1.0) for name, pair in pairs.items()},
            "of counts": [baseline.verdicts([], 0.05, 1.25, [count]) for count in counts],
            "drops": [[baseline.drop(*count), baseline.drop(*count[::-1])] for count in counts],
            "least": [baseline.least_drop(n, m) for n, m in ((0, 3), (3, 0), (1, 1), (3, 5))],
            "intervals": {name: baseline.interval(pair[1], 0.05) for name, pair in pairs.items()},
            "rises": {
                name: [regression.least_rise(after, share) for share in (0.05, 1e-4)]
                for name, (_, after) in pairs.items()
            },
            "falls": [
                [regression._falls(count[0], share) for share in (0.05, 1e-3)] for count in counts
            ],
            "seen": [
                regression.smallest_seen([before], [counts[1][0]], counts[1][0], 0.01, 1.25)
                for before, _ in every
            ],
            "seen on two": regression.smallest_seen(
                [every[0][0], every[8][0]], [counts[0][0], counts[4][0]], counts[1][0], 0.01, 1.25
            ),
        }
    )  # fmt: skip


def kept(best, error=0.0, seconds=1.0, status=Status.BUDGET):
    """A trial as a store gives it back."""
    theta = {"k": 1.0 + error, "c": 2.0}
    trace = pack([(1, 9.0), (10, best)])
    return TrialRow(
        0, 0, status, best=best, theta=theta, evaluations=10, seconds=seconds, trace=trace
    )


def test_what_a_study_requires_is_told_where_it_is_not_met(stays):
    goal = baseline.Goal(0.0, 10.0, 1.0, {"k": 1.0, "c": 2.0})
    rows = [kept(0.5), kept(1.0, 0.1), kept(1.1, 0.2, 2.0), kept(2.0, 0.3, 4.0)]
    failed = [TrialRow(0, 4, Status.ERROR, seconds=9.0)]
    required = [
        {"min_success": 0.5},
        {"min_success": 0.51},
        {"max_parameter_error": 0.3},
        {"max_parameter_error": 0.29},
        {"max_parameter_error": 0.1, "min_success": 0.5},
        {"max_parameter_error": 0.09, "min_success": 0.5},
        {"max_seconds": 4.0},
        {"max_seconds": 3.9},
        {"max_seconds": 1.0, "min_success": 0.5},
        {"max_seconds": 0.9, "min_success": 0.5},
        {},
    ]
    stays(
        {
            "met or not": [list(regression._broken(rows, goal, each)) for each in required],
            "one failed": [
                list(regression._broken(rows + failed, goal, each)) for each in required
            ],
            "all failed": [list(regression._broken(failed, goal, each)) for each in required],
            "nothing known": [
                list(regression._broken(rows, replace(goal, parameters={}), each))
                for each in required
            ],
        }
    )
