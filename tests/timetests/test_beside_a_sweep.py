"""Tests added to a sweep make an answer better: an effect belongs to the test whose rig has it."""

from __future__ import annotations

import importlib
import json

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.measurement import Measurement, TimeTest
from springpot.registry import parse_model, plugins
from springpot.report.told import told
from springpot.rheology import Effect, Points, chain
from springpot.rheology.grammar import Formula
from springpot.timetests import diagnose, discover, identify

NOISE = 0.006
OMEGA = 2.0 * np.pi * np.geomspace(0.1, 30.0, 30)
TIME = np.geomspace(0.01, 100.0, 60)
EFFECTS = {"inertia.m": 0.02, "time-delay.tau": 8e-4, "gain-error.g": 0.05, "phase-error.phi": 0.02}
MATERIALS = {
    "fractional-maxwell": {"k": 400.0, "c": 60.0, "alpha": 0.5},
    "zener": {"k1": 400.0, "k2": 300.0, "c": 60.0},
}


def sweep_of(expression, seed):
    """A sweep of a model, with noise."""
    model, rng = parse_model(expression), np.random.default_rng(seed)
    values = MATERIALS[model.base] | EFFECTS
    exact = model.stiffness(model.vector({name: values[name] for name in model.names}), OMEGA)
    noise = rng.normal(size=30) + 1j * rng.normal(size=30)
    return Measurement(
        OMEGA, exact + NOISE * np.abs(exact) * noise / np.sqrt(2.0), name="sweep.csv"
    )


def step_of(expression, kind, seed):
    """A relaxation or creep test of a model, with noise."""
    model, rng = parse_model(expression), np.random.default_rng(1000 + seed)
    values = MATERIALS[model.base] | EFFECTS
    theta = model.vector({name: values[name] for name in model.names})
    noise = 1.0 + NOISE * rng.normal(size=60)
    if kind == "relaxation":
        return TimeTest.of_relaxation(TIME, model.relaxation(theta, TIME) * noise, name="relax.csv")
    return TimeTest.of_compliance(TIME, model.creep(theta, TIME) * noise, name="creep.csv")


def house(seed):
    """A sweep on a rig with a mass and a delay, and a relaxation of the same material."""
    sweep = sweep_of("fractional-maxwell + inertia + time-delay", seed)
    return [sweep, step_of("fractional-maxwell", "relaxation", seed)]


def chained():
    """Effects of the measuring chain of a sweep, and others that could be taken for them."""
    names = ("time-delay", "gain-error", "phase-error", "frame-resonance", "parallel-dashpot")
    return [plugins().effect(name) for name in names]


@pytest.mark.soak_cases("2", "3")
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_model_with_a_delay_is_fitted_to_a_sweep_and_a_relaxation(seed):
    fit = identify(house(seed), parse_model("fractional-maxwell + inertia + time-delay"))
    truth = MATERIALS["fractional-maxwell"] | EFFECTS
    for name, row in fit.parameters.items():
        assert row.value == pytest.approx(truth[name], rel=0.08)
    assert max(test.over_floor for test in fit.tests) < 2.0
    assert any(note.startswith("time-delay: of the rig of the sweeps") for note in fit.notes)


@pytest.mark.soak
@pytest.mark.parametrize("seed", [1, 2])
def test_a_delay_of_the_sweep_is_found_beside_a_relaxation(seed):
    diagnosis = diagnose(house(seed), parse_model("fractional-maxwell + inertia"), chained())
    assert diagnosis.verdict == "effect-missing"
    assert diagnosis.best.effect == "time-delay"


@pytest.mark.soak
@pytest.mark.parametrize("seed", [2, 3])
def test_a_discovery_from_a_sweep_and_a_relaxation_ends_at_the_truth(seed):
    ladder = discover(house(seed), "fractional-maxwell")
    assert [step.accepted for step in ladder.steps] == [None, "inertia", "time-delay"]
    assert ladder.verdict == "adequate"


@pytest.mark.soak
@pytest.mark.parametrize("effect", ["time-delay", "gain-error", "phase-error"])
def test_what_a_chain_does_to_a_sweep_is_found_beside_a_creep(effect):
    tests = [sweep_of(f"zener + {effect}", 1), step_of("zener", "creep", 1)]
    diagnosis = diagnose(tests, parse_model("zener"), chained())
    assert diagnosis.verdict == "effect-missing"
    assert effect in diagnosis.leading


@pytest.mark.soak_cases("zener + inertia", "zener")
@pytest.mark.parametrize("there", ["zener", "zener + inertia"])
def test_a_mass_is_found_whether_or_not_the_creep_is_of_the_same_rig(there):
    tests = [sweep_of("zener + inertia", 1), step_of(there, "creep", 1)]
    some = [plugins().effect(name) for name in ("inertia", "time-delay", "parallel-dashpot")]
    diagnosis = diagnose(tests, parse_model("zener"), some)
    assert (diagnosis.verdict, diagnosis.leading) == ("effect-missing", ("inertia",))
    fit = identify(tests, parse_model("zener + inertia"))
    assert fit.parameters["inertia.m"].value == pytest.approx(0.02, rel=0.01)
    assert fit.on_sweeps == (() if "inertia" in there else ("inertia",))


def test_the_kept_fit_of_a_sweep_and_a_relaxation_predicts_a_relaxation(tmp_path):
    fit = identify(house(1), parse_model("fractional-maxwell + inertia + time-delay"))
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again = springpot.load(path)
    at = np.array([0.5, 2.0])
    expected = parse_model("fractional-maxwell").relaxation(fit.theta[:3], at)
    assert np.allclose(again.of_specimen.model.relaxation(again.of_specimen.theta, at), expected)


def test_a_fault_in_an_effect_is_no_answer():
    def faulty(at: Points, tau):
        raise IndexError("a programming error")

    delay = plugins().effect("time-delay")
    element = Formula(delay.element.parameters, faulty)
    effect = Effect("faulty", chain, element, "fails", delay.layer)
    with pytest.raises(IndexError, match="programming"):
        diagnose(house(1), parse_model("fractional-maxwell + inertia"), [effect])


@pytest.mark.soak
def test_an_effect_that_cannot_be_gone_on_from_is_told_and_loses_no_rung(monkeypatch):
    module = importlib.import_module("springpot.timetests.discovery")
    whole = module.examine

    def failing(tests, model, effects, **known):
        if "time-delay" in str(model):
            raise ModelError("nothing follows it")
        return whole(tests, model, effects, **known)

    monkeypatch.setattr(module, "examine", failing)
    some = [plugins().effect(name) for name in ("inertia", "time-delay")]
    ladder = discover(house(1), "fractional-maxwell", some)
    assert [step.accepted for step in ladder.steps] == [None, "inertia"]
    assert ladder.to_dict()["left_out"] == {"time-delay": "nothing follows it"}
    assert "left out: time-delay: nothing follows it" in told(ladder)


def test_a_creep_beside_a_sparse_sweep_makes_nothing_less_certain():
    """Neighbours of a dozen points differ by the curve too: its own fit tells the sweep's noise."""
    rng, model = np.random.default_rng(3), parse_model("zener-2")
    theta = model.vector({"k0": 25.0, "k1": 41.0, "c1": 107.0, "k2": 28.0, "c2": 3.6})
    omega, t = np.geomspace(0.01, 30.0, 12), np.geomspace(1.0, 120.0, 60)
    noise = 0.002 * (rng.normal(size=12) + 1j * rng.normal(size=12))
    sweep = Measurement(omega, model.stiffness(theta, omega) * (1.0 + noise), name="sweep.csv")
    exact = model.creep(theta, t)
    scatter = 0.002 * np.sqrt(np.mean(exact**2)) * rng.normal(size=60)
    creep = TimeTest.of_compliance(t, exact + scatter, "Pa")
    together, alone = identify([sweep, creep], model), springpot.identify(sweep, model)
    # The two branches may change places.
    widths = [
        sorted(fit.parameters[name].high - fit.parameters[name].low for name in ("k0", "k1", "k2"))
        for fit in (together, alone)
    ]
    assert np.all(np.array(widths[0]) < 1.2 * np.array(widths[1]))
