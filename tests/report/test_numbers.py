"""Numbers are printed with the digits that are known."""

from math import inf, nan

import pytest
from hypothesis import given, strategies as st

from springpot.report.text import percent, seconds, with_interval
from springpot.writing import number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.0, "1.000"),
        (123456.0, "123500"),
        (1e6, "1.000e+06"),
        (0.001234, "0.001234"),
        (0.0001234, "1.234e-04"),
        (9.99996, "10.00"),
        (-9.99996, "-10.00"),
        (None, "-"),
        (nan, "-"),
        (inf, "inf"),
        (-inf, "-inf"),
    ],
)
def test_number(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "low", "high", "texts"),
    [
        (400.13, 399.2, 401.03, ("400.1", "[399.2, 401.0]")),
        (1.0, 0.98, 1.02, ("1.000", "[0.980, 1.020]")),
        (0.5, 0.0, 1.0, ("0.5", "[0, 1.0]")),
        (2.1e-7, 2e-7, 2.2e-7, ("2.10e-07", "[2.00e-07, 2.20e-07]")),
        (5.0, -1000.0, 1000.0, ("5.0", "[-1000, 1000]")),
        (3.0, 3.0, 3.0, ("3.000", "[3.000, 3.000]")),
        (3.0, None, None, ("3.000", "")),
        (3.0, nan, nan, ("3.000", "")),
        (0.01, 0.0, inf, ("0.01000", "[0, inf]")),
        (2.3e-309, -1e-12, 1e-12, ("0", "[-1.0e-12, 1.0e-12]")),
        (6.1e-11, 0.0, 1.2e-10, ("6e-11", "[0, 1.2e-10]")),
        (4.8e-27, 0.0, 7.1e-27, ("5e-27", "[0, 7e-27]")),
        (4e-7, 5.3e-8, 2.9e-6, ("4.0e-07", "[5.3e-08, 2.9e-06]")),
        (0.12, -0.001, 0.24, ("0.12", "[0.00, 0.24]")),
        (999999.6, 999989.6, 1000009.6, ("1.000000e+06", "[9.999900e+05, 1.000010e+06]")),
        (20.0, 3.1, 120.0, ("20", "[3.1, 120]")),
        (-3e-7, -3.26e-6, 2e-8, ("-3e-07", "[-3.3e-06, 0]")),
        (400.0, 400.0 - 1e-12, 400.0 + 1e-12, ("400.00000", "[400.00000, 400.00000]")),
    ],
)
def test_with_interval(value, low, high, texts):
    assert with_interval(value, low, high) == texts


@given(st.floats(-1e12, 1e12), st.floats(1e-12, 1e12), st.floats(1e-12, 1e12))
def test_what_is_printed_is_near_what_was_meant(value, below, above):
    text, interval = with_interval(value, value - below, value + above)
    width = 0.5 * (below + above)
    # One digit of the width is kept in the worst case, two of a value that its interval swamps.
    slack = 0.15 * width + 0.06 * abs(value)
    assert abs(float(text) - value) <= slack
    low, high = map(float, interval[1:-1].split(","))
    assert abs(low - (value - below)) <= slack + 0.06 * below
    assert abs(high - (value + above)) <= slack + 0.06 * above


def test_percent_and_seconds():
    assert percent(0.0031) == "0.310 %"
    assert percent(nan) == "-"
    assert [seconds(s) for s in (3e-4, 0.012, 3.0, 1000.0)] == [
        "300 us",
        "12.0 ms",
        "3.00 s",
        "16.7 min",
    ]
