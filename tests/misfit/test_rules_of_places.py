"""Where a misfit lies, how it grows and what of it a material has: each rule at its edge."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement, Units
from springpot.misfit import drift_search, material, residual_causes, residual_tests, where
from springpot.numerics import FEWEST
from springpot.thresholds import VERDICT


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_model_is_of_a_material_where_its_own_follows_a_tenth_of_the_error(monkeypatch, share):
    asked = []

    def least(model, data, others):
        asked.append((data, [each.tolist() for each in others]))
        return share * (0.1 * 0.03 + VERDICT.arithmetic)

    monkeypatch.setattr(material, "least_error", least)
    theta = np.array([5.0, 0.2, 3.0])
    model = springpot.parse_model("kelvin + coulomb-friction")
    # The effect is the last parameter, and no part of what is asked.
    assert material.is_of_material(model, theta, (2.0, 50.0), 0.03) is (share < 1.0)
    [(data, others)] = asked
    np.testing.assert_allclose(data.omega, np.geomspace(0.02, 5000.0, 60))
    np.testing.assert_allclose(data.stiffness, 5.0 + 0.2j * data.omega)
    assert others == [[]]


def test_a_material_that_needs_a_condition_is_none_that_every_material_follows(monkeypatch):
    monkeypatch.setattr(material, "least_error", lambda *given: 0.0)
    model = SimpleNamespace(material=SimpleNamespace(needs={"amplitude"}))
    assert material.is_of_material(model, np.zeros(0), (1.0, 2.0), 1.0) is False


@pytest.mark.parametrize(
    ("course", "says"),
    [
        ([1.0, 2.0], ""),
        ([1.0, 1.5, 2.0], ""),
        ([1.0, 2.3, 2.0], " (most at b)"),
        ([2.0, 2.3, 1.0], " (most at b)"),
        ([1.0, 2.1, 2.0], ""),
        ([1.0, 2.13, 2.0], " (most at b)"),
        ([1.0, 0.5, 2.0], " (least at b)"),
        ([1.0, 1.5, 0.4, 2.0], " (least at c)"),
    ],
)
def test_a_course_turns_where_it_lies_a_tenth_beyond_both_ends(course, says):
    assert material._turn(np.array(course), "abcd") == says


@pytest.mark.parametrize("common", [FEWEST - 1, FEWEST])
def test_levels_are_compared_at_three_frequencies_that_all_share(common):
    """The first stands for 2 and 1 N/mm, the second for 3 and 6: once and a half and twice."""
    omega = np.r_[np.arange(1.0, 6.0), np.arange(6.0 - common, 9.0)]
    rows = np.arange(5), np.arange(5, len(omega))
    curves = (2.0 + 1.0j, 3.0 + 6.0j)
    levels = [
        SimpleNamespace(
            rows=each,
            value=value,
            fitted=SimpleNamespace(
                model=SimpleNamespace(stiffness=lambda theta, at, curve=curve: curve + 0 * at),
                theta=None,
            ),
        )
        for each, value, curve in zip(rows, (0.1, 0.3), curves, strict=True)
    ]
    data = Measurement(omega, omega + 1j, name="made")
    says = material._course(data, levels)
    if common < FEWEST:
        assert says == "the amplitude matters"
        return
    assert "|G*| rises by 200 %" in says
    assert "the loss factor goes from 0.50 to 2.0" in says


def test_what_is_called_by_a_vowel_has_its_article():
    assert residual_tests.one_of("amplitude") == "an amplitude"
    assert residual_tests.one_of("temperature") == "a temperature"
    assert residual_tests.one_of("year") == "a year"


def missed(power, factor, count=6, turned=()):
    """Points over so wide a range of which the misfit goes with a power of frequency."""
    omega = np.geomspace(1.0, factor, count)
    residual = -(omega**power)
    residual[list(turned)] *= -1e-3
    return (
        SimpleNamespace(omega=omega),
        SimpleNamespace(residual=residual),
        np.arange(count),
    )


def test_a_misfit_grows_as_its_points_of_one_sign_do():
    few, wide = where.FEWEST_OF_A_LAW, np.exp(where.WIDE)
    for power, words in where.FREQUENCY_POWERS.items():
        assert where._growth(*missed(power, 1.01 * wide, few)) == words
        assert where._growth(*missed(power, 9.0, few + 1, [1])) == words
    assert where._growth(*missed(1.0, 0.99 * wide, few)) == ""
    assert where._growth(*missed(1.0, 9.0, few, [1])) == ""


def test_a_region_is_as_long_as_its_frequencies_hold_points():
    region = SimpleNamespace(spans=[(2, 5), (0, 1)])
    assert where._length(SimpleNamespace(points_of_each=4), region) == 12


@pytest.mark.parametrize(("size", "side"), [(0.021, "low"), (-0.021, "high")])
def test_a_curve_that_lies_below_its_points_is_too_low(size, side):
    data = Measurement(np.geomspace(1.0, 10.0, 5), np.full(5, 3.0 + 1.0j), name="made")
    part = SimpleNamespace(
        word="storage", name="storage", relative=np.full(5, size), residual=np.full(5, size)
    )
    found = where._place(data, [None], part, np.arange(3), "storage")
    assert found.says.startswith(f"storage 2.1 % of |G*| too {side} ")
    assert found.size == pytest.approx(size)


@pytest.mark.parametrize(
    ("column", "numbers"),
    [
        # Of a temperature held to what a rig holds, no parts; of one that was swept, three.
        (np.r_[np.zeros(6), 40.0 + np.zeros(6)], np.repeat([0, 1], 6)),
        (np.r_[np.zeros(6), 40.0 + 40.0 * np.arange(6)], np.r_[np.zeros(6), 1, 1, 2, 2, 3, 3]),
    ],
)
def test_a_sweep_of_a_condition_without_steps_stands_in_parts(column, numbers):
    level = np.repeat([0, 1], 6)
    data = SimpleNamespace(conditions={"temperature": column}, levels=lambda name: level)
    np.testing.assert_array_equal(where._set_values(data, "temperature", 3), numbers)


def test_a_shift_is_that_of_all_laws_of_temperature_together():
    data = Measurement(
        np.array([1.0, 2.0, 3.0]),
        np.full(3, 1.0 + 1.0j),
        conditions={"temperature": np.array([300.0, 310.0, 320.0])},
    )

    def shift(model, *theta):
        return residual_causes.log_shift_of(
            SimpleNamespace(
                model=springpot.parse_model(model),
                theta=np.array(theta),
                fit=SimpleNamespace(measurement=data),
            )
        )

    first = shift("kelvin + arrhenius-shift", 1.0, 1.0, 5e4)
    second = shift("kelvin + wlf-shift", 1.0, 1.0, 8.0, 120.0)
    assert np.ptp(first) > 1.0
    assert np.ptp(second) > 1.0
    both = shift("kelvin + arrhenius-shift + wlf-shift", 1.0, 1.0, 5e4, 8.0, 120.0)
    np.testing.assert_allclose(both, first + second)
    assert shift("kelvin", 1.0, 1.0) is None


@pytest.mark.parametrize(("start", "end", "has"), [(1.0, 2.0, True), (1.0, 1.0, False)])
def test_a_drift_has_ends_where_a_point_was_measured_twice(start, end, has):
    own = SimpleNamespace(start=start, end=end)
    assert drift_search.Course.has_ends.fget(own) is has


@pytest.mark.parametrize(
    ("low", "high", "says"),
    [
        (1.0, 8.0, "at all frequencies"),
        (1.0, 4.0, "below 4 Hz"),
        (2.0, 8.0, "above 2 Hz"),
        (2.0, 4.0, "between 2 and 4 Hz"),
        (2.0, 2.0, "at 2 Hz"),
        (1.0, 1.0, "below 1 Hz"),
        (8.0, 8.0, "above 8 Hz"),
        (1.0 + 0.9 * where.HELD_ALIKE, 8.0 / (1.0 + 0.9 * where.HELD_ALIKE), "at all frequencies"),
    ],
)
def test_a_range_is_told_by_the_ends_that_are_its_own(low, high, says):
    frequency = np.array([1.0, 2.0, 4.0, 8.0])
    assert where._range(low, high, frequency, Units()) == says
    assert where._range(2.0, 2.0, np.full(3, 2.0), Units()) == "at 2 Hz"


@pytest.mark.parametrize(
    ("relative", "whitened", "some", "says"),
    [
        ([0.02, 0.02], [9.0, -9.0], False, "the same at all temperatures"),
        ([0.02, 0.02], [9.0, -9.0], True, "the same at all these temperatures"),
        ([0.02, -0.02], [0.1, -0.1], False, ""),
        (
            [0.02, 0.05],
            [2.0, 9.0],
            False,
            "larger at higher temperatures (2 % at 20 degC, 5 % at 60 degC)",
        ),
        (
            [-0.05, 0.02],
            [-9.0, 2.0],
            False,
            "smaller at higher temperatures (5 % at 20 degC, 2 % at 60 degC)",
        ),
        ([0.02, 0.05, 0.02], [2.0, 9.0, 2.0], False, "varying with temperature"),
        (
            [0.02, 0.05, 0.04],
            [2.0, 9.0, 7.0],
            False,
            "larger at higher temperatures (2 % at 20 degC, 4 % at 60 degC)",
        ),
    ],
)
def test_a_misfit_goes_with_a_condition_where_its_levels_differ(
    monkeypatch, relative, whitened, some, says
):
    """Three points of each level, of which those of size and of noise are given."""
    monkeypatch.setattr(where, "_some", lambda *given: some)
    count = len(relative)
    level = np.repeat(np.arange(count), 3)
    data = Measurement(
        np.tile([1.0, 2.0, 3.0], count),
        np.full(3 * count, 1.0 + 1.0j),
        conditions={"temperature": np.linspace(20.0, 60.0, count)[level]},
    )
    part = SimpleNamespace(relative=np.array(relative)[level], whitened=np.array(whitened)[level])
    found = where._dependence(data, "temperature", part, np.arange(3 * count), level)
    assert found.replace("\N{DEGREE SIGN}C", "degC") == says


@pytest.mark.parametrize(
    ("off", "says"),
    [
        (0.13, "about 12 % of |G*| beyond the noise"),
        (0.05, "about 2.6 % of |G*| beyond the noise"),
        (0.04, "no more than the noise in size"),
    ],
)
def test_what_is_left_is_told_beyond_the_noise_that_no_parameter_followed(off, says):
    """Noise of 3 % and 4 %, of which 13 of 18 parts are left: 5 * sqrt(13 / 18) is 4.25 %."""
    model = np.full(9, 3.0 + 4.0j)
    data = Measurement(np.geomspace(1.0, 9.0, 9), model / (1.0 - off))
    size = 5.0 / (1.0 - off)
    frame = SimpleNamespace(
        measurement=data,
        model_stiffness=model,
        weights=np.full(9, 1.0 / (0.03 * size) + 1.0j / (0.04 * size)),
        absorbed=np.zeros((18, 5)),
        size=18,
    )
    assert residual_causes._size_in_words(frame, "") == f"what is left is {says}"
    assert residual_causes._size_in_words(frame, "here") == f"what is left is {says}: here"


def test_nothing_is_a_linear_material_too():
    """Friction may take all of the data, and leave spring and dashpot at nothing."""
    model = springpot.parse_model("kelvin")
    assert material.is_of_material(model, np.zeros(2), (1.0, 10.0), 0.1)
