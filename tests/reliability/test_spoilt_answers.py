"""An answer that was changed by hand, cut off or damaged is refused in one line, or loaded."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import pytest
from spoilt_answers import SPOILT, fault, places, spoilt

import springpot
from springpot import timetests
from springpot.measurement import TimeTest
from springpot.measurement.covered import Covered
from springpot.plain_data import Plain

ONE_IN = 211
"""The suite spoils each so many a place and way, the soak all of them."""


def sweep():
    rng = np.random.default_rng(2)
    omega = np.geomspace(1.0, 300.0, 10)
    stiffness = 60.0 * (1j * omega) ** 0.5 * (1.0 + 0.01 * rng.standard_normal(10))
    return springpot.Measurement(omega, stiffness)


def relaxation():
    time = np.geomspace(0.01, 10.0, 20)
    rng = np.random.default_rng(3)
    signal = 50.0 + 200.0 * np.exp(-time / 0.3) + rng.standard_normal(20)
    return TimeTest.of_relaxation(time, signal, "kPa")


def zener():
    return springpot.parse_model("zener")


ANSWERS = {
    "identification": lambda: springpot.identify(sweep(), "fractional-maxwell"),
    "identification of a spectrum": lambda: springpot.identify(sweep(), "material"),
    "identification in time": lambda: timetests.identify(
        [relaxation()], springpot.parse_model("zener")
    ),
    "diagnosis": lambda: springpot.diagnose(sweep(), "maxwell", only=["inertia"]),
    "discovery": lambda: springpot.discover(sweep(), "kelvin", accept="inertia", only=["inertia"]),
    "comparison": lambda: springpot.compare(sweep(), ["maxwell", "springpot"]),
}
"""How each is made; all of them can be loaded again."""


def ways(document):
    for place in places(document):
        for name, by in SPOILT.items():
            yield place, name, by


@pytest.mark.soak_cases(
    "identification-211",
    "comparison-211",
    "diagnosis-211",
    "discovery-211",
    "identification of a spectrum-211",
)
@pytest.mark.parametrize("one_in", [ONE_IN, pytest.param(1, marks=pytest.mark.soak)])
@pytest.mark.parametrize("kind", ANSWERS)
def test_a_spoilt_answer_is_refused_in_one_line_or_can_be_used(kind, one_in, tmp_path):
    document = json.loads(json.dumps(ANSWERS[kind]().to_dict()))
    path, found = tmp_path / "answer.json", {}
    for number, (place, name, by) in enumerate(ways(document)):
        if number % one_in:
            continue
        path.write_text(spoilt(document, place, by), encoding="utf-8")
        if said := fault(path):
            found[place, name] = said
    assert found == {}


@dataclass(frozen=True)
class Told(Plain):
    value: float
    word: str | None
    parts: tuple[float, ...]


def test_null_is_a_number_that_is_none_or_what_may_be_left_out_and_nothing_else():
    told = Told.from_dict({"value": None, "word": None, "parts": [None, 2.0]})
    assert np.isnan([told.value, told.parts[0]]).all()
    assert told.word is None
    with pytest.raises(ValueError, match="null stands where"):
        Told.from_dict({"value": 1.0, "word": "", "parts": None})


@pytest.mark.parametrize("ends", [(0.0, 1.0), (-1.0, 1.0), (2.0, 1.0)])
def test_a_band_of_frequencies_has_two_ends(ends):
    with pytest.raises(ValueError, match="rad/s are none"):
        Covered.read({"omega": ends})
