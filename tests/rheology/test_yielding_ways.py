"""Bouc and Wen's element along any course, against its differential equation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from springpot.registry import parse_model
from springpot.rheology.hysteresis import yielding_force, yielding_step

COURSE = np.concatenate([[0.0], np.cumsum(np.random.default_rng(1).normal(size=25))])
SHAPES = [(1.0, 1.0), (0.6, 0.3), (3.0, 0.8), (8.0, 0.5)]


@pytest.mark.parametrize(("n", "beta"), SHAPES)
def test_the_force_is_that_of_the_differential_equation(n, beta):
    found, _ = yielding_force(COURSE, 2.0, 0.7, n, beta)
    z, expected = 0.0, [0.0]
    for way in np.diff(COURSE):

        def rate(_, y, way=way):
            return 2.0 / 0.7 * way * (1.0 - np.abs(y) ** n * (beta * np.sign(y * way) + 1.0 - beta))

        z = solve_ivp(rate, (0.0, 1.0), [z], rtol=1e-8, atol=1e-10, max_step=0.1).y[0, -1]
        expected.append(0.7 * z)
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize(("n", "beta"), SHAPES)
def test_its_derivatives_are_those_of_differences(n, beta):
    theta = np.array([2.0, 0.7, n, beta])
    _, by_theta = yielding_force(COURSE, *theta)
    for i, slope in enumerate(by_theta):
        step = 1e-4 * theta[i] * (np.arange(4) == i)
        more, less = (yielding_force(COURSE, *(theta + sign * step))[0] for sign in (1.0, -1.0))
        expected = (more - less) / (2e-4 * theta[i])
        np.testing.assert_allclose(slope, expected, atol=1e-5 * np.abs(expected).max())


def test_where_it_rests_it_goes_on_as_it_went():
    course = np.array([0.0, 0.0, 0.3, 0.3, 0.5, 0.2, 0.2, 0.4])
    rests = np.array([0, 2, 4, 5, 7])
    there, _ = yielding_force(course[rests], 2.0, 0.7, 1.5, 0.4)
    np.testing.assert_allclose(yielding_force(course, 2.0, 0.7, 1.5, 0.4)[0][rests], there)


def test_it_stands_beside_a_material_in_time():
    model = parse_model("zener + smooth-hysteresis")
    t = np.linspace(0.0, 2.0, 41)
    own, beside = np.array([1.0, 2.0, 0.5]), np.array([3.0, 0.4, 1.2, 0.5])
    force = model.respond(np.append(own, beside), t, np.sin(3.0 * t))
    alone = (model - "smooth-hysteresis").respond(own, t, np.sin(3.0 * t))
    np.testing.assert_allclose(force - alone, yielding_force(np.sin(3.0 * t), *beside)[0])


def test_step_by_step_it_goes_as_at_once():
    force, found = 0.0, [0.0]
    for way in np.diff(COURSE):
        force = yielding_step(force, way, 2.0, 0.7, 1.5, 0.4)
        found.append(force)
    np.testing.assert_allclose(found, yielding_force(COURSE, 2.0, 0.7, 1.5, 0.4)[0], atol=1e-6)
