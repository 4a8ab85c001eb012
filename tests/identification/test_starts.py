"""Starts read off the data.

Shapes fill their space, gains are exact, branches are found in any network.
"""

import numpy as np
import pytest
from native_problems import OMEGA, POINTS, noisy, relative_weights, setup

from springpot.identification import Window, settings
from springpot.identification.starts import (
    Branches,
    interleaved,
    low_discrepancy,
    non_negative,
    project,
    thinned,
)
from springpot.identification.task import Task
from springpot.registry import parse_model
from springpot.rheology import GRADIENT, Dimension, Parameter


def task(expression, stiffness):
    return Task(parse_model(expression), POINTS, stiffness[None], relative_weights(stiffness)[None])


def test_low_discrepancy_points_fill_every_cell():
    points = low_discrepancy(64, 2)
    cells = {tuple(cell) for cell in np.floor(points * 4).astype(int).tolist()}
    assert len(cells) == 16
    moved = low_discrepancy(64, 2, 0.25)
    assert moved == pytest.approx((points + 0.25) % 1.0)


def test_thinning_keeps_every_condition():
    log_omega = np.repeat(np.linspace(0.0, 5.0, 1000), 9)
    picked = thinned(log_omega, 300)
    counts = np.bincount(picked % 9, minlength=9)
    assert len(picked) <= 302
    assert counts.min() > 15
    assert {0, 8999} <= set(picked.tolist())


@pytest.mark.parametrize(
    ("expression", "count", "compliance"),
    [
        ("springpot", 1, False),
        ("fractional-kelvin", 2, False),
        ("fractional-maxwell", 2, True),
        ("fractional-kelvin4", 2, True),
        ("fractional-zener", 2, False),
        ("fractional-zener + inertia", 3, False),
        ("fractional-maxwell + series-spring", 3, True),
        ("fractional-maxwell + inertia + time-delay", 2, False),
        ("fractional-maxwell + time-delay", 2, True),
    ],
)
def test_branches_add_up_to_the_network(expression, count, compliance, rng):
    model = parse_model(expression)
    branches = Branches.of(model.network)
    assert (len(branches.gains), branches.compliance) == (count, compliance)
    theta = rng.uniform(0.2, 0.9, (5, len(model.parameters)))
    response = model.network.respond(theta, POINTS, GRADIENT)
    total = branches.shares(theta, *response[:2]).sum(axis=1)
    assert total == pytest.approx(1.0 / response.value if compliance else response.value, rel=1e-10)


def test_scaled_shapes_give_the_data_back(rng):
    _, theta, data = setup("fractional-zener")
    one = task("fractional-zener", data.stiffness)
    u = one.coordinates.u(theta[None], one.coordinates.size)
    back = one.full(one.shaped(u)[None])[0]
    assert one.coordinates.theta(back, one.coordinates.size)[0] == pytest.approx(theta, rel=1e-9)


@pytest.mark.parametrize(
    "expression", ["fractional-kelvin4", "fractional-zener", "fractional-maxwell + inertia"]
)
def test_placed_starts_have_the_gains_of_an_exact_projection(expression, rng):
    _, _, data = setup("fractional-zener")
    one = task(expression, noisy(data.stiffness, 0.01, rng))
    v, u = one.starts(5)
    assert u == pytest.approx(one.full(v), abs=1e-6)


def test_the_best_start_is_near_the_truth():
    _, theta, data = setup("fractional-maxwell")
    one = task("fractional-maxwell", data.stiffness)
    start = one.coordinates.theta(one.starts(1)[1][0], one.coordinates.size)[0]
    assert start == pytest.approx(theta, rel=0.5)


def test_kaufman_derivative_is_exact_where_the_residual_vanishes():
    _, theta, data = setup("fractional-kelvin4")
    one = task("fractional-kelvin4", data.stiffness)
    evaluate = one.shape_evaluator(np.zeros(1, dtype=int))
    v = one.shaped(one.coordinates.u(theta[None], one.coordinates.size))
    rows = np.zeros(1, dtype=int)
    _, jacobian = evaluate(v, rows)
    for i in range(v.shape[1]):
        step = np.zeros_like(v)
        step[:, i] = 1e-6
        slope = (evaluate(v + step, rows)[0] - evaluate(v - step, rows)[0]) / 2e-6
        assert slope[0] == pytest.approx(jacobian[0, i], abs=1e-6)


def test_gains_are_those_of_non_negative_least_squares(rng):
    optimize = pytest.importorskip("scipy.optimize")
    for m in (1, 2, 3, 5):
        shares = rng.standard_normal((40, m, 12))
        target = rng.standard_normal((40, 12))
        gains, residual, _ = project(shares, target)
        for i in range(40):
            _, distance = optimize.nnls(shares[i].T, target[i])
            assert np.linalg.norm(residual[i]) == pytest.approx(distance, rel=1e-3)
        assert np.all(gains > 0)


def test_held_gains_leave_the_projection(rng):
    matrix = np.array([[[1.0, 0.5], [0.5, 1.0]]])
    x, inverse = non_negative(matrix, np.array([[1.0, 0.1]]))
    assert x[0] == pytest.approx([1.0, 0.0], abs=1e-6)
    assert inverse[0] == pytest.approx(np.array([[1.0, 0.0], [0.0, 0.0]]))


def test_interleaving_keeps_every_number(rng):
    values = rng.standard_normal((3, 4)) + 1j * rng.standard_normal((3, 4))
    parts = interleaved(values)
    assert np.array_equal(parts[:, ::2] + 1j * parts[:, 1::2], values)
    assert len(OMEGA) == 14


def test_a_rate_is_sought_over_frequencies_and_amplitudes_together():
    """Slowest at the lowest of both, fastest at the highest: three decades and two make five."""
    window = Window(stiffness=1.0, time=1.0, amplitude=1.0, time_decades=3.0, amplitude_decades=2.0)
    rate = Parameter("Vc", "V_c", Dimension(time=-1, amplitude=1))
    found = settings((rate,), window, 200)[:, 0]
    assert found.min() < 10.0**-2.5 < 10.0**2.5 < found.max()


def test_a_power_of_time_that_is_itself_sought_needs_no_stiffness():
    """A time to the power of an order, as a plugin may have it."""
    window = Window(
        stiffness=1.0, time=10.0, amplitude=1.0, time_decades=3.0, amplitude_decades=2.0
    )
    order = Parameter("n", "n", Dimension(), 0.0, 1.0, "linear", 0.5)
    found = settings((order, Parameter("A", "A", Dimension(time="n"))), window, 50)
    assert np.all(np.isfinite(found))
    assert found[:, 1].min() < 1.0 < 10.0 < found[:, 1].max()


@pytest.mark.parametrize(
    ("time", "amplitude", "decades", "wide"),
    [
        # As few decades as ever where that is enough: a dashpot, a mass in a narrow sweep.
        (1.0, 0.0, 5.0, 4.0),
        (2.0, 0.0, 5.0, 2.0),
        # c3 of a cubic damper, 3.5 decades of frequency: from K / (omega^3 X^2) in their middle.
        (3.0, -2.0, 2.5 + 0.5 * (3.0 * 3.5 + 2.0 * 1.8), 3.5),
    ],
)
def test_a_size_is_tried_so_small_that_it_does_little_where_it_does_the_most(
    time, amplitude, decades, wide
):
    size = Parameter("c", "c", Dimension(stiffness=1, time=time, amplitude=amplitude))
    found = settings((size,), Window(1.0, 1.0, 1.0, wide, 1.8), 400)[:, 0]
    assert np.log10(found).min() == pytest.approx(-decades, abs=0.05)
    assert np.log10(found).max() == pytest.approx(decades, abs=0.05)
