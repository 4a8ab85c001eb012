"""Effects of tests in time do what their names say; a broken one is told apart.

Contract: see test_contracts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.measurement import Loading, Record, TimeTest
from springpot.registry import parse_model, plugins
from springpot.rheology import FORCE, Answered, Effect, Parameter, StageLaw, on_response
from springpot.testing import check_effect
from springpot.timetests import diagnose, identify, recorded

MODEL = parse_model("fractional-zener")
THETA = MODEL.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.55)
T = np.linspace(0.0, 15.0, 400)


def offset(record: Record, response, size):
    return Answered(response + size, (2.0 * np.ones_like(response),), np.ones_like(response))


SIZE = (Parameter("size", "F", FORCE),)
BROKEN = Effect(
    "offset",
    on_response,
    StageLaw(offset, SIZE),
    "the zero is off",
    citation="none",
    signature="a constant, all along",
)


def test_a_wrong_derivative_is_found():
    assert any("derivative by offset.size is wrong" in says for says in check_effect(BROKEN))


@pytest.mark.soak
def test_an_effect_that_does_not_vanish_is_found():
    def never(record, response, size):
        return Answered(response + size + 1.0, (np.ones_like(response),), np.ones_like(response))

    says = check_effect(replace(BROKEN, element=StageLaw(never, SIZE)))
    assert any("still changes when size" in each for each in says)


@pytest.mark.soak
def test_words_without_a_signature_are_found():
    assert any("signature" in each for each in check_effect(replace(BROKEN, signature="")))


def held(effect, values, test):
    model = MODEL + plugins().effect(effect)
    return recorded(model, np.concatenate([THETA, values]), test).value


def test_a_slow_step_is_a_ramp():
    t = np.geomspace(0.01, 100.0, 50)
    step = TimeTest.of_relaxation(t, t, "kPa")
    ramp = TimeTest.of_relaxation(t, t, "kPa", rise=0.3)
    assert held("finite-ramp", [0.3], step) == pytest.approx(
        recorded(MODEL, THETA, ramp).value, rel=1e-5
    )


@pytest.mark.parametrize(("effect", "size"), [("finite-ramp", 0.25), ("sudden-step", 1.0 / 6.0)])
def test_a_ramp_that_was_said_may_have_been_slower_or_quicker(effect, size):
    said, true = (0.05, 0.3) if effect == "finite-ramp" else (0.36, 0.3)
    t = np.geomspace(0.01, 100.0, 50)
    test, was = (TimeTest.of_relaxation(t, t, "kPa", rise=rise) for rise in (said, true))
    assert plugins().effect(effect).applies_to.suits(test)
    clean = recorded(MODEL, THETA, was).value
    assert held(effect, [size], test) == pytest.approx(clean, rel=1e-6)
    slope = (held(effect, [size + 1e-6], test) - held(effect, [size - 1e-6], test)) / 2e-6
    grown = MODEL + plugins().effect(effect)
    exact = recorded(grown, np.concatenate([THETA, [size]]), test).by_theta[:, -1]
    assert exact == pytest.approx(slope, rel=1e-4, abs=1e-4 * np.abs(slope).max())


@pytest.mark.parametrize(("noise", "sought"), [(0.0, True), (0.002, False)])
def test_a_target_does_not_tell_when_it_was_reached_and_a_transducer_does(noise, sought):
    t = np.geomspace(0.03, 10.0, 60)
    was = TimeTest.of_relaxation(t, t, "kPa", rise=0.12)
    moved = 0.02 + 0.02 * noise * np.random.default_rng(4).normal(size=len(t))
    force = 0.02 * recorded(MODEL, THETA, was).value
    test = TimeTest.of_history(t, moved, force, "-", "kPa")
    assert "risen evenly until then" in test.said_of_start
    assert plugins().effect("finite-ramp").applies_to.suits(test) == sought
    if sought:
        assert held("finite-ramp", [0.12 - t[0]], test) == pytest.approx(force, rel=1e-6)


def test_a_ramp_is_sought_before_the_first_sample_too():
    """Most steps are over when the first sample is taken: there the ramp is a small thing."""
    t = np.geomspace(0.04, 30.0, 25)
    test = TimeTest.of_relaxation(t, t, "kPa")
    (ramps,) = zip(*plugins().effect("finite-ramp").element.tries(test), strict=True)
    assert min(ramps) == pytest.approx(0.1 * t[0])
    assert max(ramps) == pytest.approx(t[-1])
    assert sum(ramp < 0.9 * t[0] for ramp in ramps) >= 2


def test_a_load_that_came_between_two_samples_may_have_come_at_once():
    t = np.linspace(0.0, 60.0, 31)
    load = np.where((t > 0.0) & (t < 31.0), 5.0, 0.0)
    test = TimeTest.of_history(t, load, load, "mm", "N", control="force")
    assert plugins().effect("sudden-step").applies_to.suits(test)
    exact = 5.0 * MODEL.creep(THETA, t[1:16])
    assert held("sudden-step", [0.999], test)[1:16] == pytest.approx(exact, rel=2e-3)
    # A ramp that was recorded came as it was recorded.
    ramp = TimeTest.of_history(t, t, t, "mm", "N", control="force")
    assert not plugins().effect("sudden-step").applies_to.suits(ramp)


@pytest.mark.parametrize("corners", [False, True])
def test_play_is_left_behind_at_a_turn_between_two_samples_too(corners):
    """Of 40 samples a cycle a motion turned up to a tenth of the play beyond the last one."""

    def moved(t):
        x = np.sin(1.3 * t) * (1.0 + 0.3 * np.sin(0.31 * t))
        return 2.0 / np.pi * np.arcsin(np.sin(1.3 * t)) if corners else x

    t = np.linspace(0.0, 15.0, 125)
    test = TimeTest.of_history(t, moved(t), 3.0 * moved(t), "mm", "N")
    dense = np.linspace(0.0, 15.0, 124 * 16 + 1)
    end, followed = 0.0, []
    for here in moved(dense):
        end = min(max(end, here - 0.2), here + 0.2)
        followed.append(end)
    behind = TimeTest.of_history(dense, np.array(followed), 3.0 * moved(dense), "mm", "N")
    felt = recorded(MODEL, THETA, behind).value[::16]
    missed = held("backlash-in-time", [0.2], test) - felt
    assert np.sqrt(np.mean(missed**2)) < 0.004 * np.sqrt(np.mean(felt**2))


PULL = np.interp(T, [0.0, 1.0, 3.0, 15.0], [0.0, 0.0, 0.3, 0.3])


def test_tissue_relaxes_an_exponential_of_its_strain():
    test = TimeTest.of_history(T, PULL, 3.0 * PULL, "mm", "N")
    felt = TimeTest.of_history(T, np.expm1(6.0 * PULL) / 6.0, 3.0 * PULL, "mm", "N")
    assert held("strain-stiffening", [6.0], test) == pytest.approx(
        recorded(MODEL, THETA, felt).value, abs=1e-9
    )


def test_a_cracking_specimen_creeps_ever_faster():
    k, c, rupture, p = 40.0, 900.0, 20.0, 0.3
    model = parse_model("maxwell") + plugins().effect("creep-damage")
    test = TimeTest.of_compliance(T[1:], T[1:])
    left = 1.0 - T[1:] / rupture
    crept = left**-p / k + rupture / c * (1.0 - left ** (1.0 - p)) / (1.0 - p)
    assert recorded(model, np.array([k, c, rupture, p]), test).value == pytest.approx(
        crept, rel=1e-4
    )


@pytest.mark.soak_cases("0.16")
def assert_missing(effect, test, clean, noise, model):
    """What is named first in a response with relative noise."""
    scatter = noise * np.random.default_rng(5).standard_normal(len(clean))
    found = diagnose(replace(test, response=clean * (1.0 + scatter)), model)
    assert (found.verdict, found.candidates[0].effect) == ("effect-missing", effect)


@pytest.mark.soak
@pytest.mark.parametrize("rise", [0.13, 0.16])
def test_a_ramp_that_one_sample_lies_within_is_found(rise: float):
    t = np.geomspace(0.1, 1000.0, 80)
    test = TimeTest.of_relaxation(t, t)
    theta = np.array([74.0, 249.0, 660.0, 0.4, rise])
    clean = recorded(MODEL + plugins().effect("finite-ramp"), theta, test).value
    assert_missing("finite-ramp", test, clean, 0.01, MODEL)


@pytest.mark.soak
@pytest.mark.parametrize("exponent", [0.15, 0.3])
def test_tertiary_creep_is_told_from_warming_and_drift(exponent: float):
    t = np.linspace(0.5, 300.0, 100)
    test = TimeTest.of_compliance(t, t)
    model = parse_model("burgers") + plugins().effect("creep-damage")
    theta = np.array([10.0, 2000.0, 8.0, 80.0, 360.0, exponent])
    clean = recorded(model, theta, test).value
    assert_missing("creep-damage", test, clean, 0.003, parse_model("burgers"))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_loose_specimen_feels_what_goes_beyond_its_length(side: float):
    test = TimeTest.of_history(T, side * PULL, 3.0 * PULL, "mm", "N")
    felt = TimeTest.of_history(T, side * np.maximum(PULL - 0.1, 0.0), 3.0 * PULL, "mm", "N")
    assert held("slack", [0.1], test) == pytest.approx(recorded(MODEL, THETA, felt).value, abs=1e-9)


def test_of_free_play_a_specimen_feels_what_goes_beyond_it_on_either_side():
    x = np.sin(1.3 * T)
    test = TimeTest.of_history(T, x, 3.0 * x, "mm", "N", control="displacement")
    assert plugins().effect("slack").applies_to(test)
    beyond = np.sign(x) * np.maximum(np.abs(x) - 0.2, 0.0)
    felt = TimeTest.of_history(T, beyond, 3.0 * x, "mm", "N", control="displacement")
    assert held("slack", [0.2], test) == pytest.approx(recorded(MODEL, THETA, felt).value, abs=0.3)


@pytest.mark.soak
def test_free_play_is_told_from_what_stiffens():
    x = np.sin(1.3 * T)
    test = TimeTest.of_history(T, x, 3.0 * x, "mm", "N", control="displacement")
    clean = held("slack", [0.2], test)
    noise = 0.005 * np.abs(clean).max() * np.random.default_rng(4).normal(size=len(T))
    rivals = [plugins().effect(name) for name in ("slack", "dead-zone", "strain-stiffening")]
    found = diagnose(replace(test, response=clean + noise), MODEL, rivals)
    assert (found.verdict, found.leading) == ("effect-missing", ("slack",))


def test_bump_and_rebound_differ_by_a_force_of_one_sign():
    x = np.sin(1.3 * T)
    test = TimeTest.of_history(T, x, 3.0 * x, "mm", "N")
    extra = held("asymmetric-damping", [2.0], test) - recorded(MODEL, THETA, test).value
    assert extra == pytest.approx(2.0 * np.abs(Record.of(test).rate), abs=1e-9)


def test_stiffening_is_told_from_any_material():
    rng = np.random.default_rng(3)
    model = MODEL + plugins().effect("strain-stiffening")
    test = TimeTest.of_history(T, PULL, PULL, "mm", "N")
    clean = recorded(model, np.append(THETA, 10.0), test).value
    noisy = clean + 0.005 * np.abs(clean).max() * rng.standard_normal(len(clean))
    fit = identify(replace(test, response=noisy), parse_model("material + strain-stiffening"))
    assert fit["strain-stiffening.B"].value == pytest.approx(10.0, rel=0.1)


def start_up(n: float, rate: float = 1.0) -> TimeTest:
    """A Maxwell material (G = 2 kPa, tau = 2 s) whose network fades as exp(-n gamma).

    By the K-BKZ integral at a constant rate: what lay there before the start is strained by all of
    gamma, what came a time s ago by rate s (doi:10.1007/BF01517505).
    """
    stress = []
    for t in T[1:]:
        s = np.linspace(0.0, t, 4001)
        memory = np.exp(-s / 2.0) * rate * s * np.exp(-n * rate * s)
        before = 2.0 * np.exp(-t / 2.0) * rate * t * np.exp(-n * rate * t)
        stress.append(before + np.trapezoid(memory, s))
    ramp = Loading(np.array([0.0, T[-1]]), np.array([0.0, rate * T[-1]]))
    return TimeTest(T[1:], np.array(stress), ramp, force_unit="kPa")


def test_a_network_that_fades_answers_to_a_start_up_as_its_integral_says():
    test = start_up(0.4)
    model = parse_model("maxwell + fading-network")
    theta = model.theta(k=2.0, c=4.0, **{"fading-network.n": 0.4})
    value = recorded(model, theta, test).value
    assert value == pytest.approx(test.response, rel=2e-4)


@pytest.mark.soak
def test_an_overshoot_is_a_fading_network_as_much_as_any_other_effect_that_does_it():
    rng = np.random.default_rng(5)
    test = start_up(0.4)
    noisy = test.response + 0.002 * test.response.max() * rng.standard_normal(len(test.response))
    names = ("fading-network", "thermal-transient", "finite-ramp", "inertia")
    effects = [plugins().effect(name) for name in names]
    found = diagnose(replace(test, response=noisy), parse_model("material"), effects)
    assert "fading-network" in found.candidates[0].alike
    # Several do as well, and none of them is the missing one for certain.
    assert all(each.verdict != "missing" for each in found.candidates)


@pytest.mark.soak
def test_a_network_that_has_faded_early_in_a_long_start_up_is_found():
    test = start_up(0.7, 50.0 / T[-1])
    noisy = test.response + 0.005 * test.response.max() * np.random.default_rng(5).normal(
        size=len(test.response)
    )
    names = ("fading-network", "thermal-transient", "thermal-force", "force-drift")
    effects = [plugins().effect(name) for name in names]
    found = diagnose(replace(test, response=noisy), parse_model("maxwell"), effects)
    assert found.best.effect == "fading-network"


def test_a_fluid_that_is_set_in_motion_is_not_seen_after_an_ideal_step():
    effect = plugins().effect("basset")
    t = np.geomspace(0.1, 10.0, 20)
    stepped = TimeTest.of_relaxation(t, 1.0 / t, "Pa")
    assert not effect.applies_to(stepped)
    assert effect.applies_to(start_up(0.4))
    assert effect.applies_to(TimeTest.of_compliance(t, t, "Pa"))


def test_a_bearing_that_holds_lets_less_through_and_holds_back():
    loading = Loading(np.array([0.0, 0.0, 7.0, 7.0, 15.0]), np.array([0.0, 1.0, 1.0, 0.0, 0.0]))
    test = TimeTest(T[1:], T[1:], loading, "force", "mm", "N")
    less = Loading(loading.time, np.array([0.0, 0.9, 0.9, 0.1, 0.1]))
    wanted = recorded(MODEL, THETA, replace(test, loading=less)).value
    assert held("bearing-friction", [0.1], test) == pytest.approx(wanted, rel=1e-5)


def test_a_material_that_ages_as_fast_as_time_answers_to_its_logarithm():
    t = np.geomspace(0.01, 100.0, 50)
    test = TimeTest.of_relaxation(t, t, "kPa")
    wanted = MODEL.relaxation(THETA, 3.0 * np.log1p(t / 3.0))
    assert held("ageing", [1.0, 3.0], test) == pytest.approx(wanted, rel=1e-5)


def test_a_specimen_that_is_colder_at_first_runs_slower_at_first():
    t = np.geomspace(0.01, 100.0, 50)
    test = TimeTest.of_relaxation(t, t, "kPa")
    found = held("thermal-transient", [2.0, 5.0], test)
    assert found[0] == pytest.approx(MODEL.relaxation(THETA, np.exp(-2.0) * t[:1])[0], rel=1e-2)
    assert np.all(found >= MODEL.relaxation(THETA, t) * (1.0 - 1e-5))


def test_damage_is_counted_by_the_way_and_not_by_the_samples():
    x = np.sin(2.0 * T)
    whole = held("damage", [0.05], TimeTest.of_history(T, x, 3.0 * x, "mm", "N"))
    model = MODEL + plugins().effect("damage")
    some = recorded(
        model, np.append(THETA, 0.05), TimeTest.of_history(T, x, 3.0 * x, "mm", "N"), at=T[::7]
    ).value
    assert whole[::7] == pytest.approx(some, rel=1e-6, abs=1e-6)


def test_a_mass_does_not_go_by_the_clock_of_its_material():
    t = np.geomspace(0.01, 100.0, 50)
    test = TimeTest.of_compliance(t, t, "kPa")
    model = parse_model("fractional-zener + inertia + ageing")
    theta = model.vector(
        {
            "k1": 50.0,
            "k2": 400.0,
            "c": 60.0,
            "alpha": 0.5,
            "inertia.m": 1.0,
            "ageing.mu": 0.5,
            "ageing.waited": 1.0,
        }
    )
    with pytest.raises(ModelError, match="does not go by the clock"):
        recorded(model, theta, test)


def test_an_expression_may_name_effects_of_either_kind():
    model = parse_model("fractional-zener + force-drift + inertia")
    assert model.names[-2:] == ("inertia.m", "force-drift.rate")
    with pytest.raises(ModelError, match="write MODEL"):
        parse_model("force-drift")
    with pytest.raises(ModelError, match="already"):
        parse_model("fractional-zener + force-drift + force-drift")


def test_a_named_effect_is_identified_with_the_model():
    t = np.geomspace(0.01, 100.0, 120)
    model = parse_model("fractional-zener + thermal-force")
    truth = np.concatenate([THETA, [-20.0, 8.0]])
    exact = recorded(model, truth, TimeTest.of_relaxation(t, t, "kPa")).value
    noise = 0.3 * np.random.default_rng(2).normal(size=len(t))
    found = identify(TimeTest.of_relaxation(t, exact + noise, "kPa"), model)
    low, high = found.low, found.high
    assert np.all((low < truth) & (truth < high))
    with pytest.raises(ModelError, match="cannot be seen in such a test"):
        identify(TimeTest.of_compliance(t, MODEL.creep(THETA, t), "kPa"), model)
