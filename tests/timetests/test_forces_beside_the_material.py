"""Forces beside the material under an imposed force: they are told where the specimen was."""

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.measurement import TimeTest
from springpot.misfit.residuals_of_tests import InTimePart
from springpot.timetests import diagnose, identify, recorded
from springpot.timetests.exponentials import QuickPart

T = np.linspace(0.0, 3.0, 120)
GROWN = {
    "cubic-stiffness": ("zener + cubic-stiffness", [30.0, 60.0, 18.0, 25.0]),
    "elasto-sliding": ("zener + elasto-sliding", [30.0, 60.0, 18.0, 40.0, 6.0]),
}


def under_a_force(name, noise=0.002):
    """What moves a specimen like that, and the noise in where it went."""
    model, theta = springpot.parse_model(GROWN[name][0]), np.array(GROWN[name][1])
    moved = 0.7 * np.sin(2.0 * np.pi * T / 1.5) + 0.3 * np.sin(2.0 * np.pi * T / 0.73)
    force = recorded(model, theta, TimeTest.planned(T, moved, "mm")).value
    moved = moved + noise * np.random.default_rng(2).normal(size=len(T))
    return TimeTest.of_history(T, moved, force, "mm", "N", control="force"), model, theta


@pytest.mark.parametrize("name", GROWN)
def test_a_force_beside_the_material_is_followed_under_a_force(name):
    test, model, theta = under_a_force(name)
    fit = identify(test, model, seeds=[1.3 * theta], thorough=False)
    assert fit.tests[0].over_floor == pytest.approx(1.0, abs=0.1)
    assert fit.theta == pytest.approx(theta, rel=0.05)


@pytest.mark.soak
@pytest.mark.parametrize("name", GROWN)
def test_and_found_there(name):
    test, _, _ = under_a_force(name)
    names = ("cubic-stiffness", "elasto-sliding", "series-spring", "relaxation-mode")
    found = diagnose(test, "zener", [springpot.plugins().effect(each) for each in names])
    assert found.verdict == "effect-missing"
    assert found.leading[0] == name


def test_its_slopes_are_differences_also_as_the_search_sees_it():
    test, model, theta = under_a_force("cubic-stiffness", noise=0.0)
    exact = recorded(model, theta, test)
    for i, size in enumerate(1e-5 * theta):
        change = size * (np.arange(len(theta)) == i)
        up, down = (recorded(model, theta + sign * change, test).value for sign in (1.0, -1.0))
        slope = (up - down) / (2.0 * size)
        assert exact.by_theta[:, i] == pytest.approx(slope, abs=2e-3 * np.abs(slope).max())
    quick = QuickPart.of(InTimePart(test)).recorded(model, theta, 293.0)
    assert quick.value == pytest.approx(exact.value, abs=1e-3)


def test_of_what_was_only_planned_it_is_refused():
    plan = TimeTest.planned(T, np.sin(T), "N")
    with pytest.raises(ModelError, match="is not linear"):
        recorded(springpot.parse_model("zener + friction"), np.array([30.0, 60.0, 18.0, 1.0]), plan)
