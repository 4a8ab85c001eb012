"""What a baseline is said to see is what drawn samples show."""

import csv
from math import inf
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.benchmark.gate import regression
from springpot.benchmark.gate.baseline import LEVEL, Successes, chance, drop
from springpot.benchmark.gate.regression import POWER, least_drop_seen, least_rise, smallest_seen

ROOT = Path(__file__).resolve().parents[2]
SHARE = 0.002


@pytest.mark.parametrize(("trials", "before"), [(20, 20), (40, 36), (60, 60)])
def test_the_least_fall_of_success_is_seen_as_often_as_is_said(trials, before, rng):
    rate = least_drop_seen(Successes(before, trials), SHARE)
    draws = rng.binomial(trials, rate, 2000)
    found = [drop(Successes(before, trials), Successes(int(k), trials)) < SHARE for k in draws]
    assert np.mean(found) == pytest.approx(POWER, abs=0.04)


@pytest.mark.soak
@pytest.mark.parametrize("trials", [20, 50])
def test_the_least_rise_of_costs_is_seen_as_often_as_is_said(trials, rng):
    """Averaged over baselines: one sample knows its own spread only roughly."""
    found = []
    for _ in range(150):
        before, after = np.exp(0.3 * rng.standard_normal((2, trials)))
        found.append(chance(1.1 * before, after * least_rise(before, SHARE)) < SHARE)
    assert np.mean(found) == pytest.approx(POWER, abs=0.12)


def test_what_cannot_be_seen_is_said():
    assert least_drop_seen(Successes(5, 5), 1e-6) is None
    assert least_drop_seen(Successes(0, 20), SHARE) is None
    assert least_rise(np.ones(3), SHARE) == inf
    assert least_rise(np.full(20, 25.0), SHARE) == pytest.approx(1.1)
    words = smallest_seen([np.ones(3)], [Successes(3, 3)], Successes(3, 3), SHARE, 1.1)
    assert words == "costs no rise; success no fall from 100 % on one problem"
    twenty = [Successes(20, 20)] * 2
    words = smallest_seen([np.full(20, 25.0)] * 2, twenty, Successes(40, 40), SHARE, 1.1)
    assert words == "costs x1.1; success 100 -> 58 % on one problem, 100 -> 75 % over its 2"


def test_a_baseline_that_missed_often_sees_a_rise_less(rng):
    whole = np.exp(0.3 * rng.standard_normal(20))
    half = np.where(np.arange(20) < 9, inf, whole)
    assert least_rise(half, SHARE) > least_rise(whole, SHARE)


def committed() -> dict[str, dict[str, str]]:
    """Rows of the table of what the gate sees, by what changed."""
    with (ROOT / "results" / "gate" / "power.csv").open(encoding="utf-8", newline="") as file:
        return {row["what changed"]: row for row in csv.DictReader(file)}


def test_the_documents_say_what_was_measured():
    rows, said = committed(), (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
    for change in ("success 100 -> 50 % in one cell of 6", "evaluations x1.5 in one cell of 6"):
        [line] = [line for line in said.splitlines() if line.startswith(f"| {change} |")]
        shares = [100 * float(rows[change][f"{trials} trials"]) for trials in (20, 40, 60, 80)]
        assert [float(cell) for cell in line.split("|")[2:-1]] == pytest.approx(shares, abs=0.51)
    fifth = rows["success 100 -> 80 % of one optimiser on all its 3 problems"]
    assert float(fifth["20 trials"]) > POWER
    quiet = [row for change, row in rows.items() if change.startswith("nothing")]
    assert len(quiet) == 3
    assert all(
        float(row[f"{trials} trials"]) <= LEVEL for row in quiet for trials in (20, 40, 60, 80)
    )


@pytest.mark.soak
def test_a_row_is_drawn_as_the_gate_judges(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "studies"))
    from gate_power import Scene, share_seen

    assert share_seen(Scene(1, 6, after=0.8), 20, 15).value > 0.9
    assert share_seen(Scene(3, 0), 20, 15).value == 0.0


def test_the_level_is_shared_by_all_that_is_asked_of_a_baseline(monkeypatch):
    levels = []
    keys = {"one": ["a", "b"], "other": ["c"]}
    sample = SimpleNamespace(array=list, successes=None)
    before = SimpleNamespace(samples=dict.fromkeys("abc", sample))
    monkeypatch.setattr(regression, "by_optimiser", lambda samples: keys)
    monkeypatch.setattr(regression, "together", lambda samples, keys: None)
    monkeypatch.setattr(regression, "smallest_seen", lambda *given: levels.append(given[3]))
    assert len(list(regression._seen(before, 0.07, 1.5))) == 2
    # Time and successes of each of three, and the successes of one on both of its problems.
    assert levels == pytest.approx([0.01] * 2)
