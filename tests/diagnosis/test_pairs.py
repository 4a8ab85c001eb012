"""Pairs of effects are refitted once, however many ways lead to them."""

import numpy as np
import pytest
from hidden_data import KELVIN, SWEEP, exact, measured

import springpot
from springpot.diagnosis import examine
from springpot.diagnosis.search import scan_effects
from springpot.misfit.refit import refit
from springpot.registry import plugins
from springpot.thresholds import SEARCH

OMEGA = SWEEP.omega


@pytest.fixture(scope="module")
def search():
    """A mass and a delay that no single effect explains."""
    data = measured(SWEEP, (exact(KELVIN, SWEEP) - 2e-4 * OMEGA**2) * np.exp(-5e-4j * OMEGA))
    library = list(plugins().items("effect"))
    return examine(
        data, springpot.parse_model(KELVIN.name), library, np.random.default_rng(0)
    ).search


@pytest.mark.soak
def test_each_pair_is_fitted_once(search):
    pairs = [tuple(sorted(grown.names)) for grown in search.grown if len(grown.effects) == 2]
    assert len(pairs) > SEARCH.seconds
    assert len(pairs) == len(set(pairs))


@pytest.mark.soak
def test_a_pair_fits_as_well_as_from_the_starts_of_either_way(search):
    alone = {grown.names[0]: grown.refit for grown in search.grown if len(grown.effects) == 1}
    best = next(grown for grown in search.grown if len(grown.effects) == 2)
    for first, second in (best.effects, best.effects[::-1]):
        before = alone[first.name]
        (score,) = scan_effects(before, before.frame(), [second]).scores
        again = refit(
            score.influence.model, before.data, before.noise, list(score.starts), starts=0
        )
        assert best.refit.rss <= again.rss + 0.01
