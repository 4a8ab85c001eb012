"""The study of measured data.

Its tables follow from its answers, and it runs with what is on this machine.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "studies"))

import real_data  # noqa: E402
from real_sets import sets, unseen, without_model  # noqa: E402
from real_sets.answers import saved, table  # noqa: E402
from real_sets.published import published  # noqa: E402
from springpot.report.page import to_csv, to_markdown  # noqa: E402

RESULTS = ROOT / "results" / "real_data"
SMALL = replace(sets.SETS[0], data="nist-srm2491@temperature=20", models=("maxwell-2",), accept=())


@pytest.fixture
def nowhere(monkeypatch, tmp_path):
    """No data directory at all."""
    from springpot.registry import plugins

    monkeypatch.setenv("SPRINGPOT_DATA", str(tmp_path / "nothing"))
    plugins.cache_clear()
    yield
    plugins.cache_clear()


def test_the_committed_tables_follow_from_the_committed_answers():
    answers = list(saved(RESULTS))
    assert "pdms" in {one["set"] for one in answers} <= {one.name for one in sets.SETS}
    for stem, made in (("real_data", table(answers)), ("published", published(answers))):
        assert (RESULTS / f"{stem}.md").read_text(encoding="utf-8") == to_markdown(made)
        assert (RESULTS / f"{stem}.csv").read_text(encoding="utf-8") == to_csv(made)
    without = list(without_model.saved(RESULTS))
    if without:
        made = without_model.table(without)
        assert (RESULTS / "without_model.md").read_text(encoding="utf-8") == to_markdown(made)


def test_the_table_changes_with_an_answer():
    answers = list(saved(RESULTS))
    changed = json.loads(json.dumps(answers[0]))
    changed["verdict"] = "inconclusive"
    assert table([changed]).rows[0] != table(answers[:1]).rows[0]
    assert "inconclusive" in table([changed]).rows[0]


@pytest.mark.soak
def test_an_embedded_set_goes_through_from_data_to_tables(nowhere, monkeypatch, tmp_path):
    monkeypatch.setattr(real_data, "SETS", (SMALL,))
    real_data.main(["pdms", "--out", str(tmp_path)])
    (one,) = saved(tmp_path)
    assert (one["points"], one["model"]) == (16, "maxwell-2")
    assert one["steps"][0]["relative_rms"] > 0
    assert (tmp_path / "pdms.png").stat().st_size > 10_000
    first = {path.name: path.read_bytes() for path in tmp_path.glob("*.*")}
    real_data.main(["--out", str(tmp_path), "--report-only"])
    assert {path.name: path.read_bytes() for path in tmp_path.glob("*.*")} == first
    (free,) = without_model.saved(tmp_path)
    assert 0 < free["first"]["error"]["material_floor"] < one["steps"][0]["relative_rms"]
    assert "within 1.5 x or named" in (tmp_path / "without_model.md").read_text(encoding="utf-8")


def told(verdict: str, error: float, missing: list[str], notes: list[str]) -> dict[str, object]:
    step = {"relative_rms": error, "noise_floor": 0.01, "accepted": None, "class": []}
    part = {"verdict": verdict, "says": "", "notes": notes, "error": {"material_floor": 0.01}}
    last = part | {"missing": missing}
    return {
        "set": "x",
        "points": 9,
        "steps": [step],
        "verdict": verdict,
        "first": part,
        "last": last,
    }


def test_without_a_model_a_set_is_settled_near_the_floor_or_with_a_named_cause():
    near, far = (
        told("unexplained", 0.014, [], []),
        told("unexplained", 0.016, [], ["diagnosed on 9 points"]),
    )
    effect = told("effect-missing", 0.05, ["inertia", "basset"], [])
    chain = told("unexplained", 0.05, [], ["what is missing looks like a gain that drifts"])
    points = told("unexplained", 0.05, [], ["a single point stands out and was set aside"])
    found = [without_model.is_settled(one) for one in (near, far, effect, chain, points)]
    assert found == [True, False, True, True, False]
    assert without_model.cause(effect) == "inertia or basset"
    goal = without_model.table([near, far, effect, chain]).rows[-1]
    assert goal[-3] == "3 of 4: not met"
    assert without_model.table([near] * 12).rows[-1][-3] == "12 of 12: met"


@pytest.mark.parametrize(
    ("verdict", "accepted", "missing", "notes", "word"),
    [
        ("unexplained", ["payne"], [], [], "right"),
        ("effect-missing", [], ["friction", "payne"], [], "right"),
        ("effect-missing", ["payne"], ["inertia"], [], "confidently wrong"),
        ("unexplained", ["friction"], [], [], "confidently wrong"),
        ("adequate", [], [], [], "confidently wrong"),
        ("unexplained", [], [], ["payne would explain the data as well"], "defensible"),
        ("unexplained", [], [], [], "hedged"),
    ],
)
def test_a_set_is_judged_by_what_is_true_of_it(verdict, accepted, missing, notes, word):
    one = told(verdict, 0.05, missing, notes) | {"set": "elastomer"}
    one["steps"] += [one["steps"][0] | {"accepted": name, "class": [name]} for name in accepted]
    assert without_model.judged(one) == word


def test_absent_sets_are_one_line_each(nowhere, capsys, tmp_path):
    real_data.main(["micelles", "friction-damper", "--out", str(tmp_path)])
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(": not on this machine")[0] for line in lines] == [
        "micelles",
        "friction-damper",
    ]
    assert not list(tmp_path.iterdir())


def test_an_unknown_set_is_refused_with_the_known_ones(capsys):
    with pytest.raises(SystemExit):
        real_data.main(["nothing"])
    assert "no set nothing; there are pdms" in capsys.readouterr().err


def _told(**changed):
    answer = {
        "file": unseen.FILES[4].file,
        "verdict": "unexplained",
        "says": "something is missing",
        "explains": [],
        "helps": ["finite-ramp", "thermal-force"],
        "missing": [],
        "before": 0.0234,
        "after": 0.0091,
        "floor": 0.002,
        "action": "accept it",
    }
    return answer | changed


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ({}, "right"),
        ({"helps": ["thermal-force", "finite-ramp"]}, "defensible"),
        ({"helps": ["thermal-force"]}, "hedged"),
        (
            {"explains": ["basset", "ageing"], "says": "missing is basset or ageing"},
            "defensible",
        ),
        (
            {"verdict": "effect-missing", "explains": ["basset"], "missing": ["basset"]},
            "confidently wrong",
        ),
        ({"verdict": "adequate", "helps": []}, "confidently wrong"),
    ],
)
def test_an_answer_on_a_file_is_judged_by_what_is_true_of_it(changed, word):
    one = unseen.FILES[4]
    assert unseen.judged(one, _told(**changed)) == word
    rows = unseen.table([_told(**changed)]).rows
    assert rows[0][7] == word
    assert rows[-1][7].endswith("of 1")


def test_a_file_that_is_not_here_is_passed_over_with_the_reason(tmp_path):
    told = unseen.ask(unseen.FILES[0], tmp_path)
    assert told["skipped"] == "not on this machine"
    assert unseen.table([told]).rows[-1][7].endswith("of 0")
