"""The suggested measurement: what it promises is what a fit to old and new points leaves."""

import re

import numpy as np
import pytest
from hidden_data import AMPLITUDES, KELVIN, SWEEP, design, hidden, measured

import springpot
from springpot.diagnosis import examine
from springpot.diagnosis.evidence import best_with
from springpot.diagnosis.experiment import (
    Contest,
    actions,
    next_experiment,
    planned_sweep,
    promise,
    separation,
)
from springpot.measurement import Measurement
from springpot.misfit.error import plain
from springpot.misfit.residuals_of_tests import SweepPart
from springpot.registry import plugins
from springpot.rheology.points import complex_form, real_form


def explained(effect, at=SWEEP, chi2=200.0):
    """The case, and the best fitted model with each effect."""
    library = list(plugins().items("effect"))
    case = examine(
        hidden(KELVIN, at, effect, chi2),
        springpot.parse_model(KELVIN.name),
        library,
        np.random.default_rng(0),
    )
    return case, best_with(case.search)


def upwards(measurement):
    return next(action for action in actions(measurement) if "upwards" in action.says)


def clash(truth, rival, action):
    """Two explanations after an action: one holds, the other may follow it."""
    made = SweepPart(truth.fit.measurement, noise=real_form(truth.noise.sd))
    return Contest(truth, rival, (made, planned_sweep(action, made, truth)))


def refitted(truth, rival, action):
    """The same separation, from a fit of the rival to noise-free old and new points.

    The identification layer fits.
    """
    old = truth.fit.measurement
    new = truth.model.stiffness(truth.theta, action.points)
    level = np.median(truth.noise.sd.real / np.abs(truth.stiffness))
    sd = np.concatenate([truth.noise.sd, level * np.abs(new) * (1 + 1j)])
    omega = np.concatenate([old.omega, np.exp(action.points.log_omega)])
    both = Measurement(omega, np.concatenate([truth.stiffness, new]), sd=sd, units=old.units)
    fit = springpot.identify(both, rival.model, objective="weighted")
    off = rival.model.stiffness(fit.theta, both.points) - both.stiffness
    return np.sqrt(np.sum((off.real / sd.real) ** 2 + (off.imag / sd.imag) ** 2))


@pytest.mark.soak
def test_the_fitted_separation_is_that_of_an_independent_fit():
    case, best = explained("inertia")
    action = upwards(case.search.base.fit.measurement)
    for truth, rival in (("inertia", "specimen-inertia"), ("specimen-inertia", "inertia")):
        promised = clash(best[truth], best[rival], action).fitted()
        assert promised == pytest.approx(refitted(best[truth], best[rival], action), rel=0.05)
        assert promised > 5.0


@pytest.mark.soak
def test_a_rival_far_from_its_parameters_follows_further_than_its_slopes_tell():
    case, best = explained("time-delay")
    action = upwards(case.search.base.fit.measurement)
    both = best["time-delay"], best["fixture-resonance"]
    contest = clash(*both, action)
    assert contest.fitted() < 0.7 * contest.linear
    assert contest.fitted() == pytest.approx(refitted(*both, action), rel=0.05)


@pytest.mark.soak
def test_a_model_that_holds_another_follows_it_everywhere():
    """Friction is a power-law damper of exponent 0: no measurement can rule the larger one out."""
    case, best = explained("friction", AMPLITUDES, 3000.0)
    friction, power = best["friction"], best["power-law-damper"]
    for action in actions(case.search.base.fit.measurement):
        assert clash(friction, power, action).fitted() < 1.5


@pytest.mark.soak
def test_where_no_measurement_tells_more_none_is_asked_for():
    """A measurement that leaves the odds as they are is no advice, and no number of it either."""
    _, best = explained("friction", AMPLITUDES, 3000.0)
    fits = dict.fromkeys(("friction", "friction too"), best["friction"])
    advice = next_experiment(best["friction"], [tuple(fits)], fits, dict.fromkeys(fits, 0.5))
    assert advice.says.startswith(
        "no feasible measurement tells friction from friction too: even the best ("
    )
    assert "less than 0.1 sigma" in advice.says
    assert advice.expected_separation_sigma < 1e-3
    assert not advice.action


@pytest.mark.parametrize(
    ("sigmas", "says"),
    [
        ((20.0, 9.0), "it separates a from b by 9 sigma"),
        ((2.0, 3.0), "it separates a from b by 2 sigma"),
        (
            (4.0, 0.3),
            (
                "if a is right it speaks against b by 4 sigma; if not, a stays possible; "
                "1.2 sigma are to be expected"
            ),
        ),
        (
            (0.3, 150.0),
            (
                "if b is right it rules out a by 150 sigma; if not, b stays possible; "
                "1.1e+02 sigma are to be expected"
            ),
        ),
    ],
)
def test_who_is_right_decides_what_the_measurement_shows(sigmas, says):
    shares = (0.25, 0.75)
    assert promise(("a", "b"), shares, sigmas) == says.replace("1.1e+02", "110")
    told = float(re.findall(r"([\d.e+]+) sigma", says)[-1])
    assert separation(shares, sigmas) == pytest.approx(told, rel=0.05)


@pytest.mark.soak
def test_what_is_said_is_the_number_that_is_given():
    """Friction at one frequency, whose likeliest rival may follow it everywhere."""
    x = np.geomspace(0.01, 10.0, 25)
    exact = KELVIN.law(KELVIN.truth, 2j * np.pi * 2.0) + 4j * 0.15 / (np.pi * x)
    scatter = np.random.default_rng(7).normal(size=(2, 25))
    data = Measurement(
        np.full(25, 4.0 * np.pi),
        exact + 0.007 * np.abs(exact) * (scatter[0] + 1j * scatter[1]),
        conditions={"amplitude": x},
        units=springpot.Units("kN/m", "mm"),
    )
    advice = springpot.diagnose(data, "fractional-maxwell").next_experiment
    assert advice is not None
    told = re.findall(r"([\d.]+) sigma", advice.says)[-1]
    assert told == plain(max(advice.expected_separation_sigma, 0.1), 2)


@pytest.mark.soak
def test_a_known_mass_tells_the_chain_of_measurement_from_the_specimen():
    """In place of the specimen it shows what the rig adds: a delay, but no relaxation."""
    case, best = explained("time-delay")
    measurement = case.search.base.fit.measurement
    [action] = [action for action in actions(measurement) if "known mass" in action.says]
    mass = np.median(np.abs(measurement.stiffness)) / measurement.omega.max() ** 2
    assert f"of about {1e3 * mass:.2g} kg" in action.says
    omega = np.exp(action.points.log_omega)
    delayed = best["time-delay"]
    tau = delayed.theta[-1]
    seen = complex_form(clash(delayed, best["relaxation-mode"], action)._shown[1])
    np.testing.assert_allclose(seen, -mass * omega**2 * np.exp(-1j * omega * tau), rtol=2e-3)
    assert clash(delayed, best["relaxation-mode"], action).fitted() > 5.0


def test_every_sweep_says_how_many_points_it_has():
    at = design(6, 0.3, 30.0, amplitudes=(0.2, 0.5), temperatures=(5.0, 25.0))
    plan = list(actions(measured(at, KELVIN.stiffness(KELVIN.truth, at))))
    for action in plan[1:]:
        assert f"{len(action.action['omega'])} points" in action.says
        assert len(action.points.log_omega) == len(action.action["omega"])
    [denser] = [action for action in plan if "more densely" in action.says]
    assert "24 points from 0.3 to 30 Hz" in denser.says


def test_at_one_frequency_others_are_proposed_not_the_same_again():
    x = np.geomspace(0.1, 10.0, 9)
    data = Measurement(np.full(9, 4 * np.pi), 100 + 10j / x, conditions={"amplitude": x})
    says = [action.says for action in actions(data)]
    assert "measure a sweep of frequencies: 20 points from 0.2 to 20 Hz" in says
    assert not any("wards" in sentence or "densely" in sentence for sentence in says)


def test_a_certain_answer_asks_for_nothing():
    diagnosis = springpot.diagnose(
        hidden(KELVIN, SWEEP, "phase-error", 3000.0, just=True), KELVIN.name
    )
    assert diagnosis.best.alike == ("phase-error",)
    assert diagnosis.next_experiment is None


def test_a_strain_has_no_unit_in_the_advice():
    at = design(6, 0.3, 30.0, amplitudes=(0.01, 0.03))
    data = measured(at, KELVIN.stiffness(KELVIN.truth, at))
    strain = Measurement(
        data.omega, data.stiffness, conditions=data.conditions, units=springpot.Units("kPa", "-")
    )
    says = [action.says for action in actions(strain) if "amplitude" in action.says]
    assert says == [
        "measure 20 points at the amplitude 0.09",
        "measure 20 points at the amplitude 0.00333",
    ]


def sweep(points, **given):
    w = 2 * np.pi * np.geomspace(0.1, 100.0, points)
    return Measurement(w, 1e5 * (1j * w) ** 0.3, **given)


@pytest.mark.parametrize("points", [5, 20, 99, 150, 399, 400, 500])
def test_a_denser_sweep_is_denser_and_costs_as_many_points_as_it_has(points):
    denser = [action for action in actions(sweep(points)) if "densely" in action.says]
    if points >= 400:
        assert not denser
    else:
        assert len(denser[0].action["omega"]) > points
        assert denser[0].effort == pytest.approx(1.0 + min(4 * points, 400) / 80)


@pytest.mark.parametrize(
    ("unit", "asked"),
    [(None, False), ("Pa", False), ("N m/rad", False), ("N/m", True), ("kN/mm", True)],
)
def test_a_known_mass_is_asked_for_only_with_its_size(unit, asked):
    given = {"units": springpot.Units(unit)} if unit else {}
    masses = [
        action.says
        for action in actions(sweep(20, **given))
        if action.mass or "mass" in action.says
    ]
    assert bool(masses) == asked
    assert all(re.search(r"a known mass of about \S+ kg in place", sentence) for sentence in masses)
