"""What the amplitude does, told without a model."""

import numpy as np
import pytest

import springpot
from springpot.diagnosis import examine
from springpot.misfit.material import notes_on_amplitudes

FREQUENCY = np.geomspace(0.1, 50.0, 15)
AMPLITUDES = (0.05, 0.2, 0.6, 1.5)
FEW = ["inertia", "payne"]
OMEGA = np.tile(2.0 * np.pi * FREQUENCY, len(AMPLITUDES))
AMPLITUDE = np.repeat(AMPLITUDES, len(FREQUENCY))
GEL = 1e3 * (1.0 + 0.3 * (1j * OMEGA) ** 0.25)


def measured(stiffness, level=0.004, **conditions):
    noise = np.random.default_rng(1).normal(size=(2, OMEGA.size))
    disturbed = stiffness * (1.0 + level * (noise[0] + 1j * noise[1]))
    return springpot.Measurement(
        OMEGA, disturbed, conditions={"amplitude": AMPLITUDE, **conditions}, name="gel"
    )


def notes(data):
    search = examine(data, springpot.parse_model("material"), [], np.random.default_rng(0)).search
    return list(notes_on_amplitudes(search.base))


def test_a_gel_that_softens_is_told_to_soften():
    (note,) = notes(measured(GEL / (1.0 + AMPLITUDE)))
    assert "one material for all 4 amplitudes is" in note
    # From 1 / 1.05 to 1 / 2.5.
    change = float(note.partition("falls by ")[2].partition(" %")[0])
    assert change == pytest.approx(58.0, abs=1.0)
    assert "the loss factor stays at" in note


@pytest.mark.soak
def test_a_gel_that_stiffens_and_loses_more_is_told_both():
    softer = GEL * (1.0 + 0.2 * AMPLITUDE) + 100.0 * (1j * OMEGA) ** 0.5 * AMPLITUDE
    (note,) = notes(measured(softer))
    low, high = note.partition("loss factor goes from ")[2].split(" to ")[:2]
    assert "rises by" in note
    assert float(high) > 1.5 * float(low)


@pytest.mark.soak
def test_where_the_amplitude_does_nothing_that_is_said():
    (note,) = notes(measured(GEL - 0.02 * OMEGA**2))
    assert note.endswith("the amplitude does not matter")


@pytest.mark.soak
def test_a_loss_that_is_largest_between_is_told_with_its_place():
    between = 1.0 + np.exp(-(np.log(AMPLITUDE / 0.2) ** 2))
    (note,) = notes(measured(GEL.real + 1j * GEL.imag * between, level=0.001))[:1]
    assert "(most at 0.2)" in note


@pytest.mark.soak
def test_several_temperatures_are_no_question_of_the_amplitude():
    temperature = np.tile(np.repeat([10.0, 40.0, 70.0], 5), len(AMPLITUDES))
    assert notes(measured(GEL / (1.0 + AMPLITUDE), temperature=temperature)) == []


@pytest.mark.soak
def test_a_diagnosis_tells_it():
    found = springpot.diagnose(measured(GEL / (1.0 + AMPLITUDE)), "kelvin", only=FEW)
    assert any("one material for all 4 amplitudes" in note for note in found.notes)


@pytest.mark.soak
def test_a_mass_shows_where_no_material_behaves_so():
    found = springpot.diagnose(measured(GEL - 0.02 * OMEGA**2), "kelvin", only=FEW)
    (note,) = (each for each in found.notes if each.startswith("no linear material follows"))
    assert "above" in note
    assert "Hz" in note


@pytest.mark.soak
def test_what_a_material_follows_is_no_such_place():
    found = springpot.diagnose(measured(GEL), "kelvin", only=FEW)
    assert not any("no linear material follows" in note for note in found.notes)


@pytest.mark.soak
def test_where_no_material_follows_any_amplitude_it_is_not_said_to_do_nothing():
    """A damper of speed^0.4 is no material at one amplitude either: what differs is hidden."""
    speed = OMEGA * AMPLITUDE
    (note,) = notes(measured(GEL + 300j * speed**0.4 / AMPLITUDE * np.sign(OMEGA)))[:1]
    assert "the amplitude does not matter" not in note


def test_amplitudes_that_fall_along_the_sweeps_are_not_judged_by_a_few_that_come_again():
    """Only two of them have rows enough for a material: they say nothing of the others."""
    again = np.isin(AMPLITUDE, AMPLITUDES[:2])
    falling = np.where(again, AMPLITUDE, AMPLITUDE / (1.0 + 0.1 * OMEGA))
    search = measured(GEL / (1.0 + (falling > 0.3)), amplitude=falling)
    assert notes(search) == []
