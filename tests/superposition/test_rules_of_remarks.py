"""What is said of vertical factors, and which constant of a law is its pole."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.rheology.parameters import Dimension, Parameter
from springpot.superposition import curve, laws
from springpot.thresholds import SUPERPOSITION

RANGE = SUPERPOSITION.vertical_range


@pytest.mark.parametrize(
    ("column", "span", "told"),
    [
        ("temperature", 1.001 * RANGE, True),
        ("temperature", 0.999 * RANGE, False),
        ("water", 9.0 * RANGE, False),
    ],
)
def test_vertical_factors_are_told_that_range_beyond_density(column, span, told):
    """The last is not told, and does not count."""
    log_b = np.array([0.0, -0.5 * np.log(span), 0.5 * np.log(span), 99.0])
    factors = SimpleNamespace(column=column, log_b=log_b)
    found = curve.vertical_range(factors, np.array([True, True, True, False]))
    assert bool(found) is told
    if told:
        assert found[0].startswith(f"the vertical factors range over a factor of {span:.2g}, more")


@pytest.mark.parametrize(
    ("unit", "scale", "pole"),
    [("K", "linear", True), ("K", "log", False), ("kJ/mol", "linear", False)],
)
def test_a_pole_is_a_temperature_that_may_be_of_either_sign(unit, scale, pole):
    assert laws._is_pole(Parameter("T", "T", Dimension(label=unit), 0.0, 9.0, scale)) is pole
