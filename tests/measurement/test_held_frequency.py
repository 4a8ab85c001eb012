"""A frequency that was held and is told as it was measured, a part in ten thousand to and fro."""

import numpy as np
import pytest

import springpot
from springpot.errors import DataError
from springpot.measurement import sweeps_of
from springpot.measurement.mixed_up import runs_of

CELSIUS = np.linspace(20.0, 60.0, 41)


def ramp(hertz, wander):
    """Temperature ramps at some held frequencies, that of each row off by a given small share."""
    rng = np.random.default_rng(5)
    omega, warm = (
        each.ravel() for each in np.meshgrid(2.0 * np.pi * np.array(hertz), CELSIUS, indexing="ij")
    )
    stiffness = 1e4 * np.exp(-(warm - 20.0) / 20.0) * (1j * omega) ** 0.2
    stiffness = stiffness * (1.0 + 0.01 * rng.standard_normal(len(warm)))
    measured = omega * (1.0 + wander * rng.standard_normal(len(warm)))
    return springpot.Measurement(
        measured, stiffness, conditions={"temperature": warm}, units=springpot.Units("Pa", "-")
    )


@pytest.mark.parametrize("hertz", [[1.0], [1.0, 10.0]])
def test_the_points_of_a_ramp_follow_one_another_by_temperature(hertz):
    exact, wandering = (sweeps_of(ramp(hertz, wander)) for wander in (0.0, 1e-4))
    assert [sweep.rows.tolist() for sweep in wandering] == [sweep.rows.tolist() for sweep in exact]


@pytest.mark.parametrize("wander", [0.0, 1e-4])
def test_a_ramp_at_one_frequency_has_no_master_curve(wander):
    with pytest.raises(DataError, match="all points have one frequency"):
        springpot.mastercurve(ramp([1.0], wander))


def test_a_ramp_stays_one_run_wherever_its_frequency_lies():
    """Also where rounding would split a frequency measured now a bit lower, now a bit higher."""
    omega = np.exp(0.0005 + 1e-4 * np.tile([-1.0, 1.0], 8))
    warm = np.repeat(np.arange(20.0, 60.0, 5.0), 2)
    data = springpot.Measurement(omega, np.ones(16) + 1j, conditions={"temperature": warm})
    assert [len(run.rows) for run in runs_of(data)] == [16]
