"""The native solver finds the truth from any seed, in one data set or thousands of any size."""

import numpy as np
import pytest
from native_problems import OMEGA, POINTS, TRUTHS, noisy, random_truths, relative_weights, setup

from springpot.errors import DataError, ModelError, OptionError
from springpot.identification import Effort, fit, fit_batch
from springpot.identification.native import COARSE_POINTS
from springpot.measurement import Measurement
from springpot.registry import parse_model, plugins


@pytest.mark.suite_cases("springpot")
@pytest.mark.parametrize("name", TRUTHS)
def test_noise_free_parameters_are_exact_from_a_hundred_seeds(name):
    model, theta, data = setup(name)
    errors = [
        fit(model, data, rng=np.random.default_rng(seed)).theta / theta - 1.0 for seed in range(100)
    ]
    assert np.max(np.abs(errors)) < 1e-6


@pytest.mark.soak_cases("fractional-kelvin4", "fractional-zener")
@pytest.mark.parametrize("name", [name for name in TRUTHS if name != "springpot"])
def test_batch_of_random_truths(name, rng):
    model, theta, stiffness = random_truths(name, 1500, rng)
    found, _ = fit_batch(model, POINTS, stiffness, relative_weights(stiffness))
    assert np.mean(np.max(np.abs(found / theta - 1.0), axis=1) < 1e-6) >= 0.999


@pytest.mark.parametrize("objective", ["paper", "relative", "log"])
def test_every_objective_has_the_same_noise_free_optimum(objective):
    model, theta, data = setup("fractional-zener")
    found = fit(model, data, plugins().find("objective", objective))
    assert found.theta == pytest.approx(theta, rel=1e-6)


@pytest.mark.parametrize("name", ["fractional-maxwell", "fractional-kelvin4", "fractional-zener"])
@pytest.mark.parametrize("objective", ["paper", "relative", "log"])
def test_noisy_optimum_is_no_worse_than_any_found_from_the_truth(name, objective, rng):
    model, theta, data = setup(name)
    measured = Measurement(OMEGA, noisy(data.stiffness, 0.02, rng))
    chosen = plugins().find("objective", objective)
    found = fit(model, measured, chosen)
    from_truth = fit(model, measured, chosen, starts=0, seeds_theta=[theta])
    assert found.cost <= from_truth.cost * (1.0 + 1e-9)
    assert found.cost == pytest.approx(float(found.residual @ found.residual))
    # At an optimum inside the bounds the residuals are orthogonal to every derivative.
    slope = found.jacobian_u.T @ found.residual
    assert np.max(np.abs(slope)) < 1e-6 * found.cost


@pytest.mark.soak
def test_batch_and_single_agree_on_noisy_data(rng):
    model, _, stiffness = random_truths("fractional-kelvin4", 40, rng)
    measured = noisy(stiffness, 0.01, rng)
    _, cost = fit_batch(model, POINTS, measured, relative_weights(measured))
    single = np.array([fit(model, Measurement(OMEGA, row)).cost for row in measured])
    assert np.mean(np.abs(cost / single - 1.0) < 1e-3) >= 0.95


def test_real_weights_of_a_batch_weigh_both_parts(rng):
    model, _, stiffness = random_truths("fractional-kelvin4", 5, rng)
    measured = noisy(stiffness, 0.02, rng)
    real = 1.0 / np.abs(measured)
    theta, cost = fit_batch(model, POINTS, measured, real)
    both = fit_batch(model, POINTS, measured, real * (1.0 + 1.0j))
    np.testing.assert_array_equal(theta, both[0])
    np.testing.assert_array_equal(cost, both[1])
    # Without a weight the loss would be whatever the storage leaves open.
    missed = np.abs(model.stiffness(theta, POINTS) - measured) / np.abs(measured)
    assert np.median(missed) < 0.05
    # One for all data sets, and one for all points.
    np.testing.assert_array_equal(fit_batch(model, POINTS, measured, 2.0)[0].shape, theta.shape)


@pytest.mark.parametrize(
    ("rows", "weights", "says"),
    [
        (0, 1.0, r"stiffness has the shape \(\d+,\): write \(B, \d+\)"),
        (slice(0, 2), np.ones((3, len(OMEGA))), r"weights have the shape \(3, \d+\)"),
        (slice(0, 2), -1.0, "finite and not negative"),
        (slice(0, 2), np.nan, "finite and not negative"),
    ],
)
def test_a_batch_of_another_shape_is_refused_in_one_line(rng, rows, weights, says):
    model, _, stiffness = random_truths("fractional-kelvin4", 3, rng)
    with pytest.raises(OptionError, match=says) as refused:
        fit_batch(model, POINTS, stiffness[rows], weights)
    assert "\n" not in str(refused.value)


def test_jacobian_and_residual_are_those_of_the_objective(rng):
    model, theta, data = setup("fractional-zener")
    measured = Measurement(OMEGA, noisy(data.stiffness, 0.02, rng))
    found = fit(model, measured)
    weights = found.objective.weights(measured)
    residual = found.objective.residual(model.stiffness(found.theta, OMEGA), measured, weights)
    assert found.residual == pytest.approx(residual, rel=1e-9, abs=1e-12)
    step = 1e-6
    for i in range(len(theta)):
        shifted = found.u.copy()
        shifted[i] += step
        moved = found.objective.residual(
            model.stiffness(found.from_u(shifted), OMEGA), measured, weights
        )
        assert found.jacobian_u[:, i] == pytest.approx(
            (moved - residual) / step, rel=1e-3, abs=1e-4
        )
    assert found.to_u(found.from_u(found.u)) == pytest.approx(found.u, abs=1e-12)


def test_same_seed_same_bits():
    model, _, data = setup("fractional-kelvin4")
    first, second = (fit(model, data, rng=np.random.default_rng(7)).theta for _ in range(2))
    assert first.tobytes() == second.tobytes()


def test_a_given_start_is_never_made_worse(rng):
    model = parse_model("fractional-maxwell + inertia")
    theta = model.theta(k=400.0, c=150.0, alpha=0.6, inertia__m=0.02)
    measured = Measurement(OMEGA, noisy(model.stiffness(theta, OMEGA), 0.01, rng))
    start = theta * 1.05
    before = float(
        np.sum(
            np.abs((model.stiffness(start, OMEGA) - measured.stiffness) / measured.magnitude) ** 2
        )
    )
    found = fit(model, measured, starts=0, seeds_theta=[start])
    assert found.cost < before


@pytest.mark.parametrize(
    "expression",
    [
        "fractional-maxwell + inertia",
        "fractional-zener + time-delay",
        "fractional-kelvin + series-spring",
        "burgers",
        "prony-2",
    ],
)
def test_grown_and_classical_models_are_found_too(expression):
    model = parse_model(expression)
    omega = np.geomspace(0.3, 300.0, 25)
    sizes = {"inertia.m": 0.02, "time-delay.tau": 1e-3}
    theta = model.vector({p.name: sizes.get(p.name, _plain(p.name)) for p in model.parameters})
    found = fit(model, Measurement(omega, model.stiffness(theta, omega)))
    fitted, truth = model.stiffness(found.theta, omega), model.stiffness(theta, omega)
    assert np.max(np.abs(fitted / truth - 1.0)) < 1e-9


def _plain(name: str) -> float:
    """A size for a parameter by its name.

    Orders below one, times well apart, the rest of order a hundred.
    """
    last = name.rpartition(".")[2]
    number = int("".join(filter(str.isdigit, last)) or 1)
    if last in ("alpha", "beta", "r", "q"):
        return 0.6 if last != "q" else 0.9
    return 0.003 * 10**number if last.startswith(("tau", "lam")) else 100.0 * 3**number


def test_large_data_are_thinned_and_then_used_whole(rng):
    model, theta, _ = setup("fractional-zener")
    omega = np.geomspace(0.1, 1000.0, 20 * COARSE_POINTS)
    measured = Measurement(omega, noisy(model.stiffness(theta, omega), 0.01, rng))
    found = fit(model, measured)
    whole = fit(model, measured, starts=0, seeds_theta=[theta])
    assert found.cost == pytest.approx(whole.cost, rel=1e-9)
    assert found.theta == pytest.approx(theta, rel=0.01)


def test_ten_points_are_enough():
    model, theta, _ = setup("fractional-zener")
    omega = np.geomspace(1.0, 80.0, 10)
    assert fit(model, Measurement(omega, model.stiffness(theta, omega))).theta == pytest.approx(
        theta, rel=1e-6
    )


@pytest.mark.parametrize("factor", [1e-12, 1e-3, 1e9])
def test_units_do_not_matter(factor):
    model, theta, data = setup("fractional-kelvin4")
    found = fit(model, Measurement(OMEGA, data.stiffness * factor)).theta
    assert found == pytest.approx(theta * np.array([factor, factor, factor, 1.0]), rel=1e-6)


def test_more_unknowns_than_data_is_an_error():
    model = parse_model("fractional-zener")
    data = Measurement(OMEGA[:1], np.array([1.0 + 1.0j]))
    with pytest.raises(
        DataError, match="4 parameters, but there are only 2 numbers in 1 measured point;"
    ):
        fit(model, data)


def test_a_missing_column_is_an_error():
    _, _, data = setup("springpot")
    with pytest.raises(ModelError, match="amplitude"):
        fit(parse_model("maxwell + friction"), data)


def test_bounds_are_never_left(rng):
    model = parse_model("fractional-kelvin")
    # Inertia alone bends the data downwards, which no springpot can follow: the order runs to its
    # bound.
    measured = Measurement(OMEGA, 400.0 + 5.0j * OMEGA**1.3)
    found = fit(model, measured)
    assert 0.0 <= found.theta[2] <= 1.0
    assert np.all(found.theta[:2] >= 0.0)
    assert found.theta[2] == pytest.approx(1.0, abs=1e-9)


def test_a_hopeless_model_is_not_searched_further(rng):
    model, _, data = setup("fractional-zener")
    wrong = parse_model("kelvin")
    whole = fit(wrong, data)
    assert (
        fit(wrong, data, effort=Effort(hopeless=0.1 * whole.cost)).evaluations <= whole.evaluations
    )
    assert fit(model, data, effort=Effort(hopeless=0.0)).cost <= whole.cost


def test_less_effort_stops_within_what_is_negligible(rng):
    model, _, data = setup("fractional-zener")
    measured = Measurement(OMEGA, noisy(data.stiffness, 0.02, rng))
    exact, quick = fit(model, measured), fit(model, measured, effort=Effort(negligible=1e-6))
    assert quick.cost == pytest.approx(exact.cost, rel=1e-5)
    assert quick.evaluations <= exact.evaluations
