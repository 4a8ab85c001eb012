"""A motion that is smooth and not steady is taken without the noise of its transducer."""

import tracemalloc

import numpy as np
import pytest

from springpot.distributions import autoregressive
from springpot.measurement import TimeTest
from springpot.measurement.course import BENDS, answer_to_unfelt, likeliest, smoothed
from springpot.measurement.imposed import Loading

STEP, COUNT = 0.002, 1500


def motions(rng):
    """Place and acceleration of two smooth motions that do not repeat."""
    t = STEP * np.arange(COUNT)
    turns = rng.uniform(2.0, 50.0, 30)
    size, start = rng.normal(size=30) / turns, rng.uniform(0.0, 6.0, 30)
    waves = size[:, None] * np.sin(np.outer(turns, t) + start[:, None])
    yield waves.sum(0), -(turns**2) @ waves
    rates = np.array([[-0.8 + 25.0j], [-0.5 + 10.0j]])
    ringing = np.exp(rates * t)
    yield ringing.sum(0).real, (rates**2 * ringing).sum(0).real


def with_noise(share, rng):
    return [
        (place + share * np.std(place) * rng.normal(size=COUNT), place, push)
        for place, push in motions(rng)
    ]


@pytest.mark.parametrize("share", [0.001, 0.01])
def test_a_mass_is_told_that_noise_would_hide(share):
    rng = np.random.default_rng(4)
    for read, place, push in with_noise(share, rng):
        force = 3.0 * place + 0.01 * push
        response = force + 0.01 * np.std(force) * rng.normal(size=COUNT)
        loading, said = smoothed(Loading(STEP * np.arange(COUNT), read, sampled=True), response)
        inner, bent = loading.value[1:-1], np.diff(loading.value, 2) / STEP**2
        columns = np.column_stack([inner, bent])
        told = np.linalg.lstsq(columns, response[1:-1], rcond=None)[0]
        assert "smooth" in said["motion"]
        assert told == pytest.approx([3.0, 0.01], rel=0.03)


@pytest.mark.parametrize("memory", [0.3, 0.6])
def test_noise_may_remember_the_sample_before(memory):
    rng = np.random.default_rng(4)
    place, push = next(motions(rng))
    read = place + 0.01 * np.std(place) * autoregressive(rng.normal(size=COUNT), memory)
    force = 3.0 * place + 0.01 * push
    response = force + 0.01 * np.std(force) * rng.normal(size=COUNT)
    loading, said = smoothed(Loading(STEP * np.arange(COUNT), read, sampled=True), response)
    columns = np.column_stack([loading.value[1:-1], np.diff(loading.value, 2) / STEP**2])
    told = np.linalg.lstsq(columns, response[1:-1], rcond=None)[0]
    assert "noise with a memory" in said["motion"]
    assert told == pytest.approx([3.0, 0.01], rel=0.03)


@pytest.mark.parametrize("degree", [1, 2])
def test_a_rough_motion_stays_as_it_was_read(degree):
    rng = np.random.default_rng(4)
    rough = rng.normal(size=COUNT)
    for _ in range(degree):
        rough = autoregressive(rough, 0.9)
    read = Loading(STEP * np.arange(COUNT), rough, sampled=True)
    response = 3.0 * rough + 0.01 * rng.normal(size=COUNT)
    assert smoothed(read, response)[0] is read


def test_nothing_is_taken_off_a_motion_that_was_read_without_noise():
    for place, push in motions(np.random.default_rng(4)):
        read = Loading(STEP * np.arange(COUNT), place, sampled=True)
        assert smoothed(read, 3.0 * place + 0.01 * push)[0] is read


def test_what_the_specimen_answers_to_was_felt():
    rng = np.random.default_rng(4)
    for rough, _, _ in with_noise(0.02, rng):
        read = Loading(STEP * np.arange(COUNT), rough, sampled=True)
        response = 3.0 * rough + 0.001 * np.std(rough) * rng.normal(size=COUNT)
        assert smoothed(read, response)[0] is read


def test_what_does_not_move_has_no_course():
    rng = np.random.default_rng(4)
    noise, response = rng.normal(size=(2, COUNT))
    read = Loading(STEP * np.arange(COUNT), noise, sampled=True)
    assert smoothed(read, response)[0] is read


def test_what_was_sampled_unevenly_is_left_as_it_was_read():
    rng = np.random.default_rng(4)
    for rough, place, _ in with_noise(0.02, rng):
        clock = np.cumsum(rng.uniform(0.5, 1.5, COUNT))
        read = Loading(clock, rough, sampled=True)
        assert smoothed(read, place + 0.1 * rng.normal(size=COUNT))[0] is read


def test_what_is_answered_to_the_error_of_a_course_is_told_at_each_frequency():
    from scipy.fft import dct

    found = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        read, place, push = with_noise(0.01, rng)[0]
        response = 3.0 * place + 0.01 * push
        noisy = response + 0.02 * np.std(response) * rng.normal(size=COUNT)
        loading, _ = smoothed(Loading(STEP * np.arange(COUNT), read, sampled=True), noisy)
        off = loading.value - place
        missed = 3.0 * off + 0.01 * np.gradient(np.gradient(off, STEP), STEP)
        ends = COUNT // 50
        power = dct(missed[ends:-ends], norm="ortho") ** 2
        told = answer_to_unfelt(loading, loading.time, noisy)[: len(power)]
        edge = int(loading.unfelt.numbers)
        found.append([np.sum(power[part]) / np.sum(told[part]) for part in bands(edge)])
    # Of an octave below the edge of what is followed, and one about it.
    assert np.median(found, axis=0) == pytest.approx([1.0, 1.0], abs=0.6)


def bands(edge):
    return slice(edge // 2, edge), slice(int(0.7 * edge), int(1.4 * edge))


def test_of_white_noise_no_course_is_left_but_a_polynomial():
    spline = likeliest(np.random.default_rng(2).normal(size=400))
    assert BENDS <= spline.freedom < 3 * BENDS


def test_a_record_keeps_what_was_taken_off_in_any_unit():
    rng = np.random.default_rng(4)
    read, place, push = with_noise(0.01, rng)[0]
    force = 3.0 * place + 0.01 * push
    force += 0.01 * np.std(force) * rng.normal(size=COUNT)
    test = TimeTest.of_history(STEP * np.arange(COUNT), read, force, "mm", "N")
    noise, numbers = test.loading.unfelt
    assert noise == pytest.approx(0.01 * np.std(place), rel=0.1)
    assert test.loading.scaled(-1e-3).unfelt == (pytest.approx(1e-3 * noise), numbers)


def test_ends_of_a_smooth_course_are_not_judged():
    rng = np.random.default_rng(4)
    read, place, push = with_noise(0.01, rng)[0]
    force = 3.0 * place + 0.01 * push
    force += 0.01 * np.std(force) * rng.normal(size=COUNT)
    test = TimeTest.of_history(STEP * np.arange(COUNT), read, force, "mm", "N")
    few = int(np.ceil(COUNT / test.loading.unfelt.numbers))
    unsure = np.isin(test.time, test.loading.unsure(True))
    assert unsure[:few].all()
    assert unsure[-few:].all()
    assert not unsure[few + 1 : -few - 1].any()


def test_a_course_of_a_long_record_takes_little_memory():
    count = 5_000
    read = np.sin(np.linspace(0.0, 60.0, count)) + 0.01 * np.random.default_rng(1).normal(
        size=count
    )
    likeliest(read[:COUNT])
    tracemalloc.start()
    likeliest(read)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 90 * read.nbytes
