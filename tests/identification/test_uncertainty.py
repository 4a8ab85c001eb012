"""Intervals: they cover the truth as often as they say, and say so where the data give none."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from native_problems import OMEGA, noisy, setup
from scipy.optimize import least_squares

from soaked import soaked
from springpot.distributions import autoregressive, effective_share, student
from springpot.identification import (
    Uncertainty,
    bootstrap,
    fit,
    fitting,
    held_material,
    identify,
    intervals,
    profile,
)
from springpot.measurement import Measurement
from springpot.registry import parse_model

TRIALS = 300


@pytest.mark.soak
@pytest.mark.parametrize(
    ("name", "given"),
    [
        pytest.param("fractional-kelvin", True, id="fractional-kelvin-given-sd"),
        pytest.param("fractional-zener", False, id="fractional-zener-scatter"),
        soaked("fractional-kelvin", False, id="fractional-kelvin-scatter"),
        soaked("fractional-zener", True, id="fractional-zener-given-sd"),
    ],
)
def test_coverage_is_that_of_the_level(name, given, rng):
    model, theta, data = setup(name)
    sd = 0.004 * data.magnitude
    inside = np.zeros(len(theta))
    for _ in range(TRIALS):
        measured = noisy(data.stiffness, 0.004, rng)
        found = fit(model, Measurement(OMEGA, measured, sd=sd * (1 + 1j) if given else None))
        low, high = Uncertainty.of(found).interval()
        inside += (low <= theta) & (theta <= high)
    # Three standard errors of a binomial proportion around 0.95.
    assert inside / TRIALS == pytest.approx(0.95, abs=3.0 * np.sqrt(0.95 * 0.05 / TRIALS))


def _remembering(memory, rng, points=30):
    """A fractional Zener body in noise of 1 % that goes on from point to point."""
    model, omega = parse_model("fractional-zener"), np.geomspace(0.1, 1e3, points)
    noise = autoregressive(rng.normal(size=(2, points)), memory)
    exact = model.stiffness(TRUTH, omega)
    return fit(model, Measurement(omega, exact * (1.0 + 0.01 * (noise[0] + 1j * noise[1]))))


TRUTH = np.array([1e6, 4e6, 2e6, 0.5])


def test_errors_that_go_on_from_point_to_point_widen_intervals(rng):
    known = Uncertainty.of(_remembering(0.8, rng, 60))
    assert known.memory == pytest.approx(0.8, abs=0.15)
    white = replace(known, memory=0.0)
    wider = np.diag(known.covariance) / np.diag(white.covariance)
    assert np.all((wider > 3.0) & (wider < 1.5 / effective_share(known.memory)))
    assert known.widening(3) == pytest.approx(wider[3], rel=0.3)
    assert known.quantile > white.quantile
    drawn = intervals._errors(known.fit, 200, rng).real
    assert np.mean(drawn[:, 1:] * drawn[:, :-1]) > 0.6 * np.mean(drawn**2)


@pytest.mark.soak
@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8])
def test_intervals_cover_the_truth_beside_a_memory(memory, rng):
    inside = []
    for _ in range(TRIALS):
        low, high = Uncertainty.of(_remembering(memory, rng)).interval()
        inside.append((low <= TRUTH) & (high >= TRUTH))
    assert 0.91 < np.mean(inside) < 0.98


@pytest.fixture
def found(rng):
    model, _, data = setup("fractional-kelvin")
    return fit(model, Measurement(OMEGA, noisy(data.stiffness, 0.01, rng)))


def test_profile_agrees_with_the_jacobian_where_the_model_is_nearly_linear(found):
    low, high = Uncertainty.of(found).interval()
    for i, name in enumerate(found.model.names):
        ends = profile(found, name)
        assert ends == pytest.approx((low[i], high[i]), rel=0.01)
        assert ends[0] < found.theta[i] < ends[1]


def test_profile_ends_where_the_objective_has_risen_enough(found):
    low, _ = profile(found, "alpha")
    held = parse_model("fractional-kelvin")
    allowed = found.cost * (1.0 + student(0.95, found.dof) ** 2 / found.dof)
    base = found.measurement
    weights = found.objective.weights(base)
    design = np.stack([np.ones(len(OMEGA), dtype=complex), (1j * OMEGA) ** low])
    rows = np.concatenate([design.real * weights.real, design.imag * weights.imag], axis=1)
    target = np.concatenate(
        [base.stiffness.real * weights.real, base.stiffness.imag * weights.imag]
    )
    best = np.linalg.lstsq(rows.T, target, rcond=None)[1][0]
    assert held.names[2] == "alpha"
    assert best == pytest.approx(allowed, rel=1e-3)


def test_the_profile_of_a_springpot_s_constant_holds_the_constant_itself(rng):
    # The solver's coordinate, c omega^alpha, would let c move with alpha; far from linear the two
    # differ much.
    model, _, data = setup("fractional-maxwell")
    found = fit(model, Measurement(OMEGA, noisy(data.stiffness, 0.05, rng)))
    allowed = found.cost * (1.0 + student(0.95, found.dof) ** 2 / found.dof)
    for end in profile(found, "c"):

        def rest(x, end=end):
            difference = (
                model.stiffness(np.array([x[0], end, x[1]]), OMEGA) / found.measurement.stiffness
                - 1.0
            )
            return np.concatenate([difference.real, difference.imag])

        best = least_squares(
            rest, found.theta[[0, 2]], x_scale=[100.0, 0.1], xtol=1e-12, ftol=1e-12
        )
        assert 2.0 * best.cost == pytest.approx(allowed, rel=2e-3)


def test_bootstrap_spread_agrees_with_the_jacobian(found, rng):
    drawn = bootstrap(found, 500, rng)
    low, high = np.percentile(drawn, [2.5, 97.5], axis=0)
    ends = Uncertainty.of(found).interval()
    assert drawn.shape == (500, 3)
    assert high - low == pytest.approx(ends[1] - ends[0], rel=0.3)


def test_bootstrap_is_the_same_for_the_same_seed(found):
    one, other = (bootstrap(found, 20, np.random.default_rng(1)) for _ in range(2))
    assert one.tobytes() == other.tobytes()


def test_what_the_data_do_not_determine_has_no_end():
    # In series with another spring only the sum of the two compliances can be seen.
    model = parse_model("fractional-maxwell + series-spring")
    theta = model.vector(dict(zip(model.names, [400.0, 150.0, 0.6, 800.0], strict=True)))
    known = Uncertainty.of(fit(model, Measurement(OMEGA, model.stiffness(theta, OMEGA))))
    low, high = known.interval()
    lost = [
        i
        for i, p in enumerate(model.parameters)
        if p.unit.stiffness and not isinstance(p.unit.time, str)
    ]
    assert np.all(np.isinf(high[lost]))
    assert np.all(low[lost] == 0.0)
    assert np.all(np.isfinite(high[[1, 2]]))


@pytest.mark.parametrize("seed", [2, 3, 9])
def test_a_parameter_that_is_zero_has_a_one_sided_interval(seed):
    # The data are those of a Maxwell element: the parallel spring of the Zener model is not there.
    _, _, data = setup("fractional-maxwell")
    zener = parse_model("fractional-zener")
    found = fit(zener, Measurement(OMEGA, noisy(data.stiffness, 0.01, np.random.default_rng(seed))))
    assert found.theta[0] < 1e-6
    low, high = Uncertainty.of(found).interval()
    assert low[0] == 0.0
    assert profile(found, "k1")[0] == 0.0
    assert profile(found, "k1")[1] == pytest.approx(high[0], rel=0.4)


def test_intervals_of_positive_parameters_stay_positive_and_orders_in_bounds(rng):
    model, theta, _ = setup("fractional-zener")
    omega = OMEGA[::4]
    for seed in range(20):
        measured = noisy(model.stiffness(theta, omega), 0.05, np.random.default_rng(seed))
        low, high = Uncertainty.of(fit(model, Measurement(omega, measured))).interval()
        assert np.all(low >= 0.0)
        assert high[3] <= 1.0


@pytest.mark.parametrize(
    ("dof", "expected"),
    [(1, 12.7062), (2, 4.30265), (3, 3.18245), (10, 2.22814), (100, 1.98397), (np.inf, 1.95996)],
)
def test_student_quantiles(dof, expected):
    # Tabulated values, to the digits that tables have.
    assert student(0.95, dof) == pytest.approx(expected, rel=3e-6)


def test_no_degrees_of_freedom_no_interval():
    model, _, data = setup("fractional-zener")
    known = Uncertainty.of(fit(model, data.subset(np.array([0, 13]))))
    low, high = known.interval()
    assert np.all(low[:3] == 0.0)
    assert np.all(np.isinf(high[:3]))


def test_draws_of_a_parameter_that_is_as_good_as_zero_reach_down_to_its_bound(monkeypatch):
    """No two fits stop at the same tiny number."""
    parameters = parse_model("zener").parameters
    theta = np.array([1e-12, 3.0, 1e12])
    drawn = theta * np.array([[2.0, 0.9, 0.5], [3.0, 1.1, 0.6]])
    monkeypatch.setattr(fitting, "bootstrap", lambda *given: drawn)
    fit = SimpleNamespace(theta=theta, model=SimpleNamespace(parameters=parameters))
    known = SimpleNamespace(specimens=None, level=1.0, fit=fit, at_bound=np.array([-1, 0, 1]))
    low, high, _ = fitting._interval(known, "bootstrap", 0)
    assert low == pytest.approx([parameters[0].lower, 2.7, 0.5e12])
    assert high == pytest.approx([3e-12, 3.3, parameters[2].upper])


def test_where_slopes_say_little_the_interval_is_that_of_the_profile():
    """Of a peak of which half was measured, slopes know the shape at the fit alone."""
    rng = np.random.default_rng(2)
    omega = np.geomspace(0.05, 3.0, 17)
    model = parse_model("havriliak-negami")
    truth = model.picked({"k0": 2.0, "k1": 9.0, "tau": 1.4, "alpha": 0.6, "gamma": 0.65})
    noise = 1.0 + 0.005 * (rng.normal(size=17) + 1j * rng.normal(size=17))
    found = identify(Measurement(omega, model.stiffness(truth, omega) * noise), model)
    gamma = model.names.index("gamma")
    assert found.uncertainty.interval()[1][gamma] < truth[gamma] < found.high[gamma]
    assert found.high[gamma] == pytest.approx(profile(found.uncertainty.fit, "gamma")[1])


def test_of_computed_data_no_profile_is_sought(monkeypatch):
    """Their objective rises by rounding alone, and each profile took longer than the fit."""
    monkeypatch.setattr(held_material, "profiled", None)
    model, omega = parse_model("prony-3"), np.geomspace(0.1, 100.0, 15)
    theta = model.theta(k0=10.0, k1=20.0, tau1=0.05, k2=30.0, tau2=0.5, k3=10.0, tau3=5.0)
    found = identify(Measurement(omega, model.stiffness(theta, omega)), model)
    assert found.relative_rms < 1e-9
