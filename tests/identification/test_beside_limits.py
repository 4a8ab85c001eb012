"""Intervals of a fit that has ended where a parameter has no end: the others may be elsewhere."""

import numpy as np
import pytest

import springpot

MODEL = springpot.parse_model("zener")
TRUE = MODEL.theta(k1=200.0, k2=300.0, c=30.0)


@pytest.mark.soak_cases("0.005", "0.001")
@pytest.mark.parametrize("width", [0.005, 0.001])
def test_they_hold_the_truth_where_nearly_one_frequency_was_measured(width):
    """Kelvin's limit or Maxwell's fits as well there: its slopes alone miss in every third case."""
    held, cases = 0, 20
    for seed in range(cases):
        rng = np.random.default_rng(seed)
        omega = 2.0 * np.pi * (1.0 + width * np.linspace(-1.0, 1.0, 6))
        noise = 0.003 * (rng.normal(size=6) + 1j * rng.normal(size=6))
        data = springpot.Measurement(omega, MODEL.stiffness(TRUE, omega) * (1.0 + noise))
        fit = springpot.identify(data, MODEL)
        held += np.sum((fit.low <= TRUE) & (fit.high >= TRUE))
    assert held >= 0.9 * 3 * cases


def test_what_the_data_tell_keeps_its_interval():
    data = springpot.read("artificial-hidden")
    fit = springpot.identify(data, "zener")
    known = springpot.identification.Uncertainty.of(fit.fit)
    assert np.array_equal([fit.low, fit.high], known.interval())
