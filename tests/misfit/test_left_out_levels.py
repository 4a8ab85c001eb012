"""What is left out to be predicted.

Inner levels of what was set, and nothing of what merely drifted.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from springpot import Measurement
from springpot.misfit import refit
from springpot.misfit.frame import folds_of


def measured(**conditions):
    omega = np.tile(np.geomspace(1.0, 100.0, 8), 5)
    return Measurement(omega, 10.0 + 1j * omega, conditions=conditions)


def test_inner_levels_are_left_out_one_at_a_time_and_the_outer_ones_never():
    level = np.repeat(np.arange(5.0), 8)
    for name, values in (("temperature", 10.0 * level), ("amplitude", 1e-3 * (1.0 + level))):
        folds = folds_of(measured(**{name: values}), name)
        assert [np.flatnonzero(fold).tolist() for fold in folds] == [
            list(range(8 * number, 8 * number + 8)) for number in (1, 2, 3)
        ]


def test_a_temperature_that_drifts_about_one_that_was_set_is_not_left_out():
    drift = 20.0 + np.repeat([0.0, 0.11, 0.22, 0.33, 0.44], 8)
    assert folds_of(measured(temperature=drift), "temperature") == []
    assert folds_of(measured(), "temperature") == []


@pytest.mark.parametrize(
    ("left", "says"),
    [(1.5, "predicts it better: 1.5 x the noise instead of 2 x"), (1.97, "does not predict it")],
)
def test_what_predicts_a_level_that_it_has_not_seen_does_so_clearly(monkeypatch, left, says):
    errors = {"base": 2.0, "grown": left}
    monkeypatch.setattr(refit, "left_out_error", lambda fitted, folds: errors[fitted.model])
    data = SimpleNamespace(measurement=measured(temperature=10.0 * np.repeat(np.arange(5.0), 8)))
    base, grown = (SimpleNamespace(model=name, fit=data) for name in errors)
    [told] = refit.validation(base, grown)
    assert says in told
