"""Forces beside the material under an imposed force: they are told where the specimen was."""

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.measurement import TimeTest
from springpot.measurement.timenoise import without_scatter
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


def crept(seed, noise=0.004):
    """A creep of a standard solid with noise, held from its first sample on."""
    t = np.geomspace(0.01, 100.0, 150)
    slow = 1.0 / 2000.0 - (1.0 / 2000.0 - 1.0 / 2800.0) * np.exp(-t / 0.84)
    strain = 50.0 * slow * (1.0 + noise * np.random.default_rng(seed).normal(size=len(t)))
    return TimeTest.of_history(t, strain, np.full(len(t), 50.0), "-", "Pa", control="force")


@pytest.mark.parametrize("seed", [1, 2])
def test_a_force_that_feels_the_place_takes_up_none_of_its_noise(seed):
    """A softening spring whose force turned at the held level answered the noise with itself.

    The error fell to a third of the noise, and `cubic-stiffness` was missing.
    """
    test = crept(seed)
    soft = springpot.plugins().effect("cubic-stiffness")
    found = diagnose(test, "zener", [soft])
    assert found.verdict == "adequate"
    assert found.error.noise_floor == pytest.approx(0.004, rel=0.2)


def test_and_is_known_no_better_than_the_noise_allows():
    off, model = [], springpot.parse_model("zener + cubic-stiffness")
    for seed in range(6):
        fit = identify(crept(seed), model, thorough=False)
        size = fit.parameters["cubic-stiffness.k3"]
        off.append(size.value / (size.high - size.low) * 2.0 * 1.96)
    assert np.sqrt(np.mean(np.square(off))) < 1.8


def test_where_the_specimen_was_is_told_without_the_sample_itself():
    test = crept(3)
    was, exact = without_scatter(test), without_scatter(crept(3, noise=0.0))
    held = test.time > 10.0
    noise, left = (each[held] / 0.025 - 1.0 for each in (test.response, was))
    assert np.std(left) < 0.7 * np.std(noise)
    assert exact == pytest.approx(crept(3, noise=0.0).response, rel=1e-6)


def test_of_what_was_only_planned_it_is_refused():
    plan = TimeTest.planned(T, np.sin(T), "N")
    with pytest.raises(ModelError, match="is not linear"):
        recorded(springpot.parse_model("zener + friction"), np.array([30.0, 60.0, 18.0, 1.0]), plan)
