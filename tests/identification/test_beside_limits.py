"""Intervals of a fit that has ended where a parameter has no end: the others may be elsewhere."""

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.timetests.exponentials import QuickPart

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


def half_a_swing(seed):
    """A spring of 200 N/m beside a dashpot of 30 N s/m, carried along half a sine from rest."""
    rng, t = np.random.default_rng(seed), 0.02 * np.arange(101)
    x = 0.03 * np.sin(0.5 * np.pi * t)
    force = 200.0 * x + 30.0 * 0.015 * np.pi * np.cos(0.5 * np.pi * t)
    return springpot.TimeTest.of_history(t, x, force + 0.02 * rng.normal(size=101), "m", "N")


def test_in_time_a_limit_that_fits_as_well_lies_within():
    """A spring in series that does not give; by slopes it was within [3500, 14000] N/m."""
    fit = springpot.identify(half_a_swing(2), "zener")
    told = dict(zip(fit.model.names, zip(fit.low, fit.high, strict=True), strict=True))
    assert 199.0 < told["k1"][0] < 200.0 < told["k1"][1] < 200.5
    assert 29.5 < told["c"][0] < 30.0 < told["c"][1] < 30.5
    assert 2000.0 < told["k2"][0] < 1e-3 * told["k2"][1]


def test_in_time_what_the_tests_tell_keeps_its_interval():
    """That of its slopes: by the same factor either way."""
    fit = springpot.identify(half_a_swing(1), "kelvin")
    assert fit.low * fit.high == pytest.approx(fit.theta**2, rel=1e-9)


def test_in_time_where_many_cannot_be_answered_at_once_each_is_asked(monkeypatch):
    def refused(*_):
        raise ModelError("one of them is out of reach")
        yield

    fit = springpot.identify(half_a_swing(1), "kelvin")
    monkeypatch.setattr(QuickPart, "nearly", refused)
    again = springpot.identify(half_a_swing(1), "kelvin")
    assert np.array_equal([fit.low, fit.high], [again.low, again.high])
