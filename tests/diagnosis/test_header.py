"""Constants of an instrument in the header of a file, beside what is diagnosed."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.diagnosis.notes import header_notes
from springpot.diagnosis.result import AsTold

INERTIA = 0.002
OMEGA = np.geomspace(1.0, 300.0, 40)


@pytest.fixture(scope="module")
def measured():
    heavy = springpot.parse_model("fractional-maxwell + inertia")
    exact = heavy.stiffness(np.array([400.0, 60.0, 0.5, INERTIA]), OMEGA)
    noise = np.random.default_rng(1).normal(size=(2, len(OMEGA))) * 0.01
    return springpot.Measurement(OMEGA, exact * (1 + noise[0] + 1j * noise[1]), name="fluid")


def notes(measured, said, unit="Pa"):
    facts = {} if said is None else {"inertia as modulus": f"{said:g} Pa s^2"}
    measured = replace(measured, provenance=facts, units=springpot.Units(unit, "-"))
    return [
        note
        for note in springpot.diagnose(measured, "fractional-maxwell").notes
        if "header" in note
    ]


@pytest.mark.soak
def test_an_inertia_that_agrees(measured):
    [note] = notes(measured, INERTIA)
    assert "0.002 Pa s^2" in note
    assert "inertia of 0.00" in note
    assert "agrees with it" in note


@pytest.mark.soak_cases("0.02-of it: what a correction left", "0.0001-times as much")
@pytest.mark.parametrize(
    ("said", "words"), [(0.02, "of it: what a correction left"), (1e-4, "times as much")]
)
def test_an_inertia_that_does_not(measured, said, words):
    [note] = notes(measured, said)
    assert words in note


@pytest.mark.soak
def test_the_unit_of_the_data_is_converted(measured):
    kilo = replace(measured, stiffness=measured.stiffness / 1000)
    [note] = notes(kilo, INERTIA, "kPa")
    assert "agrees with it" in note


@pytest.mark.soak
def test_nothing_is_said_without_a_header_or_of_a_damper(measured):
    assert notes(measured, None) == []
    assert notes(measured, INERTIA, "N/m") == []


@pytest.mark.soak
def test_an_inertia_of_which_nothing_is_known_agrees_with_nothing(measured):
    said = replace(
        measured, provenance={"inertia as modulus": "1.4 Pa s^2"}, units=springpot.Units("Pa", "-")
    )
    [found] = [
        row
        for row in springpot.diagnose(said, "fractional-maxwell").candidates
        if row.effect == "inertia"
    ]
    [known] = found.parameters.values()
    endless = AsTold(parameters={"m": replace(known, low=0.0, high=np.inf)})
    open_ended = replace(found, verdict="cannot-tell", alone=endless)
    assert list(header_notes([open_ended], said)) == []
    closed = replace(found, alone=AsTold(parameters={"m": replace(known, low=0.0, high=2.0)}))
    assert "agrees with it" in next(header_notes([closed], said))
