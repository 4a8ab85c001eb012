"""What is no effect of the library is a hypothesis like one.

Laws that are typed or found, columns that are split and rows that stand out: each is seen before it
is taken, taken with a click, and stands in the ladder, the session and the command.
"""

from __future__ import annotations

import json
import shlex
from typing import Any

import numpy as np
import pytest
from browsing import IN_A_BROWSER, Open

import springpot
from springpot.diagnosis.result import silent, unseen
from springpot.errors import SpringpotError
from springpot.measurement import Measurement
from springpot.report.text import to_json
from springpot.web import leaving
from springpot.web.sessions import State, digest_of, measured_in, text_of
from springpot.web.tasks import _ladder, again, answered, ladder_of, trial
from springpot.web.trying import ranked, telling

MODEL = "fractional-maxwell"
LAW = "my-mass = parallel: -m*omega^2"
OMEGA = np.geomspace(3.0, 300.0, 12)


def table(data: Measurement, **columns: str) -> str:
    """A CSV file of these data."""
    head = ["omega [rad/s]", "storage [N/mm]", "loss [N/mm]"]
    head += [f"{name} [{unit}]" for name, unit in columns.items()]
    rows = np.column_stack(
        [data.omega, data.storage, data.loss, *(data.conditions[name] for name in columns)]
    )
    lines = [",".join(head), *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    return "\n".join(lines) + "\n"


def of_amplitudes() -> Measurement:
    """What softens by a power of the amplitude, which no effect of the library does."""
    omega, amplitude = np.tile(OMEGA, 4), np.repeat([0.2, 0.5, 1.0, 3.0], len(OMEGA))
    model = springpot.parse_model(f"{MODEL} + (series: X^n/k)")
    conditions = {"amplitude": amplitude}
    at = springpot.Measurement(omega, omega + 0j, conditions=conditions).points
    exact = model.stiffness(np.array([400.0, 60.0, 0.5, 900.0, 0.7]), at)
    noise = 0.01 * np.random.default_rng(1).normal(size=(2, len(omega)))
    return springpot.Measurement(
        omega, exact * (1 + noise[0] + 1j * noise[1]), conditions=conditions
    )


def of_currents(extra: float = 0.0) -> Measurement:
    """Half as stiff again at the second current; the sixth point by `extra` more."""
    omega, current = np.tile(OMEGA, 2), np.repeat([0.5, 1.0], len(OMEGA))
    noise = 0.005 * np.random.default_rng(3).normal(size=(2, len(omega)))
    stiffness = 50.0 * np.where(current > 0.7, 1.5, 1.0) * (1j * omega) ** 0.4
    stiffness *= 1.0 + noise[0] + 1j * noise[1]
    stiffness[5] *= 1.0 + extra
    return springpot.Measurement(omega, stiffness, conditions={"current": current})


def asked(data: Measurement, model: str, *accepted: str) -> tuple[State, dict[str, Any]]:
    """A state and its answer, as the page gets it from a worker that remembers ladders."""
    text = text_of(data)
    state = State(digest_of(text), model, accepted)
    return state, json.loads(to_json(answered(silent, state.to_dict(), text)))


def tried(state: State, data: Measurement, law: object) -> dict[str, Any]:
    """What the page is told of a state with a law, before it is asked for."""
    return trial(silent, state.to_dict(), text_of(data), law)


@pytest.fixture(scope="module")
def damper_data(damper: bytes) -> Measurement:
    return measured_in("damper.csv", damper)[0]


def test_a_law_is_tried_with_the_error_that_its_rung_has(damper_data: Measurement):
    state = State("0" * 64, MODEL)
    found = tried(state, damper_data, LAW)
    assert found["accept"] == [LAW]
    assert found["sizes"][0].startswith("m = 0.59")
    known = springpot.identify(damper_data, f"{MODEL} + inertia")
    assert found["error"] == pytest.approx(known.relative_rms, rel=1e-3)
    assert len(found["curves"][0]["storage"]) > 50


def test_a_law_without_a_name_is_called_by_its_place(damper_data: Measurement):
    state = State("0" * 64, MODEL, (LAW,))
    (law,) = tried(state, damper_data, "series: 1/k")["accept"]
    assert law == "law-2 = series: 1/k"
    assert state.accepting(law).expression == f"{MODEL} + ({LAW}) + ({law})"


@pytest.mark.parametrize("typed", ["foo", "x = parallel: -m*omega^", 7, "x" * 300])
def test_what_is_no_law_is_one_line(damper_data: Measurement, typed: object):
    with pytest.raises(SpringpotError) as told:
        tried(State("0" * 64, MODEL), damper_data, typed)
    assert "\n" not in str(told.value)


@pytest.mark.soak
def test_an_accepted_law_is_a_rung_and_stands_in_command_and_session(damper_data: Measurement):
    state = State(digest_of(text_of(damper_data)), MODEL, (LAW,))
    ladder = _ladder(state, text_of(damper_data), silent)
    assert [step.accepted for step in ladder.steps] == [None, "my-mass"]
    assert ladder.verdict == "adequate"
    words = shlex.split(leaving.command(state, "damper.csv"))
    assert words[words.index("--accept") + 1] == LAW
    assert State.of(json.loads(json.dumps(state.to_dict()))) == state


@pytest.mark.soak
def test_a_column_is_split_with_the_error_that_its_rung_has():
    data = of_currents()
    state, told = asked(data, "springpot")
    (action,) = told["actions"]
    assert action["label"] == "split by current"
    ladder = ladder_of(state.accepting(*action["accept"]), data)
    preview = told["previews"][action["name"]]
    assert preview["error"] == pytest.approx(ladder.steps[-1].relative_rms, rel=0.01)
    assert preview["error"] < 0.1 * told["discovery"]["diagnosis"]["error"]["relative_rms"]


def test_rows_are_chosen_by_any_column_that_was_set():
    told = again(silent, {}, text_of(of_currents()), "mine.csv", False)
    assert [(level["name"], len(level["rows"])) for level in told["levels"]] == [
        ("current 0.5", len(OMEGA)),
        ("current 1", len(OMEGA)),
    ]


@pytest.mark.soak
def test_taking_one_of_two_rivals_leaves_the_question(damper_data: Measurement):
    _, before = asked(damper_data, MODEL)
    _, told = asked(damper_data, MODEL, "inertia")
    assert told["discovery"]["diagnosis"]["next_experiment"] is None
    assert told["proposed"] == before["proposed"]
    assert told["next"]["rivals"] == before["next"]["rivals"]
    _, both = asked(damper_data, MODEL, "inertia", "specimen-inertia")
    assert both["proposed"] is None


@pytest.mark.soak
def test_a_row_that_stands_out_is_seen_left_out(damper_data: Measurement):
    stiffness = damper_data.stiffness.copy()
    stiffness[7] *= 1.3
    data = springpot.Measurement(damper_data.omega, stiffness)
    _, told = asked(data, f"{MODEL} + inertia")
    (action,) = told["actions"]
    assert (action["label"], action["exclude"]) == ("leave out row 8", [7])
    whole = springpot.identify(data, f"{MODEL} + inertia").relative_rms
    assert told["previews"][action["name"]]["error"] < 0.3 * whole


@pytest.mark.soak
def test_causes_are_told_as_they_are_tried(damper_data: Measurement):
    lines: list[Any] = []
    text = text_of(damper_data)
    state = State(digest_of(text), MODEL, seed=7)  # one that no ladder is remembered of
    told = answered(lines.append, state.to_dict(), text)
    early = {line["action"]["name"]: line for line in lines if isinstance(line, dict)}
    assert lines[-1] == "drawing what each effect would change"
    after = {
        one["effect"]: one["error_after"] for one in told["discovery"]["diagnosis"]["candidates"]
    }
    assert early["inertia"]["action"]["shown"].startswith("m = 0.59")
    assert {"inertia", "specimen-inertia"} <= set(early) <= set(after)
    for name in early:
        assert early[name]["preview"]["error"] == pytest.approx(after[name], rel=0.02)
    assert telling(print, state.accepting("inertia"), damper_data) is unseen


@pytest.mark.soak
def test_another_model_is_accepted_with_the_error_that_its_rung_has(damper_data: Measurement):
    state = State(digest_of(text_of(damper_data)), MODEL)
    models = [f"{MODEL} + inertia", "kelvin"]
    told = ranked(state, damper_data, springpot.compare(damper_data, models))
    first, second = told["actions"]
    assert (first["model"], first["accept"]) == (MODEL, ["inertia"])
    assert (first["shown"], second["shown"]) == ("4 parameters, holds", "2 parameters, fails")
    taken = State(state.data, first["model"], tuple(first["accept"]))
    step = _ladder(taken, text_of(damper_data), silent).steps[-1]
    preview = told["previews"][first["name"]]
    assert preview["error"] == pytest.approx(step.relative_rms, rel=1e-3)


@pytest.mark.soak
@IN_A_BROWSER
def test_a_law_is_previewed_while_it_is_typed_taken_and_undone(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, MODEL)
    here.page.fill("#law", "my-mass = parallel: -m*omega^")
    here.page.locator("#law-says", has_text="no formula").wait_for()
    assert here.page.get_attribute("#add-law", "aria-disabled") == "true"
    here.page.fill("#law", LAW)
    here.page.locator("#law-says", has_text="m = 0.59").wait_for()
    assert "kg" in here.reads("#law-says")
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert "0.57" in here.page.text_content("#plot-ladder .ghost")
    assert here.violations() == []
    card = here.page.locator("[data-title='A law of your own'] [role=option]")
    here.page.hover("#verdict")
    card.hover()
    assert "0.57" in here.page.text_content("#plot-ladder .ghost")
    card.click()
    here.shows(f"{MODEL} + ({LAW})")
    assert here.page.locator("[data-title='A law of your own']").count() == 0
    assert "+ my-mass" in here.reads("#rungs")
    here.page.reload()
    here.shows(f"{MODEL} + ({LAW})")
    here.page.click("#undo")
    here.shows(MODEL)


@IN_A_BROWSER
@pytest.mark.soak
def test_a_law_is_found_where_no_effect_explains(page: Open):
    here = page()
    here.open("rubber.csv", table(of_amplitudes(), amplitude="mm").encode(), MODEL)
    assert "unexplained" in here.reads("#verdict")
    here.page.click("#find-law")
    here.done()
    first = here.page.locator("#effects .shelf").first
    assert first.get_attribute("data-title") == "Laws that these data cannot tell apart"
    option = first.locator("[role=option]").first
    option.hover()
    assert here.page.locator("#plot-view .line.preview").count() == 8
    assert "13.0 % → 1.17 %" in here.reads("#effect-details")
    assert here.violations() == []
    option.click()
    here.shows(f"{MODEL} + (law-1 = series: X^n/k)")
    assert "adequate" in here.reads("#verdict")


@IN_A_BROWSER
@pytest.mark.soak
def test_other_models_are_cards_while_nobody_waits(page: Open, damper: bytes):
    here = page()
    here.rests()
    here.open("damper.csv", damper, MODEL)
    card = here.page.locator("[data-title='Another model'] [role=option]").first
    card.wait_for()
    card.hover()
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert here.violations() == []


@pytest.mark.soak
@IN_A_BROWSER
def test_points_are_seen_left_out_before_they_are(page: Open, damper: bytes):
    here = page()
    here.open("damper.csv", damper, f"{MODEL} + inertia")
    box = here.page.locator("#plot-residual").bounding_box()
    here.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 20)
    here.page.mouse.down()
    here.page.mouse.move(box["x"] + 0.98 * box["width"], box["y"] + 90, steps=3)
    here.page.mouse.up()
    card = here.page.locator("[data-title='Points that are chosen'] [role=option]")
    card.wait_for()
    here.page.hover("#exclude")
    ghost = here.page.text_content("#plot-ladder .ghost")
    here.page.hover("#verdict")
    card.hover()
    assert here.page.locator("#plot-view .line.preview").count() == 2
    assert here.page.text_content("#plot-ladder .ghost") == ghost
    card.click()
    here.page.locator("#left-out").wait_for()
    here.done()
    assert f"{float(ghost.split()[0]):.2g}" == f"{100 * here.error():.2g}"
    here.page.click("#left-out button")
    here.page.locator("#left-out").wait_for(state="detached")
