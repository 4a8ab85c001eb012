"""The search in the shapes alone, the gains being solved for.

Its derivative is that of what it lowers.
"""

import numpy as np
import pytest
from native_problems import POINTS, noisy, relative_weights

from springpot.identification.task import Task
from springpot.registry import parse_model

SMALL = ("time-delay.tau", "inertia.m")


@pytest.mark.parametrize(
    "expression",
    [
        "fractional-kelvin",
        "fractional-maxwell",
        "fractional-zener",
        "fractional-kelvin + time-delay",
        "fractional-maxwell + time-delay",
        "fractional-zener + inertia + time-delay",
    ],
)
def test_the_derivative_by_the_shapes_is_that_of_the_objective(expression, rng):
    """Where a residual is left, too.

    Gains at their best, the objective changes by the shapes alone.
    """
    model = parse_model(expression)
    theta = rng.uniform(0.3, 0.6, (1, len(model.parameters)))
    # A delay of few degrees and a mass that is felt at the end only: else no gain is above zero.
    theta[0, [name in SMALL for name in model.names]] = 1e-3
    stiffness = noisy(model.stiffness(theta[0], POINTS), 0.05, rng)
    task = Task(model, POINTS, stiffness[None], relative_weights(stiffness)[None])
    rows = np.zeros(1, dtype=int)
    evaluate = task.shape_evaluator(rows)
    v = task.shaped(task.coordinates.u(1.2 * theta, task.coordinates.size))

    def objective(at):
        return 0.5 * float(np.sum(evaluate(at, rows)[0] ** 2))

    residual, jacobian = evaluate(v, rows)
    slope = jacobian[0] @ residual[0]
    for i in range(v.shape[1]):
        step = np.zeros_like(v)
        step[:, i] = 1e-5
        numeric = (objective(v + step) - objective(v - step)) / 2e-5
        assert slope[i] == pytest.approx(numeric, rel=1e-4, abs=1e-6 * np.abs(slope).max())
