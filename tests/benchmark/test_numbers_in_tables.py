"""A number in a table: four digits for people, every digit for programs."""

import numpy as np
import pytest

from springpot.benchmark.commands.tables import _rounded
from springpot.benchmark.standings import _or_none
from springpot.benchmark.statistics import Interval
from springpot.report.page import _field, _fields, number, text


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (3, "3"),
        (1234567, "1234567"),
        (0.001, "0.001"),
        (0.00099999, "1.000e-03"),
        (-0.5, "-0.5"),
        (0.123456, "0.1235"),
        (12345.6, "12346"),
        (999999.0, "999999"),
        (1e6, "1.000e+06"),
        (np.nan, "–"),
        (np.inf, "∞"),
        (-np.inf, "-∞"),
    ],
)
def test_for_people(value, shown):
    assert number(value) == shown
    assert text(value) == shown


def test_entries():
    assert text(None) == "–"
    assert text("a word") == "a word"
    assert text(Interval(1.0, 0.5, 2.0)) == "1 [0.5, 2]"
    assert _field(None) == ""
    assert _field(np.float64(0.1)) == "0.1"
    assert _field(7) == "7"
    assert _fields(Interval(1.0, 0.5, 2.0), True) == ("1.0", "0.5", "2.0")
    assert _fields(1.0, True) == ("1.0", "", "")
    assert _fields(1.0, False) == ("1.0",)


def test_rounded_but_for_counts_and_words():
    assert _rounded(0.12345, 2) == 0.12
    assert _rounded(0.12345, None) == 0.12345
    assert _rounded(12345, 2) == 12345
    assert _rounded("0.12345", 2) == "0.12345"
    assert _rounded(None, 2) is None
    assert _rounded(Interval(0.126, 0.111, 1.29), 2) == Interval(0.13, 0.11, 1.3)


def test_no_test_has_no_number():
    assert _or_none(float("nan")) is None
    assert _or_none(0.0) == 0.0
