"""Columns beside a measurement: which set something, and which only name or repeat the known."""

import numpy as np
import pytest

import springpot
from springpot.measurement import settings_of, tests_together as several_tests

CELSIUS = np.repeat(np.linspace(-50.0, 100.0, 21), 10)
OMEGA = 2.0 * np.pi * np.tile(np.geomspace(0.1, 100.0, 10), 21)
NUMBER = np.repeat(np.arange(21.0), 10)
TWO_AT_EACH = np.tile(np.repeat([1.0, 2.0], 5), 21)


def table(conditions=(), labels=()):
    stiffness = 1e6 * (1j * OMEGA) ** 0.3
    return springpot.Measurement(OMEGA, stiffness, conditions=dict(conditions), labels=dict(labels))


@pytest.mark.parametrize("name", ["set", "step", "Segment"])
def test_a_number_of_each_temperature_is_no_setting(name):
    data = table({"temperature": CELSIUS, name: NUMBER})
    assert settings_of(data) == {}
    assert several_tests(data) == []


def test_nor_is_a_word_for_each():
    words = np.array([f"segment {number:.0f}" for number in NUMBER])
    data = table({"temperature": CELSIUS}, {"step": words})
    assert settings_of(data) == {}
    assert several_tests(data) == []


def test_a_number_that_is_not_one_of_each_temperature_is_a_setting():
    """Two specimens, each at every temperature."""
    data = table({"temperature": CELSIUS, "specimen": TWO_AT_EACH})
    assert list(settings_of(data)) == ["specimen"]


@pytest.mark.parametrize("pair", [(0.400, 0.401), (19.98, 20.02), (-0.401, -0.400)])
def test_what_was_held_within_its_rounding_is_no_setting(pair):
    held = np.random.default_rng(1).choice(np.array(pair), len(OMEGA))
    assert settings_of(table({"displacement": held})) == {}


@pytest.mark.parametrize("pair", [(1001.0, 1002.0), (0.40, 0.44), (0.0, 0.5)])
def test_numbers_of_specimens_and_values_that_differ_are_settings(pair):
    chosen = np.random.default_rng(1).choice(np.array(pair), len(OMEGA))
    assert list(settings_of(table({"specimen": chosen}))) == ["specimen"]


SWEEP = np.geomspace(1.0, 100.0, 8)


@pytest.mark.parametrize("name", ["gap", "normal_force", "time"])
def test_what_was_chosen_for_whole_sweeps_is_a_setting_whatever_its_name(name):
    """Three sweeps, each in a gap of its own: rows of one frequency are no repeats."""
    omega, chosen = np.tile(SWEEP, 3), np.repeat([0.5, 1.0, 2.0], 8)
    data = springpot.Measurement(omega, 1j * omega, conditions={name: chosen})
    assert list(settings_of(data)) == [name]


def test_an_answer_that_stands_still_within_a_sweep_is_none():
    force = np.repeat([0.1, 0.2], 4)
    data = springpot.Measurement(SWEEP, 1j * SWEEP, conditions={"normal_force": force})
    assert settings_of(data) == {}


@pytest.mark.parametrize(
    ("number", "told"), [(NUMBER, False), (TWO_AT_EACH, True)], ids=["of temperatures", "of two"]
)
def test_only_a_file_of_several_tests_is_said_to_hold_them(tmp_path, number, told):
    """The note is written where the file is read."""
    rows = np.column_stack([OMEGA / (2.0 * np.pi), 100.0 + OMEGA**0.3, OMEGA**0.3, CELSIUS, number])
    path = tmp_path / "sweeps.csv"
    header = "frequency [Hz],storage [kN/m],loss [kN/m],temperature [degC],set"
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    notes = " ".join(str(note) for note in springpot.read(path).provenance.values())
    assert ("rows of several tests" in notes) == told
