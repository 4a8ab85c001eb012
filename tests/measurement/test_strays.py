"""Single samples that stray from their neighbours are found; corners, jumps and noise are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.measurement import Loading, TimeTest
from springpot.measurement.timenoise import said_of_strays, strays

T = np.linspace(0.0, 30.0, 240)
NOISE = np.random.default_rng(1).normal(size=(30, 240))


def record(response: np.ndarray, imposed: np.ndarray | None = None) -> TimeTest:
    """A record in time of a response."""
    loading = Loading(T, np.sin(T) if imposed is None else imposed)
    return TimeTest(T, response, loading, displacement_unit="mm", force_unit="N")


def test_noise_has_no_strays() -> None:
    assert [len(strays(record(100.0 * np.cos(T) + noise))) for noise in NOISE] == [0] * len(NOISE)


def test_noise_that_grows_on_the_way_has_none() -> None:
    share = np.where(T < 20.0, 0.1, 1.5)
    found = [len(strays(record(100.0 * np.cos(T) + share * noise))) for noise in NOISE]
    assert sum(found) <= 1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_sample_that_is_off_by_itself_is_found(sign: float) -> None:
    for at, noise in enumerate(NOISE, start=10):
        off = sign * 40.0 * (np.arange(len(T)) == at)
        assert strays(record(100.0 * np.cos(T) + noise + off)).tolist() == [at]


def test_most_that_are_off_by_a_dozen_deviations_are_found_and_no_other() -> None:
    """In 59 of 60 draws; by plain least squares of the differences it was 17."""
    found = []
    for at, noise in enumerate(NOISE, start=10):
        for sign in (1.0, -1.0):
            off = sign * 12.0 * (np.arange(len(T)) == at)
            found.append(strays(record(100.0 * np.cos(T) + noise + off)).tolist())
            assert found[-1] in ([at], [])
    assert sum(bool(each) for each in found) == 59


def test_strays_do_not_hide_one_another() -> None:
    """Beside what they leave in the differences of their neighbours 6 of these 150 were found."""
    places = [60, 70, 140, 150, 160]
    off = 15.0 * np.isin(np.arange(len(T)), places)
    found = [strays(record(100.0 * np.cos(T) + noise + off)).tolist() for noise in NOISE]
    assert all(set(each) <= set(places) for each in found)
    assert sum(map(len, found)) == 137


def test_several_are_found_and_told() -> None:
    off = 60.0 * np.isin(np.arange(len(T)), [40, 90, 91 + 60])
    test = record(100.0 * np.cos(T) + NOISE[0] + off)
    assert strays(test).tolist() == [40, 90, 151]
    said = said_of_strays(test)
    assert "3 samples" in said
    assert "5.021, 11.3, 18.95 s" in said


@pytest.mark.parametrize("broken", [np.abs(np.cos(T)), np.sign(np.cos(T))])
def test_corners_and_jumps_are_none(broken: np.ndarray) -> None:
    for noise in NOISE:
        assert len(strays(record(100.0 * broken + noise))) == 0


def test_the_blow_of_a_mass_at_a_corner_of_the_motion_is_none() -> None:
    zigzag = np.abs(np.mod(np.arange(len(T)), 60) - 30.0)
    turns = np.isin(np.mod(np.arange(len(T)), 30), [0])
    response = 5.0 * zigzag + 300.0 * turns * np.where(zigzag > 15.0, -1.0, 1.0)
    assert len(strays(record(response + NOISE[0], zigzag))) == 0
    assert len(strays(record(response + NOISE[0]))) > 0


def test_what_is_off_in_most_places_is_the_signal() -> None:
    often = 80.0 * (np.mod(np.arange(len(T)), 7) == 0)
    assert len(strays(record(100.0 * np.cos(T) + NOISE[0] + often))) == 0


@pytest.mark.soak
def test_a_model_does_not_follow_it() -> None:
    time = np.geomspace(0.01, 100.0, 80)
    model = springpot.parse_model("zener")
    exact = model.relaxation(model.theta(k1=50.0, k2=400.0, c=60.0), time)
    clean = TimeTest.of_relaxation(time, exact + 0.5 * NOISE[0, :80], "kPa")
    off = replace(clean, response=clean.response + 200.0 * (np.arange(80) == 30))
    fits = [springpot.identify(test, model) for test in (clean, off)]
    widths = fits[0].high - fits[0].low
    assert np.all(np.abs(fits[1].theta - fits[0].theta) < 0.2 * widths)
    assert any("left out" in note for note in fits[1].notes)
    answer = springpot.diagnose(off, model, effects=["force-drift"])
    assert answer.verdict == "adequate"
    assert any("the sample at" in note for note in answer.notes)
