"""Small rules of misfits, each at both sides of its edge, with values by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.identification.held_material import parameters_of
from springpot.measurement import Measurement, Units
from springpot.measurement.scatter import Noise
from springpot.misfit import outliers, refit, residual_causes, residual_tests, where
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.frame import able_to_follow
from springpot.thresholds import VERDICT

LEVELS = np.array([1.0, 2.0, 4.0, 8.0])


@pytest.mark.parametrize(
    ("amplitude", "residual", "told"),
    [
        (LEVELS, LEVELS**2, True),
        (LEVELS, -(LEVELS**2), True),
        (np.r_[1.0, 1.1, 1.2, 4.0], np.r_[1.0, 1.1, 1.2, 4.0] ** 2, True),
        (np.r_[2.0, 2.1, 2.2, 5.9], np.r_[2.0, 2.1, 2.2, 5.9] ** 2, False),
        (LEVELS, LEVELS**2 * [1, 1, 1, -1], False),
        (LEVELS, LEVELS**1.5, False),
        (np.r_[-1.0, LEVELS[1:]], LEVELS**2, False),
        (1.0 + 0.01 * LEVELS, (1.0 + 0.01 * LEVELS) ** 2, False),
    ],
)
def test_a_power_of_the_amplitude_is_told_where_levels_are_enough(amplitude, residual, told):
    assert (where._power(amplitude, residual) == where.AMPLITUDE_POWERS[2.0]) == told
    few = where.FEWEST_OF_A_LAW
    wide = 1.0 + where.AMPLITUDES * np.arange(few)
    assert where._power(wide, wide) == where.AMPLITUDE_POWERS[1.0]
    assert where._power(wide[1:], wide[1:]) == ""


def test_products_of_neighbours_are_weighted_by_their_distance():
    first, second, third = np.exp(-0.5 * (np.array([1.0, 2.0, 3.0]) / 3.0) ** 2)
    assert residual_tests.kinship(np.array([2.0, 3.0])) == pytest.approx(6.0 * first)
    assert residual_tests.kinship(np.array([1.0, 2.0, 5.0])) == pytest.approx(
        first * (2.0 + 10.0) + second * 5.0
    )
    assert residual_tests.kinship(np.array([1.0, 0.0, 0.0, 7.0])) == pytest.approx(7.0 * third)
    ninth = np.zeros(9)
    ninth[[0, 7]] = 1.0
    assert residual_tests.kinship(ninth) == 0.0
    both = residual_tests.kinship(np.array([[1.0, 2.0], [3.0, 4.0]]))
    np.testing.assert_allclose(both, [2.0 * first, 12.0 * first])


def framed(rest, weights=1.0):
    """A residual of n points in units of its noise, of which nothing was fitted."""
    n = len(rest) // 2
    omega = np.geomspace(1.0, 10.0, n)
    data = Measurement(omega, np.full(n, 1.0 + 1.0j), name="made")
    return SimpleNamespace(
        measurement=data,
        rest=np.array(rest),
        residual=np.array(rest),
        weights=np.full(n, weights),
        scale_dof=np.inf,
        size=2 * n,
    )


def test_deviations_are_brought_to_full_size_where_curves_follow_them():
    frame = framed([3.0, 1.0, -1.0, 2.0, 0.0, 0.0, 0.0, 1.0])
    # A curve that is the first point of the storage for four fifths, the second for the rest.
    followed = np.zeros((8, 1))
    followed[:2, 0] = np.sqrt([0.8, 0.2])
    left = frame.residual - followed[:, 0] * (followed[:, 0] @ frame.residual)
    expected = left**2 / [0.2, 0.8, 1, 1, 1, 1, 1, 1]
    scaled, _ = outliers._squares(frame, followed, np.arange(4))
    np.testing.assert_allclose(scaled, expected[:4] + expected[4:])
    worst, chance = outliers._worst(frame, followed, np.arange(4))
    assert worst == int(np.argmax(scaled))
    # Chi-square of two degrees of freedom; any of the four might have been it.
    assert chance == pytest.approx(1.0 - (1.0 - np.exp(-0.5 * scaled.max())) ** 4)
    # What curves follow wholly shows nothing.
    followed[:2, 0] = [1.0, 0.0]
    scaled, _ = outliers._squares(frame, followed, np.arange(4))
    assert scaled[0] == 0.0


@pytest.mark.parametrize("scatter", [0.5, 3.0])
def test_noise_is_as_large_as_neighbours_differ(scatter, monkeypatch):
    monkeypatch.setattr(residual_causes, "replace", lambda frame, weights: weights)
    # Second differences of 4 or -4, whose median size is that of a normal scatter of 2.42.
    rest = scatter * np.tile([1.0, -1.0], 20)
    weights = residual_causes._no_rougher(framed(rest, 2.0))
    sigma = 4.0 * scatter / (0.6744897501960817 * np.sqrt(6.0))
    np.testing.assert_allclose(weights, 2.0 / max(sigma, 1.0))
    few = framed(rest[:8], 2.0)
    assert residual_causes._no_rougher(few) is few


def test_the_evidence_of_bumps_is_that_of_normal_coefficients():
    columns = np.array([[2.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    values_ = np.array([3.0, 5.0, 1.0])
    found = residual_causes._evidence_of_bumps(columns, values_, np.array([0.5, 2.0]))
    expected = []
    for size in (0.5, 2.0):
        # Normal values of covariance 1 + size^2 C C^T against those of unit covariance.
        covariance = np.eye(3) + size**2 * columns @ columns.T
        quadratic = values_ @ (np.eye(3) - np.linalg.inv(covariance)) @ values_
        expected.append(0.5 * quadratic - 0.5 * np.log(np.linalg.det(covariance)))
    np.testing.assert_allclose(found, expected)
    doubled = np.hstack([columns, columns[:, :1]])
    found = residual_causes._evidence_of_bumps(doubled, values_, np.array([0.5]))
    covariance = np.eye(3) + 0.25 * doubled @ doubled.T
    quadratic = values_ @ (np.eye(3) - np.linalg.inv(covariance)) @ values_
    assert found == pytest.approx(0.5 * quadratic - 0.5 * np.log(np.linalg.det(covariance)))


def several_currents(count, levels, share):
    """Points of several currents, of whose misfit so much goes with the current."""
    omega = np.tile(np.geomspace(1.0, 10.0, count), levels)
    amperes = np.repeat(np.arange(float(levels)), count)
    rng = np.random.default_rng(1)
    noise = rng.normal(size=len(omega)) + 1j * rng.normal(size=len(omega))
    offset = np.repeat(np.linspace(-1.0, 1.0, levels), count)
    change = 1.0 + 0.01 * (1.0 - share) * noise + 0.05 * share * offset
    return Measurement(
        omega, (100.0 + 2.0j * omega) * change, conditions={"current": amperes}, name="made"
    )


@pytest.mark.parametrize(("share", "told"), [(1.0, True), (0.6, True), (0.0, False)])
def test_a_column_is_behind_a_misfit_of_which_it_takes_most(share, told):
    found = fitted_to_floor(springpot.parse_model("kelvin"), several_currents(6, 3, share))
    column = residual_causes.column_behind(found.frame())
    assert (column is not None) == told
    if column is not None:
        assert (column.name, column.values) == ("current", 3)
        assert VERDICT.takes_most < column.share <= 1.0


def test_as_many_shapes_as_numbers_tell_nothing():
    """Each point of its own current: the shapes follow everything."""
    data = several_currents(1, 9, 1.0)
    data = Measurement(np.geomspace(1.0, 9.0, 9), data.stiffness, conditions=data.conditions)
    found = fitted_to_floor(springpot.parse_model("kelvin"), data)
    assert residual_causes.column_behind(found.frame()) is None


def test_values_are_printed_in_units_of_their_own():
    """A mass beside a stiffness in kN/m and s is in t; it is printed in kg, with its interval."""
    omega = np.geomspace(1.0, 60.0, 12)
    rng = np.random.default_rng(2)
    noise = 1.0 + 0.002 * (rng.normal(size=12) + 1j * rng.normal(size=12))
    k = (100.0 + 2.0j * omega - 0.05 * omega**2) * noise
    model = springpot.parse_model("kelvin + inertia")
    found = fitted_to_floor(model, Measurement(omega, k, units=Units("kN/m", "mm")))
    told = parameters_of(found.known)
    factors = {p.name: found.fit.measurement.units.of(p.unit)[0] for p in model.parameters}
    assert {round(factor, 9) for factor in factors.values()} != {1.0}
    for i, name in enumerate(model.names):
        value = told[name]
        assert value.value == pytest.approx(found.theta[i] * factors[name])
        assert value.low < value.value < value.high
        assert value.high < 1.5 * value.value


FEWEST, MOST = outliers.FEWEST, max(2, int(outliers.OUTLIERS.most * 60))


@pytest.mark.parametrize(
    ("n", "bad", "told"),
    [
        (60, 0, 0),
        (60, 1, 1),
        (60, MOST, MOST),
        (60, MOST + 1, 0),
        (FEWEST, 2, 2),
        (FEWEST - 1, 1, 0),
    ],
)
def test_outliers_are_few_or_none(n, bad, told, monkeypatch):
    """They are set aside one by one; where there are more than a share, none is an outlier."""
    limit = outliers.OUTLIERS.rare

    def worst(frame, followed, rows):
        left = [row for row in rows if row < bad]
        return (left[-1], limit) if left else (int(rows[0]), 1.01 * limit)

    monkeypatch.setattr(outliers, "_worst", worst)
    frame = SimpleNamespace(
        measurement=np.zeros(n), absorbed=np.zeros((2 * n, 1)), smooth=np.zeros((2 * n, 1))
    )
    assert outliers.outlying(frame).tolist() == list(range(told))


def test_two_neighbours_in_a_sweep_are_side_by_side_and_ends_have_two_rows():
    omega = np.tile(np.geomspace(1.0, 10.0, 6), 2)
    data = Measurement(omega, omega + 1j, conditions={"amplitude": np.repeat([1.0, 2.0], 6)})
    for rows, both in (([1, 2], True), ([1, 3], False), ([5, 6], False), ([0], False)):
        assert outliers.side_by_side(data, np.array(rows)) == both
    end = outliers.END
    for rows, beside in (([0], range(end)), ([3], ()), ([11], range(12 - end, 12))):
        assert outliers.ends_beside(data, np.array(rows)).tolist() == list(beside)


def test_a_row_pulls_that_carries_most_of_what_a_fit_leaves():
    n, carries = 12, outliers.OUTLIERS.carries

    def framed(absorbed, rest):
        return SimpleNamespace(
            measurement=np.zeros(n), absorbed=np.array(absorbed), rest=np.array(rest)
        )

    rest = np.zeros(2 * n)
    rest[[3, n + 3]] = 1.0
    free, others = np.zeros((2 * n, 1)), np.arange(2 * n) % n != 3
    # Of what is left the row carries just the share, or a little more.
    for factor, rows in ((1.01, []), (0.99, [3])):
        rest[others] = factor * np.sqrt((2.0 / carries - 2.0) / others.sum())
        assert outliers.pulling([framed(free, rest)]).tolist() == rows
    # Parameters follow nine tenths of another's storage, which is ten times as far off.
    rest[others] = 0.0
    rest[5] = 0.5
    followed = free.copy()
    followed[5] = np.sqrt(0.9)
    assert outliers.pulling([framed(followed, rest)]).tolist() == [5]
    # Of several fits that counts in which a row carries most.
    assert outliers.pulling([framed(free, rest), framed(followed, rest)]).tolist() == [5]
    assert outliers.pulling([framed(followed[:, :0], 0.0 * rest)]).tolist() == []


@pytest.mark.parametrize(("lines", "told"), [(6, False), (7, True)])
def test_a_ripple_needs_lines_beyond_those_that_the_parameters_follow(monkeypatch, lines, told):
    """One parameter follows the four slowest, and a period spreads over two of its neighbours."""
    power = np.zeros(lines)
    power[5] = 1e4
    monkeypatch.setattr(where, "scales", lambda dof: np.ones(8))
    monkeypatch.setattr(where, "spectrum", lambda data, rows: np.ones((len(rows), lines)) * 1e-3)
    frame = SimpleNamespace(
        measurement=None, rest=np.zeros(9), absorbed=np.zeros((9, 1)), scale_dof=9, size=9
    )
    assert where._period(frame, np.random.default_rng(0)) == (0.0, 0.0)
    monkeypatch.setattr(
        where, "spectrum", lambda data, rows: power[None] if len(rows) == 1 else power[None] * 1e-4
    )
    assert (where._period(frame, np.random.default_rng(0))[0] > 0.0) is told


def test_a_ripple_is_looked_for_between_the_lines_beside_the_strongest(monkeypatch):
    """Of 40 half waves along a sweep the 20th has a period of four points."""
    power, asked = np.full(41, 1e-3), []
    power[20] = 1e4
    monkeypatch.setattr(outliers, "sweeps_of", lambda data: [None])
    monkeypatch.setattr(
        outliers,
        "spectrum",
        lambda data, rows: power[None] if len(rows) == 1 else 0.0 * power[None],
    )
    monkeypatch.setattr(
        outliers,
        "_energy_of_ripples",
        lambda frame, curves, left, x: asked.append(x) or -abs(x - 4.0),
    )
    scatter = SimpleNamespace(kept=np.ones(82, bool), left=np.ones(82), variance=1.0)
    frame = SimpleNamespace(measurement=None)
    assert outliers._ripple(frame, np.zeros((82, 2)), scatter) == pytest.approx(4.0, rel=1e-3)
    assert 80.0 / 21.0 < asked[0].min() < 3.85
    assert 4.15 < asked[0].max() < 80.0 / 19.0


@pytest.mark.parametrize(
    ("pattern", "one", "together"),
    [("fixed", True, True), ("fixed", False, False), ("", True, False)],
)
def test_all_sweeps_tell_of_causality_together_where_one_curve_is_all_that_is_left(
    pattern, one, together, monkeypatch
):
    asked = []
    sweeps = [SimpleNamespace(rows=np.arange(3)), SimpleNamespace(rows=np.arange(3, 6))]
    for name, value in {
        "sweeps_of": lambda data: sweeps,
        "_curve": lambda frame, x: None,
        "_is_one": lambda frame, curve: one,
        "_no_rougher": lambda frame: frame,
        "causal_evidence": lambda frame, x, groups: asked.append(len(groups)) or 1e9,
    }.items():
        monkeypatch.setattr(residual_causes, name, value)
    frame = SimpleNamespace(measurement=SimpleNamespace(omega=np.arange(1.0, 7.0)))
    residual_causes._causality(frame, pattern, None)
    assert asked == [1 if together else 2]


def test_noise_of_another_size_alone_asks_for_no_search(monkeypatch):
    omega = np.geomspace(1.0, 60.0, 12)
    rng = np.random.default_rng(2)
    stiffness = (100.0 + 2.0j * omega) * (1.0 + 0.01 * rng.normal(size=12))
    found = fitted_to_floor(springpot.parse_model("maxwell"), Measurement(omega, stiffness))
    larger = found.noise.scaled(3.0)
    searched = refit.refit(found.model, found.data, larger, [found.theta])
    shaped = Noise(found.noise.sd * np.linspace(1.0, 2.0, 12), found.noise.dof, "estimated")
    asked = []
    monkeypatch.setattr(refit, "refit", lambda *rest: asked.append(rest))
    again = refit.in_noise(found, larger)
    assert again.rss == pytest.approx(found.rss / 9.0) == pytest.approx(searched.rss, rel=1e-9)
    assert again.noise is larger
    np.testing.assert_allclose(again.frame().residual, found.frame().residual / 3.0)
    np.testing.assert_allclose(again.fit.residual, found.fit.residual / 3.0)
    refit.in_noise(found, shaped)
    refit.in_noise(replace(found, fit=replace(found.fit, converged=False)), larger)
    assert [rest[2] for rest in asked] == [shaped, larger]


@pytest.mark.parametrize(
    ("theta", "left", "free"),
    [
        ([2.0, 0.5], [1.0, 1.0], [True, True]),
        # Downhill lies beyond the upper end of an order, and then on its way back.
        ([2.0, 1.0], [1.0, 1.0], [True, False]),
        ([2.0, 1.0], [1.0, -1.0], [True, True]),
        ([2.0, 0.0], [1.0, -1.0], [True, False]),
        # A size that has gone to nothing changes nothing.
        ([1e-9, 0.5], [1.0, 1.0], [False, True]),
    ],
)
def test_what_a_bound_holds_follows_nothing(theta, left, free):
    model = springpot.parse_model("springpot")
    slopes, curve = np.eye(2), np.array([3.0, 4.0])
    found = able_to_follow(model, np.array(theta), np.array(left), slopes, curve)
    assert found.tolist() == free
