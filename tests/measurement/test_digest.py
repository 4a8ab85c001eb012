"""A digest is of what a fit can tell apart: no last bit reaches it, all else does."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest
from hypothesis import given, strategies as st

from springpot.measurement import Loading, Measurement, TimeTest, Units
from springpot.measurement.rows import TOLD, digest_of_columns, told, told_of

POINTS = 4
ULP = 2.0**-52


def many(one):
    return st.lists(one, min_size=POINTS, max_size=POINTS).map(np.array)


@st.composite
def numbers(draw, least=-6, most=6, signs=(1.0, -1.0)):
    """A column whose numbers lie a tenth of a digit from an edge between two at least."""
    digits = draw(many(st.integers(2 ** (TOLD - 1) + 1, 2**TOLD - 2)))
    parts, sides = draw(many(st.floats(-0.4, 0.4))), draw(many(st.sampled_from(signs)))
    return np.ldexp(sides * (digits + parts), draw(many(st.integers(least, most))) - TOLD)


positive = numbers(signs=(1.0,))
decades = numbers(-60, 60, (1.0,))


@st.composite
def rising(draw):
    """Times over decades."""
    steps = 2 + draw(st.integers(0, 9))
    return np.ldexp(draw(numbers(0, 0, (1.0,))), steps * np.arange(POINTS))


@st.composite
def sweeps(draw):
    return Measurement(
        draw(decades),
        draw(positive) + 1j * draw(numbers()),
        sd=draw(positive) + 1j * draw(positive),
        conditions={"temperature": draw(numbers()), "amplitude": draw(positive)},
    )


@st.composite
def records(draw):
    imposed = draw(numbers())
    imposed[0] = -2.0 * imposed[1]
    loading = Loading(draw(rising()) / 4.0, imposed)
    return TimeTest(draw(rising()), draw(numbers()), loading, warmth=draw(positive))


def columns_of(data):
    """The columns of real numbers, each with what puts another in its place."""
    if isinstance(data, TimeTest):
        for name in ("time", "response", "warmth"):
            yield getattr(data, name), lambda x, name=name: replace(data, **{name: x})
        for name in ("time", "value"):
            yield (
                getattr(data.loading, name),
                lambda x, name=name: replace(data, loading=replace(data.loading, **{name: x})),
            )
        return
    yield data.omega, lambda x: replace(data, omega=x)
    for name in ("stiffness", "sd"):
        k = getattr(data, name)
        yield k.real, lambda x, k=k, name=name: replace(data, **{name: x + 1j * k.imag})
        yield k.imag, lambda x, k=k, name=name: replace(data, **{name: k.real + 1j * x})
    for name, column in data.conditions.items():
        yield column, lambda x, name=name: replace(data, conditions={**data.conditions, name: x})


@given(st.one_of(sweeps(), records()), many(st.integers(-8, 8)))
def test_last_bits_of_every_number_leave_the_digest(data, bits):
    moved = data
    for i in range(len(list(columns_of(data)))):
        column, changed = list(columns_of(moved))[i]
        moved = changed(column * (1.0 + ULP * np.roll(bits, i)))
    assert moved.digest() == data.digest()


@given(st.one_of(sweeps(), records()), st.integers(0, POINTS - 1))
def test_a_millionth_of_any_number_changes_it(data, place):
    for column, changed in columns_of(data):
        other = column.copy()
        other[place] *= 1.0 + 1e-6
        assert changed(other).digest() != data.digest()


def test_zeros_that_are_computed_are_zeros():
    """What is nearer to nothing than sums and products leave has neither size nor sign."""
    turns = np.linspace(0.0, 4.0, 33)
    wave = np.sin(np.pi * turns)
    exact = np.where(turns % 1.0 == 0.0, 0.0, wave)
    assert np.count_nonzero(wave != exact) == 4
    first = TimeTest(turns, wave, Loading(turns, 0.1 * wave, sampled=True))
    second = TimeTest(turns, -0.0 + exact, Loading(turns, 0.1 * exact, sampled=True))
    third = TimeTest(turns, np.where(exact, exact, -0.0), second.loading)
    assert first.digest() == second.digest() == third.digest()
    storage, loss = np.array([5.0, -3e-16, 1e-9]), np.array([1.0, 2.0, 1e-9])
    near = Measurement([1.0, 2.0, 3.0], storage + 1j * loss)
    assert near.digest() == replace(near, stiffness=storage.round(15) + 1j * loss).digest()
    # Each row beside its own size, however large another is.
    less = replace(near, stiffness=np.array([5.0, 0.0, 2e-9]) + 1j * loss)
    assert near.digest() != less.digest()


def test_frequencies_and_times_over_thirty_decades_are_told_apart():
    omega = np.geomspace(1e-15, 1e15, 7)
    data = Measurement(omega, np.full(7, 1.0 + 1.0j))
    assert data.digest() != replace(data, omega=omega * np.r_[1.000001, np.ones(6)]).digest()
    test = TimeTest(omega, np.ones(7), Loading.step())
    assert test.digest() != replace(test, time=omega * np.r_[1.000001, np.ones(6)]).digest()


def test_what_is_no_number_is_told_as_that():
    column = np.array([1.0, np.nan, np.inf, -np.inf, 5e-324, -0.0])
    other = np.array([1.0, -np.nan, np.inf, -np.inf, 0.0, 0.0])
    assert told(column).tobytes() == told(other).tobytes()
    assert told(column).tolist()[2:] == [np.inf, -np.inf, 0.0, 0.0]
    assert np.isnan(told(column)[1])
    assert told(np.array([[5e-324], [1e300]])).tolist() == [[5e-324], [told_of(1e300)]]
    assert len({told(np.array([each])).tobytes() for each in (np.nan, np.inf, -np.inf, 0.0)}) == 4


def test_kind_and_shape_names_and_words_are_told():
    columns = {"a": np.array([1.0, 2.0])}
    others = [
        {"b": np.array([1.0, 2.0])},
        {"a": np.array([1, 2])},
        {"a": np.array([1.0 + 2.0j])},
        {"a": np.array([[1.0, 2.0]])},
        {"a": np.array(["1.0", "2.0"])},
        {"a": np.array([1.0]), "b": np.array([2.0])},
    ]
    found = {digest_of_columns("of", each, ()) for each in [columns, *others]}
    assert len(found | {digest_of_columns("another", columns, ())}) == 8
    # Bytes of another order are the same numbers.
    turned = {"a": np.array([1.0, 2.0], dtype=">f8")}
    assert digest_of_columns("of", turned, ()) == digest_of_columns("of", columns, ())


@pytest.mark.parametrize(
    "change",
    [
        {"units": Units("kN/m", "mm")},
        {"harmonics": np.full((2, 1), 0.1j)},
        {"labels": {"specimen": np.array(["A", "B"])}},
        {"reference": 300.0},
    ],
    ids=lambda change: next(iter(change)),
)
def test_what_a_fit_sees_of_a_sweep_beside_its_numbers_is_told(change):
    data = Measurement([1.0, 2.0], [1.0 + 1j, 2.0 + 1j])
    assert replace(data, **change).digest() != data.digest()


@pytest.mark.parametrize(
    "change",
    [
        {"marks": {"specimen": 2.0}},
        {"temperature": 20.0},
        {"loading": Loading([0.0, 1.0], [0.0, 1.0], sampled=True)},
        {"loading": Loading([0.0, 1.0], [0.0, 1.0], before=1)},
    ],
    ids=["marks", "temperature", "sampled", "before"],
)
def test_what_a_fit_sees_of_a_record_beside_its_numbers_is_told(change):
    test = TimeTest([0.5, 1.0], [1.0, 2.0], Loading([0.0, 1.0], [0.0, 1.0]))
    assert replace(test, **change).digest() != test.digest()


def test_a_long_record_takes_no_time(rng):
    time = np.arange(100_000) * 1e-3
    test = TimeTest(time, rng.normal(size=len(time)), Loading(time, np.sin(time), sampled=True))
    began = perf_counter()
    test.digest()
    assert perf_counter() - began < 0.5  # 0.03 s where nobody else is at work
