"""Rules of superposition, each at both sides of its edge, with values by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.measurement import Measurement
from springpot.measurement.imposed import Loading
from springpot.measurement.timetest import TimeTest
from springpot.rheology.points import HELD
from springpot.superposition import curve, laws, laws as steps, simplicity
from springpot.thresholds import SUPERPOSITION, VERDICT
from springpot.writing import number

DECADE = np.log(10.0)
ROOM = HELD["temperature"]


def relaxation(time, response, start=0.0, rise=0.0, size=2.0, **more):
    """A test whose displacement rises to its size from a start on."""
    loading = Loading(np.array([0.0, start, start + rise, 200.0]), np.array([0.0, 0.0, size, size]))
    time, response = np.array(time, dtype=float), np.array(response, dtype=float)
    known = {"temperature": 25.0, "name": "one#2", "displacement_unit": "mm", "force_unit": "N"}
    return TimeTest(time, response, loading, **known | more)


def test_time_counts_from_the_middle_of_the_ramp_and_what_was_read_within_it_does_not():
    time = [5.0, 5.5, 6.0, 7.0, 105.0]
    test = relaxation(time, [1.0, 1.0, 9.0, 6.0, 4.0], start=5.0, rise=1.0)
    assert (test.start, test.rise) == (5.0, 1.0)
    rates, values, celsius = steps._shown(test, "relaxation")
    # The ramp's end is no time after it; 7 and 105 s are 1.5 and 99.5 s from its middle.
    np.testing.assert_allclose(rates, [1 / 99.5, 1 / 1.5])
    np.testing.assert_allclose(values, [2.0, 3.0])
    np.testing.assert_array_equal(celsius, [25.0, 25.0])


def test_samples_of_a_twentieth_of_a_decade_are_one():
    # In twentieths of a decade of the rate: -1.5 and -1.2 lie in one, -0.5 in the next.
    time = 10.0 ** (np.array([0.5, 1.2, 1.5]) / 20.0)
    rates, values, _ = steps._shown(relaxation(time, [8.0, 6.0, 4.0]), "relaxation")
    np.testing.assert_allclose(np.log10(rates) * 20.0, [-1.35, -0.5])
    np.testing.assert_allclose(values, [2.5, 4.0])


@pytest.mark.parametrize(
    ("kind", "more", "says"),
    [
        ("creep", {}, "and this is a test of relaxation"),
        ("relaxation", {"temperature": None}, "a master curve needs the temperature"),
        ("relaxation", {"response": np.array([1.0, 0.0])}, "is not positive after the step"),
        ("relaxation", {"response": np.array([-1.0, 1.0])}, "is not positive after the step"),
    ],
)
def test_what_no_master_curve_is_made_of_is_refused(kind, more, says):
    test = replace(relaxation([1.0, 2.0], [2.0, 1.0]), **more)
    with pytest.raises(DataError, match=says):
        steps._shown(test, kind)


def test_several_relaxations_are_one_set_of_points():
    tests = [
        relaxation([1.0, 10.0], [4.0, 2.0], name="a#1"),
        relaxation([1.0, 10.0], [3.0, 1.0], name="a#2", temperature=40.0),
        relaxation([1.0, 2.0], [3.0, 2.0], name="b", temperature=50.0),
    ]
    found = steps.after_steps(tests)
    assert found.points.name == "a + b"
    assert found.points.conditions["temperature"].tolist() == [25.0, 25.0, 40.0, 40.0, 50.0, 50.0]
    np.testing.assert_allclose(found.points.storage, [1.0, 2.0, 0.5, 1.5, 1.0, 1.5])
    np.testing.assert_allclose(found.points.omega, [0.1, 1.0, 0.1, 1.0, 0.5, 1.0])


@pytest.mark.parametrize(
    ("band", "low", "high", "inside"),
    [
        (0, 0.1, 0.2, True),
        (0, -5.0, 5.0, True),
        (1, -1.0, 1.0001 * DECADE, True),
        (1, -1.0, DECADE, False),
        (-2, -DECADE, 1.0, False),
        (-2, -1.0001 * DECADE, 1.0, True),
        (2, 0.0, DECADE, False),
    ],
)
def test_a_branch_is_told_where_its_decade_meets_the_reduced_frequencies(band, low, high, inside):
    assert simplicity._inside(band, np.array([low, 0.5 * (low + high), high])) == inside


def test_shares_and_directions_in_words():
    assert simplicity._direction(1e-9) == "more"
    assert simplicity._direction(0.0) == "less"
    assert simplicity._direction(-1e-9) == "less"
    assert simplicity._of_all(0.256) == " (26 % of what is left)"
    assert simplicity._of_all(1.7) == " (100 % of what is left)"
    assert simplicity._percent(0.01234) == "1.2 %"
    assert simplicity._total(np.array([3.0, -9.0, 4.0])) == 7.0
    assert simplicity._total(np.array([0.2, -9.0])) == 1.0


class Rows(SimpleNamespace):
    """Fitted factors of three levels."""

    def named(self, level):
        return f"{self.elements[0].shown[level]:g} degC"


def strange(errors, dof, flags):
    rows = Rows(elements=[SimpleNamespace(shown=np.array([10.0, 20.0, 30.0, 40.0]))])
    judged = np.array([True, True, True, True])
    alone = SimpleNamespace(
        judged=judged,
        error=np.array(errors),
        dof=np.array(dof),
        strange=np.array(flags),
    )
    return simplicity._no_material(rows, alone)


def test_a_level_that_no_material_follows_is_told_beside_the_usual_error():
    errors, dof = [0.01, 0.01, 0.03, 0.05], [90.0, 90.0, 90.0, 90.0]
    worst, next_ = strange(errors, dof, [False, False, True, True])
    assert (worst.place, next_.place) == (40.0, 30.0)
    # The median error is 0.02; F(6.25; 90, 90) and F(2.25; 90, 90), each of four levels.
    assert worst.size == 0.05
    assert worst.says.startswith(
        "at 40 degC no linear material comes nearer than 5 %, elsewhere 2 %"
    )
    assert worst.chance == pytest.approx(4.0 * simplicity.f_sf(6.25, 90.0, 90.0))
    assert next_.chance == pytest.approx(4.0 * simplicity.f_sf(2.25, 90.0, 90.0))
    assert np.isnan(worst.share)
    assert strange(errors, dof, [False] * 4) == []
    # With a degree of freedom or two nothing is certain.
    assert strange(errors, [1.0] * 4, [True] * 4) == []


def test_a_level_is_told_that_its_own_material_follows_and_the_common_one_does_not(monkeypatch):
    monkeypatch.setattr(simplicity, "_excess", lambda alone, rows: np.array([380.0, 20.0, -50.0]))
    rows = Rows(
        elements=[SimpleNamespace(shown=np.array([10.0, 20.0, 30.0]))],
        numbers=np.array([40, 40, 40]),
    )
    alone = SimpleNamespace(
        judged=np.array([True, True, True]),
        error=np.array([0.01, 0.01, 0.01]),
        dof=np.array([20.0, 20.0, 20.0]),
    )
    nearly = VERDICT.agrees * 0.01
    [found] = simplicity._levels(rows, alone, np.array([0.03, 0.03, nearly]))
    assert (found.kind, found.place) == ("level", 10.0)
    assert found.size == pytest.approx(3.0)
    assert found.share == pytest.approx(0.95)
    # Ten times the variance of its own, of 40 numbers against 20, three levels being looked at.
    assert found.chance == pytest.approx(3.0 * simplicity.f_sf(10.0, 40.0, 20.0))
    assert found.says == (
        "at 10 degC the curve is 3 % off, a material of its own 1 % (95 % of what is left)"
    )
    assert simplicity._levels(rows, alone, np.array([nearly, 0.0, 0.0])) == []


def test_a_law_is_judged_by_what_it_leaves():
    assert laws._verdict(3.0, 0)[0] == "cannot-tell"
    assert np.isnan(laws._verdict(3.0, 0)[1])
    # chi-square of one degree of freedom: 6.63 at 1 %.
    verdict, chance = laws._verdict(6.634897, 1)
    assert chance == pytest.approx(0.01, rel=1e-5)
    assert verdict == ("departs" if VERDICT.structure_alarm > 0.01 else "holds")
    assert laws._verdict(100.0, 1)[0] == "departs"
    assert laws._verdict(0.5, 1)[0] == "holds"


def test_bounds_keep_the_pole_below_the_coldest_level():
    kelvin = np.array([250.0, 300.0])
    boxes = {law.name: laws._box(law, kelvin, 290.0) for law in laws.LAWS}
    for law in laws.LAWS:
        low, high = boxes[law.name]
        for i, parameter in enumerate(law.element.parameters):
            if parameter.name == "T0":
                assert (low[i], high[i]) == (parameter.lower, 249.0)
            elif parameter.name == "C2":
                assert (low[i], high[i]) == (41.0, parameter.upper)
            else:
                assert (low[i], high[i]) == (parameter.lower, parameter.upper)


def test_a_law_is_begun_at_one_place_or_along_its_second_parameter():
    [only] = laws._starts(np.array([1.0]), np.array([101.0]))
    assert only.tolist() == [6.0]
    starts = np.array(laws._starts(np.array([0.0, 10.0]), np.array([100.0, 110.0])))
    assert starts[:, 0].tolist() == [5.0] * 4
    np.testing.assert_allclose(starts[:, 1], 10.0 + 100.0 * np.geomspace(0.02, 0.9, 4))


@pytest.mark.parametrize(
    ("log_a", "levels", "told"),
    [
        ([-3.0, 0.0, 3.0], [10.0, 20.0, 30.0], True),
        ([3.0, 0.0, -3.0], [10.0, 20.0, 30.0], False),
        ([3.0, 0.0, -3.0], [30.0, 20.0, 10.0], True),
        ([-0.05, 0.0, 0.05], [10.0, 20.0, 30.0], False),
    ],
)
def test_shifts_that_rise_with_temperature_are_told(log_a, levels, told):
    class Factors(SimpleNamespace):
        def __len__(self):
            return len(self.levels)

    factors = Factors(
        column="temperature",
        reference=1,
        levels=np.array(levels),
        log_a=np.array(log_a),
        covariance=0.1**2 * np.eye(3),
    )
    known = np.array([True, True, True])
    assert laws.slower_when_hot(factors, known) == [laws.SLOWER] * told
    assert laws.slower_when_hot(factors, ~known) == []
    only = np.array([False, True, False])
    assert laws.slower_when_hot(factors, only) == []
    factors.column = "pressure"
    assert laws.slower_when_hot(factors, known) == []


def test_an_error_of_its_own_makes_the_misfit_of_a_law_what_is_to_be_expected():
    task = laws._Task(
        laws.LAWS[0],
        None,
        np.arange(4),
        np.array([1.0, -1.0, 1.0, -1.0]),
        1e-8 * np.eye(4),
        np.array([-1.0]),
        np.array([1.0]),
    )
    object.__setattr__(task, "log_factor", lambda theta: np.full(4, theta[0]))
    theta, square, slopes = task.solve([np.array([0.5])], 0.5)
    assert theta[0] == pytest.approx(0.0, abs=1e-6)
    # Four errors of one in units of a half.
    assert square == pytest.approx(16.0, rel=1e-6)
    np.testing.assert_allclose(slopes, 2.0, rtol=1e-6)
    # The square is 3 where the law is off by 2 / sqrt(3) at each; the steps halve 2e9 eight times.
    off = task.own_error(np.array([0.5]), 3)
    assert 2.0 / np.sqrt(3.0) <= off < 1.1 * 2.0 / np.sqrt(3.0)


@pytest.mark.parametrize(
    ("theta", "at_bound"),
    [(0.0, True), (1e-5, False), (0.5, False), (1.0 - 1e-5, False), (1.0, True)],
)
def test_a_parameter_rests_on_a_bound(theta, at_bound):
    task = laws._Task(None, None, None, None, None, np.zeros(1), np.ones(1))
    assert task.at_bound(np.array([theta])) == at_bound


@pytest.mark.parametrize(("square", "seen"), [(1e-5, False), (0.99e-4, False), (1.01e-4, True)])
def test_a_step_is_told_where_spectrum_and_factors_leave_some_of_its_direction(
    square, seen, monkeypatch
):
    slope = np.array([[np.sqrt(square)], [0.0]])
    monkeypatch.setattr(simplicity, "_excess", lambda alone, rows: np.array([6.0]))
    monkeypatch.setattr(simplicity, "_variance", lambda alone, rows: np.array([4.0]))
    monkeypatch.setattr(simplicity, "weighted", lambda columns, weights: columns)
    monkeypatch.setattr(simplicity.Tangent, "left", lambda basis, asked: slope)
    rows = SimpleNamespace(
        level_of_row=np.array([0, 0]),
        by_theta=np.zeros((2, 1)),
        fit=SimpleNamespace(model=SimpleNamespace(material=SimpleNamespace(parameters=[0]))),
        weights=None,
        factors=np.zeros((2, 1)),
        residual=np.array([5.0, 1.0]),
    )
    # In units of the scatter of 2 the direction is 100 long.
    size, chance, share = simplicity._one_step(rows, None, np.array([[200.0, 0.0]]))
    if not seen:
        assert (size.tolist(), chance.tolist(), share.tolist()) == ([0.0], [1.0], [0.0])
        return
    assert size[0] == pytest.approx(2.5 / np.sqrt(square))
    # A score of 2.5, to both sides; 6.25 of what is left.
    assert chance[0] == pytest.approx(0.012419331, rel=1e-6)
    assert share[0] == pytest.approx(6.25 / 6.0)


@pytest.mark.parametrize(("reference", "moved"), [(0, False), (1, True)])
def test_a_law_is_one_at_the_level_of_the_curve(reference, moved, monkeypatch):
    asked = []
    monkeypatch.setattr(curve, "replace", lambda thing, **more: SimpleNamespace(**more))
    monkeypatch.setattr(curve, "Direct", lambda data, *rest: asked.append(data) or "direct")
    monkeypatch.setattr(curve, "judged_laws", lambda *given: laws.JudgedLaws([], []))
    rows = SimpleNamespace(
        fit=SimpleNamespace(measurement="data", objective=None),
        material=None,
        elements=[SimpleNamespace(reference=0)],
        expected=None,
    )
    factors = SimpleNamespace(reference=reference, levels=np.array([20.0, 30.0]))
    curve._laws(rows, factors, SimpleNamespace(placed=None), None, None)
    if moved:
        assert asked[0].reference == pytest.approx(303.15)
    else:
        assert asked == ["data"]


@pytest.mark.parametrize(
    ("column", "wanted", "number", "noted"),
    [
        ("temperature", None, 2, False),
        ("temperature", 20.0 + ROOM, 1, False),
        ("temperature", 20.01 + ROOM, 1, True),
        ("temperature", 26.0, 2, True),
        ("strain", 20.2, 1, False),
        ("strain", 20.3, 1, True),
        ("strain", 19.81, 1, False),
        ("strain", 19.7, 1, True),
    ],
)
def test_the_reference_is_the_nearest_level_that_was_measured(column, wanted, number, noted):
    factors = SimpleNamespace(column=column, levels=np.array([10.0, 20.0, 30.0]), reference=2)
    found, notes = curve._reference(factors, wanted)
    assert (found, bool(notes)) == (number, noted)
    if noted:
        assert notes[0].startswith("nothing was measured at")


OMEGA = np.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("omega", "conditions", "says"),
    [
        (OMEGA, {"strain": OMEGA}, ""),
        (OMEGA, {"force": OMEGA}, "no column 'strain' to shift by; the data have force: name one"),
        (OMEGA, {}, "no column 'strain' to shift by; the data have no condition at all"),
        (np.ones(3), {"strain": OMEGA}, "all points have one frequency"),
    ],
)
def test_sweeps_at_levels_of_a_column_are_shifted(omega, conditions, says):
    data = Measurement(omega, omega + 1j, conditions=conditions, name="made")
    if not says:
        curve._check(data, "strain")
        return
    with pytest.raises(DataError, match=says):
        curve._check(data, "strain")


def test_an_error_is_relative_at_each_point():
    data = SimpleNamespace(points=None, stiffness=np.array([1.0 + 0j, 100.0 + 0j]))
    model = SimpleNamespace(stiffness=lambda theta, points: np.array([1.3, 60.0]))
    fitted = SimpleNamespace(measurement=data, model=model, theta=None)
    assert curve._error(fitted) == pytest.approx(np.sqrt((0.09 + 0.16) / 2.0))


@pytest.mark.parametrize(
    ("value", "vertical", "told"),
    [
        (1.0, False, False),
        (2.0, False, False),
        (2.1, False, True),
        (0.9, False, True),
        (9.0, True, False),
    ],
)
def test_a_law_without_vertical_factors_is_told_where_it_is_another(value, vertical, told):
    parameter = SimpleNamespace(name="Ea", unit=SimpleNamespace(label="kJ/mol"))
    law = SimpleNamespace(
        vertical=vertical, name="Arrhenius", element=SimpleNamespace(parameters=[parameter])
    )
    best = SimpleNamespace(law=law, low=np.array([1.0]), high=np.array([2.0]))
    alone = np.array([value]), np.array([value - 0.5]), np.array([value + 0.5])
    said = curve._without_vertical([best], lambda element: alone)
    assert bool(said) == told
    if told:
        shown = [number(each, 4) for each in (value, value - 0.5, value + 0.5)]
        assert "has Ea {} [{}, {}] kJ/mol".format(*shown) in said[0]
    assert curve._without_vertical([], None) == []


def test_a_level_exceeds_by_squares_of_its_own_scatter_and_where_that_is_unknown_by_none():
    """Three levels: of one degree of freedom, of half a one, and one with too few points."""
    rows = SimpleNamespace(
        level_of_row=np.array([0, 0, 1, 1, 2, 2]),
        residual=np.array([3.0, 1.0, 2.0, 2.0, 9.0, 9.0]),
        scale=np.array([1.0, 1.0, 1.0, 1.0, 2.0, 4.0]),
    )
    alone = SimpleNamespace(
        cost=np.array([4.0, 1.0, 9.0]),
        dof=np.array([2.0, 0.5, 0.0]),
        judged=np.array([True, True, False]),
    )
    # Without a scatter of its own it is the common one; of less than one degree it counts as one.
    np.testing.assert_allclose(simplicity._variance(alone, rows), [2.0, 1.0, 10.0])
    np.testing.assert_allclose(simplicity._excess(alone, rows), [10.0 / 2.0 - 2.0, 8.0 - 0.5, 0.0])


NEARLY, ADDED, ALARM = VERDICT.agrees, SUPERPOSITION.added, VERDICT.structure_alarm


@pytest.mark.parametrize(
    ("chance", "missed", "shared", "own", "verdict"),
    [
        (ALARM, [], 0.5, 0.1, "simple"),
        # A part that is missed leaves it nearly simple at best.
        (ALARM, ["loss"], 0.5, 0.1, "not-simple"),
        (0.5 * ALARM, [], 0.99 * NEARLY * 0.1, 0.1, "nearly-simple"),
        (0.5 * ALARM, [], 1.01 * NEARLY * 0.1, 0.1, "not-simple"),
        (0.5 * ALARM, [], 0.9 * ADDED, 1e-6, "nearly-simple"),
        (0.5 * ALARM, [], 1.1 * ADDED, 1e-6, "not-simple"),
    ],
)
def test_one_curve_is_simple_nearly_or_not(monkeypatch, chance, missed, shared, own, verdict):
    """By chance, or by a loss that is small beside the noise or by itself."""
    judged, error, alone_error = np.ones(2, dtype=bool), np.zeros(2), np.ones(2)
    for name in ("_levels", "_storage_and_loss", "_branches", "_no_material"):
        monkeypatch.setattr(simplicity, name, lambda *_: [])
    monkeypatch.setattr(simplicity, "_missed_parts", lambda *_: missed)
    monkeypatch.setattr(simplicity, "_chance", lambda *_: chance)
    monkeypatch.setattr(simplicity, "_relative", lambda *_: np.full(3, 0.2))
    monkeypatch.setattr(simplicity, "_level_errors", lambda *_: error)
    monkeypatch.setattr(
        simplicity, "_mean", lambda rows, values, which: shared if values is error else own
    )
    alone = SimpleNamespace(judged=judged, error=alone_error)
    rows = SimpleNamespace(elements=[SimpleNamespace(shown=np.array([20.0, 40.0]))])
    found = simplicity.simplicity(rows, alone)
    assert (found.verdict, found.error, found.alone) == (verdict, pytest.approx(0.2), own)
    assert found.added == pytest.approx(np.sqrt(shared**2 - own**2))
    assert list(found.failures) == missed


def test_a_curve_is_drawn_in_the_columns_of_its_tests():
    """Over the time 1 / omega a relaxation, which is real; over omega storage and loss."""
    omega, values = np.array([0.5, 4.0]), np.array([3.0 + 1.0j, 5.0 + 2.0j])
    over = curve.MasterCurve.drawn
    time, relaxed = over(SimpleNamespace(columns=("time", "relaxation")), omega, values)
    assert (time.tolist(), relaxed.tolist()) == ([2.0, 0.25], [3.0, 5.0])
    columns = over(SimpleNamespace(columns=("omega", "storage", "loss")), omega, values)
    assert [column.tolist() for column in columns] == [[0.5, 4.0], [3.0, 5.0], [1.0, 2.0]]
