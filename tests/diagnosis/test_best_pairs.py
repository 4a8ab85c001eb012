"""The pair that is tried first is the one whose directions together take most of the misfit."""

import numpy as np
import pytest
from hidden_data import KELVIN, SWEEP, exact, measured

from springpot.diagnosis.scan import _joint_gain, _representatives, best_pairs, scan_effects
from springpot.misfit.floor import fitted_to_floor
from springpot.registry import parse_model, plugins

OMEGA = SWEEP.omega


@pytest.fixture(scope="module")
def scanned():
    """A mass and a delay, as three effects are scanned for them."""
    data = measured(SWEEP, (exact(KELVIN, SWEEP) - 2e-4 * OMEGA**2) * np.exp(-5e-4j * OMEGA))
    base = fitted_to_floor(parse_model(KELVIN.name), data)
    effects = [plugins().effect(name) for name in ("inertia", "time-delay", "mounting-compliance")]
    return base, scan_effects(base, base.frame(), effects).scores


def test_each_two_effects_by_their_best_two_directions(scanned):
    base, scores = scanned
    frame = base.frame()
    pairs = best_pairs(frame, scores, base.model, base.theta, 10)
    wanted = {}
    for a, first in enumerate(scores):
        for second in scores[a + 1 :]:
            one, two = _representatives(frame, first), _representatives(frame, second)
            unit = np.hstack([first.directions.unit[:, one], second.directions.unit[:, two]])
            gain, size = _joint_gain(unit, frame.rest)
            between = gain[: len(one), len(one) :]
            i, j = np.unravel_index(int(np.argmax(between)), between.shape)
            if between[i, j] > 0.0:
                sizes = size[i, len(one) + j], size[len(one) + j, i]
                wanted[first, second] = between[i, j], (one[i], two[j]), sizes
    assert len(pairs) == len(wanted) > 0
    assert [pair.gain for pair in pairs] == sorted((pair.gain for pair in pairs), reverse=True)
    for pair in pairs:
        gain, rows, sizes = wanted[pair.first, pair.second]
        assert pair.gain == pytest.approx(gain)
        values = dict(zip(pair.model.names, pair.start, strict=True))
        for score, row, size in zip((pair.first, pair.second), rows, sizes, strict=True):
            step = size / score.directions.length[row]
            own = score.influence.sized(int(score.directions.setting[row]), float(step))
            assert {name: values[name] for name in own} == pytest.approx(own)


def test_no_more_than_are_asked_for(scanned):
    base, scores = scanned
    assert len(best_pairs(base.frame(), scores, base.model, base.theta, 1)) == 1
    assert best_pairs(base.frame(), [], base.model, base.theta, 1) == []
