"""What stands behind fits: boxes, ranges, starts, uncertainties, factors, levels, kept parts."""

from __future__ import annotations

from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import nnls
from test_whole_identification import DATA, EXACT, MODEL, OMEGA, made

from springpot.identification import (
    convex,
    fitting,
    free_factors,
    intervals,
    kept,
    known_factors,
    levels_alone,
    regularisation,
    space,
    starts,
    uncertainty,
)
from springpot.identification.native import fit
from springpot.measurement import Measurement, Units
from springpot.registry import parse_model, plugins
from springpot.rheology import Dimension, Parameter
from springpot.rheology.parameters import Coordinates
from springpot.thresholds import SUPERPOSITION

STRAINED = Measurement(
    np.tile(OMEGA, 3),
    np.concatenate([EXACT + 20j / x for x in (0.2, 0.5, 2.0)]),
    conditions={"amplitude": np.repeat([0.2, 0.5, 2.0], 14)},
    units=Units("kN/m", "mm"),
    name="strained",
)
HEATED = DATA["heated"]
SLOW = Measurement(1e-3 * OMEGA, 3.7 * EXACT, units=Units("Pa", "-"), name="slow")


def effects():
    return sorted(plugins().items("effect"), key=lambda each: each.name)


@pytest.mark.parametrize("data", [STRAINED, HEATED, SLOW], ids=lambda data: data.name)
def test_boxes_and_ranges_of_all_effects(data, stays):
    window = starts.Window.of(data)
    found = {"window": window}
    for effect in effects():
        if effect.of_test or effect.by_levels or effect.needs - set(data.conditions):
            continue
        box = space.paper_box(MODEL + effect, data)
        parameters = effect.element.parameters
        found[effect.name] = [
            [box.lower, box.upper, box.theta(0.5 * (box.lower + box.upper))],
            starts.settings(parameters, window, 3),
            [starts.shown(parameter, window) for parameter in parameters],
            convex.is_passive(effect),
            convex.within_material(parse_model("material"), effect),
        ]
    stays(found)


@pytest.mark.parametrize(
    ("value", "up"),
    [(0.9, 1.0), (1.0, 1.0), (1.0001, 2.0), (2.0, 2.0), (4.9, 5.0), (5.1, 10.0), (1000.0, 1000.0),
     (0.021, 0.05), (10.0 * (1.0 + 1e-13), 10.0), (10.0 * (1.0 + 1e-11), 20.0)],
)  # fmt: skip
def test_sizes_are_rounded_up_to_1_2_or_5(value, up):
    assert space.rounded_up(value) == pytest.approx(up, rel=1e-15)


def test_ranges_of_parameters_of_every_kind(stays):
    window = starts.Window(2.0, 0.1, 5.0, 3.0, 1.5)
    kinds = {
        "stiffness": Parameter("p", "p", Dimension(1)),
        "time": Parameter("p", "p", Dimension(time=1)),
        "amplitude": Parameter("p", "p", Dimension(amplitude=-2)),
        "of both": Parameter("p", "p", Dimension(time=-1, amplitude=1), 0.01, 3.0),
        "pure": Parameter("p", "p", Dimension()),
        "order": Parameter("p", "p", Dimension(), 0.2, 0.8, "linear", 0.5),
        "either sign": Parameter("p", "p", Dimension(1), -np.inf, np.inf, "linear", 3.0),
        "upwards": Parameter("p", "p", Dimension(), -2.0, np.inf, "linear"),
    }
    found = {
        name: [starts.settings((each,), window, 9), starts.shown(each, window)]
        for name, each in kinds.items()
    }
    by_order = (Parameter("c", "c", Dimension(1, "a")), kinds["order"].renamed("a"))
    found["by an order"] = [starts.settings(by_order, window, 5), starts.shown(by_order[0], window)]
    stays(found)


def test_numbers_that_fill_a_space_evenly(stays):
    stays(
        [
            starts.low_discrepancy(7, 3),
            starts.low_discrepancy(4, 1, 0.3),
            starts.thinned(np.sort(np.random.default_rng(1).normal(size=40)), 12),
            starts.thinned(np.arange(5.0), 12),
        ]
    )


def test_least_squares_without_negative_amounts():
    matrix = np.array([[1.0, 0.5], [0.5, 1.0]])
    found, inverse = starts.non_negative(matrix, matrix @ np.array([1.0, 2.0]))
    np.testing.assert_allclose(found, [1.0, 2.0])
    np.testing.assert_allclose(inverse @ matrix, np.eye(2), atol=1e-12)
    # Held where it would be less than nothing; the other one then follows alone.
    found, inverse = starts.non_negative(matrix, np.array([2.0, -3.0]))
    np.testing.assert_allclose(found, [2.0 - 0.5 * starts.LEAST_GAIN, starts.LEAST_GAIN])
    np.testing.assert_allclose(inverse, [[1.0, 0.0], [0.0, 0.0]])
    both, _ = starts.non_negative(
        np.stack([matrix, matrix]), np.array([[2.0, -3.0], matrix @ np.array([1.0, 2.0])])
    )
    np.testing.assert_allclose(both[1], [1.0, 2.0])
    np.testing.assert_allclose(both[0], found)


@pytest.mark.parametrize("count", [3, 5])
def test_amounts_of_nearly_one_shape_are_the_best(count):
    rng = np.random.default_rng(7)
    columns = rng.normal(size=(50, 1, 28)) + 0.01 * rng.normal(size=(50, count, 28))
    columns /= np.linalg.norm(columns, axis=-1, keepdims=True)
    target = columns[:, 0] + 0.01 * rng.normal(size=(50, 28))
    matrix = columns @ columns.transpose(0, 2, 1)
    found, _ = starts.non_negative(matrix, np.matmul(columns, target[..., None])[..., 0])
    left = np.linalg.norm(np.matmul(found[:, None], columns)[:, 0] - target, axis=1)
    best = [nnls(shapes.T, each)[1] for shapes, each in zip(columns, target, strict=True)]
    np.testing.assert_allclose(left, best, rtol=1e-6)


NETWORKS = ("zener", "fractional-zener", "fractional-maxwell + inertia", "burgers", "prony-3")


@pytest.mark.parametrize("name", NETWORKS)
def test_branches_and_shapes_of_a_network(name, stays):
    model = parse_model(name)
    branches = starts.branches_of(model)
    points = made().points
    theta = np.array([p.typical * (1.0 + 0.1 * i) for i, p in enumerate(model.parameters)])
    theta = np.clip(theta, [p.lower for p in model.parameters], [p.upper for p in model.parameters])
    stiffness = np.array([300.0])
    unit = Coordinates.of(model.parameters, points.log_omega.mean(), stiffness, 2.0)
    size = unit.size[0]
    found = {
        "branches": {each.name: getattr(branches, each.name) for each in fields(branches)},
        "leaders": [branches.leaders, branches.free, starts.shape_count(branches)],
        "coordinates": [unit.bounds, unit.size, unit.slopes(theta, size), unit.u(theta, size)],
    }
    stays(found)


@pytest.mark.parametrize("name", ["one", "given", "repeats", "few", "exact"])
def test_uncertainty_of_a_fit(name, stays):
    fitted = fit(MODEL, DATA[name])
    known = uncertainty.Uncertainty(fitted, absolute=False)
    absolute = uncertainty.Uncertainty(fitted, absolute=True)
    low, high = known.interval()
    around = fitted.theta[1] * np.array([0.8, 1.0, 1.3])
    found = {
        "known": [known.scale, known.freedom, known.quantile, known.at_bound, known.covariance],
        "absolute": [absolute.scale, absolute.quantile, absolute.covariance],
        "told": [known.correlation, known.prior_residual, known.slopes, low, high],
        "widening": [known.widening(i) for i in range(4)],
        "notes": fitting.notes_on(known, low, high),
        "uses sd": uncertainty.uses_sd(fitted),
    }
    if name != "exact":
        found["profile"] = [
            intervals.profile(fitted, "alpha"),
            intervals.allowed_cost(known),
            intervals.held_costs(fitted, "k2", around),
        ]
    stays(found, within=1e-3)


def test_factors_of_each_level(stays):
    fitted = fit(parse_model("material + free-shift"), HEATED)
    rows = free_factors.FactorRows.of(fitted)
    own = levels_alone.each_alone(
        HEATED, rows.number, levels_alone.usual_objective(fitted.model, HEATED)
    )
    found = free_factors.factors_of(rows)
    known = known_factors.known_factors(rows, found, found, own)
    stays(
        {
            "factors": [
                found.levels, found.log_a, found.log_b, found.covariance, found.reach_a,
                found.reach_b, found.reference, found.quantile,
            ],
            "referred": vars(found.referred_to(1)),
            "of modulus": vars(found.of_modulus),
            "rows": [
                rows.number, rows.numbers, rows.level_of_row, rows.residual, rows.scale, rows.unit,
                rows.alike, rows.objective, rows.factors, rows.reduced, rows.named(0),
            ],
            "told": free_factors.told_by_data(rows, 0),
            "known": [known.reason, known.low, known.high, known.joined, known.determined],
            "flat": known_factors.flat_levels(rows),
            "alone": [own.error, own.cost, own.dof, own.strange, own.judged, own.share],
            "overlaps": known_factors.overlaps(rows, own),
        },
        within=1e-3,
    )  # fmt: skip


def test_ranges_meet(stays):
    number, values = np.array([0, 0, 1, 1, 2]), np.array([1.0, 3.0, 3.5, 5.0, 9.0])
    low, high = known_factors.ranges(number, values)
    assert (low.tolist(), high.tolist()) == ([1.0, 3.5, 9.0], [3.0, 5.0, 9.0])
    stays([known_factors.meeting(low, high, room) for room in (0.0, 0.5, 0.51, 4.0)])


def test_what_a_file_keeps_of_a_fit(stays):
    model = parse_model("material + arrhenius-shift")
    fitted = fit(model, HEATED)
    data = kept.measurement_to_dict(DATA["repeats"])
    again = kept.measurement_of(data)
    np.testing.assert_array_equal(again.stiffness, DATA["repeats"].stiffness)
    stays(
        {
            "rates": [kept.rates_of(fitted.model), kept.rates_of(MODEL)],
            "bounds": kept.bounds_of(MODEL),
            "data": data,
        },
        within=1e-3,
    )


@pytest.mark.parametrize("name", ["one", "heated"])
def test_a_smooth_spectrum(name, stays):
    model = parse_model("material" if name == "one" else "material + arrhenius-shift")
    found = regularisation.regularised(fit(model, DATA[name]), np.random.default_rng(2), 20)
    stays(
        {
            **{key: value for key, value in vars(found).items() if key not in ("low", "high")},
            "step": found.step,
            "within": found.within(0.9),
            "peaks": found.peaks,
        },
        within=5e-3,
    )


@pytest.mark.parametrize(
    ("error", "scatter", "judged", "weighed"),
    [
        # The loss is a hundredth of |K|, of which 2 % are left: twice the loss, and its own
        # neighbours tell it to 1 %.
        (0.02, 0.01, True, True),
        # They tell it no better than |K| does.
        (0.02, 2.0, True, False),
        # So many parts are looked at that one of them may look like this by chance.
        (0.02, 0.9, True, False),
        # What is left of |K| is little beside the loss.
        (0.01 * SUPERPOSITION.missed, 1e-6, True, False),
        (0.02, 0.01, False, False),
    ],
)
def test_a_part_counts_by_its_own_size_where_its_neighbours_tell_it(
    error, scatter, judged, weighed, monkeypatch
):
    parts = (
        SimpleNamespace(share=1.0, scatter=1e9, dof=9.0),
        SimpleNamespace(share=0.01, scatter=scatter, dof=9.0),
    )
    monkeypatch.setattr(levels_alone, "parts_of", lambda sweep: parts)
    own = SimpleNamespace(
        error=np.array([error, error]),
        judged=np.array([judged, False]),
        strange=np.array([False, False]),
        dof=np.array([9.0, 9.0]),
    )
    unfitted = SimpleNamespace(columns=("omega", "storage", "loss"))
    data = HEATED.subset(np.arange(28))
    found = levels_alone._by_own_size(data, np.repeat([0, 1], 14), own, unfitted)
    assert found.real.tolist() == [1.0, 1.0]
    assert found.imag.tolist() == [pytest.approx(100.0) if weighed else 1.0, 1.0]
