"""Without a model `compare` calls adequate what `diagnose` calls so.

An error of noise, in size and in pattern.
"""

import numpy as np
import pytest

import springpot


def sweep(rng, count, ripple=0.0):
    """A fractional Zener element, 0.05 % noise; its gain may go up and down along the sweep."""
    omega = 2.0 * np.pi * np.geomspace(0.1, 50.0, count)
    power = (1j * omega * 0.03) ** 0.62
    gain = 1.0 + ripple * np.sin(12.0 * np.linspace(0.0, 1.0, count))
    real, imaginary = 5e-4 * rng.normal(size=(2, count))
    stiffness = gain * (120.0 + 440.0 * power / (1.0 + power)) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(omega, stiffness, units=springpot.Units("kN/m", "mm"))


@pytest.fixture(scope="module")
def whole():
    data = sweep(np.random.default_rng(3), 11)
    return data, springpot.compare(data)


@pytest.mark.soak
def test_the_simplest_adequate_model_is_adequate_to_diagnose_too(whole):
    data, ranking = whole
    assert ranking.adequate
    assert springpot.diagnose(data, ranking.best.model).verdict == "adequate"


@pytest.mark.soak
def test_none_whose_residual_has_a_pattern_is_adequate(whole):
    _, ranking = whole
    for one in ranking.adequate:
        assert one.at_noise
        assert not one.fails


@pytest.mark.soak
def test_nor_where_a_ripple_is_within_the_noise_by_size():
    """The errors of these fits are no larger than noise, but their residuals go up and down."""
    ranking = springpot.compare(sweep(np.random.default_rng(1), 12, ripple=0.0015))
    assert not [one.model.name for one in ranking.adequate if one.fails]


def test_an_error_of_its_size_that_goes_up_and_down_is_no_noise():
    """As above, of one model."""
    data = sweep(np.random.default_rng(1), 12, ripple=0.0015)
    [judged] = springpot.compare(data, ["fractional-zener"]).judgements
    assert judged.at_noise
    assert judged.fails
    assert not judged.adequate
