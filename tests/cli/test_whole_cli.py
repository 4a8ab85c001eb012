"""All that commands print and write, for small files in one folder."""

import json
import re
from importlib import import_module
from pathlib import Path
from time import sleep

import numpy as np
import pytest

from springpot.cli import hints
from springpot.cli.group import CORE
from springpot.registry import parse_model

MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=400.0, c=60.0, alpha=0.5)
TIME, OMEGA = np.geomspace(0.02, 50.0, 40), 2.0 * np.pi * np.geomspace(0.2, 20.0, 12)
SECONDS = re.compile(r"\b[\d.]+ m?s\b")


def columns(header, *values):
    rows = (
        ",".join(map(repr, row)) for row in zip(*(each.tolist() for each in values), strict=True)
    )
    return "\n".join([header, *rows]) + "\n"


def sweep(name, seed, mass=0.0, clock="frequency [Hz]", extra=""):
    rng = np.random.default_rng(seed)
    k = MODEL.stiffness(THETA, OMEGA) - mass * OMEGA**2
    k = k * (1.0 + 0.005 * (rng.normal(size=12) + 1j * rng.normal(size=12)))
    at = OMEGA if clock.startswith("omega") else OMEGA / (2.0 * np.pi)
    return columns(f"{clock},storage [kPa],loss [kPa]", at, k.real, k.imag)


def step(values, header, seed):
    scatter = 1.0 + 0.01 * np.random.default_rng(seed).normal(size=len(TIME))
    return columns(f"time [s],{header}", TIME, values * scatter)


def swinging(frequency, amplitude, seed):
    time, rng = np.arange(0.0, 3.0, 0.01), np.random.default_rng(seed)
    turn = amplitude * np.exp(2j * np.pi * frequency * time)
    force = ((100.0 + 20.0j) * frequency**0.3 * turn).imag + 0.1 * rng.normal(size=300)
    return columns("time [s],displacement [mm],force [N]", time, turn.imag, force)


def heated():
    """Relaxations at three temperatures."""
    return {
        f"at{celsius}.csv": step(
            MODEL.relaxation(THETA, TIME * np.exp(0.05 * celsius)), "relaxation [kPa]", celsius
        )
        for celsius in (0, 20, 40)
    }


def strained():
    """Two amplitudes and a column that no effect knows."""
    lines = sweep("", 5).splitlines()
    rows = [f"{row},{x},{batch}" for x, batch in ((0.1, 1), (0.2, 2)) for row in lines[1:]]
    return "\n".join([f"{lines[0]},amplitude [-],batch", *rows]) + "\n"


FILES = {
    "sweep.csv": sweep("sweep", 1),
    "second.csv": sweep("second", 2, clock="omega [rad/s]"),
    "heavy.csv": sweep("heavy", 3, mass=2e-2),
    "strained.csv": strained(),
    "relaxation.csv": step(MODEL.relaxation(THETA, TIME), "relaxation [kPa]", 1),
    "creep.csv": step(1e3 * MODEL.creep(THETA, TIME), "compliance [1/MPa]", 2),
    "slow.csv": swinging(1.0, 2.0, 3),
    "fast.csv": swinging(4.0, 1.0, 4),
    "bad.csv": "nothing\n1\n",
}
M = ("-m", "fractional-maxwell")
ACCEPT = ("--accept", "inertia")
HEATED = [f"at{celsius}.csv?temperature={celsius}[degC]" for celsius in (0, 20, 40)]
ASKED = {
    "identify": ("identify", "sweep.csv", *M),
    "identify-heavy": ("identify", "heavy.csv", *M, "--figure", "fit.svg", "-v"),
    "identify-csv": ("identify", "sweep.csv", *M, "--csv"),
    "identify-two": ("identify", "sweep.csv", "second.csv", "bad.csv", *M),
    "identify-two-json": ("identify", "sweep.csv", "bad.csv", *M, "--json"),
    "identify-joint": ("identify", "sweep.csv", "second.csv", *M, "--joint"),
    "identify-held": ("identify", "sweep.csv", *M, "--fix", "alpha=0.5", "--bounds", "k=0:390"),
    "in-time": ("identify", "relaxation.csv", *M, "--figure", "fit.svg"),
    "in-time-two": ("identify", "relaxation.csv", "creep.csv", "-m", "maxwell"),
    "in-time-csv": ("identify", "relaxation.csv", "sweep.csv", *M, "--csv"),
    "diagnose": ("diagnose", "heavy.csv", *M),
    "diagnose-adequate": ("diagnose", "sweep.csv", *M, "-v"),
    "discover": ("discover", "heavy.csv", *M, *ACCEPT, "--figure", "way.svg"),
    "compare": ("compare", "heavy.csv", *M, "-m", "kelvin", "--figure", "views.svg"),
    "compare-in-time": ("compare", "relaxation.csv", *M, "-m", "maxwell", "--figure", "all.svg"),
    "mastercurve": ("mastercurve", *HEATED, "-o", "curve.csv", "--no-vertical"),
    "signals": ("signals", "slow.csv", "fast.csv", "-o", "measured.csv"),
    "signals-json": ("signals", "slow.csv", "bad.csv", "--json"),
    "signals-held": ("signals", "slow.csv", "--frequency", "1", "--harmonics", "5"),
    "inspect": ("inspect", "sweep.csv", "relaxation.csv", "bad.csv"),
    "inspect-strained": ("inspect", "strained.csv", "--json"),
    "inspect-json": ("inspect", "relaxation.csv", "sweep.csv", "--json"),
    "list": ("list", "objectives"),
    "none": ("identify", "sweep.csv", *M, "--csv", "--json"),
    "neither": ("discover", "sweep.csv", *M),
    "both": ("discover", "sweep.csv", *M, "--auto", *ACCEPT),
}


@pytest.fixture
def folder(tmp_path, monkeypatch, asked_once):
    for name, text in (FILES | heated()).items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    # What is told to those who wait hangs on the machine.
    monkeypatch.setattr(hints, "PATIENCE", 1e3)
    return tmp_path


def told(answer):
    """What a user sees, without seconds, and what was written."""
    written = {
        path.name: [",".join(row.split(",")[:3]) for row in path.read_text().splitlines()[:3]]
        for path in sorted(Path().glob("*.csv"))
        if path.name not in FILES and not path.name.startswith("at")
    }
    lines = [SECONDS.sub("#", part).splitlines() for part in (answer.out, answer.err)]
    return {"code": answer.code, "out": lines[0], "err": lines[1], "written": written}


@pytest.mark.parametrize("asked", list(ASKED))
def test_answer_of_a_command(springpot, folder, undrawn, asked, stays):
    answer = told(springpot(*ASKED[asked]))
    if asked.endswith("json"):
        text = "\n".join(answer["out"])
        documents = text.splitlines() if text.startswith('{"') else [text]
        answer["out"] = [without(json.loads(each)) for each in documents]
    stays({**answer, "figures": [len(figure.axes) for figure in undrawn]})


def without(part):
    """A document without what no two runs share."""
    if isinstance(part, dict):
        return {name: without(each) for name, each in part.items() if name != "seconds"}
    return [without(each) for each in part] if isinstance(part, list) else part


PREDICTED = {
    "frequency": ("--frequency", "0.1,1,100", "-o", "band.csv"),
    "omega": ("--omega", "1..10", "--level", "0.9"),
    "sweep": ("--history", "second.csv", "-o", "band.csv"),
    "time": ("--history", "relaxation.csv", "-o", "band.csv", "--figure", "band.svg"),
    "temperature": ("--history", "relaxation.csv", "--temperature", "30"),
    "nothing": (),
    "twice": ("--omega", "1", "--frequency", "1"),
    "falling": ("--omega", "10..1"),
    "zero": ("--omega", "0..1"),
    "geometry": ("--omega", "1", "--geometry", "shear-pads area=200cm^2 gap=10mm"),
}


@pytest.mark.parametrize("asked", list(PREDICTED))
def test_prediction(springpot, folder, undrawn, asked, stays):
    Path("fit.json").write_text(springpot("identify", "sweep.csv", *M, "--json").out)
    stays(told(springpot("predict", "fit.json", *PREDICTED[asked])))


def test_those_who_wait_are_told_each_kind_of_stage_once(monkeypatch, capsys):
    monkeypatch.setattr(hints, "PATIENCE", 0.001)
    with hints.Waiting() as told:
        for stage in ("fitting a", "fitting b", "weighing"):
            told.told(stage)
            sleep(0.05)
    assert capsys.readouterr().err == "fitting a\nweighing\n"


def test_nobody_is_told_before_a_second_is_over(capsys):
    with hints.Waiting() as told:
        told.told("fitting a")
        sleep(0.05)
    assert capsys.readouterr().err == ""


def test_what_the_arguments_of_commands_take(stays):
    """How often each may stand, and between which ends its numbers lie."""
    ends = ("min", "max", "min_open", "max_open", "choices", "dir_okay", "exists")

    def takes(given):
        told = {"nargs": given.nargs, "required": given.required, "multiple": given.multiple}
        told |= {"flag": getattr(given, "is_flag", False), "type": given.type.name}
        return told | {end: getattr(given.type, end) for end in ends if hasattr(given.type, end)}

    found = {}
    for name, entry in CORE.items():
        command = import_module(entry.module).command
        found[name] = {" ".join(given.opts): takes(given) for given in command.params}
    stays(found)
