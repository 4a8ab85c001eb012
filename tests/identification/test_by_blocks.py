"""Levels with parameters of their own are solved by blocks, to the same as all at once."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import springpot
from springpot.identification import fit_batch
from springpot.identification.normal import Arrow, Eliminated, Layout, LevelSlopes, Whole
from springpot.identification.population import Errors, component
from springpot.rheology import levels_of


@st.composite
def problems(draw):
    """A layout of few levels in any order, with a generator for the rest."""
    levels, own, shared = (draw(st.integers(*ends)) for ends in ((2, 6), (1, 3), (0, 3)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    places = np.concatenate(
        [
            shared + np.arange(levels * own).reshape(levels, own),
            np.tile(np.arange(shared), (levels, 1)),
        ],
        axis=1,
    )
    # Of any order in theta and among the rows; a level has rows enough for its own parameters.
    order, columns = rng.permutation(levels * own + shared), rng.permutation(own + shared)
    number = np.concatenate(
        [np.repeat(np.arange(levels), own + shared), rng.integers(0, levels, 9)]
    )
    return Layout(order[places][:, columns], rng.permutation(number)), rng


@settings(max_examples=30, deadline=None)
@given(problems())
def test_a_step_is_that_of_all_parameters_at_once(problem) -> None:
    layout, rng = problem
    residual = rng.standard_normal((3, len(layout.number)))
    slopes = rng.standard_normal((3, layout.places.shape[1], len(layout.number)))
    whole = Whole().normal(residual, np.array([layout.dense(each) for each in slopes]))
    arrow = Arrow(layout).normal(residual, slopes)
    assert arrow[0] == pytest.approx(whole[0])
    assert arrow[1] == pytest.approx(whole[1], abs=1e-12)
    damping, frozen = np.array([1e-6, 1e-2, 10.0]), rng.random(whole[1].shape) < 0.2
    step = Whole().step(whole[2], -whole[1], damping, frozen)
    assert Arrow(layout).step(arrow[2], -whole[1], damping, frozen) == pytest.approx(step, rel=1e-6)
    bent = Whole().bent(whole[2], step)
    assert Arrow(layout).bent(arrow[2], step) == pytest.approx(bent, rel=1e-9, abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(problems())
def test_a_covariance_is_that_of_all_parameters_at_once(problem) -> None:
    layout, rng = problem
    slopes = rng.standard_normal((layout.places.shape[1], len(layout.number)))
    free = rng.random(layout.count) < 0.8
    eliminated, columns = (
        Eliminated(LevelSlopes(layout, slopes), free),
        layout.dense(slopes)[free].T,
    )
    expected = np.zeros((layout.count, layout.count))
    expected[np.ix_(free, free)] = 4.0 * np.linalg.pinv(columns.T @ columns)
    known = eliminated.covariance(2.0)
    scale = np.abs(expected).max(initial=1e-9)
    assert known.dense() == pytest.approx(expected, abs=1e-7 * scale)
    assert known.variance == pytest.approx(np.diag(expected), abs=1e-7 * scale)
    vectors = rng.standard_normal((2, layout.count))
    assert known.times(vectors) == pytest.approx(vectors @ expected, abs=1e-6 * scale)
    for rows in (layout.number == 1, layout.number >= 0):
        slope = rng.standard_normal(len(rows)) * rows
        left = slope - columns @ np.linalg.lstsq(columns, slope)[0]
        assert eliminated.left(slope) == pytest.approx(np.linalg.norm(left), rel=1e-6, abs=1e-9)


def test_what_the_data_leave_open_is_lost_with_all_that_have_a_part_in_it() -> None:
    places = np.array([[0, 1, 4], [2, 3, 4]])
    layout, rng = Layout(places, np.repeat([0, 1], 8)), np.random.default_rng(1)
    slopes, free = rng.standard_normal((3, 16)), np.ones(5, dtype=bool)
    # Two of one level go together.
    slopes[1, :8] = 2.0 * slopes[0, :8]
    known = Eliminated(LevelSlopes(layout, slopes), free).covariance(1.0)
    assert known.lost.tolist() == [True, True, False, False, False]
    assert np.all(np.isfinite(known.variance[2:]))
    # The shared one goes with one of each level.
    slopes = rng.standard_normal((3, 16))
    slopes[2] = slopes[0]
    known = Eliminated(LevelSlopes(layout, slopes), free).covariance(1.0)
    assert known.lost.tolist() == [True, False, True, False, True]


def batch(count: int, points: int = 8) -> springpot.Measurement:
    """Specimens that differ in stiffness and dashpot."""
    rng, specimen = np.random.default_rng(1), np.repeat(np.arange(1.0, count + 1), points)
    omega = np.tile(np.geomspace(1.0, 100.0, points), count)
    k, c = (
        size * np.repeat(np.exp(0.1 * rng.standard_normal(count)), points) for size in (100.0, 2.0)
    )
    noise = 1.0 + 0.003 * (rng.standard_normal(len(omega)) + 1j * rng.standard_normal(len(omega)))
    exact = (k + 1j * c * omega) * noise
    return springpot.Measurement(omega, exact, conditions={"specimen": specimen}, name="batch")


@pytest.mark.parametrize("own", [{"k": "specimen"}, {"*": "specimen"}])
def test_a_fit_is_the_least_one_and_known_as_well_as_all_columns_say(own) -> None:
    found = springpot.identify(batch(6), "kelvin", own=own)
    slopes, residual = found.fit.jacobian_u, found.fit.residual
    sizes = np.linalg.norm(slopes, axis=0)
    assert np.all(np.abs(slopes.T @ residual) < 1e-7 * sizes * np.linalg.norm(residual))
    by_u = found.fit.cost / found.fit.dof * np.linalg.inv(slopes.T @ slopes)
    # Both of them are searched by their logarithms.
    assert found.covariance == pytest.approx(by_u * np.outer(found.theta, found.theta), rel=1e-8)
    told = replace(found, judge=None).to_dict()["covariance"]
    second = [found.model.names.index(name) for name in told["names"][1]]
    assert {"k_2", "c", "c_2"} >= {*told["names"][1]} > {"k_2"}
    part = found.covariance[np.ix_(second, second)]
    assert np.array(told["levels"][1]) == pytest.approx(part, rel=1e-8, abs=1e-20)


def test_specimens_beside_levels_scatter_as_all_columns_say() -> None:
    data = batch(12)
    number = data.conditions["specimen"]
    both = {"specimen": number, "lot": 1.0 + number % 3}
    data = springpot.Measurement(data.omega, data.stiffness, conditions=both, name="lots")
    found = springpot.identify(data, "kelvin", own={"k": "lot"}, specimen="specimen")
    known = found.uncertainty
    assert known.specimens.count == 12
    slopes = found.fit.jacobian_u
    inverse = np.linalg.inv(slopes.T @ slopes)
    expected = known.specimens.sandwich(slopes, found.fit.residual, inverse)
    assert known.covariance.dense() == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


@pytest.mark.soak
def test_memory_grows_with_the_specimens_and_no_faster() -> None:
    peaks = []
    springpot.identify(batch(20), "kelvin", own={"k": "specimen"})
    for count in (50, 200):
        data = batch(count)
        tracemalloc.start()
        springpot.identify(data, "kelvin", own={"k": "specimen"})
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # What is dense in all parameters would take sixteen times as much.
    assert peaks[1] < 6.0 * peaks[0]


def test_many_data_sets_are_fitted_by_blocks_each_as_if_alone() -> None:
    data, model = batch(5), springpot.parse_model("kelvin").owning(["k"], "specimen")
    model = model.bound_to(data.points)
    noise = 1.0 + 0.02 * np.random.default_rng(3).standard_normal((2, len(data)))
    sets, weights = data.stiffness * noise, 1.0 / data.magnitude
    theta, cost = fit_batch(model, data.points, sets, weights)
    for i, values in enumerate(sets):
        # Rows weighed as all of the batch are.
        sd = data.magnitude * (1.0 + 1.0j)
        one = springpot.Measurement(data.omega, values, sd=sd, conditions=data.conditions)
        alone = springpot.identify(one, "kelvin", own={"k": "specimen"})
        assert theta[i] == pytest.approx(alone.theta, rel=1e-6)
        assert cost[i] == pytest.approx(alone.cost, rel=1e-6)


@pytest.mark.soak
def test_simulated_fits_scatter_as_the_intervals_say_and_take_little_memory() -> None:
    data, ends = batch(40), []
    tracemalloc.start()
    for intervals in ("jacobian", "bootstrap"):
        found = springpot.identify(data, "kelvin", own={"*": "specimen"}, intervals=intervals)
        ends.append(np.log(found.high / found.low))
    # What is dense in all parameters would take two hundred times as much for its derivative alone.
    assert tracemalloc.get_traced_memory()[1] < 150e6
    tracemalloc.stop()
    assert np.median(ends[1] / ends[0]) == pytest.approx(1.0, abs=0.05)
    assert ends[1] == pytest.approx(ends[0], rel=0.3)


def test_a_thousand_numbered_specimens_are_as_many_levels() -> None:
    number = np.arange(1.0, 1001.0)
    assert levels_of("specimen", number).tolist() == list(range(1000))
    # Settings that a rig holds are told apart as before.
    assert levels_of("preload", number + 500.5).max() < 999


def test_levels_without_points_leave_a_model() -> None:
    data = batch(4)
    found = springpot.identify(data, "kelvin", own={"k": "specimen"})
    kept = found.model.at_levels(np.array([0, 3]))
    assert kept.names == ("k_1", "k_4", "c")
    theta = found.theta[[found.model.names.index(name) for name in kept.names]]
    part = data.subset(np.isin(data.conditions["specimen"], [1.0, 4.0]))
    expected = found.model.stiffness(found.theta, part.points)
    assert kept.stiffness(theta, part.points).tolist() == expected.tolist()


@pytest.mark.parametrize("common", [0, 2])
def test_errors_in_common_are_as_their_whole_covariance(common: int) -> None:
    rng = np.random.default_rng(common)
    errors = Errors(rng.uniform(0.5, 2.0, 7), rng.standard_normal((7, common)))
    whole = np.diag(errors.own) + errors.common @ errors.common.T
    again, vector = Errors.of(whole), rng.standard_normal(7)
    for each in (errors, again):
        assert each.times(vector) == pytest.approx(whole @ vector)
        solved = np.linalg.solve(whole + 0.3 * np.eye(7), vector)
        assert each.beside(0.3, vector[:, None])[:, 0] == pytest.approx(solved)
    one, other = (component(vector, each, np.ones((7, 1))) for each in (errors, again))
    assert one.value == other.value
    assert one.means == pytest.approx(other.means)
    assert one.drawn == pytest.approx(other.drawn)
