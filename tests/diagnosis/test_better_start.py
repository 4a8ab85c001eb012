"""A base model that was left in a local minimum is told from one that lacks an effect."""

from dataclasses import replace

import numpy as np
from hidden_data import KELVIN, SWEEP, exact, hidden, measured

import springpot
from springpot.diagnosis import examine
from springpot.diagnosis.examination import better_start
from springpot.diagnosis.scan import Scan
from springpot.misfit.refit import Refit
from springpot.registry import plugins


def searched(data):
    library = list(plugins().items("effect"))
    return examine(
        data, springpot.parse_model(KELVIN.name), library, np.random.default_rng(0)
    ).search


def stuck(found, theta):
    """The same search as if the base model had ended elsewhere, flagged by the scan."""
    base = found.base
    off = base.model.stiffness(theta, base.fit.measurement.points) - base.fit.measurement.stiffness
    sd = base.noise.sd
    cost = float(np.sum((off.real / sd.real) ** 2 + (off.imag / sd.imag) ** 2))
    wrong = Refit(replace(base.fit, theta=theta, cost=cost), base.noise, base.data)
    return replace(found, base=wrong, scan=Scan(found.scan.scores, 1e-4, found.scan.threshold))


def test_a_local_minimum_is_left_with_the_help_of_the_grown_models():
    found = searched(measured(SWEEP, exact(KELVIN, SWEEP)))
    start = better_start(stuck(found, np.array([80.0, 60.0, 0.3])))
    np.testing.assert_allclose(start, found.base.theta, rtol=1e-3)


def test_a_missing_effect_is_no_local_minimum():
    found = searched(hidden(KELVIN, SWEEP, "inertia", 300.0))
    assert found.scan.p_value < 0.01
    assert better_start(found) is None


def test_nothing_is_tried_where_nothing_is_suspicious():
    found = searched(measured(SWEEP, exact(KELVIN, SWEEP)))
    assert min(found.scan.p_value, found.structure.p_value) > 0.01
    assert better_start(found) is None
