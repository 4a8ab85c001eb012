"""Parameters that follow from others, ``k2 = 2*k1``, or keep an order, ``tau1 < tau2``."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.constraints import owning
from springpot.distributions import student
from springpot.errors import ModelError
from springpot.measurement import TimeTest
from springpot.rheology.points import Points

OMEGA = np.geomspace(0.01, 100.0, 30)
TRUTH = {"k1": 3.0, "tau1": 10.0, "k2": 6.0, "tau2": 0.1}


@pytest.fixture(scope="module")
def sweep():
    """Two modes, the slower one first and twice as soft; 1 % noise."""
    model, rng = springpot.parse_model("maxwell-2"), np.random.default_rng(1)
    noise = 0.01 * (rng.normal(size=30) + 1j * rng.normal(size=30))
    exact = model.stiffness(model.vector(TRUTH), OMEGA)
    return springpot.Measurement(OMEGA, exact * (1.0 + noise))


@pytest.mark.parametrize(
    ("ties", "theta"),
    [
        (["k2 = 2*k1", "tau2 < tau1"], [3.0, 10.0, 0.01]),
        (["k1 = k2*exp(-tau2/tau1)", "tau1 = sqrt(k2) + tau2^1.5"], [6.0, 0.1]),
        (["tau2 < 0.5*tau1"], [3.0, 10.0, 6.0, 0.4]),
    ],
)
def test_derivatives_are_exact(ties, theta):
    """Against central differences."""
    model, at = springpot.parse_model("maxwell-2").tying(ties), Points.at(OMEGA)
    exact = model.jacobian(np.array(theta), at)
    for i, value in enumerate(theta):
        steps = np.array(theta)[:, None] + 1e-6 * value * np.outer(np.eye(len(theta))[i], [-1, 1])
        low, high = model.stiffness(steps.T, at)
        assert exact[:, i] == pytest.approx((high - low) / (2e-6 * value), rel=1e-6, abs=1e-8)


def test_what_is_tied_follows_with_its_interval(sweep):
    tied = springpot.identify(sweep, "maxwell-2", tie="k2 = 2*k1")
    first, second = tied["k1"], tied["k2"]
    assert second.value == pytest.approx(2.0 * first.value)
    assert (second.low, second.high) == pytest.approx((2.0 * first.low, 2.0 * first.high))
    assert str(second).endswith("(k2 = 2*k1)")
    # What is known beforehand makes the rest surer, and costs nothing in the fit where it is true.
    free = springpot.identify(sweep, "maxwell-2")
    slow = free["k1"] if free["tau1"].value > 1.0 else free["k2"]
    assert first.high - first.low < slow.high - slow.low
    assert tied.relative_rms == pytest.approx(free.relative_rms, rel=0.02)


def test_modes_keep_their_order(sweep):
    for tie, slow in (("tau1 < tau2", "2"), ("tau2 < tau1", "1"), ("tau1 > tau2", "1")):
        fit = springpot.identify(sweep, "maxwell-2", tie=tie)
        assert fit[f"tau{slow}"].value == pytest.approx(10.0, rel=0.03)
        assert fit[f"k{slow}"].value == pytest.approx(3.0, rel=0.03)
        assert fit.relative_rms < 0.0121


def test_five_modes_are_sorted_by_one_tie():
    model, rng = springpot.parse_model("prony-5"), np.random.default_rng(2)
    times = [0.01, 0.1, 1.0, 10.0, 50.0]
    theta = [1.0, *(part for time in times for part in (2.0, time))]
    data = model.stiffness(np.array(theta), OMEGA) * (1.0 + 0.001 * rng.normal(size=30))
    tie = "tau5 < tau4 < tau3 < tau2 < tau1"
    fit = springpot.identify(springpot.Measurement(OMEGA, data), model, tie=tie)
    found = [fit[f"tau{i}"].value for i in (5, 4, 3, 2, 1)]
    assert found == pytest.approx(times, rel=0.1)


def test_numbers_are_in_printed_units():
    model = springpot.parse_model("kelvin + inertia")
    theta = model.vector({"k": 100.0, "c": 2.0, "inertia.m": 5e-3})
    units = springpot.Units("kN/m", "mm")
    data = springpot.Measurement(OMEGA, model.stiffness(theta, OMEGA), units=units)
    with pytest.raises(ModelError, match="several parts"):
        springpot.identify(data, model, tie="inertia.m = 0.05*k")
    # A kN s^2/m is 1000 kg: the mass that is free is told in kg, and so is that in a tie.
    fit = springpot.identify(data, "kelvin", tie="c = 10 - 0.08*k", bounds={"k": (0.0, 200.0)})
    assert fit["c"].value == pytest.approx(10.0 - 0.08 * fit["k"].value)
    assert fit["k"].value < 125.0  # beyond it c would be negative


def test_bounds_of_what_is_tied_are_kept(sweep):
    fit = springpot.identify(sweep, "maxwell-2", tie="k2 = 2*k1", bounds={"k2": (0.0, 5.0)})
    assert fit["k2"].value == pytest.approx(5.0)
    assert fit["k1"].value == pytest.approx(2.5)


def test_another_parameter_may_have_bounds_far_from_its_natural_size(sweep):
    """What is free is no tied one: at its bound it has a slope."""
    free = springpot.identify(sweep, "maxwell-2", tie="k2 = 2*k1")
    tau = free["tau1"].value
    bounds = {"tau1": (0.99 * tau, 1.01 * tau)}
    kept = springpot.identify(sweep, "maxwell-2", tie="k2 = 2*k1", bounds=bounds)
    assert kept["tau1"].value == pytest.approx(tau, rel=1e-6)
    outside = springpot.identify(
        sweep, "maxwell-2", tie="k2 = 2*k1", bounds={"tau1": (1.5 * tau, 2.0 * tau)}
    )
    assert outside["tau1"].value == pytest.approx(1.5 * tau)


def test_each_level_has_its_own_tied_parameter():
    model, batches = springpot.parse_model("zener"), (1.0, 1.1, 1.2)
    sweeps = [model.stiffness(model.theta(k1=k, k2=2 * k, c=3.0), OMEGA) for k in batches]
    batch = {"batch": np.repeat([1.0, 2.0, 3.0], len(OMEGA))}
    data = springpot.Measurement(np.tile(OMEGA, 3), np.concatenate(sweeps), conditions=batch)
    fit = springpot.identify(data, model, tie="k2 = 2*k1", own={"k1": "batch"})
    assert [fit[f"k2_{i}"].value for i in (1, 2, 3)] == pytest.approx([2.0, 2.2, 2.4], rel=1e-5)


def specimens(count):
    """Zener specimens of which the second spring is twice the first."""
    rng, omega = np.random.default_rng(2), np.tile(np.geomspace(1.0, 300.0, 12), count)
    k, c = (size * np.exp(0.1 * rng.standard_normal(count)).repeat(12) for size in (100.0, 1.0))
    exact = k + 2 * k * 1j * omega * c / (2 * k + 1j * omega * c)
    exact *= 1.0 + 0.003 * rng.standard_normal((2, len(omega))).T @ [1.0, 1j]
    return springpot.Measurement(
        omega, exact, conditions={"specimen": np.arange(1.0, count + 1).repeat(12)}
    )


@pytest.mark.parametrize("own", [("k1", "c"), ("k1", "k2", "c"), ("k2", "c"), "*"])
def test_what_is_tied_is_each_level_s_own_with_what_it_follows_from(own):
    data = specimens(4)
    fit = springpot.identify(data, "zener", tie="k2 = 2*k1", own=dict.fromkeys(own, "specimen"))
    names = [f"{name}_{i}" for name in ("k1", "c") for i in range(1, 5)]
    assert sorted(fit.model.names) == sorted(names)
    for i in range(1, 5):
        one, two = fit[f"k1_{i}"], fit[f"k2_{i}"]
        assert (two.value, two.low, two.high) == pytest.approx(
            (2 * one.value, 2 * one.low, 2 * one.high)
        )
    first, second = fit.populations["k1"], fit.populations["k2"]
    assert second.mean.value == pytest.approx(2.0 * first.mean.value)
    assert second.between.value == first.between.value
    assert [each.value for each in fit.values_by_level("k2")] == [
        fit[f"k2_{i}"].value for i in range(1, 5)
    ]
    assert second.specimens["3"] == pytest.approx(2.0 * first.specimens["3"])


def test_a_tie_of_what_is_own_and_what_is_shared_has_the_interval_of_both():
    fit = springpot.identify(specimens(4), "zener", tie="k2 = k1 + 40*c", own={"k1": "specimen"})
    names = fit.model.names
    i, j = names.index("k1_2"), names.index("c")
    spread = fit.covariance[i, i] + 80.0 * fit.covariance[i, j] + 1600.0 * fit.covariance[j, j]
    reach = student(0.95, fit.dof) * np.sqrt(spread) / fit["k2_2"].value
    assert np.log(fit["k2_2"].high / fit["k2_2"].value) == pytest.approx(reach, rel=1e-6)
    # Its errors are part of the population's: what all share is no scatter.
    assert fit.populations["k2"].mean.value > fit.populations["k1"].mean.value


def test_an_order_is_each_level_s_own_by_its_share():
    model = springpot.parse_model("prony-2").tying(["tau1 < tau2"])
    own, _ = owning(model, [specimens(3)], {"tau1": "specimen"})
    assert own.own == {"tau1/tau2": "specimen"}


def test_tests_in_time_know_ties_too():
    model, t = springpot.parse_model("prony-2"), np.geomspace(0.01, 30.0, 60)
    theta = model.theta(k0=1.0, k1=2.0, tau1=0.3, k2=4.0, tau2=3.0)
    noise = 1.0 + 0.01 * np.random.default_rng(3).normal(size=60)
    test = TimeTest.of_relaxation(t, model.relaxation(theta, t) * noise)
    fit = springpot.identify(test, model, tie=["k2 = 2*k1", "tau1 < tau2"])
    assert fit["k2"].low < 4.0 < fit["k2"].high
    assert fit["tau2"].value == pytest.approx(3.0, rel=0.05)


def test_a_kept_fit_is_tied_as_before(sweep, tmp_path):
    fit = springpot.identify(sweep, "maxwell-2", tie=["k2 = 2*k1", "tau2 < tau1"])
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again = springpot.load(path)
    assert again.model.ties == ("k2 = 2*k1", "tau2 < tau1")
    assert again.parameters == fit.parameters
    assert again.predict([1.0]).storage == pytest.approx(fit.predict([1.0]).storage)


def test_without_ties_a_model_is_itself():
    model = springpot.parse_model("prony-2")
    assert model.tying([]) is model
    assert not model.constrained


@pytest.mark.parametrize(
    ("tie", "told"),
    [
        ("k2 = 2*k9", "no free parameter 'k9' .there are: k1, tau1, k2, tau2"),
        ("k9 = 2*k1", "no free parameter 'k9'"),
        ("k1 = k1 + k2", "k1 -> k1: ties go round in a circle"),
        (["k1 = k2", "k2 = k1"], "ties go round in a circle"),
        (["k1 = k2", "k1 > tau1/tau2"], "k1 is tied already"),
        ("k1 = 2", "hold it by fix"),
        ("k1 == k2", "is no tie: write it as"),
        ("k1", "is no tie"),
        ("k1 < tau1", "different units"),
        ("k1 = i*k2", "is real"),
        ("k1 = k2.real", "no attribute"),
        ("k1 = __import__(k2)", "no meaning in a formula|no function"),
        ("k1 = omega*k2", "no free parameter 'omega'"),
        ("tau2 = 3*tau1", "tau1 is held already"),
    ],
)
def test_what_is_no_tie_is_told_in_one_line(sweep, tie, told):
    with pytest.raises(ModelError, match=told) as error:
        springpot.identify(sweep, "maxwell-2", tie=tie, fix={"tau1": 10.0} if "3*" in tie else None)
    assert "\n" not in str(error.value)


def test_a_free_spectrum_has_none(sweep):
    with pytest.raises(ModelError, match="free spectrum"):
        springpot.identify(sweep, "material", tie="K_e = c")
