"""The problem's gradient is its objective's derivative, within thermodynamic order or not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from paper_problems import TRUTHS, artificial
from springpot.identification import Problem


@pytest.mark.parametrize(
    "name", ["fractional-kelvin4", "fractional-zener", "fractional-maxwell", "fractional-kelvin"]
)
def test_gradient_is_exact_where_kinf_is_repaired_too(name):
    problem = artificial(name)
    rng = np.random.default_rng(1)
    points = (0.1 + 0.8 * rng.random((20, problem.dimension))) * problem.upper
    if name in ("fractional-kelvin4", "fractional-zener"):
        repaired = points[:, 1] <= points[:, 0]
        assert 0 < repaired.sum() < 20
    value, slope = problem.gradient(points)
    np.testing.assert_allclose(value, problem.evaluate(points), rtol=1e-12)
    for i in range(problem.dimension):
        step = np.zeros(problem.dimension)
        step[i] = 1e-6 * problem.upper[i]
        differences = (problem.evaluate(points + step) - problem.evaluate(points - step)) / (
            2 * step[i]
        )
        error = np.abs(slope[:, i] - differences) * problem.upper[i]
        assert np.all(error <= 1e-6 * (1 + np.abs(slope * problem.upper).sum(axis=1)))


def test_a_logarithmic_objective_is_the_sum_of_its_squared_residuals():
    base = artificial("fractional-zener")
    problem = Problem(
        base.model, base.measurement, replace(base.objective, logarithmic=True), base.space
    )
    x = base.upper * [[0.2, 0.4, 0.3, 0.5], [0.1, 0.6, 0.2, 0.7]]
    np.testing.assert_allclose(
        problem.evaluate(x), np.sum(problem.residuals(x) ** 2, axis=-1), rtol=1e-12
    )


@pytest.mark.parametrize("logarithmic", [False, True])
@pytest.mark.parametrize("name", sorted(TRUTHS))
def test_a_value_depends_on_no_point_beside_it(name, logarithmic):
    """Batches lie differently in memory.

    A run alone must still be the run among many, to the last bit.
    """
    base = artificial(name)
    problem = Problem(
        base.model, base.measurement, replace(base.objective, logarithmic=logarithmic), base.space
    )
    points = np.random.default_rng(7).random((600, problem.dimension)) * 1.2 * problem.upper
    whole = problem.evaluate(points)
    np.testing.assert_array_equal(
        whole.reshape(30, 20), problem.evaluate(points.reshape(30, 20, -1))
    )
    for size in (1, 2, 13, 14, 15, 100):
        np.testing.assert_array_equal(whole[:size], problem.evaluate(points[:size]))
        np.testing.assert_array_equal(
            whole[-size:], problem.evaluate(np.asfortranarray(points[-size:]))
        )
    np.testing.assert_array_equal(whole[:5], [problem.evaluate(point) for point in points[:5]])
