"""Batched Levenberg-Marquardt.

Each row is solved as if it were alone, bounds are kept, budgets counted.
"""

import numpy as np
import pytest

from springpot.identification import levenberg_marquardt


class Exponentials:
    """Residuals of a exp(-b t) + c against rows of data; counts its calls by row."""

    def __init__(self, data: np.ndarray) -> None:
        self.t = np.linspace(0.0, 3.0, data.shape[1])
        self.data = data
        self.rows = 0

    def __call__(self, u, rows):
        self.rows += len(rows)
        a, b, c = (column[:, None] for column in u.T)
        decay = np.exp(-b * self.t)
        jacobian = np.stack([decay, -a * self.t * decay, np.ones_like(decay)], axis=1)
        return a * decay + c - self.data[rows], jacobian


@pytest.fixture
def many(rng):
    truth = rng.uniform([1.0, 0.5, -1.0], [3.0, 2.0, 1.0], (50, 3))
    t = np.linspace(0.0, 3.0, 20)
    data = truth[:, :1] * np.exp(-truth[:, 1:2] * t) + truth[:, 2:]
    return truth, data


NO_BOX = np.full(3, -np.inf), np.full(3, np.inf)


def test_every_row_reaches_its_own_truth(many):
    truth, data = many
    evaluate = Exponentials(data)
    found = levenberg_marquardt(evaluate, np.tile([1.0, 1.0, 0.0], (50, 1)), *NO_BOX)
    assert found.u == pytest.approx(truth, rel=1e-9, abs=1e-9)
    assert found.converged.all()
    assert found.evaluations == evaluate.rows


def test_rows_do_not_disturb_each_other(many, rng):
    _, data = many
    data = data + 0.05 * rng.standard_normal(data.shape)
    starts = rng.uniform(0.5, 1.5, (50, 3))
    together = levenberg_marquardt(Exponentials(data), starts, *NO_BOX)
    for i in (0, 17, 49):
        alone = levenberg_marquardt(Exponentials(data[i : i + 1]), starts[i : i + 1], *NO_BOX)
        assert together.u[i] == pytest.approx(alone.u[0], rel=1e-7, abs=1e-7)


def test_it_agrees_with_minpack(many, rng):
    optimize = pytest.importorskip("scipy.optimize")
    _, data = many
    data = data + 0.1 * rng.standard_normal(data.shape)
    found = levenberg_marquardt(Exponentials(data), np.ones((50, 3)), *NO_BOX)
    for i in range(0, 50, 10):
        problem = Exponentials(data[i : i + 1])

        def residuals(u, problem=problem):
            return problem(u[None], np.zeros(1, dtype=int))[0][0]

        reference = optimize.least_squares(
            residuals, np.ones(3), method="lm", xtol=1e-14, ftol=1e-14
        )
        assert found.cost[i] <= 2.0 * reference.cost * (1.0 + 1e-9)


def test_the_box_is_kept_and_the_best_point_in_it_is_found(many):
    truth, data = many
    upper = np.array([np.inf, 1.0, np.inf])
    found = levenberg_marquardt(
        Exponentials(data), np.tile([1.0, 0.7, 0.0], (50, 1)), NO_BOX[0], upper
    )
    held = truth[:, 1] > 1.0
    assert np.all(found.u[:, 1] <= 1.0)
    assert found.u[held, 1] == pytest.approx(1.0)
    assert found.u[~held] == pytest.approx(truth[~held], rel=1e-8, abs=1e-8)
    # With b held at 1 the other two are linear.
    t = np.linspace(0.0, 3.0, 20)
    design = np.column_stack([np.exp(-t), np.ones(20)])
    for i in np.flatnonzero(held)[:5]:
        best = np.linalg.lstsq(design, data[i], rcond=None)[0]
        assert found.u[i, [0, 2]] == pytest.approx(best, rel=1e-6)


def test_a_hopeless_row_does_not_spoil_the_others(many):
    truth, data = many
    data = data.copy()
    data[3] = np.nan
    found = levenberg_marquardt(Exponentials(data), np.tile([1.0, 1.0, 0.0], (50, 1)), *NO_BOX)
    good = np.arange(50) != 3
    assert found.u[good] == pytest.approx(truth[good], rel=1e-8, abs=1e-8)
    assert not np.isfinite(found.cost[3])


def test_a_team_stops_when_one_has_reached_the_floor(many):
    _, data = many
    data = np.repeat(data[:1], 8, axis=0)
    starts = np.array([1.0, 1.0, 0.0]) * np.geomspace(0.5, 4.0, 8)[:, None]
    team = np.zeros(8, dtype=int)
    alone, joined = Exponentials(data), Exponentials(data)
    levenberg_marquardt(alone, starts, *NO_BOX, floor=1e-25)
    found = levenberg_marquardt(joined, starts, *NO_BOX, floor=1e-25, team=team)
    assert found.cost.min() <= 1e-25
    assert joined.rows < alone.rows


def test_degenerate_directions_do_no_harm():
    def evaluate(u, rows):
        # Only the sum of the parameters matters.
        total = u.sum(axis=1, keepdims=True) - 3.0
        return total * np.ones(4), np.ones((len(u), 2, 4))

    found = levenberg_marquardt(evaluate, np.zeros((5, 2)), np.full(2, -np.inf), np.full(2, np.inf))
    assert found.u.sum(axis=1) == pytest.approx(3.0)


def test_a_team_stops_sooner_where_ends_need_agree_less_closely(many, rng):
    _, data = many
    data = np.repeat(data[:1] + 0.1 * rng.standard_normal(data[:1].shape), 8, axis=0)
    starts, team = rng.uniform(0.2, 4.0, (8, 3)), np.zeros(8, dtype=int)
    closely, loosely = Exponentials(data), Exponentials(data)
    exact = levenberg_marquardt(closely, starts, *NO_BOX, team=team, flat=1e-3)
    found = levenberg_marquardt(loosely, starts, *NO_BOX, team=team, flat=1e-3, alike=1e-2)
    assert loosely.rows < closely.rows
    assert found.cost.min() == pytest.approx(exact.cost.min(), rel=1e-2)
