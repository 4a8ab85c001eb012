"""Whether an error lies beyond a noise floor or below it, by more than chance takes it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.measurement.scatter import Noise
from springpot.misfit.floor import below_floor, beyond_floor
from springpot.misfit.refit import Refit
from springpot.thresholds import VERDICT

POINTS = 200


def fit_of(ratio, sd, source="estimated", doubt="", known=False):
    """A fit whose error is so many times its floor, under noise of these deviations of K = 1."""
    noise = Noise(np.asarray(sd * (1.0 + 1.0j)), np.inf if known else 2.0 * POINTS, source, doubt)
    data = SimpleNamespace(mean=SimpleNamespace(magnitude=np.ones(POINTS)))
    found = Refit(SimpleNamespace(dof=2 * POINTS - 4), noise, data)
    return SimpleNamespace(
        noise=noise, relative_rms=0.02 * ratio, floor=0.02, error_dof=found.error_dof
    )


EVEN = np.full(POINTS, 0.01)
ONE_END = np.where(np.arange(POINTS) < 4, 1.0, 0.01)
"""Four points hold nearly all of the noise, as where the force is smallest."""


@pytest.mark.parametrize(
    ("found", "below_if_certain"),
    [
        (fit_of(0.8, EVEN), True),
        (fit_of(0.8, ONE_END), False),
        (fit_of(1.01 * VERDICT.below, EVEN), False),
        (fit_of(0.8, EVEN, "given"), False),
        (fit_of(0.8, EVEN, doubt="the given ones were smaller"), False),
    ],
)
def test_an_error_is_below_a_noise_that_the_data_tell(found, below_if_certain):
    assert below_floor(found, True) is below_if_certain


@pytest.mark.parametrize("sd", [EVEN, ONE_END])
def test_below_the_noise_an_alarm_must_be_beyond_doubt(sd):
    assert below_floor(fit_of(0.8, sd), False)
    assert not below_floor(fit_of(1.01 * VERDICT.below, sd), False)


def test_a_floor_of_few_noisy_points_is_as_uncertain_as_they_are():
    assert beyond_floor(fit_of(1.4, EVEN))
    assert not beyond_floor(fit_of(1.4, ONE_END))
    assert beyond_floor(fit_of(1.4, EVEN, "given", known=True))
