"""Rules of loads, noise and levels of a measurement, by hand and at both sides of their edges."""

from __future__ import annotations

from math import tanh
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import f

from springpot.errors import DataError
from springpot.measurement import (
    Measurement,
    geometry,
    imposed,
    independence,
    measurement,
    mixed_up,
    replicates,
    rows,
    scatter,
    signals,
    timenoise,
)
from springpot.thresholds import OUTLIERS, REPEATS, SEARCH, VERDICT


@pytest.mark.parametrize(
    ("course", "released"),
    [
        ([0.0, 1.0, 2.0, 1.0, 0.0], True),
        ([0.0, -1.0, -2.0, -1.0, 0.0], True),
        ([0.0, 2.0, 0.039], True),
        ([0.0, 2.0, 0.041], False),
        ([0.0, 2.0, -0.039], True),
        ([0.0, 2.0, -0.041, 0.0], False),
        ([0.0, 2.0, -0.039, 0.0], True),
        ([0.0, 2.0, 0.9, 2.0, 0.0], False),
        ([0.0, 2.0, 1.1, 2.0, 0.0], True),
        ([0.0, 1.0, 2.0, 2.0], False),
        ([*np.linspace(0.0, 2.0, 50), *np.linspace(2.0, 0.0, 50)], False),
        ([*np.linspace(0.0, 2.0, 50), *np.linspace(2.0, 0.0, 40), *[0.0] * 10], True),
    ],
)
def test_a_load_is_released_that_goes_up_once_and_stays_at_nothing(course, released):
    clock = np.arange(float(len(course)))
    assert imposed.is_released(clock, np.array(course), 2.0) is released


@pytest.mark.parametrize("a", [0.005, 0.0199, 0.0201, 1.0])
def test_what_a_layer_lacks_of_its_length_is_a_less_tanh_a(a):
    series = a**3 / 3.0 - 2.0 * a**5 / 15.0 + 17.0 * a**7 / 315.0
    wanted = a - tanh(a) if a > 0.1 else series
    assert geometry._less_tanh(a) == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize(
    ("values", "held"),
    [
        ([1.5, 1.515], True),
        ([1.5, 1.52], False),
        ([-1.52, -1.51], True),
        ([1000.0, 1001.0], False),
        ([1000.5, 1001.0], True),
        (["a", "b"], False),
    ],
)
def test_values_within_a_hundredth_are_one_unless_they_count(values, held):
    assert mixed_up._was_held(np.array(values)) is held


@pytest.mark.parametrize(
    ("levels", "frequencies", "parts"),
    [
        ([0, 0, 1, 1], [1, 2, 1, 2], 2),
        ([0, 0, 1, 1], [1, 2, 1, 1], 1),
        ([0, 0, 0, 0], [1, 2, 3, 4], 1),
        ([0, 1, 1, 1], [1, 2, 3, 4], 2),
    ],
)
def test_levels_are_sweeps_where_each_has_two_frequencies_in_the_mean(levels, frequencies, parts):
    data = SimpleNamespace(
        conditions={"temperature": 300.0 + 20.0 * np.array(levels)},
        omega=np.array(frequencies, dtype=float),
    )
    found = mixed_up._by_level(data, "temperature", np.arange(4))
    assert len(found) == parts
    if parts == 2:
        for number, part in enumerate(found):
            np.testing.assert_array_equal(part, np.flatnonzero(np.array(levels) == number))


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("temperature", ""),
        ("temprature", "temperature"),
        ("Temperatures", "temperature"),
        ("temperature_2", ""),
        ("amplitud", "amplitude"),
        ("water", ""),
    ],
)
def test_a_name_that_is_nearly_a_condition_is_told(name, near):
    says = measurement.misspelt(name)
    assert says.startswith(f"is nearly '{near}': ") if near else says == ""


@pytest.mark.parametrize(
    ("asked", "found"),
    [("A", "A"), ("a", "a"), ("b", "b 2"), ("2", "b 2"), ("BC", "bc"), ("", None), ("z", None)],
)
def test_a_word_means_itself_before_what_it_begins_and_that_before_what_it_is_in(asked, found):
    words = np.array(["A", "a", "b 2", "bc", "A"])
    data = SimpleNamespace(labels={"specimen": words}, name="made")
    if found is None:
        with pytest.raises(DataError, match=f"made: no specimen '{asked}'"):
            rows._matching_words(data, "specimen", asked)
        return
    np.testing.assert_array_equal(rows._matching_words(data, "specimen", asked), words == found)


def test_words_that_several_values_hold_are_told_as_several():
    data = SimpleNamespace(labels={"specimen": np.array(["ab", "cb"])}, name="made")
    with pytest.raises(DataError, match="several values of specimen match 'b'"):
        rows._matching_words(data, "specimen", "b")


@pytest.mark.parametrize(("spent", "shape"), [(1, True), (2, False)])
def test_noise_with_heavy_tails_costs_its_scales_and_its_shape(spent, shape):
    part = np.array([1.0, -2.0]), np.array([0.5, 3.0])
    form = np.array([2.0, 4.0]), np.array([1.0, 0.5])
    given = scatter.Shape(form[0], form[1], shape, 7.0)
    scales = np.array([0.5, 2.0])
    wanted = 7.0 + spent * np.log(4.0)
    for values, size, scale in zip(part, form, scales, strict=True):
        width = scale * size
        wanted += np.sum(2.0 * np.log(width) + 5.0 * np.log1p((values / width) ** 2 / 4.0))
    found = scatter._student_cost(given, scales, part[0] + 1j * part[1])
    assert found == pytest.approx(wanted)


def test_noise_is_a_share_of_each_part_or_of_both_or_has_a_floor_of_stiffness_or_of_force():
    amplitude = np.array([1.0, 2.0])
    size = np.array([1.0, 1.5])
    data = Measurement(
        np.array([1.0, 2.0]), size * (0.6 + 0.8j), conditions={"amplitude": amplitude}
    )
    whole, apart, parts, *floors = scatter._shapes_of(data)
    for shape in (whole, apart):
        np.testing.assert_allclose([shape.real, shape.imag], [size, size])
    np.testing.assert_allclose([parts.real, parts.imag], [0.6 * size, 0.8 * size])
    assert [each.tied for each in (whole, apart, parts)] == [True, False, True]
    assert [each.price for each in (whole, apart, parts)] == [0.0, *[SEARCH.decisive] * 2]
    levels = scatter.FLOOR_LEVELS
    told = [(level, unit) for unit in (np.ones(2), amplitude) for level in levels]
    for (level, unit), floor in zip(told, floors, strict=True):
        np.testing.assert_allclose(floor.real, np.hypot(size, level / unit))
        assert floor.price == VERDICT.clear_evidence
    one = Measurement(np.array([1.0, 2.0]), size * 1j, conditions={"amplitude": np.full(2, 3.0)})
    assert len(list(scatter._shapes_of(one))) == 3 + len(levels)


@pytest.mark.parametrize(
    ("cycles", "groups", "told"),
    [(9.0, 2, False), (2.229, 3, False), (2.233, 3, True), (1.7, 9, True)],
)
def test_cycles_that_scatter_beyond_chance_give_the_uncertainty(cycles, groups, told):
    """By F of two and sixty degrees of freedom, 4.977 at one in a hundred: 2.231 deviations."""
    for both in (complex(cycles, 0.5), complex(0.5, cycles)):
        size, words = signals._chosen(1.0 + 1.0j, both, groups, 60.0)
        assert bool(words) is told
        assert size == (complex(max(1.0, both.real), max(1.0, both.imag)) if told else 1.0 + 1.0j)


@pytest.mark.parametrize(("beyond", "out"), [(0.99, False), (1.01, True)])
def test_a_noise_is_ruled_out_by_its_likelihood_beside_the_best(beyond, out):
    """One of two degrees of freedom: minus twice the logarithm of the chance."""
    levels = timenoise._Levels(np.ones(3), np.array([2.0, 3.0, 4.0]), np.array([5.0, 6.0, 7.0]))
    best = 5.0 * np.log(2.0) + 6.0 * np.log(3.0) + 7.0 * np.log(4.0) + 18.0
    assert levels.cost(levels.power) == pytest.approx(best)
    limit = -2.0 * np.log(timenoise.SIGNALS.ruled_out)
    assert levels.rule_out(best + beyond * limit) is out
    two = timenoise._Levels(*(each[:2] for each in levels))
    assert two.rule_out(1e9) is False


def test_what_settles_takes_what_a_curve_of_its_time_explains():
    """Four pairs of repeats, which differ as a rig that settles lets them, and as none does."""
    group, usable = np.tile(np.arange(4), 2), np.ones(8, dtype=bool)
    along = np.linspace(0.0, 1.0, 8)
    for time in replicates.SETTLING_TIMES:
        curve = np.exp(-along / time)
        curve = curve - np.tile((curve[:4] + curve[4:]) / 2.0, 2)
        found = replicates._by_settling(3.0j * curve, group, usable)
        assert found == pytest.approx(9.0 * np.sum(curve**2))
    assert replicates._by_settling(np.zeros(8, dtype=complex), group, usable) == 0.0


def test_a_polynomial_leaves_out_what_it_was_made_to_meet():
    x = np.linspace(2.0, 5.0, 40)
    degree = independence.SMOOTH_DEGREE
    y = np.polynomial.Polynomial([1.0, -2.0, 0.5])(x)
    y[7] += 3.0
    left = independence._off_polynomial(x, y)
    assert len(left) == 40 - degree - 1
    # One bad point is left as it is, and moves the curve by nothing.
    assert left[-1] == pytest.approx(3.0, rel=1e-2)
    assert left[-2] < 1e-2


def repeated(gain, slope, short=0):
    """Three runs at sixteen frequencies whose gains and slopes are so strong by their F.

    Beside noise that is alike in each, of which neither mean nor slope is anything; `short`
    points of a fourth run.
    """
    count = 16
    omega = np.geomspace(1.0, 20.0, count)
    x = np.log(omega) - np.mean(np.log(omega))
    noise = np.cos(2.0 * np.arange(count)) + 1j * np.sin(3.0 * np.arange(count))
    noise -= noise.mean()
    noise -= x * (x @ noise) / (x @ x)
    # 48 rows of which a third is the mean, two gains and two slopes: 28 complex numbers.
    free = 2.0 * (32.0 - 4.0)
    unit = 3.0 * float(np.sum(np.abs(noise) ** 2)) / free
    chosen = f.isf(OUTLIERS.rare, 4.0, free) * unit * 4.0 / 6.0
    each = np.array([1.0, -2.0, 1.0])
    a, b = np.sqrt(gain * chosen / count), np.sqrt(slope * chosen / (x @ x))
    relative = np.concatenate([noise + run * (a * 1j + b * x) for run in each])
    rows = np.r_[np.tile(np.arange(count), 3), np.arange(short)]
    data = Measurement(
        omega[rows],
        np.full(len(rows), 1.0 + 1.0j),
        repeat=np.r_[np.repeat([1, 2, 3], count), [4] * short],
    )
    relative = np.concatenate([relative, np.full(short, 9.0)])
    return replicates._replicate_gains(data, relative, rows), 1j * a * np.repeat(each, count)


@pytest.mark.parametrize(
    ("gain", "slope", "told"),
    [
        (1.01, 0.0, True),
        (0.99, 0.0, False),
        (9.0, 0.99, True),
        (9.0, 1.01, False),
    ],
)
def test_runs_have_gains_of_their_own_where_these_and_not_slopes_differ(gain, slope, told):
    (found, spent), expected = repeated(gain, slope)
    if not told:
        assert (found, spent) == (None, 0.0)
        return
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert spent == pytest.approx(2.0)


def test_a_run_of_few_points_has_no_gain():
    (found, _), expected = repeated(99.0, 0.0, short=REPEATS.points_of_a_run - 1)
    np.testing.assert_allclose(found[:48], expected, atol=1e-12)
    np.testing.assert_array_equal(found[48:], 0.0)


def test_a_specimen_that_settles_has_no_gains():
    """What the fourth of the times explains tells three runs apart better than their gains do."""
    count = 16
    along = np.linspace(0.0, 1.0, 48)
    curve = np.exp(-along / replicates.SETTLING_TIMES[3]).reshape(3, count)
    relative = (curve - curve.mean(axis=0)).ravel() + 1e-9 * np.cos(5.0 * np.arange(48))
    rows = np.tile(np.arange(count), 3)
    data = Measurement(
        np.geomspace(1.0, 20.0, count)[rows],
        np.full(48, 1.0 + 1.0j),
        repeat=np.repeat([1, 2, 3], count),
    )
    assert replicates._replicate_gains(data, relative + 0.0j, rows) == (None, 0.0)
