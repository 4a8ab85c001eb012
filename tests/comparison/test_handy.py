"""The model to write down, where the best one has more parameters than are worth it."""

import numpy as np
import pytest

import springpot
from springpot.report.told import told

OMEGA = np.geomspace(0.1, 100.0, 80)


def sweep(extra):
    """A standard solid with a second relaxation of this share, and 0.5 % of noise."""
    modes = 100.0 + 300j * OMEGA / (1j * OMEGA + 3.0) + extra * 400j * OMEGA / (1j * OMEGA + 30.0)
    noise = np.random.default_rng(0).normal(size=(2, 80)) * 0.005
    return springpot.Measurement(OMEGA, modes * (1.0 + noise[0] + 1j * noise[1]))


@pytest.fixture(scope="module")
def nearly():
    return springpot.compare(sweep(0.02), ["material", "zener", "prony-2"])


@pytest.mark.soak
def test_the_fewest_parameters_within_half_more_of_the_nearest_error(nearly):
    assert nearly.best.model.name != "zener"
    assert nearly.handy.model.name == "zener"
    assert nearly.to_dict()["handy"] == "zener"
    assert "the simplest that is nearly as near as any that can be written down is zener:" in told(
        nearly
    )


def test_a_kept_comparison_names_it_too(nearly):
    kept = type(nearly).from_dict(nearly.to_dict())
    assert kept.handy.model.name == "zener"


@pytest.mark.soak
@pytest.mark.parametrize("extra", [0.0, 0.5])
def test_none_is_named_where_the_best_is_it_or_simpler_ones_are_far_off(extra):
    compared = springpot.compare(sweep(extra), ["zener", "prony-2"])
    assert compared.handy is None
    assert compared.to_dict()["handy"] is None
    assert "the simplest that is nearly" not in told(compared)
