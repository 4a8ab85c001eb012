"""A spring that yields by flowing: its first harmonic, its course in time, its two limits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from springpot.errors import ModelError
from springpot.registry import parse_model
from springpot.rheology import Points, hysteresis, yielding_spring
from springpot.structure import Damper

K, F, A = 5.0, 1.0, 0.3


def course(t, x, *theta):
    return yielding_spring().in_time(t, x, np.gradient(x, t), *theta)


def test_its_course_solves_the_equation_of_a_spring_before_a_power_law_damper():
    t = np.linspace(0.0, 2.0, 801)
    x = 3.0 * np.sin(2.0 * np.pi * t)

    def rate(now, z):
        speed = 6.0 * np.pi * np.cos(2.0 * np.pi * now)
        return K * (speed - np.sign(z) * np.abs(z / F) ** (1.0 / A))

    exact = solve_ivp(rate, (0.0, 2.0), [0.0], "LSODA", t, rtol=1e-9, atol=1e-10).y[0]
    np.testing.assert_allclose(course(t, x, K, F, A)[0], exact, atol=1e-3 * np.abs(exact).max())


@pytest.mark.parametrize(("k", "force", "a"), [(5.0, 1.0, 0.3), (1e4, 30.0, 0.05), (0.1, 2.0, 1.0)])
def test_its_derivatives_are_those_of_differences(k, force, a):
    t = np.linspace(0.0, 1.5, 151)
    x, theta = np.sin(7.0 * t), np.array([k, force, a])
    slopes = course(t, x, *theta)[1]
    for j, slope in enumerate(slopes):
        step = 1e-5 * theta[j] * np.eye(3)[j]
        up, down = (course(t, x, *(theta + sign * step))[0] for sign in (1.0, -1.0))
        by_difference = (up - down) / (2e-5 * theta[j])
        np.testing.assert_allclose(slope, by_difference, atol=1e-5 * np.abs(slope).max() + 1e-9)


@pytest.mark.parametrize("free", [1e-9, 0.5, 40.0, -3e5])
@pytest.mark.parametrize("share", [1e-8, 1.0, 1e6])
@pytest.mark.parametrize("power", [1.0, 10.0, 20.0])
def test_a_stage_solves_its_equation_however_stiff(free, share, power):
    z = hysteresis._flowed(free, share, 5.0, power)
    flow = share * np.sign(z) * (abs(z) / 5.0) ** power
    assert z + flow == pytest.approx(free, rel=1e-11)


@pytest.mark.parametrize("force", [1e-170, 1e-300])
def test_a_stage_of_hardly_any_force_ends_too(force):
    """Its square was no number any more, and it was divided by nothing."""
    z = hysteresis._flowed(1e-200, 1.0, force, 20.0)
    assert 0.0 <= z <= 1e-200


def test_a_force_of_hardly_any_digits_has_gone():
    """What is left of one that relaxes to nothing, of 1.5e-323 three units in its last place."""
    assert hysteresis._flowed(-1.5e-323, 0.0085, 0.00155, 1.0000000000000002) == 0.0


def test_an_irregular_motion_far_beyond_yield_stays_near_the_force_of_its_flow():
    """Each way is so long that the spring adds nothing: |z| is F |v|^a of its own way."""
    rng = np.random.default_rng(1)
    t, x = np.linspace(0.0, 6.0, 200), rng.normal(size=200)
    speed = np.diff(x) / np.diff(t)
    z = course(t, x, 3e6, 5.0, 0.05)[0][1:]
    np.testing.assert_allclose(z, 5.0 * np.sign(speed) * np.abs(speed) ** 0.05, rtol=1e-3)


def test_the_force_lies_flat_over_the_speed():
    """A hundred times the speed is no more than a^a of the force: a plateau, as of an MR fluid."""
    forces = []
    for speed in (1.0, 100.0):
        t = np.linspace(0.0, 20.0 / speed, 200)
        forces.append(course(t, speed * t, 50.0, F, 0.1)[0][-1])
    assert forces[1] / forces[0] == pytest.approx(100.0**0.1, rel=1e-3)


def test_its_first_harmonic_is_nearly_that_of_its_course():
    """By the balance of the first harmonics, which is a tenth off where it yields most."""
    model = parse_model("springpot + yielding")
    theta = model.vector(
        {"c": 1e-9, "alpha": 0.5, "yielding.k": K, "yielding.F": F, "yielding.a": A}
    )
    for amplitude in (0.02, 0.3, 3.0):
        t = np.linspace(0.0, 6.0, 6001)
        z = course(t, amplitude * np.cos(2.0 * np.pi * t), K, F, A)[0][5000:6000]
        turn = np.exp(-2j * np.pi * t[5000:6000])
        at = Points.at([2.0 * np.pi], amplitude=amplitude)
        balanced = model.stiffness(theta, at)[0]
        assert abs(2.0 * np.mean(z * turn) / amplitude / balanced - 1.0) < 0.11


def test_a_structure_is_told_that_it_cannot_follow_it():
    model = parse_model("kelvin + yielding")
    with pytest.raises(ModelError, match="flows by a clock of its own"):
        Damper(model, np.array([1.0, 1.0, K, F, A]))
