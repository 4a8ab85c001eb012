"""A kind of test that springpot does not know, added by one class and one reader.

An impedance head tells the level of force over velocity, in decibels, and its phase.
"""

from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.measurement import OtherTest, TimeReader, TimeTest
from springpot.registry import Owner
from springpot.rheology import Points
from springpot.rheology.intime import Traced

pytestmark = pytest.mark.usefixtures("asked_once")

HEADER = "f [Hz],level [dB],phase [rad]"


def parts(values):
    return np.concatenate([values.real, values.imag])


@dataclass(frozen=True, eq=False, kw_only=True)
class Impedance(OtherTest):
    """Level in dB over 1 N s/m and phase in rad of Z = K/(i omega), at frequencies in Hz (n,)."""

    kind, quantity, unit = "impedance", "Re Z, Im Z", "N s/m"
    frequency: np.ndarray
    level: np.ndarray
    phase: np.ndarray

    @property
    def omega(self):
        return 2.0 * np.pi * self.frequency

    @property
    def impedance(self):
        return 10.0 ** (self.level / 20.0) * np.exp(1j * self.phase)

    @property
    def at(self):
        return np.tile(self.frequency, 2)

    @property
    def measured(self):
        return parts(self.impedance)

    @property
    def sd(self):
        return 0.01 * np.tile(np.abs(self.impedance), 2)

    @property
    def stiffness(self):
        return float(np.exp(np.mean(np.log(self.omega * np.abs(self.impedance)))))

    def answer(self, model, theta, reference):
        at = Points(np.log(self.omega), reference_temperature=reference)
        velocity = 1j * self.omega
        shown = model.stiffness(theta, at) / velocity
        return Traced(parts(shown), parts(model.jacobian(theta, at) / velocity[:, None]))

    def subset(self, rows):
        kept = rows.reshape(2, -1).all(axis=0)
        names = ("frequency", "level", "phase")
        return replace(self, **{name: getattr(self, name)[kept] for name in names})


def read(path, choice):
    frequency, level, phase = np.loadtxt(path, delimiter=",", skiprows=1).T
    told = {"name": Path(path).stem, "units": springpot.Units("N/m", "m")}
    return [Impedance(frequency=frequency, level=level, phase=phase, **told)]


def recognises(head):
    return float(head.startswith(HEADER.encode()))


READER = TimeReader("impedance-head", "level in dB and phase in rad", recognises, read)
# So far the new kind.

FREQUENCY = np.geomspace(0.5, 200.0, 40)
MODEL = springpot.parse_model("fractional-maxwell")
TRUTH = {"k": 4e5, "c": 6e3, "alpha": 0.5}


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A moving mass of 0.9 kg hides in what the head has recorded."""
    installed = springpot.plugins()
    shelf = deepcopy(installed.shelf("time reader"))
    shelf.put(READER, Owner("impedance", "tests"))
    monkeypatch.setitem(installed._filled, "time reader", shelf)
    omega = 2.0 * np.pi * FREQUENCY
    stiffness = MODEL.stiffness(MODEL.theta(**TRUTH), omega) - 0.9 * omega**2
    noise = 0.01 * np.random.default_rng(8).normal(size=(2, 40))
    shown = np.log(stiffness / (1j * omega)) + noise[0] + 1j * noise[1]
    path = tmp_path / "head.csv"
    rows = np.column_stack([FREQUENCY, 20.0 * shown.real / np.log(10.0), shown.imag])
    np.savetxt(path, rows, delimiter=",", header=HEADER, comments="")
    return path


def test_it_takes_sixty_lines():
    lines = Path(__file__).read_text(encoding="utf-8").split("# So far")[0].splitlines()
    assert len(lines) - lines.index("def parts(values):") <= 60


@pytest.mark.soak
def test_it_is_identified_diagnosed_and_accepted(file):
    told = springpot.diagnose(file, MODEL)
    assert (told.verdict, told.best.effect) == ("effect-missing", "inertia")
    fit = springpot.identify(file, "fractional-maxwell + inertia")
    assert fit.tests[0].kind == "impedance"
    assert fit.tests[0].over_floor == pytest.approx(1.0, abs=0.15)
    for name, value in {**TRUTH, "inertia.m": 0.9}.items():
        assert fit.parameters[name].low < value < fit.parameters[name].high


def test_it_stands_beside_a_test_in_time(file):
    t = np.geomspace(0.01, 10.0, 60)
    exact = MODEL.relaxation(MODEL.theta(**TRUTH), t)
    noisy = exact * (1.0 + 0.01 * np.random.default_rng(2).normal(size=60))
    relaxed = TimeTest.of_relaxation(t, noisy, "N/m")
    alone = springpot.identify(relaxed, MODEL)
    both = springpot.identify([relaxed, file], "fractional-maxwell + inertia")
    assert [test.kind for test in both.tests] == ["relaxation", "impedance"]
    wide, narrow = (
        fit.parameters["alpha"].high - fit.parameters["alpha"].low for fit in (alone, both)
    )
    assert narrow < 0.9 * wide


@pytest.mark.soak
def test_it_is_compared_drawn_and_told(file, tmp_path):
    compared = springpot.compare(file, ["maxwell + inertia", "fractional-maxwell + inertia"])
    assert compared.judgements[0].model.name == "fractional-maxwell + inertia"
    drawn = springpot.identify(file, "fractional-maxwell + inertia").plot(tmp_path / "fit.svg")
    assert "impedance" in drawn.read_text(encoding="utf-8")


def test_commands_take_it(file, request):
    command = request.getfixturevalue("springpot")
    told = command("inspect", file)
    assert "head: impedance, 80 points" in told.out
    assert command("inspect", file, "--json").json["tests"][0]["kind"] == "impedance"
    few = "--effects", "inertia,time-delay,series-spring"
    found = command("diagnose", file, "--model", "fractional-maxwell", *few, "--json").json
    assert found["candidates"][0]["effect"] == "inertia"
    fewer = command("identify", file, "--model", "maxwell", "--exclude", "row=1..3", "--json").json
    assert fewer["tests"][0]["points"] == 74
    command("identify", file, "--model", "maxwell", "--geometry", "sandwich").is_one_line(
        "geometry"
    )
