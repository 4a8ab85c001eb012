"""Master curves of a few short series, with all that is judged and said of them."""

from dataclasses import replace

import numpy as np
import pytest
from sweeps import mass, measured, phase_error, simple, two_branches

import springpot
from springpot.measurement import Measurement


def repeated():
    """The hottest sweep stands twice, with another gain."""
    data = measured(simple)
    hot = data.conditions["temperature"] == 60.0
    celsius = data.conditions["temperature"]
    return Measurement(
        np.concatenate([data.omega, data.omega[hot]]),
        np.concatenate([data.stiffness, 1.05 * data.stiffness[hot]]),
        conditions={"temperature": np.concatenate([celsius, celsius[hot]])},
        name="twice",
    )


def given(factor):
    data = measured(simple)
    sd = factor * np.abs(data.stiffness) * (1 + 1j)
    return Measurement(data.omega, data.stiffness, sd=sd, conditions=data.conditions, name="given")


def flat(i, omega):
    """Two glassy levels on which a shift changes nothing."""
    if i < 2:
        return np.full(len(omega), 35.0 + 0.5j)
    return simple(i, omega)


def glassy(i, omega):
    """Nearly all storage, whose loss the line may miss."""
    return 1000.0 + (1.0 + 0.3j * (i == 2)) * simple(i, omega) * 0.01


def by_pressure(sweep, **given):
    """No column of temperatures: nothing is said of laws, which cost most of the time."""
    if not isinstance(sweep, Measurement):
        sweep = measured(sweep, **({"points": 9} | given))
    conditions = {"pressure": next(iter(sweep.conditions.values()))}
    return replace(sweep, conditions=conditions)


CASES = {
    "simple": (by_pressure(simple), {}),
    "branches": (by_pressure(two_branches), {"reference": 15.0}),
    "phase": (by_pressure(phase_error), {"vertical": False}),
    "mass": (by_pressure(mass, noise=0.01), {}),
    "twice": (by_pressure(repeated()), {}),
    "narrow": (by_pressure(simple, points=6, decades=0.3), {}),
    "few": (by_pressure(simple, points=3), {}),
    "flat": (by_pressure(flat), {"reference": 50.0}),
    "glassy": (by_pressure(glassy), {}),
    "given": (by_pressure(given(0.005)), {}),
    "shared": (by_pressure(given(0.05)), {}),
}


@pytest.mark.soak_cases(
    "simple", "twice", "few", "flat", "shared", "branches", "mass", "narrow", "glassy"
)
@pytest.mark.parametrize("case", list(CASES))
def test_master_curve(case, stays):
    data, options = CASES[case]
    found = springpot.mastercurve(data, column=next(iter(data.conditions)), **options)
    answer = found.to_dict()
    del answer["seconds"], answer["curve"]
    omega = np.geomspace(0.1, 10.0, 5)
    conditions = dict(found.reduced.conditions)
    if case == "glassy":
        # A bound nobody has found: where the search for one gave up.
        del conditions["a_high"]
    stays(
        {
            **answer,
            "sentence": repr(found),
            "curve": found.curve(omega),
            "drawn": found.drawn(omega, found.curve(omega)),
            "of each level": [found.simplicity.level_error, found.simplicity.level_alone],
            "law factors": [law.log_factors for law in found.laws],
            "reduced": [found.reduced.omega, found.reduced.stiffness, conditions],
            "covariance": found.factors.covariance,
        },
        within=1e-3,
    )
