"""A line of one frequency in what is left of a record is told."""

import re

import numpy as np
import pytest

from springpot import parse_model
from springpot.measurement import Loading, TimeTest
from springpot.timetests import diagnose


def notes_of(step, hertz, size, model="zener", seed=0):
    time = step * np.arange(1000)
    stroke = 2.0 * np.sin(3.0 * np.pi * time)
    zener = parse_model(model)
    force = zener.respond(zener.theta(k1=0.1, k2=0.1, c=0.01), time, stroke)
    force = force + 0.002 * np.random.default_rng(seed).normal(size=len(time))
    force += size * np.sin(2.0 * np.pi * hertz * time)
    test = TimeTest(time, force, Loading(time, stroke), control="displacement", name="record")
    found = diagnose([test], zener, [])
    return [note for note in found.notes if "holds a line" in note]


def told(note):
    """Frequency in Hz and size of a line, as a note has them."""
    hertz, size = re.search(r"a line at (\S+) Hz, (\S+) Pa in amplitude", note).groups()
    return float(hertz), float(size)


@pytest.mark.parametrize("step", [0.001, 0.005])
def test_the_hum_of_the_mains_is_told(step):
    (note,) = notes_of(step, 50.0, 0.01)
    assert told(note) == pytest.approx((50.0, 0.01), rel=0.05)
    assert "the mains" in note


def test_another_line_is_a_vibration():
    (note,) = notes_of(0.005, 71.3, 0.01)
    assert told(note) == pytest.approx((71.3, 0.01), rel=0.05)
    assert "a vibration" in note
    assert "no part of the specimen" in note


def test_a_harmonic_of_the_motion_may_be_the_specimens_own():
    # Of 1.5 Hz the eleventh: friction leaves all odd ones.
    (note,) = notes_of(0.025, 16.5, 0.01)
    assert told(note) == pytest.approx((16.5, 0.01), rel=0.05)
    assert "or a harmonic of the motion" in note
    assert "no part of the specimen" not in note


@pytest.mark.soak_cases("2", "3")
@pytest.mark.parametrize("seed", range(4))
def test_noise_has_none(seed):
    assert not notes_of(0.005, 50.0, 0.0, seed=seed)
