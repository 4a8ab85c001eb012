"""Pure parts of the workbench.

States, data as text, sessions, what one leaves with, parameters by hand.
"""

from __future__ import annotations

import json
import runpy
import shlex
from collections import OrderedDict
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

import springpot
from remembered import remember
from springpot.diagnosis import Ladder
from springpot.errors import DataError, ModelError, OptionError
from springpot.measurement import Measurement
from springpot.measurement.replicates import THINNED
from springpot.report.interactive import scene as drawing
from springpot.report.interactive.scene import (
    PageScene,
    proposed_points,
    relative_error,
    rounded,
)
from springpot.report.page import modules
from springpot.report.text import to_json
from springpot.rheology.nodes import PLANES, Parallel
from springpot.web import leaving, tasks
from springpot.web.sessions import (
    State,
    digest_of,
    is_session,
    joined,
    joined_anew,
    kept,
    measured_in,
    measurement_of,
    safe_name,
    session_of,
    text_of,
)
from springpot.web.tasks import answer, curve, held, ladder_of

MODEL = "fractional-maxwell"


@pytest.fixture(scope="module")
def data(damper: bytes) -> Measurement:
    return measurement_of(text_of(measured_in("damper.csv", damper)[0]))


@pytest.fixture(scope="module")
def state(data: Measurement) -> State:
    return State(digest_of(text_of(data)), MODEL)


@pytest.fixture(scope="module")
def ladder(state: State, data: Measurement) -> Ladder:
    with pytest.MonkeyPatch.context() as patch:
        # The README asks for the same.
        remember(patch)
        return ladder_of(state, data)


@pytest.fixture(scope="module")
def first(state: State, ladder: Ladder, data: Measurement) -> dict:
    return json.loads(to_json(answer(state, ladder, data)))


def test_a_key_is_that_of_its_state_and_of_no_other(state: State):
    others = [
        State(state.data, MODEL, ("inertia",)),
        State(state.data, MODEL, (), (1,)),
        State(state.data, MODEL, (), (), 1),
        State("x", MODEL),
        State(state.data),
        State(state.data, MODEL, fixed=(("k", 390.0),)),
        State(state.data, MODEL, options="--tie 'c = 2*k'"),
    ]
    assert len({one.key for one in [state, *others]}) == 8
    assert all(State.of(json.loads(json.dumps(one.to_dict()))).key == one.key for one in others)


ANYTHING = st.none() | st.integers() | st.floats() | st.text() | st.lists(st.text() | st.integers())


@given(
    st.dictionaries(
        st.sampled_from(["data", "model", "accepted", "excluded", "seed", "fixed", "options"]),
        ANYTHING,
    )
)
def test_a_state_takes_nothing_that_is_none(anything: dict[str, object]):
    try:
        state = State.of(anything)
    except DataError:
        return
    assert State.of(state.to_dict()) == state
    assert all(isinstance(name, str) for name in (state.data, state.model, *state.accepted))


@given(st.text(max_size=300))
def test_a_safe_name_is_a_name_and_no_path(name: str):
    safe = safe_name(name)
    assert safe
    assert Path(safe).name == safe
    assert safe not in (".", "..")
    assert not safe.startswith("-")
    assert not set(safe) & set("/\\?#@\0\n\x1b<>")
    assert len(safe) <= 80


def test_data_cross_as_text_bit_for_bit():
    data = springpot.read("nist-srm2491")
    again = measurement_of(text_of(data))
    assert np.array_equal(again.stiffness, data.stiffness)
    assert np.array_equal(again.omega, data.omega)
    assert again.sd is not None
    assert data.sd is not None
    assert np.array_equal(again.sd, data.sd)
    assert again.units == data.units
    assert again.reference_temperature == data.reference_temperature
    assert text_of(again) == text_of(data)


def test_what_is_left_out_is_left_out_and_nothing_else(data: Measurement):
    rest = kept(data, (0, 3))
    assert len(rest) == len(data) - 2
    assert rest.name == data.name
    assert np.array_equal(rest.omega, np.delete(data.omega, [0, 3]))
    with pytest.raises(DataError, match="no point 99"):
        kept(data, (99,))
    with pytest.raises(DataError, match="take some back"):
        kept(data, tuple(range(len(data))))


def test_new_data_join_in_the_units_that_are_there(data: Measurement):
    other = measured_in(
        "more.csv", b"frequency [Hz],storage [N/mm],loss [N/mm]\n60,250,50\n80,220,40\n"
    )[0]
    both = joined(data, other)
    assert both.units == data.units
    assert both.storage[-2:] == pytest.approx([250.0, 220.0])
    assert text_of(measurement_of(text_of(both))) == text_of(both)
    with pytest.raises(DataError, match="no joint test"):
        joined(
            data,
            measured_in("p.csv", b"frequency [Hz],storage [Pa],loss [Pa]\n60,250,50\n80,220,40\n")[
                0
            ],
        )
    strained = (
        b"frequency [Hz],storage [kN/m],loss [kN/m],amplitude [%s]\n60,250,50,1\n80,220,40,1\n"
    )
    in_mm, in_percent = (measured_in("a.csv", strained % unit)[0] for unit in (b"mm", b"%"))
    with pytest.raises(DataError, match="different kinds"):
        joined(in_mm, in_percent)


@pytest.mark.soak
def test_an_answer_is_that_of_discover(first: dict, state: State, data: Measurement):
    same = springpot.discover(data, MODEL, accept=[], seed=0)
    assert first["discovery"] == json.loads(to_json(same))
    assert first["key"] == state.key


@pytest.mark.soak
def test_every_candidate_comes_with_its_curve(first: dict, data: Measurement):
    candidates = first["discovery"]["diagnosis"]["candidates"]
    assert {row["effect"] for row in candidates} == set(first["previews"])
    inertia = first["previews"]["inertia"]
    grown = springpot.identify(data, f"{MODEL} + inertia")
    assert inertia["error"] == pytest.approx(candidates[0]["error_after"], rel=1e-6)
    assert inertia["error"] == pytest.approx(grown.relative_rms, rel=0.05)
    left = inertia["planes"]["stiffness"]
    left = np.array(left["storage"]) + 1j * np.array(left["loss"])
    error = np.sqrt(np.mean(np.abs(left / data.stiffness) ** 2))
    assert error == pytest.approx(inertia["error"], rel=1e-3)
    assert len(inertia["curves"]) == 1


def test_a_plane_of_residuals_is_told_to_the_page_as_data(data: Measurement, monkeypatch):
    """It was written a second time in JavaScript: a new composition needed both."""

    class Squared(Parallel):
        plane, symbol, unit, shows = "squared", "ΔK²", "({})²", "what adds up in squares"

        @staticmethod
        def residual(measured, modelled):
            return measured**2 - modelled.value**2

        @staticmethod
        def slope(modelled):
            return 0.5 / modelled.value

    monkeypatch.setattr(drawing, "PLANES", (*PLANES, Squared))
    scene, model = drawing.PageScene(data), springpot.parse_model("kelvin")
    assert scene.to_dict()["planes"]["squared"]["label"] == "ΔK² [(kN/m)²]"
    theta = model.theta(k=100.0, c=1.0)
    told = scene.curve(model, theta, np.ones(len(data)))["planes"]["squared"]
    modelled = model.stiffness(theta, data.points)
    assert told["storage"] == pytest.approx((data.stiffness**2 - modelled**2).real, rel=1e-3)
    assert told["width"] == pytest.approx(2.0 * data.magnitude, rel=1e-3)
    for name, source in modules().items():
        assert not [plane for plane in PLANES if f'"{plane.plane}"' in source.decode()], name


@pytest.mark.soak
def test_the_rivals_part_where_the_next_experiment_measures(first: dict, data: Measurement):
    rivals = first["next"]["rivals"]
    assert {rival["effect"] for rival in rivals} == set(
        first["discovery"]["diagnosis"]["next_experiment"]["separates"]
    )
    storage = [np.array(rival["storage"]) for rival in rivals]
    assert np.max(np.abs(storage[0] - storage[1]) / np.array(rivals[0]["width"])) > 5
    assert proposed_points(first["next"]["action"], data).omega == pytest.approx(
        first["next"]["action"]["omega"]
    )


def test_ten_thousand_rows_are_drawn_as_few(rng: np.random.Generator):
    omega = np.sort(rng.uniform(1.0, 100.0, 10_000))
    big = Measurement(omega, omega + 1j * np.sqrt(omega))
    scene = PageScene(big)
    assert len(scene.rows) == THINNED.points
    assert {int(scene.rows[0]), int(scene.rows[-1])} == {0, 9999}


@given(st.lists(st.floats(), max_size=20))
def test_rounding_keeps_six_digits_and_tells_what_is_no_number(values: list[float]):
    with np.errstate(all="ignore"):
        told = rounded(np.array(values))
    for value, shown in zip(values, told, strict=True):
        if not np.isfinite(value):
            assert shown is None
        elif 1e-290 < abs(value) < 1e290:
            assert shown == pytest.approx(value, rel=1e-5)


@pytest.mark.soak
def test_the_exported_script_gives_the_numbers_of_the_page(
    damper: bytes,
    data: Measurement,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    monkeypatch.chdir(tmp_path)
    Path("damper.csv").write_bytes(damper)
    state = State(digest_of(text_of(data)), MODEL, ("inertia",), (0, 3, 4))
    Path("again.py").write_text(leaving.script(state, "damper.csv"), encoding="utf-8")
    runpy.run_path("again.py", run_name="__main__")
    out = capsys.readouterr().out
    steps = ladder_of(state, data).steps
    for step in steps:
        assert (
            f"{step.model}: error {step.relative_rms:.6%}, noise floor {step.noise_floor:.6%}"
            in out
        )
    value = steps[-1].parameters["inertia.m"]
    assert f"inertia.m = {value.value:.6g} [{value.low:.6g}, {value.high:.6g}] kg" in out


@pytest.mark.soak
def test_new_data_where_it_was_proposed_break_the_tie(
    ladder: Ladder, data: Measurement, rng: np.random.Generator
):
    before = ladder.diagnosis
    assert set(before.next_experiment.separates) == {"inertia", "specimen-inertia"}
    assert set(before.classes[0]) == {"inertia", "specimen-inertia"}
    few = {"omega": before.next_experiment.action["omega"][::4]}
    points = proposed_points(few, data)
    grown = springpot.parse_model(f"{MODEL} + inertia")
    exact = grown.stiffness(
        grown.theta(**{"k": 400e3, "c": 60e3, "alpha": 0.55, "inertia.m": 0.6}), points
    )
    noise = 0.005 * (rng.normal(size=len(exact)) + 1j * rng.normal(size=len(exact)))
    measured = Measurement(points.omega, exact * (1 + noise) / 1e3, units=data.units, name="next")
    after = springpot.discover(joined(data, measured), MODEL, accept=[]).diagnosis
    assert after.best.effect == "inertia"
    assert after.best.probability > 0.99


def test_a_name_cannot_break_out_of_the_script(state: State):
    evil = '"""\nimport os; os.system("touch pwned")\n#'
    for text in (
        leaving.script(state, evil),
        leaving.script(State(state.data, evil[:60], (evil[:40],)), "x.csv"),
    ):
        compiled = compile(text, "script", "exec")
        assert "os" not in compiled.co_names


@pytest.mark.parametrize("fixed", [[], {"k": True}, {"k": "1"}, {"k": float("inf")}])
def test_what_is_held_is_a_finite_number_by_its_name(fixed):
    with pytest.raises(DataError, match="no state of the workbench"):
        State.of({"data": "x", "fixed": fixed})


@pytest.mark.soak
def test_what_is_held_is_fitted_on_no_rung(state: State, data: Measurement):
    held = replace(state, accepted=("inertia",), fixed=(("k", 390.0),))
    told = answer(held, ladder_of(held, data), data)
    assert [one["name"] for one in told["parameters"]] == ["c", "alpha", "inertia.m"]
    assert told["state"]["fixed"] == {"k": 390.0}


@pytest.mark.soak
def test_parameters_are_own_and_tied_as_on_the_command_line():
    omega, lot = np.tile(np.geomspace(1.0, 300.0, 8), 2), np.repeat([1.0, 2.0], 8)
    exact = lot * (100.0 + 2j * omega / (1.0 + 0.01j * omega))
    noise = 0.01 * np.random.default_rng(1).standard_normal((16, 2)) @ [1.0, 1.0j]
    data = Measurement(omega, exact * (1.0 + noise), conditions={"lot": lot})
    state = State("x", "zener", options="--own k1,c:lot --tie 'k2 = 2*k1'")
    told = answer(state, ladder_of(state, data), data)
    names = ["k1_1", "k1_2", "c_1", "c_2"]
    assert [one["name"] for one in told["parameters"]] == names
    assert told["state"]["options"] == state.options
    words = shlex.split(leaving.command(state, "d.csv"))
    assert words[-6:] == ["--own", "k1,c:lot", "--tie", "k2 = 2*k1", "--seed", "0"]
    assert "own={'k1': 'lot', 'c': 'lot'}, tie=['k2 = 2*k1'])" in leaving.script(state, "d.csv")
    for wrong in ("--fix k=2", "--own", "k1", "--tie 'k2"):
        with pytest.raises(OptionError):
            ladder_of(replace(state, options=wrong), data)


def test_the_command_line_is_that_of_the_state(state: State):
    words = shlex.split(leaving.command(state.accepting("inertia"), "my damper.csv"))
    assert words == [
        "springpot",
        "discover",
        "my damper.csv",
        "--model",
        MODEL,
        "--accept",
        "inertia",
        "--seed",
        "0",
    ]
    assert shlex.split(leaving.command(State("x"), "d.csv")) == [
        "springpot",
        "diagnose",
        "d.csv",
        "--seed",
        "0",
    ]
    held = State("x", MODEL, fixed=(("alpha", 0.5), ("k", 390.0)))
    assert leaving.command(held, "d.csv").endswith("--fix alpha=0.5 --fix k=390.0 --seed 0")
    assert "fix={'alpha': 0.5, 'k': 390.0})" in leaving.script(held, "d.csv")
    left_out = State("x", MODEL, (), (1, 7, 8))
    assert leaving.command(left_out, "d.csv").endswith(
        "--exclude row=8..9 --exclude row=2 --seed 0"
    )
    assert leaving.source_of("data/damper.csv", left_out, False) == "data/damper.csv"
    assert leaving.source_of("data/damper.csv", left_out, True) == "damper-used.csv"
    assert (
        leaving.source_of("damper.csv", State("x", MODEL, (), tuple(range(0, 90, 2))), False)
        == "damper-used.csv"
    )


def test_curves_leave_with_units_in_their_header(ladder: Ladder, data: Measurement):
    lines = leaving.curves_csv(ladder, data).splitlines()
    columns = lines[0].split(",")
    assert columns[2:6] == [
        "frequency [Hz]",
        "omega [rad/s]",
        "data storage [kN/m]",
        "data loss [kN/m]",
    ]
    row = lines[1].split(",")
    assert float(row[3]) == pytest.approx(2 * np.pi * float(row[2]))
    assert float(row[4]) == pytest.approx(data.storage[0])
    assert {line.split(",")[0] for line in lines[1:]} == {"point", "curve"}


def test_the_plan_opens_as_data_once_it_is_filled_in(ladder: Ladder, data: Measurement):
    plan = leaving.plan_csv(ladder, data)
    filled = "".join(
        f"{line[:-1]}5,3\n" if line[0].isdigit() else f"{line}\n" for line in plan.splitlines()
    )
    assert len(measured_in("plan.csv", filled.encode())[0]) == 20


def test_a_fit_by_hand_keeps_what_was_fixed_and_is_otherwise_the_fit(data: Measurement):
    text, state = text_of(data), {"data": "x", "model": f"{MODEL} + inertia"}
    best = springpot.identify(data, f"{MODEL} + inertia")
    hands = {name: {"value": 1.3 * value.value} for name, value in best.parameters.items()}
    free = held(print, state, text, hands)
    assert free["error"] == pytest.approx(best.relative_rms, rel=1e-6)
    hands["k"] = {"value": 300.0, "fixed": True}
    fixed = held(print, state, text, hands)
    assert fixed["values"]["k"] == pytest.approx(300.0)
    assert fixed["error"] > free["error"]
    hands["k"] = {"value": 310.0, "lower": 305.0, "upper": 320.0}
    assert 305.0 <= held(print, state, text, hands)["values"]["k"] <= 320.0 * (1 + 1e-9)
    drawn = curve(
        print, state, text, {name: {"value": value} for name, value in free["values"].items()}
    )
    assert drawn["planes"] == free["planes"]
    for wrong in ({"value": 400.0, "upper": 320.0}, {"value": -1.0}, {"value": None}, 3):
        with pytest.raises(ModelError, match=r"k = .* is not within|k cannot be -1|no value"):
            curve(print, state, text, hands | {"k": wrong})
    swapped = {"value": 310.0, "lower": 320.0, "upper": 305.0}
    with pytest.raises(ModelError, match="lower end 320 lies above the upper end 305; swap them"):
        curve(print, state, text, hands | {"k": swapped})


def a_session(data: Measurement) -> dict:
    states = [State("", MODEL).to_dict(), State("", MODEL, ("inertia",)).to_dict()]
    branches = [{"name": "A", "states": states, "at": 1}]
    whole = {"source": "damper.csv", "joined": False, "text": text_of(data)}
    return {
        "schema": "springpot.session/1",
        "data": whole,
        "branches": branches,
        "branch": 0,
        "view": {"view": "phase"},
    }


def test_a_session_opens_as_it_was(data: Measurement):
    session = a_session(data)
    content = json.dumps(session).encode()
    assert is_session(content)
    again = session_of(content)
    assert again["branches"][0]["states"][1]["accepted"] == ("inertia",)
    assert again["branches"][0]["states"][0]["data"] == digest_of(text_of(data))
    assert again["view"] == {"view": "phase"}


@pytest.mark.parametrize("key", ["data", "branches", "schema"])
@pytest.mark.parametrize(
    "value",
    [None, 3, [], {}, "x", [[]], {"text": 3}, [{"states": []}], [{"states": [{"accepted": 3}]}]],
)
def test_a_broken_session_is_refused_in_one_line(data: Measurement, key: str, value: object):
    with pytest.raises(DataError) as error:
        session_of(json.dumps(a_session(data) | {key: value}).encode())
    assert "\n" not in str(error.value)


def test_rivals_are_curves_where_only_the_frequency_moves(first: dict):
    frequency = first["next"]["frequency"]
    proposed = np.array(first["next"]["action"]["omega"]) / (2 * np.pi)
    assert len(frequency) > 5 * len(proposed)
    assert (frequency[0], frequency[-1]) == pytest.approx(
        (proposed.min(), proposed.max()), rel=1e-5
    )
    assert all(len(rival["storage"]) == len(frequency) for rival in first["next"]["rivals"])


def test_signals_of_several_frequencies_are_one_measurement():
    time = np.arange(0.0, 4.0, 0.005)

    def signals(frequency: float) -> Measurement:
        phase = 2 * np.pi * frequency * time
        rows = zip(time, np.sin(phase), 3.0 * np.sin(phase + 0.4), strict=True)
        text = "time [s],displacement [mm],force [kN]\n" + "".join(
            f"{t:.6g},{x:.9g},{f:.9g}\n" for t, x, f in rows
        )
        return measured_in(f"{frequency}.csv", text.encode())[0]

    both = joined(joined(signals(1.0), signals(2.0)), signals(5.0))
    assert both.frequency == pytest.approx([1.0, 2.0, 5.0], rel=1e-6)
    assert both.repeat is None
    assert both.stiffness == pytest.approx(np.full(3, 3.0 * np.exp(0.4j)), rel=1e-6)
    repeated = Measurement(
        both.omega, 1.001 * both.stiffness, conditions=both.conditions, units=both.units
    )
    again = joined(both, repeated)
    assert set(again.repeat.tolist()) == {0, 1}


def test_places_in_hertz_stand_where_the_axis_is_in_radians():
    """Data told in rad/s have an axis in rad/s.

    Places of a diagnosis and a plan are in Hz and need the factor.
    """
    omega = np.geomspace(1.0, 100.0, 8)
    for clock, factor in (("Hz", 1.0), ("rad/s", 2.0 * np.pi)):
        data = springpot.Measurement(
            omega, omega * (1.0 + 1.0j), units=springpot.Units("Pa", "-", clock)
        )
        scene = PageScene(data).to_dict()
        assert clock in scene["axis"]["label"]
        assert scene["axis"]["per_hertz"] == pytest.approx(factor)
        np.testing.assert_allclose(scene["x"], data.frequency * factor, rtol=1e-5)
    turned = springpot.Measurement(
        omega[:1].repeat(4), [1 + 1j] * 4, conditions={"amplitude": [1.0, 2.0, 4.0, 8.0]}
    )
    assert PageScene(turned).to_dict()["axis"]["per_hertz"] == 1.0


def test_a_file_that_is_added_to_itself_is_no_repeat_without_noise(data: Measurement):
    with pytest.raises(DataError, match="stand in the open data already"):
        joined(data, data)
    # A folder that is watched brings the same file again.
    assert joined_anew(data, data) is data
    again = Measurement(
        data.omega[3:6], 1.001 * data.stiffness[3:6], units=data.units, name="again"
    )
    assert len(joined(data, again)) == len(data) + 3


def test_the_error_is_relative_to_what_was_measured_as_the_page_says(data: Measurement):
    model = springpot.parse_model("spring")
    half = model.theta(k=1.0) * 0.5 * abs(data.stiffness[:1]).item()
    one = data.subset(np.arange(len(data)) == 0)
    exact = abs(half.item() / one.stiffness[0] - 1.0)
    assert relative_error(one, model, half) == pytest.approx(exact)
    modules = Path(springpot.__file__).parent / "report" / "interactive" / "modules"
    words = (modules / "hero.js").read_text(encoding="utf-8")
    assert "|K − K_model| / |K|" in words


@pytest.mark.soak
def test_the_ladder_that_was_asked_for_last_is_remembered_longest(monkeypatch):
    climbed = []

    def climb(state, measurement, told, begun, fitted):
        climbed.append(state.model)
        return state.model

    monkeypatch.setattr(tasks, "_ladders", OrderedDict())
    monkeypatch.setattr(tasks, "ladder_of", climb)
    monkeypatch.setattr(tasks, "_opened", lambda text: None)
    states = [State("data", f"prony-{i}") for i in range(1, tasks.LADDERS + 2)]
    for each in states[: tasks.LADDERS]:
        tasks._ladder(each, "", print)
    # The first is worked with: another one that is new must not push it out.
    for each in (states[0], states[-1], states[0]):
        assert tasks._ladder(each, "", print) == each.model
    assert climbed == [each.model for each in states]
    tasks._ladder(states[1], "", print)
    assert climbed[-1] == states[1].model
