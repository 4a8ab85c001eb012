"""Tests in time go through the whole loop on the page, alone and beside a sweep of the specimen."""

from __future__ import annotations

import base64
import json
import math
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from browsing import IN_A_BROWSER, Open, Page

import springpot.api
from springpot.diagnosis.result import silent
from springpot.errors import DataError
from springpot.registry import plugins
from springpot.report.text import to_json
from springpot.web import tasks
from springpot.web.sessions import (
    TESTS,
    Specimen,
    data_of,
    joined,
    measured_in,
    session_of,
    specimen_of,
    text_of,
)
from springpot.web.tasks import answered, curve, first, held, perform, trial, turned, understand

TIME = np.geomspace(0.1, 100.0, 40)
ORDER = 0.2
FEW = "parallel-springpot", "parallel-spring", "relaxation-mode"


def relaxation(every: int = 1) -> bytes:
    """What relaxes as a power of time."""
    noise = 1.0 + 0.005 * np.random.default_rng(1).normal(size=len(TIME))
    rows = [*zip(TIME, 300.0 * TIME**-ORDER * noise, strict=True)][::every]
    return b"time [s],relaxation [kPa]\n" + b"".join(b"%.6g,%.6g\n" % row for row in rows)


def sweep() -> bytes:
    """The same material at frequencies."""
    omega = np.geomspace(0.05, 50.0, 25)
    noise = 0.005 * np.random.default_rng(2).normal(size=(2, len(omega)))
    modulus = 300.0 * math.gamma(1.0 - ORDER) * (1j * omega) ** ORDER
    modulus *= 1.0 + noise[0] + 1j * noise[1]
    rows = zip(omega / 2 / np.pi, modulus.real, modulus.imag, strict=True)
    head = b"frequency [Hz],storage [kPa],loss [kPa]\n"
    return head + b"".join(b"%.6g,%.6g,%.6g\n" % row for row in rows)


def record() -> bytes:
    """A spring beside a dashpot that swings up."""
    t = np.linspace(0.0, 2.0, 160)
    moved = 5.0 * np.sin(8.0 * t) * (1.0 - np.exp(-3.0 * t))
    pulled = 40.0 * moved + 3.0 * np.gradient(moved, t)
    pulled += np.random.default_rng(3).normal(size=len(t))
    rows = zip(t, moved, pulled, strict=True)
    head = b"time [s],displacement [mm],force [N]\n"
    return head + b"".join(b"%.6g,%.6g,%.6g\n" % row for row in rows)


def against() -> bytes:
    """The record with a force that counts the other way."""
    head, *rows = record().decode().splitlines()
    cells = (row.split(",") for row in rows)
    return "\n".join(
        [head, *(f"{t},{moved},{-float(pulled)}" for t, moved, pulled in cells)]
    ).encode()


def opened(name: str, content: bytes) -> dict[str, Any]:
    """What the page is told of a file."""
    return understand(silent, name, base64.b64encode(content).decode())


@pytest.fixture(scope="module")
def relaxed() -> dict[str, Any]:
    return opened("relax.csv", relaxation())


@pytest.fixture(scope="module")
def answer(relaxed: dict[str, Any]) -> dict[str, Any]:
    """As few effects give it: that of all of them takes ten times as long."""
    state = {"data": relaxed["digest"], "model": "maxwell"}
    few = [plugins().effect(name) for name in FEW]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(springpot.api, "library", lambda *_, **__: few)
        return json.loads(to_json(answered(silent, state, relaxed["text"])))


@pytest.mark.soak
def test_the_answer_is_that_of_discover(answer: dict[str, Any]):
    test = Specimen.of_file("relax.csv", relaxation(), "").tests[0]
    same = springpot.discover([test], "maxwell", accept=[], only=FEW)
    assert answer["discovery"] == json.loads(to_json(same))


def test_a_first_look_tells_what_the_answer_tells_of_the_model(
    relaxed: dict[str, Any], answer: dict[str, Any]
):
    early = json.loads(to_json(first(silent, answer["state"], relaxed["text"])))
    told, diagnosis = (one["discovery"]["diagnosis"] for one in (early, answer))
    assert told["verdict"] == "sought"
    assert told["error"]["relative_rms"] == diagnosis["error"]["relative_rms"]
    assert 0.0 < told["error"]["material_floor"] < 0.1 * told["error"]["relative_rms"]
    assert told["where"][0]["to"] == diagnosis["where"][0]["to"]
    assert early["model"] == answer["model"]
    assert early["previews"] == {}


@pytest.mark.soak
def test_causes_are_told_as_they_are_tried(relaxed: dict[str, Any], answer: dict[str, Any]):
    lines: list[Any] = []
    state = {"data": relaxed["digest"], "model": "maxwell", "seed": 7}  # that no ladder is kept of
    answered(lines.append, state, relaxed["text"])
    early = {line["action"]["name"]: line for line in lines if isinstance(line, dict)}
    assert len(early) > 5
    rows = answer["discovery"]["diagnosis"]["candidates"]
    fitted = [row for row in rows if row["error_after"] is not None]
    assert fitted
    for row in fitted[:3]:
        told = early[row["effect"]]
        assert told["preview"]["error"] == pytest.approx(row["error_after"], rel=0.02)
        assert len(told["preview"]["curves"][0]["storage"]) > 100
    assert early["parallel-springpot"]["action"]["shown"].startswith("c = 34")


def test_every_effect_that_was_fitted_comes_with_its_curve(answer: dict[str, Any]):
    best = answer["discovery"]["diagnosis"]["candidates"][0]
    preview = answer["previews"][best["effect"]]
    assert preview["error"] == pytest.approx(best["error_after"], rel=1e-6)
    assert len(preview["curves"][0]["storage"]) > 100
    left = np.array(preview["planes"]["signal"]["storage"])
    width = np.array(answer["model"]["planes"]["signal"]["width"])
    assert np.sqrt(np.mean((left / width) ** 2)) < 2.0


def test_a_force_that_counts_the_other_way_is_seen_turned_and_turned():
    data = opened("record.csv", against())
    state = {"data": data["digest"], "model": "kelvin"}
    told = json.loads(to_json(answered(silent, state, data["text"])))
    (action,) = [one for one in told["actions"] if one["turns"]]
    assert action["label"] == "turn record"
    preview, now = told["previews"][action["name"]], told["discovery"]["diagnosis"]["error"]
    assert preview["error"] < 1.05 * now["noise_floor"] < 0.1 * now["relative_rms"]
    # It is drawn over the data as they stand.
    assert max(map(abs, preview["planes"]["signal"]["storage"])) < 10.0
    anew = turned(silent, state, data["text"], "record.csv", joined=False)
    assert anew["source"] == "record.csv?force=-N"
    assert anew["scene"]["storage"] == [-one for one in data["scene"]["storage"]]
    assert "note sign" not in anew["provenance"]


def test_parameters_tell_how_they_move_together(answer: dict[str, Any]):
    k, c = answer["parameters"]
    assert k["correlated"] == {"c": c["correlated"]["k"]}
    assert 0.1 < abs(k["correlated"]["c"]) < 1.0


def test_views_are_told_to_the_page_as_data(relaxed: dict[str, Any]):
    (view,) = relaxed["scene"]["views"].values()
    assert (view["name"], view["x"]["log"]) == ("stress over time", True)
    views = opened("record.csv", record())["scene"]["views"]
    assert [view["name"] for view in views.values()] == [
        "force over time",
        "force over displacement",
    ]
    assert [view["x"]["log"] for view in views.values()] == [False, False]


def test_a_law_is_tried_on_a_test_in_time(relaxed: dict[str, Any]):
    state = {"data": relaxed["digest"], "model": "maxwell"}
    found = trial(silent, state, relaxed["text"], "gel = parallel: k*(i*omega)^a")
    assert "a = 0.199" in found["sizes"][1]
    assert found["error"] < 0.01


def test_files_cross_as_they_came_and_so_into_a_session(relaxed: dict[str, Any]):
    data = data_of(relaxed["text"])
    assert isinstance(data, Specimen)
    assert text_of(data) == relaxed["text"]
    session = {
        "schema": "springpot.session/1",
        "data": {"source": "relax.csv", "text": relaxed["text"]},
        "branches": [{"name": "A", "states": [{"data": relaxed["digest"]}], "at": 0}],
    }
    known = session_of(json.dumps(session).encode())
    assert known["branches"][0]["states"][0]["data"] == relaxed["digest"]


def test_tests_nested_too_deeply_are_refused_in_one_line():
    nested = "[" * 100_000 + "]" * 100_000
    with pytest.raises(DataError, match="no tests in time: nested too deeply"):
        specimen_of(f'{{"schema": "{TESTS}", "files": {nested}}}')


def test_a_relaxation_and_a_sweep_are_tests_of_one_specimen():
    one, other = measured_in("relax.csv", relaxation())[0], measured_in("sweep.csv", sweep())[0]
    both = joined(one, other)
    assert isinstance(both, Specimen)
    assert [test.name for test in both.tests] == ["relax", "sweep"]
    relaxed, swept = both.subset((np.arange(len(both)) > 4) & (np.arange(len(both)) != 45)).tests
    assert (len(relaxed), len(swept)) == (len(TIME) - 5, 24)
    (alone,) = both.subset(np.arange(len(both)) >= len(TIME)).tests
    assert alone.name == "sweep"


def test_rows_of_several_tests_leave_in_the_session_alone(relaxed: dict[str, Any]):
    both = joined(data_of(relaxed["text"]), measured_in("sweep.csv", sweep())[0])
    asked = {"kind": "script", "text": text_of(both), "source": "", "joined": True}
    told = perform("leave", {**asked, "state": {"data": "", "excluded": [0]}}, silent)
    assert "only the session" in told["error"]


def test_a_plan_of_frequencies_leaves_with_a_sweep_among_tests_in_time(
    relaxed: dict[str, Any], monkeypatch: pytest.MonkeyPatch
):
    advice = SimpleNamespace(action={"omega": [2.0 * np.pi]}, says="sweep: extend it")
    ladder = SimpleNamespace(undecided=SimpleNamespace(next_experiment=advice))
    monkeypatch.setattr(tasks, "_ladder", lambda *_: ladder)
    both = joined(data_of(relaxed["text"]), measured_in("sweep.csv", sweep())[0])
    asked = {"kind": "plan", "source": "", "joined": True, "state": {"data": "", "model": "kelvin"}}
    told = perform("leave", {**asked, "text": text_of(both)}, silent)
    says, head, row = told["result"]["text"].splitlines()
    assert says == "# sweep: extend it"
    assert head.startswith("frequency [Hz]")
    assert row.startswith("1.0,")
    advice.action = {"factor": [3.0]}
    told = perform("leave", {**asked, "text": text_of(both)}, silent)
    assert "told in words" in told["error"]


def test_a_hand_moves_the_parameters_of_a_test_in_time(
    relaxed: dict[str, Any], answer: dict[str, Any]
):
    state = {"data": relaxed["digest"], "model": "maxwell"}
    hands = {one["name"]: {"value": one["value"]} for one in answer["parameters"]}
    same = curve(silent, state, relaxed["text"], hands)
    told = answer["discovery"]["diagnosis"]["error"]["relative_rms"]
    assert same["error"] == pytest.approx(told, rel=1e-3)
    hands["k"]["value"] *= 2.0
    assert curve(silent, state, relaxed["text"], hands)["error"] > 1.5 * told
    hands["k"]["fixed"] = True
    found = held(silent, state, relaxed["text"], hands)
    assert found["values"]["k"] == hands["k"]["value"]
    assert found["error"] > told


@pytest.mark.soak_cases("replay", "curves")
@pytest.mark.parametrize("kind", ["command", "script", "curves", "data", "plan", "replay"])
def test_what_leaves_with_a_test_in_time_is_whole_or_says_why(relaxed: dict[str, Any], kind: str):
    state = {"data": relaxed["digest"], "model": "maxwell", "excluded": [0]}
    asked = {"kind": kind, "state": state, "text": relaxed["text"], "source": "", "joined": False}
    told = perform("leave", asked, silent)
    if kind in ("data", "plan"):
        assert not told["fault"]
    elif kind == "replay":
        assert told["result"]["name"] == "relax-replay.gif"
        assert base64.b64decode(told["result"]["base64"]).startswith(b"GIF89a")
    elif kind == "curves":
        assert len(told["result"]["text"].splitlines()) == len(TIME)
    else:
        assert "relax.csv" in told["result"]["text"]
        assert "row=1" in told["result"]["text"]


def words_stand_apart(here: Page) -> None:
    """Numbers at an axis that is bent around zero; names of floors near the foot of the ladder."""
    boxes = "words => words.map((word) => word.getBoundingClientRect().toJSON())"
    ticks = here.page.locator("#plot-residual .tick[text-anchor=end]").evaluate_all(boxes)
    assert len(ticks) > 3
    assert all(a["top"] >= b["bottom"] - 3 for a, b in pairwise(ticks[::-1]) if a["top"] > b["top"])
    [line] = here.page.locator("#plot-ladder .material").evaluate_all(boxes)
    names = here.page.locator("#plot-ladder .tick:has-text('floor')").evaluate_all(boxes)
    assert len(names) == 2
    assert not any(name["top"] < line["top"] < name["bottom"] - 3 for name in names)


def another_model(here: Page) -> None:
    """A card like that of a cause: pointed at, accepted on the ladder, undone."""
    here.page.click("#rank")
    card = here.page.locator("[data-title='Another model'] [data-effect='springpot instead']")
    card.hover()
    assert here.page.locator("#plot-view .line.preview").count() == 1
    ghost = here.page.text_content("#plot-ladder .ghost")
    assert "2 parameters" in card.inner_text()
    card.click()
    here.shows("springpot")
    assert "springpot" in here.reads("#rung-0")
    assert f"{float(ghost.split()[0]):.2g}" == f"{100 * here.error():.2g}"
    here.page.click("#undo")
    here.shows("maxwell")
    assert card.count() == 1


@pytest.mark.soak
@IN_A_BROWSER
def test_a_relaxation_goes_through_the_whole_loop(page: Open):
    here = page()
    here.open("relax.csv", relaxation(every=2), "maxwell")
    assert here.reads("#facts") == "20 points, 1 test"
    assert "effect-missing" in here.reads("#verdict")
    assert here.reads("#fails").startswith("relax is missed most")
    words_stand_apart(here)
    here.page.hover("#effect-parallel-springpot")
    assert here.page.locator("#plot-view .line.preview").count() == 1
    assert here.page.locator("#plot-residual .line.preview").count() == 1
    assert here.violations() == []
    here.page.locator("[aria-label='move k']").press("ArrowRight")
    here.page.locator("#plot-residual .line.edited").wait_for(state="attached")
    here.page.click("#effect-parallel-springpot")
    here.shows("maxwell + parallel-springpot")
    assert "adequate" in here.reads("#verdict")
    here.page.click("#undo")
    here.shows("maxwell")
    another_model(here)
    here.page.reload()
    here.shows("maxwell")
    here.page.mouse.move(600, 450)
    assert "kPa; model" in here.reads("#readout")


@pytest.mark.soak
@IN_A_BROWSER
def test_a_record_is_turned_by_a_click_and_what_was_foretold_is_fitted(page: Open):
    here = page()
    here.open("record.csv", against(), "kelvin")
    assert here.reads("#add").startswith("Turn record → ")
    here.page.click("#add")
    here.page.locator("#verdict.adequate").wait_for(state="attached")
    assert here.reads("#turned") == "turned: force=-N"
    card = here.page.locator("[role=option]:has-text('not fitted')").first
    effect = card.get_attribute("data-effect")
    card.hover()
    fitted = here.page.locator(f"[data-effect='{effect}']:not(:has-text('not fitted'))")
    fitted.wait_for(state="attached")
    assert here.page.locator("#plot-view .line.preview").count() == 1
    here.page.click("#undo")
    here.page.locator("#verdict.unexplained").wait_for(state="attached")
    assert here.page.locator("#turned").count() == 0


@pytest.mark.soak
@IN_A_BROWSER
def test_a_record_is_drawn_as_loops_and_sweeps_stand_beside(page: Open):
    here = page()
    here.open("record.csv", record(), "kelvin")
    here.page.select_option("#view", "loop-0")
    label = here.page.get_attribute("#plot-view", "aria-label")
    assert "force [N] against displacement [mm]" in label
    assert "adequate" in here.reads("#verdict")
    here.page.set_viewport_size({"width": 390, "height": 844})
    assert here.violations() == []
