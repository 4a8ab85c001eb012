"""Tests in time: what they are, what they refuse, and the noise that they tell of themselves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from springpot.errors import DataError
from springpot.measurement import Loading, TimeTest, Units, noise_of

CLOCK = np.linspace(0.0, 10.0, 201)


def record(displacement, force, **options):
    return TimeTest.of_history(CLOCK, displacement, force, "mm", "N", **options)


def test_a_record_is_called_by_what_was_imposed():
    held = np.minimum(CLOCK / 0.2, 1.0)
    answer = 5.0 * np.exp(-CLOCK / 3.0)
    assert record(held, answer).kind == "relaxation"
    assert record(held, answer).rise == pytest.approx(0.2, abs=0.01)
    assert record(0.5 * CLOCK, answer).kind == "startup"
    assert record(np.sin(CLOCK), answer).kind == "history"
    crept = 1.0 + np.log1p(CLOCK)
    assert record(crept, held).kind == "creep"
    released = np.where(CLOCK < 4.0, held, 0.0)
    assert record(crept, released, control="force").kind == "recovery"


def test_what_is_held_was_imposed():
    creep = record(1.0 + np.log1p(CLOCK), np.full(201, 3.0))
    assert (creep.control, creep.answered, creep.response_unit) == ("force", "displacement", "mm")
    assert record(np.sin(CLOCK), np.cos(CLOCK)).control == "displacement"


def test_a_record_that_begins_late_rose_from_nothing():
    late = TimeTest.of_history([0.1, 0.2, 3.0], [0.03, 0.03, 0.03], [4.0, 3.0, 1.0], "-", "Pa")
    assert late.loading.time[0] == 0.0
    assert late.loading.value[0] == 0.0
    assert late.rise == pytest.approx(0.1)
    given_ramp = TimeTest.of_history(
        [0.1, 0.2, 3.0], [0.03, 0.03, 0.03], [4.0, 3.0, 1.0], "-", "Pa", rise=0.02
    )
    assert given_ramp.rise == pytest.approx(0.02)


def test_per_cent_is_a_share_and_makes_a_modulus():
    strained = TimeTest.of_history([0.0, 1.0, 2.0], [0.0, 2.0, 2.0], [0.0, 8.0, 6.0], "%", "kPa")
    assert strained.units == Units("kPa", "-")
    assert strained.loading.value.max() == pytest.approx(0.02)


@settings(deadline=None, max_examples=40)
@given(
    st.lists(st.floats(0.0, 9.0), min_size=1, max_size=6),
    st.lists(st.floats(-3.0, 3.0), min_size=7, max_size=7),
)
def test_a_loading_is_its_jumps_and_the_rest(times, values):
    """At every time that is no knot, jumps and the smooth part together are what was given."""
    knots = np.repeat(np.sort(np.round(times, 3)), 2)
    value = np.resize(values, len(knots))
    loading = Loading(knots, value)
    at = np.unique(np.concatenate([np.linspace(0.0005, 9.9995, 50)]))
    at = at[~np.isin(np.round(at, 9), knots)]
    when, size = loading.jumps
    stepped = (size * (at[:, None] > when)).sum(axis=1)
    smooth = (
        0.0 if loading.smooth is None else np.interp(at, loading.smooth.time, loading.smooth.value)
    )
    last = np.searchsorted(knots, at, side="right")
    before, after = np.clip(last - 1, 0, None), np.clip(last, None, len(knots) - 1)
    width = np.maximum(knots[after] - knots[before], 1e-300)
    share = np.where(last == 0, 0.0, np.where(after == before, 0.0, (at - knots[before]) / width))
    wanted = np.where(last == 0, value[0], value[before] + share * (value[after] - value[before]))
    assert smooth + stepped == pytest.approx(wanted, abs=1e-9)


def test_other_units_hold_the_same_test():
    test = record(np.sin(CLOCK), 4.0 * np.cos(CLOCK))
    other = test.in_units(Units("kN/m", "m"))
    assert (other.force_unit, other.displacement_unit) == ("kN", "m")
    assert other.response == pytest.approx(4e-3 * np.cos(CLOCK))
    assert other.loading.value == pytest.approx(1e-3 * np.sin(CLOCK))
    with pytest.raises(DataError, match="a stiffness is no modulus"):
        test.in_units(Units("kPa", "-"))


@pytest.mark.parametrize(
    ("time", "modulus", "says"),
    [
        ([1.0, 1.0, 2.0], [3.0, 2.0, 1.0], "does not rise after sample 1"),
        ([1.0, np.nan, 2.0], [3.0, 2.0, 1.0], "time of sample 2 is no number"),
        ([1.0, 1.5, 2.0], [3.0, np.nan, 1.0], "force of sample 2 is no number"),
        ([-1.0, 1.5, 2.0], [3.0, 2.0, 1.0], "lies before the load"),
        ([1.0, 1.5, 2.0], [3.0, 2.0], "3 times for 2 values"),
        ([1.0], [3.0], "no test in time"),
    ],
)
def test_what_cannot_be_measured_is_refused(time, modulus, says):
    with pytest.raises(DataError, match=says):
        TimeTest.of_relaxation(time, modulus, "Pa")


def test_a_load_that_never_moves_tests_nothing():
    with pytest.raises(DataError, match="never moves"):
        record(np.zeros(201), np.ones(201), control="displacement")


@pytest.mark.parametrize(("absolute", "relative"), [(0.0, 0.01), (0.002, 0.01), (0.004, 0.0)])
@pytest.mark.parametrize("spacing", ["log", "linear", "ragged"])
def test_the_signal_tells_its_noise(absolute, relative, spacing):
    rng = np.random.default_rng(3)
    t = {
        "log": np.geomspace(0.01, 100.0, 600),
        "linear": np.linspace(0.1, 100.0, 600),
        "ragged": np.sort(rng.uniform(0.1, 100.0, 600)),
    }[spacing]
    exact = 100.0 * (1.0 + t) ** -0.6
    sd = np.hypot(absolute * exact.max(), relative * exact)
    told = noise_of(TimeTest.of_relaxation(t, exact + sd * rng.normal(size=600), "Pa"))
    assert told.estimated
    assert np.sqrt(np.mean((sd / told.sd) ** 2)) == pytest.approx(1.0, abs=0.12)


def test_a_computed_record_has_no_noise_but_a_floor():
    t = np.geomspace(0.01, 100.0, 300)
    told = noise_of(TimeTest.of_relaxation(t, t**-0.4, "Pa"))
    assert told.relative < 1e-4
    assert np.all(told.sd > 0.0)


def test_a_force_that_was_held_and_released_was_imposed():
    """Of a creep with recovery neither channel stands still in the end.

    The force has two levels, and that tells.
    """
    t = np.linspace(0.0, 20.0, 400)
    force = np.where((t > 0.1) & (t < 8.0), 2.0, 0.0)
    crept = np.where(t < 8.0, np.sqrt(np.maximum(t - 0.1, 0.0)), 2.8 * np.exp(-0.3 * (t - 8.0)))
    test = TimeTest.of_history(t, crept, force, "mm", "N")
    assert (test.control, test.kind) == ("force", "recovery")
    scatter = 1.0 + 0.005 * np.random.default_rng(1).normal(size=len(t))
    assert TimeTest.of_history(t, crept, force * scatter, "mm", "N").control == "force"


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_samples_are_told(count):
    time = np.zeros(count)
    for make in (
        lambda: TimeTest.of_history(time, time, time, "mm", "N"),
        lambda: TimeTest.planned(time, time, "mm"),
        lambda: TimeTest.of_relaxation(time, time, "Pa"),
    ):
        with pytest.raises(
            DataError, match=f"{count} samples with all of their numbers are no test in time"
        ):
            make()


@pytest.mark.parametrize("clock", [[0.0, 0.01, 0.1, 1.0, 10.0], [0.01, 0.05, 0.1, 1.0, 10.0]])
def test_a_step_of_which_the_ramp_is_said_to_take_no_time_is_a_step(clock):
    strain = [1e-3 * (1.0 + 0.1 * i) for i in range(5)]
    stress = [0.0 if t == 0.0 else 10.0 for t in clock]
    plain = TimeTest.of_history(clock, strain, stress, "-", "Pa", control="force")
    stepped = TimeTest.of_history(clock, strain, stress, "-", "Pa", control="force", rise=0.0)
    assert (plain.rise, stepped.rise) == (0.01, 0.0)
    assert stepped.kind == "creep"
    when, sizes = stepped.loading.jumps
    assert (when.tolist(), sizes.tolist()) == ([0.0], [10.0])
