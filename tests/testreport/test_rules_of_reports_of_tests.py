"""Numbers of a test report against their definitions: units, trends, areas and their errors."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import linregress, norm

from springpot.errors import DataError
from springpot.report import page
from springpot.testreport import certificate, code, deciding, quantities, record, summary
from springpot.testreport.record import Channel


@pytest.mark.parametrize(
    ("written", "wanted", "ratio"),
    [
        ("kN/mm", "N/m", 1e6),
        ("mm", "m", 1e-3),
        ("kN s/mm", "N*s/m", 1e6),
        ("kJ", "N m", 1e3),
        ("MPa mm*mm", "N", 1.0),
        ("kPa", "N/m/m", 1e3),
        ("mm/s", "m*Hz", 1e-3),
        ("Hz", "1/s", 1.0),
        ("%", "-", 0.01),
        ("N/m/s", "kN Hz/m", 1e-3),
    ],
)
def test_units_are_products_of_powers(written, wanted, ratio):
    assert code.ratio_of_units(written, wanted) == pytest.approx(ratio, rel=1e-12)
    assert code.ratio_of_units(wanted, written) == pytest.approx(1.0 / ratio, rel=1e-12)


@pytest.mark.parametrize(
    ("written", "wanted"),
    [
        ("N", "m"),
        ("N m", "N/m"),
        ("N s", "N"),
        ("N/s", "N s"),
        ("J", "N"),
        ("Pa", "N/m"),
        ("s", "Hz"),
        ("degC", "-"),
        ("m", "N/N"),
    ],
)
def test_units_of_different_things_have_no_ratio(written, wanted):
    for first, second in ((written, wanted), (wanted, written)):
        with pytest.raises(DataError, match="is no unit of what is in"):
            code.ratio_of_units(first, second)


def test_a_trend_and_its_error_are_those_of_a_straight_line():
    number, values = np.arange(3.0, 10.0), np.array([1.0, 3.0, 2.0, 5.0, 4.0, 8.0, 6.0])
    wanted = linregress(number, values)
    assert certificate._trend(number, values) == pytest.approx((wanted.slope, wanted.stderr))


@pytest.mark.parametrize(("noise", "digit"), [(0.05, 0.0), (0.0, 0.2)])
def test_noise_of_a_channel_is_its_scatter_or_its_digit(noise, digit):
    phase = np.linspace(0.0, 60.0, 4000)
    values = np.sin(phase) + noise * np.random.default_rng(1).normal(size=4000)
    if digit:
        values = digit * np.round(values / digit)
    assert record.noise_of(values) == pytest.approx(noise + digit / np.sqrt(12.0), rel=0.05)
    assert record.noise_of(np.full(50, 3.0)) == pytest.approx(12.0 * np.finfo(float).eps)


@pytest.mark.parametrize("noises", [(0.03, 0.005), (0.001, 0.03), (0.02, 0.03)])
def test_the_area_of_a_loop_is_as_sure_as_it_is_said_to_be(noises):
    """By a hundred draws of the noise of either channel, or of both."""
    time = np.linspace(-0.5, 1.5, 81)
    way, force = np.sin(2.0 * np.pi * time), 2.0 * np.cos(2.0 * np.pi * time + 0.3)
    rng, found = np.random.default_rng(5), []
    for _ in range(100):
        moved, pulled = (
            Channel(time, exact + noise * rng.normal(size=81), noise)
            for exact, noise in zip((way, force), noises, strict=True)
        )
        found.append(quantities._work(moved, pulled, 0.0, 1.0, loop=True))
    values, told = (np.array([getattr(each, name) for each in found]) for name in ("value", "sd"))
    # The area of an ellipse: pi times both half axes times the sine of the phase between them.
    assert np.mean(values) == pytest.approx(2.0 * np.pi * np.cos(0.3), rel=0.01)
    assert np.std(values) == pytest.approx(np.mean(told), rel=0.25)


def test_a_force_that_falls_as_a_power_of_the_time_is_followed_to_its_turning_point():
    away = np.linspace(-1.0, 1.0, 40)
    side, size = np.where(away < 0.0, 1.0, -1.0), np.abs(away)
    even = 3.0 + 0.4 * away**2 - 0.2 * away**4
    force = even + side * size**0.6 * (0.5 + 0.3 * away**2)
    assert record._power_of(away, force) == pytest.approx(0.6, abs=1e-4)
    *_, shape = record._shapes(away, 0.6)
    solution, *_ = np.linalg.lstsq(shape.columns, force, rcond=None)
    np.testing.assert_allclose(shape.columns @ solution, force, atol=1e-12)
    assert shape.at_turning @ solution == pytest.approx(3.0)
    # A jump is told by how the force was before it, whatever its slope and bend behind.
    force = even + side * (0.7 + 0.3 * size - 0.1 * size**3)
    shape = list(record._shapes(away, 0.6))[2]
    solution, *_ = np.linalg.lstsq(shape.columns, force, rcond=None)
    np.testing.assert_allclose(shape.columns @ solution, force, atol=1e-12)
    assert shape.at_turning @ solution == pytest.approx(3.7)


def test_samples_that_may_be_on_either_side_of_a_turning_point_are_left_out():
    time, alarm = np.linspace(-1.0, 1.0, 2001), record.SIGNALS.ruled_out
    turning = record.Turning(0.0, 0.05, record.Estimate(1.0, 0.0))
    around = record._around(Channel(time, time, 0.1), turning, 0.5)
    # That often a turning point is further off than this, on one side or the other.
    assert np.abs(around.values).min() == pytest.approx(0.05 * norm.isf(alarm / 2.0), abs=1e-3)
    assert around.moment_sd == pytest.approx(0.1)


def test_sheets_of_one_name_are_counted_from_two():
    taken = set()
    assert [page._title("loops", taken) for _ in range(3)] == ["loops", "loops 2", "loops 3"]


@pytest.mark.parametrize(("still", "told"), [(120, 0), (160, 161)])
def test_a_channel_is_clipped_where_it_stands_longer_than_its_last_digit_makes_it(still, told):
    time = np.arange(3001) / 1000.0
    limit = np.cos(np.pi * still / 1000.0)
    values = np.round(100.0 * np.clip(np.sin(2.0 * np.pi * time), -limit, limit)) / 100.0
    bounds = [SimpleNamespace(value=float(each)) for each in range(4)]
    found = SimpleNamespace(bounds=bounds, period=1.0)
    assert summary._cut(values, SimpleNamespace(time=time), found) == pytest.approx(told, abs=8)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (8.9, deciding.FAILING),
        (9.0, deciding.UNDECIDED),
        (10.9, deciding.UNDECIDED),
        (11.0, deciding.CONFORMING),
        (19.0, deciding.CONFORMING),
        (19.1, deciding.UNDECIDED),
        (21.0, deciding.UNDECIDED),
        (21.1, deciding.FAILING),
    ],
)
def test_a_result_is_decided_where_it_is_further_from_a_limit_than_it_is_unsure(value, told):
    budget = SimpleNamespace(value=value, expanded=1.0)
    assert deciding.decided(budget, 10.0, 20.0, "expanded") == told
    within = 10.0 <= value <= 20.0
    plain = deciding.CONFORMING if within else deciding.FAILING
    assert deciding.decided(budget, 10.0, 20.0, "none") == plain


@pytest.mark.parametrize("among", [True, False])
def test_a_ratio_to_a_mean_goes_with_each_test_as_its_slope_says(among, monkeypatch):
    tests = [SimpleNamespace(means={"k": SimpleNamespace(value=each)}) for each in (2.0, 5.0, 6.0)]
    one, reference = tests[0], tests if among else tests[1:]
    asked = []
    monkeypatch.setattr(deciding, "combined", lambda *given: asked.append(given))

    def ratio():
        values = [each.means["k"].value for each in reference]
        return one.means["k"].value / np.mean(values)

    base = float(np.mean([each.means["k"].value for each in reference]))
    deciding._ratio(SimpleNamespace(errors=()), "k", one, reference, base)
    [(value, meant, _, slopes, _)] = asked
    assert value == pytest.approx(ratio())
    for test, slope in zip(meant, slopes, strict=True):
        before = ratio()
        test.means["k"].value += 1e-6
        assert (ratio() - before) / 1e-6 == pytest.approx(slope, rel=1e-4)
        test.means["k"].value -= 1e-6
