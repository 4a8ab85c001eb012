"""What can be done with an answer: each step has a command, and the error that it leaves."""

import json
from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.diagnosis.result import NextExperiment, leaving_out, splitting, turning
from springpot.measurement.mixed_up import sign_note, turned, wrong_way
from springpot.registry import of_each
from springpot.report.text import percent

pytestmark = pytest.mark.usefixtures("asked_once")

FEW = ["inertia", "gain-error", "series-spring"]
OMEGA = np.geomspace(1.0, 100.0, 12)


def two_currents(extra=0.0):
    """A springpot that is half as stiff again at the second current."""
    current = np.repeat([0.5, 1.0], len(OMEGA))
    omega = np.tile(OMEGA, 2)
    gain = np.where(current > 0.7, 1.5, 1.0)
    noise = 0.005 * np.random.default_rng(3).normal(size=(2, len(omega)))
    stiffness = 50.0 * gain * (1j * omega) ** 0.4 * (1.0 + noise[0] + 1j * noise[1])
    stiffness[5] *= 1.0 + extra
    return springpot.Measurement(omega, stiffness, conditions={"current": current})


@pytest.fixture(scope="module")
def apart():
    return springpot.diagnose(two_currents(), "springpot", only=FEW)


@pytest.mark.soak
def test_a_column_with_which_the_misfit_goes_is_split_with_the_error_foretold(apart):
    (step,) = apart.steps
    assert step.command == "springpot discover DATA --split current"
    assert apart.error.relative_rms > 0.1
    ladder = springpot.discover(two_currents(), "springpot", accept=of_each("current"), only=FEW)
    assert step.error_after < 0.3 * apart.error.relative_rms
    assert ladder.steps[-1].relative_rms < 0.1 * apart.error.relative_rms


def test_steps_are_told_with_the_error_before_and_after(apart):
    text = " ".join(str(apart).split())
    before = percent(apart.error.relative_rms)
    after = percent(apart.steps[0].error_after)
    assert "one factor a value, the material shared" in text
    assert f"({before} -> {after}): springpot discover DATA --split current" in text


def test_programs_get_them_and_give_them_back(apart):
    answer = json.loads(json.dumps(apart.to_dict()))
    assert answer["actions"][0]["command"] == "springpot discover DATA --split current"
    assert type(apart).from_dict(answer).steps == apart.steps


@pytest.mark.soak
def test_effects_that_lower_the_error_are_offered_after_the_steps():
    found = springpot.diagnose("artificial-hidden", "fractional-maxwell")
    commands = [action.command for action in found.actions]
    assert commands[0] == "springpot discover DATA --accept inertia"
    after = [action.error_after for action in found.actions]
    assert all(error < 0.9 * found.error.relative_rms for error in after)


def test_a_force_that_counts_the_other_way_is_turned():
    t = np.linspace(0.0, 2.0, 200)
    x = np.sin(2.0 * np.pi * t)
    force = -(3.0 * x + 2.0 * np.gradient(x, t))
    test = springpot.TimeTest.of_history(t, x, force, "mm", "N")
    spec = turned(sign_note(test, "force=-N"))
    assert spec == "FILE?force=-N"
    assert turning("my file?force=-N").command == "springpot diagnose 'my file?force=-N'"
    assert turned({}) == ""


def test_that_it_is_to_be_turned_is_said_first(apart):
    assert apart.behind_a_sign() == apart
    told = replace(apart, steps=(*apart.steps, turning("rig.csv?force=-N"))).behind_a_sign()
    assert told.says.startswith("the force seems to count the other way")
    assert told.says.endswith(f"; {apart.says}")
    planned = replace(told, next_experiment=NextExperiment("repeat", (), None))
    assert planned.behind_a_sign().next_experiment is None
    assert replace(apart, verdict="adequate", steps=told.steps).behind_a_sign().says == apart.says


def exchanged(folder):
    """A sweep in a file whose names of storage and loss are exchanged."""
    k = 10.0 + 1.0 / (1.0 / 80.0 + 1.0 / (20.0 * (1j * OMEGA) ** 0.7))
    path = folder / "rig.csv"
    rows = "".join(f"{w},{v.imag},{v.real}\n" for w, v in zip(OMEGA, k, strict=True))
    path.write_text(f"omega [rad/s],storage [kPa],loss [kPa]\n{rows}")
    return springpot.read(path), f"{path}?storage=loss,loss=storage"


def test_columns_in_each_others_place_are_exchanged_before_all_else(tmp_path, apart):
    data, spec = exchanged(tmp_path)
    assert turned(data.provenance) == spec
    assert turned(springpot.read(spec).provenance) == ""
    step = turning(spec, what=wrong_way(data.provenance))
    assert step.says == "storage and loss stand in each other's place: exchange them"
    told = replace(apart, steps=(step,)).behind_a_sign()
    assert told.says.startswith("storage and loss stand in each other's place, as it seems: until")
    assert told.turns == [step]


@pytest.mark.soak
def test_no_effect_is_looked_for_where_columns_are_exchanged(tmp_path):
    data, spec = exchanged(tmp_path)
    found = springpot.diagnose(data, "kelvin", effects=FEW)
    assert (found.candidates, found.offered) == ((), "")
    [step] = found.turns
    assert step.command.endswith(f"'{spec}'")


def test_a_row_that_stands_out_is_left_out_by_its_number():
    assert leaving_out([12], 0.01).command == "springpot diagnose DATA --exclude row=12"
    both = leaving_out([12, 40], 0.01)
    assert both.command == "springpot diagnose DATA --exclude row=12 --exclude row=40"
    assert both.says == "rows 12, 40 stand out: leave them out of every fit too"
    assert both.exclude == (12, 40)
    assert splitting("band tension", 0.1).command.endswith("--split 'band tension'")


def three_specimens(late=0.0):
    """Three bushes that differ in stiffness, and a force that comes a moment late."""
    omega = np.tile(OMEGA, 3)
    stiffness = np.repeat([0.9, 1.0, 1.2], len(OMEGA)) * (40.0 + 8.0 * (1j * omega) ** 0.5)
    stiffness *= np.exp(-1j * late * omega)
    noise = 0.005 * np.random.default_rng(4).normal(size=(2, len(omega)))
    names = np.repeat(["left", "right", "spare"], len(OMEGA))
    return springpot.Measurement(
        omega, stiffness * (1.0 + noise[0] + 1j * noise[1]), labels={"bush": names}
    )


def test_a_column_of_words_has_factors_of_its_own():
    model = "fractional-kelvin + free-vertical-shift:bush"
    assert springpot.identify(three_specimens(), model).relative_rms < 0.01


@pytest.mark.soak
def test_a_column_of_words_is_split_too():
    known = {"only": ["time-delay", "inertia"], "accept": of_each("bush")}
    ladder = springpot.discover(three_specimens(0.003), "fractional-kelvin", **known)
    assert ladder.steps[-1].relative_rms < 0.6 * ladder.steps[0].relative_rms
    assert ladder.diagnosis.leading == ("time-delay",)
    assert "bush: 1 is left, 2 is right, 3 is spare" in ladder.diagnosis.notes


@pytest.mark.soak
def test_what_a_split_will_leave_is_without_the_effect_beside_it():
    data = three_specimens(0.003)
    found = springpot.diagnose(data, "fractional-kelvin", only=["time-delay", "inertia"])
    (step,) = found.steps
    assert step.split == "bush"
    ladder = springpot.discover(data, "fractional-kelvin", accept=of_each("bush"), only=FEW)
    assert step.error_after == pytest.approx(ladder.steps[-1].relative_rms, rel=0.05)
