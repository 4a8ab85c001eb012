"""Who waits is told what is done, and what was reached is kept when the rest is not waited for."""

import json
import signal

import numpy as np
import pytest

import springpot
from springpot.cli import discover as command
from springpot.cli.group import exit_code, run
from springpot.diagnosis import diagnose
from springpot.measurement import Measurement, Units
from springpot.registry import plugins
from springpot.report.text import jsonable

MODEL = "fractional-maxwell"
EFFECTS = ("inertia", "time-delay")


@pytest.fixture(scope="module")
def data():
    omega = 2.0 * np.pi * np.geomspace(0.5, 60.0, 24)
    model = springpot.parse_model(f"{MODEL} + inertia")
    exact = model.stiffness(np.array([400.0, 60.0, 0.55, 2e-3]), omega)
    scatter = np.random.default_rng(2).normal(size=(2, len(omega))) * 0.005
    return Measurement(
        omega, exact * (1.0 + scatter[0] + 1j * scatter[1]), units=Units("kN/m", "mm"), name="made"
    )


@pytest.mark.soak
def test_stages_come_in_the_order_of_the_work_and_change_no_bit(data):
    library = [plugins().effect(name) for name in EFFECTS]
    told = []
    watched = diagnose(
        data, springpot.parse_model(MODEL), library, np.random.default_rng(0), told.append
    )
    silent = diagnose(data, springpot.parse_model(MODEL), library, np.random.default_rng(0))
    assert jsonable(watched) == jsonable(silent)
    assert told[0] == f"fitting {MODEL} and trying what may be missing from it"
    assert told[-1] == "weighing what was found"


@pytest.mark.soak
def test_every_rung_is_handed_out_when_it_is_reached(data):
    story = []
    ladder = springpot.discover(
        data,
        MODEL,
        accept="inertia",
        progress=lambda stage: story.append(stage.partition(":")[0]),
        reached=lambda so_far: story.append(len(so_far.steps)),
    )
    assert list(dict.fromkeys(story)) == ["step 0", 1, "step 1", 2]
    assert len(ladder.steps) == 2


def test_a_comparison_names_the_model_that_it_fits(data):
    told = []
    springpot.compare(data, ["springpot", MODEL], progress=told.append)
    assert told[:2] == ["fitting springpot", f"fitting {MODEL}"]


def interrupted_at(monkeypatch, stage):
    """Let Ctrl-C be pressed when a stage begins."""

    class Pressed(command.Waiting):
        def told(self, text):
            if stage in text:
                signal.raise_signal(signal.SIGINT)
            super().told(text)

    monkeypatch.setattr(command, "Waiting", Pressed)


@pytest.mark.soak
def test_ctrl_c_keeps_the_steps_that_were_reached(data, tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    interrupted_at(monkeypatch, "step 1: weighing")
    asked = ["discover", "artificial-hidden", "--model", MODEL, "--accept", "inertia", "--json"]
    code = exit_code(lambda: run([*asked, "--figure", str(tmp_path / "kept.svg")]))
    out, err = capsys.readouterr()
    assert code == 130
    assert "interrupted; the answer is that of step 0" in err
    answer = json.loads(out)
    assert [step["model"] for step in answer["steps"]] == [MODEL]
    assert answer["diagnosis"]["candidates"][0]["effect"] == "inertia"
    assert (tmp_path / "kept.svg").stat().st_size > 1000


def test_ctrl_c_before_the_first_step_says_nothing(monkeypatch, capsys):
    interrupted_at(monkeypatch, "step 0: fitting")
    assert (
        exit_code(lambda: run(["discover", "artificial-hidden", "--model", MODEL, "--auto"])) == 130
    )
    assert capsys.readouterr().out == ""
