"""Steps, starts and expectations of a fit, by hand with small numbers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.identification import (
    fitting,
    intervals,
    leastsquares,
    levels_alone,
    material_fit,
    population,
    problem,
    robust,
    space,
    space as expected,
    starts,
)
from springpot.identification.task import Task
from springpot.identification.value import LOST, Value
from springpot.measurement import Measurement
from springpot.rheology.parameters import Dimension, Parameter


@pytest.mark.parametrize(
    ("values", "i", "place"),
    [
        ([9.0, 4.0, 1.0, 0.0, 1.0], 3, 0.0),
        ([7.0, 6.25, 2.25, 0.25, 0.25, 2.25], 3, 0.5),
        ([6.25, 2.25, 0.25, 0.25], 2, 0.5),
        ([1.0, 4.0, 9.0], 0, 0.0),
        ([9.0, 4.0, 1.0], 2, 0.0),
        ([0.0, 3.0, 5.0, 0.2], 0, 0.0),
    ],
)
def test_the_least_lies_at_the_vertex_of_a_parabola_and_at_an_end_where_it_is(values, i, place):
    assert material_fit._vertex(np.array(values), i) == pytest.approx(place)


def test_one_sweep_is_found_to_be_the_other_moved_and_lifted():
    """One Maxwell element, measured where it is 1.3 times slower and a twentieth stiffer."""
    omega = np.geomspace(0.01, 100.0, 81)

    def curve(a, b):
        data = Measurement(omega, b * (0.1 + 1j * a * omega / (1.0 + 1j * a * omega)))
        return material_fit._Curve.of(data, np.arange(81))

    one, other = curve(1.0, 1.0), curve(1.3, 1.05)
    log_a, log_b = material_fit._pair(one, other, moves=True, lifts=True)
    assert log_a == pytest.approx(np.log(1.3), abs=0.03)
    assert log_b == pytest.approx(np.log(1.05), abs=0.01)
    assert material_fit._pair(one, one, moves=False, lifts=True) == (0.0, 0.0)
    assert material_fit._pair(one, other, moves=True, lifts=False)[1] == 0.0
    # As much apart in size alone, of which some is no more than expected to be small.
    log_a, log_b = material_fit._pair(one, curve(1.0, 1.05), moves=False, lifts=True)
    assert (log_a, log_b) == (0.0, pytest.approx(np.log(1.05), rel=0.02))


def test_vertical_factors_differ_by_their_temperatures_and_twice_by_repeats():
    element = SimpleNamespace(values=(300.0, 330.0), column="temperature")
    apart = expected.spread_between(element)
    assert apart[0, 0] == pytest.approx(np.sqrt(2.0) * expected.REPEATED)
    wanted = np.hypot(np.log(1.1), np.sqrt(2.0) * expected.REPEATED)
    assert apart[0, 1] == apart[1, 0] == pytest.approx(wanted)
    element.column = "water"
    np.testing.assert_allclose(expected.spread_between(element), np.sqrt(2.0) * np.log(2.0))


def test_repeats_at_a_level_tell_its_scatter_by_one_degree_of_freedom_a_pair():
    """Of 0.98 and 1.02 twice, and of what stands alone none."""
    omega = np.array([1.0, 1.0, 2.0, 2.0, 3.0, 1.0])
    size = np.array([0.98, 1.02, 1.96, 2.04, 7.0, 3.0])
    data = Measurement(omega, size * (0.6 + 0.8j))
    found = levels_alone.repeat_scatter(data, np.array([0, 0, 0, 0, 0, 1]))
    np.testing.assert_allclose(found, [np.sqrt(4.0 * 0.02**2 / 2.0), 0.0])
    found = levels_alone.repeat_scatter(data, np.array([0, 0, 1, 1, 1, 1]))
    np.testing.assert_allclose(found, np.sqrt(2.0) * 0.02)


@pytest.mark.parametrize(("dof", "told"), [(0, 1), (1, 0)])
def test_as_many_parameters_as_numbers_are_told(dof, told):
    assert len(list(fitting._undetermined(SimpleNamespace(dof=dof)))) == told


@pytest.mark.parametrize(
    ("lower", "upper", "power", "order"),
    [(0.0, 1.0, "n", True), (0.0, 2.0, "n", False), (0.5, 1.0, "n", False), (0.0, 1.0, 1, False)],
)
def test_an_order_is_what_the_unit_of_another_depends_on(lower, upper, power, order):
    parameter = Parameter("n", "n", Dimension(), lower, upper, "linear")
    other = Parameter("c", "c", Dimension(1, power), 0.0, np.inf)
    fit = SimpleNamespace(model=SimpleNamespace(parameters=(parameter, other)))
    assert fitting._orders_of(fit) == ({"n"} if order else set())


def test_limits_hold_a_share_of_specimens_at_the_same_confidence():
    """Of ten: 9 over the 5 % quantile of chi-square of 9 (3.3251), and 1.95996 deviations."""
    low, high = population._limits(5.0, 2.0, np.zeros(10), False)
    seen = 9.0 * 4.0 / 3.3251128
    half = 1.959964 * np.sqrt(seen * 1.1)
    assert (low, high) == pytest.approx((5.0 - half, 5.0 + half), rel=1e-6)
    own = population._limits(5.0, 2.0, np.full(10, 0.5), False)
    seen = 9.0 * 4.5 / 3.3251128
    half = 1.959964 * np.sqrt(seen - 0.5 + seen / 10.0)
    assert own == pytest.approx((5.0 - half, 5.0 + half), rel=1e-6)
    ends = population._limits(5.0, 2.0, np.full(10, 0.5), True)
    assert ends == pytest.approx(np.exp(own))


def test_a_model_and_its_gradient_differ_by_a_share_where_both_are_numbers():
    def respond(theta, points, depth=None):
        value = np.array([2.0, np.nan, 4.0 + 3.0j]) * np.array([1, 1, 1 if depth is None else 1.1])
        return SimpleNamespace(value=value)

    model = SimpleNamespace(network=SimpleNamespace(respond=respond))
    assert problem._apart(model, None, None) == pytest.approx(0.1)
    empty = SimpleNamespace(
        network=SimpleNamespace(
            respond=lambda *given: SimpleNamespace(value=np.full(2, np.nan + 0j))
        )
    )
    assert problem._apart(empty, None, None) == 0.0


@pytest.mark.parametrize(
    ("parameter", "size"),
    [
        (Parameter("k", "k", Dimension(1), 0.0, np.inf), 8.0),
        (Parameter("c", "c", Dimension(1, 1), 0.0, np.inf), 8.0 * 9.0),
        (Parameter("q", "q", Dimension(1, "n"), 0.0, np.inf), 8.0 * 3.0),
        (Parameter("f", "f", Dimension(1, 0, 1), 0.0, np.inf), 8.0 * 0.5),
        (Parameter("T", "T", Dimension(), 0.0, np.inf, typical=100.0), 100.0),
        (Parameter("n", "n", Dimension(), 0.0, 0.7, "linear"), 0.7),
        (Parameter("d", "d", Dimension(1), -1.0, np.inf, "linear"), 8.0),
    ],
)
def test_a_parameter_is_expected_by_its_unit(parameter, size):
    """Stiffness 8, a time of 9 and an amplitude of a half; of an order the largest."""
    assert space._expected(parameter, 8.0, 9.0, 0.5) == pytest.approx(
        size * (1.0 if parameter.name in "Tn" else parameter.typical)
    )


@pytest.mark.parametrize("size", [1, 2, 3])
def test_the_inverse_of_shapes_is_one(size):
    matrix = np.array([np.eye(size), np.full((size, size), 0.3) + 0.7 * np.eye(size)])
    found = starts._inverse(matrix)
    np.testing.assert_allclose(found, np.linalg.inv(matrix), rtol=1e-12, atol=1e-12)


def test_weights_of_a_plane_are_those_of_the_objective_to_first_order():
    def weights(**given):
        usual = {"stiffness": np.array([3.0 + 4.0j]), "logarithmic": False, "turn": None}
        task = SimpleNamespace(weights=np.array([0.6 + 0.8j]), **(usual | given))
        return vars(Task)["_plane_weights"].func(task)

    assert weights() == pytest.approx(0.6 + 0.8j)
    assert weights(logarithmic=True) == pytest.approx((0.6 + 0.8j) / 5.0)
    assert weights(turn=1.0) == pytest.approx((1.0 + 1.0j) / np.sqrt(2.0))


@pytest.mark.parametrize(
    ("cost", "damping", "better", "rest"),
    [
        (5.0, 0.3, True, False),
        (10.0 / 1.1, 0.3, True, True),
        (10.0, 30.0, False, False),
        (11.0, 30.0, False, False),
        (np.nan, 30.0, False, False),
    ],
)
def test_a_step_that_lowers_the_cost_is_taken_and_the_damping_eased(cost, damping, better, rest):
    now, other = SimpleNamespace(cost=10.0), SimpleNamespace(cost=cost)
    way = SimpleNamespace(trial=now, damping=3.0, better=None, at_rest=None, taken=2)
    leastsquares.Way.take(way, other, 0.1001)
    assert way.trial is (other if better else now)
    assert way.damping == pytest.approx(damping)
    assert (way.better, way.at_rest, way.taken) == (better, rest, 2 + better)
    way.damping = 1e-9
    leastsquares.Way.take(way, SimpleNamespace(cost=1.0), 0.1)
    assert way.damping == 1e-9


def test_a_damped_step_goes_by_slopes_of_one_size():
    slopes = np.array([[2.0, 0.0], [0.0, 0.1]])
    residual = np.array([0.3, 0.004])
    step = leastsquares._damped_step(residual, slopes, 0.5)
    np.testing.assert_allclose(step, [0.3 / 2.0 / 1.5, 0.004 / 0.1 / 1.5])
    far = leastsquares._damped_step(1e6 * residual, slopes, 0.5)
    np.testing.assert_array_equal(far, leastsquares.REACH)


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        (1.0, 0.999 * LOST, True),
        (1.0, LOST, False),
        (0.0, 1e9, True),
        (-1.0, 1e9, True),
        (0.5, 0.4 * LOST, True),
        (0.5, 0.6 * LOST, False),
        (-np.inf, 1.0, False),
        (1.0, np.inf, False),
    ],
)
def test_a_value_is_determined_within_three_decades(low, high, told):
    assert Value(1.0, low, high, "kg").determined is told


@pytest.mark.parametrize("loss", ["huber", "soft-l1"])
def test_what_is_far_off_counts_less_as_its_slope_says(loss):
    bend = robust.TUNED[loss]
    off = np.array([-6.0, -1.3, 0.4, 1.3, 7.0]) * bend
    counts, slope = robust.influence(off, loss)
    step = 1e-6 * bend
    up, down = (each * robust.influence(each, loss)[0] for each in (off + step, off - step))
    np.testing.assert_allclose(slope, (up - down) / (2.0 * step), atol=1e-7)
    far = bend / np.abs(off)
    wanted = np.minimum(far, 1.0) if loss == "huber" else 1.0 / np.hypot(1.0, 1.0 / far)
    np.testing.assert_allclose(counts, wanted)


def test_simulated_errors_are_normal_of_the_size_that_the_fit_tells(monkeypatch):
    fit = SimpleNamespace(measurement=range(3))
    sure = SimpleNamespace(of=lambda fit: SimpleNamespace(scale=2.0, memory=0.0))
    monkeypatch.setattr(intervals, "Uncertainty", sure)
    rng, again = np.random.default_rng(1), np.random.default_rng(1)
    drawn = intervals._errors(fit, 4, rng)
    both = 2.0 * again.standard_normal((4, 6))
    np.testing.assert_array_equal(drawn, both[:, :3] + 1j * both[:, 3:])
