"""Fits of any linear passive material, alone and with effects around it."""

import numpy as np
import pytest

import springpot
from springpot.identification import fit, weighted

OMEGA = np.geomspace(0.15, 34.0, 51)


def ripple_on_a_kelvin_element(level=0.02):
    """No material ripples, so that whatever is added to one must leave the ripple, too."""
    rng = np.random.default_rng(4)
    k = (11000.0 + 2700.0j * OMEGA) * (1.0 + 0.06 * np.cos(9.0 * np.log(OMEGA)))
    noise = level * np.abs(k) * (rng.normal(size=51) + 1j * rng.normal(size=51)) / np.sqrt(2.0)
    return springpot.Measurement(OMEGA, k + noise, name="ripple")


@pytest.fixture(scope="module")
def ripple():
    return ripple_on_a_kelvin_element()


@pytest.fixture(scope="module")
def alone(ripple):
    return fit(springpot.parse_model("material"), ripple)


@pytest.mark.soak_cases("relaxation-mode", "retardation-mode")
@pytest.mark.parametrize(
    "effect",
    ["series-spring", "series-dashpot", "retardation-mode", "relaxation-mode", "parallel-spring"],
)
def test_an_element_beside_any_material_is_a_part_of_the_material(ripple, alone, effect):
    grown = fit(springpot.parse_model(f"material + {effect}"), ripple)
    assert grown.cost == pytest.approx(alone.cost, rel=1e-3)


@pytest.mark.parametrize(
    "effect", ["series-spring", "retardation-mode", "specimen-inertia", "inertia", "time-delay"]
)
def test_the_cost_is_that_of_the_fitted_curve(ripple, effect):
    """Where K is not linear in the spectrum, the objective of a linear step is not the real one."""
    grown = fit(springpot.parse_model(f"material + {effect}"), ripple)
    fitted = grown.model.stiffness(grown.theta, ripple.points)
    rest = weighted(ripple.stiffness - fitted, grown.objective.weights(ripple))
    assert grown.cost == pytest.approx(float(rest @ rest), rel=1e-6)
