"""What goes along straight lines is known without the noise of its transducer."""

import numpy as np
import pytest

from springpot.measurement import Loading, TimeTest
from springpot.measurement.course import lines, straightened
from springpot.measurement.imposed import controlled

TIME = np.linspace(0.0, 10.0, 600)
NOISE = np.random.default_rng(3).normal(size=(2, 600))
COURSES = {
    "ramp": TIME,
    "ramp and hold": np.minimum(TIME, 3.0),
    "triangles": 2.0 * np.abs((0.3 * TIME + 0.5) % 1.0 - 0.5),
    "two rates": np.where(TIME < 4.0, TIME, 4.0 + 3.0 * (TIME - 4.0)),
}


@pytest.mark.parametrize("course", COURSES)
def test_noise_that_nothing_answers_to_is_taken_off(course):
    moved = COURSES[course] / np.abs(COURSES[course]).max()
    read = moved + 0.01 * NOISE[0]
    test = TimeTest.of_history(TIME, read, 5.0 * moved + 0.02 * NOISE[1], "mm", "N")
    assert "along straight lines" in test.provenance["motion"]
    assert np.std(test.loading.value - moved) < 0.3 * np.std(read - moved)


def test_noise_that_the_specimen_felt_stays():
    read = Loading(TIME, TIME + 0.05 * NOISE[0], sampled=True)
    assert straightened(read, 5.0 * read.value + 0.02 * NOISE[1])[0] is read


@pytest.mark.parametrize("noise", [0.0003, 0.003, 0.03], ids="noise {}".format)
@pytest.mark.parametrize("cycles", [1.0, 3.0, 20.0], ids="{} cycles".format)
def test_a_swing_is_no_straight_lines(cycles, noise):
    moved = np.sin(0.2 * np.pi * cycles * TIME)
    assert lines(TIME, moved + noise * NOISE[0])[1] == []


def test_what_has_no_noise_is_left_as_it_is():
    read = Loading(TIME, np.round(TIME, 3), sampled=True)
    assert straightened(read, 5.0 * TIME + 0.02 * NOISE[1])[0] is read


@pytest.mark.parametrize("course", ["ramp", "two rates", "triangles"])
def test_of_two_noisy_channels_the_one_along_straight_lines_was_imposed(course):
    line = COURSES[course] / np.abs(COURSES[course]).max()
    bent = np.convolve(line, np.exp(-TIME))[: len(TIME)] / 60.0 + 0.3 * line
    line, bent = line + 0.005 * NOISE[0], bent + 0.001 * NOISE[1]
    under_force = TimeTest.of_history(TIME, bent, line, "mm", "N")
    assert under_force.control == "force"
    assert "straight lines" in under_force.provenance["note control"]
    assert TimeTest.of_history(TIME, line, bent, "mm", "N").control == "displacement"


def test_lines_of_a_long_record_are_told_by_some_of_its_samples_and_end_at_all():
    """A sine of 100,000 samples took ten seconds."""
    t = np.linspace(0.0, 100.0, 20_000, endpoint=False)
    course = np.abs(t % 40.0 - 20.0)
    noise = 0.02 * np.random.default_rng(1).normal(size=len(t))
    found, parts = lines(t, course + noise)
    assert len(parts) == 5
    # But where a corner lies the noise hides to a few samples.
    assert np.sqrt(np.mean((found - course) ** 2)) < 0.002
    assert lines(t, 5.0 * np.sin(t) + noise)[1] == []


def test_ramps_between_long_holds_stay_apart_where_only_some_samples_are_looked_at():
    """Of 2,000 samples one in two is looked at, and of a ramp of 24 too few to be told."""
    t = np.arange(2000.0)
    steps = np.clip(t / 24.0, 0.0, 1.0) + np.clip((t - 1000.0) / 24.0, 0.0, 1.0)
    noisy = steps + 0.01 * np.random.default_rng(5).normal(size=2000)
    loading = Loading(t, noisy, sampled=True)
    straight, _ = straightened(loading, np.random.default_rng(6).normal(size=2000))
    assert np.abs(straight.value - steps).max() < 0.03
    assert np.count_nonzero(np.abs(np.diff(straight.value, 2)) > 1e-9) <= 8


def triangle_and_answer(side):
    """A triangle of so many samples from turn to turn, and what a zener's strain lags behind it."""
    time = np.arange(1.0, 151.0)
    line = 2.0 / np.pi * np.arcsin(np.sin(np.pi * time / side))
    return time, line, line - 0.5 * np.convolve(line, np.exp(-3.0 * time / side))[:150] / side


@pytest.mark.parametrize("side", [9.3, 12.7, 25.1])
def test_of_short_lines_the_force_was_imposed_too(side):
    time, line, answer = triangle_and_answer(side)
    noise = 0.005 * np.random.default_rng(1).normal(size=(2, 150))
    moved, pulled = answer + noise[0], line + 0.2 * noise[1]
    assert TimeTest.of_history(time, moved, pulled, "mm", "N").control == "force"
    assert TimeTest.of_history(time, pulled, moved, "mm", "N").control == "displacement"


def test_a_triangle_without_noise_was_a_command_however_short_its_lines():
    time, line, answer = triangle_and_answer(10.87312)
    noise = 0.005 * np.random.default_rng(1).normal(size=150)
    assert controlled(time, answer + noise, np.round(line, 6))[0] == "force"
