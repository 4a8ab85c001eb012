"""Where a misfit lies, how it grows and what of it a material has: each rule at its edge."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement
from springpot.misfit import drift_search, material, refit, residual_causes, where
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


@pytest.mark.parametrize("common", [material.FEWEST_COMMON - 1, material.FEWEST_COMMON])
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
    if common < material.FEWEST_COMMON:
        assert says == "the amplitude matters"
        return
    assert "|G*| rises by 200 %" in says
    assert "the loss factor goes from 0.50 to 2.0" in says


def test_what_is_called_by_a_vowel_has_its_article():
    assert refit.one_of("amplitude") == "an amplitude"
    assert refit.one_of("temperature") == "a temperature"
    assert refit.one_of("year") == "a year"


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
    part = SimpleNamespace(word="storage", relative=np.full(5, size), residual=np.full(5, size))
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
