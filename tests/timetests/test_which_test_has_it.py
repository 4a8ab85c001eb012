"""What one of several tests has is said of that test.

A gain, what yields in one rig, a misfit of a sweep.
"""

from __future__ import annotations

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.measurement import Measurement, TimeTest
from springpot.misfit.residual_scatter import scatter_of_sweep
from springpot.registry import parse_model, plugins
from springpot.rheology import Effect
from springpot.timetests import diagnose, examine, identify
from springpot.timetests.specimen import at_tests

NOISE = 0.006
OMEGA = np.geomspace(0.1, 100.0, 25)
TIME = np.geomspace(0.01, 100.0, 70)
ZENER = {"k1": 400.0, "k2": 300.0, "c": 60.0}
SOME = (
    "test-gain",
    "gain-error",
    "series-spring",
    "thermal-growth",
    "finite-ramp",
    "frequency-error",
)


def some_effects():
    """A few effects, so that a diagnosis is short."""
    return [plugins().effect(name) for name in SOME]


def three_tests(seed, gain=None, yields=False):
    """A sweep, a relaxation and a creep of one material.

    One of them is too large, or the sweep's rig yields.
    """
    model, rng = parse_model("zener"), np.random.default_rng(seed)
    swept = model + plugins().effect("series-spring") if yields else model
    theta = model.vector(ZENER)
    exact = {
        "sweep": (
            swept.stiffness(swept.vector(ZENER | {"series-spring.k": 900.0}), OMEGA)
            if yields
            else model.stiffness(theta, OMEGA)
        ),
        "relax": model.relaxation(theta, TIME),
        "creep": model.creep(theta, TIME),
    }
    if gain is not None:
        exact[gain] = 1.2 * exact[gain]
    scattered = {
        name: each * (1.0 + NOISE * rng.normal(size=len(each))) for name, each in exact.items()
    }
    return [
        Measurement(
            OMEGA, scattered["sweep"] + 1j * NOISE * rng.normal(size=25) * 400.0, name="sweep"
        ),
        TimeTest.of_relaxation(TIME, scattered["relax"], name="relax"),
        TimeTest.of_compliance(TIME, scattered["creep"], name="creep"),
    ]


@pytest.mark.soak
@pytest.mark.parametrize(("gain", "name"), [("creep", "test-gain:creep"), ("sweep", "gain-error")])
def test_a_gain_is_said_of_the_test_that_has_it(gain, name):
    diagnosis = diagnose(three_tests(1, gain), parse_model("zener"), some_effects())
    assert (diagnosis.verdict, diagnosis.leading) == ("effect-missing", (name,))


@pytest.mark.soak
def test_of_two_tests_neither_is_said_to_be_the_wrong_one():
    diagnosis = diagnose(three_tests(1, "creep")[1:], parse_model("zener"), some_effects())
    assert diagnosis.verdict == "effect-missing"
    assert set(diagnosis.leading) == {"test-gain:relax", "test-gain:creep"}


@pytest.mark.soak
def test_what_yields_in_the_rig_of_the_sweep_alone_is_found():
    case = examine(three_tests(1, yields=True), parse_model("zener"), some_effects())
    diagnosis, best = case.diagnosis, case.best_fit
    assert (diagnosis.verdict, diagnosis.leading) == ("effect-missing", ("series-spring",))
    assert best.on_sweeps == ("series-spring",)
    assert best.parameters["series-spring.k"].value == pytest.approx(900.0, rel=0.05)


@pytest.mark.soak
def test_the_error_of_a_sweep_is_a_share_of_its_stiffness():
    diagnosis = diagnose(three_tests(1, "sweep")[:2], parse_model("zener"), some_effects()[-1:])
    assert diagnosis.error.noise_floor < 0.05
    assert diagnosis.error.relative_rms < 0.3


def test_an_effect_of_one_test_is_typed_with_its_name():
    model = parse_model("zener + test-gain:creep")
    assert model.name == "zener + test-gain:creep"
    assert parse_model(model.name).names == model.names
    fit = identify(three_tests(2, "creep"), model)
    assert fit.parameters["test-gain:creep.g"].value == pytest.approx(0.2, abs=0.01)
    assert plugins().effect("test-gain:creep 25 C + glue").name == "test-gain:creep-25-C-glue"
    with pytest.raises(ModelError, match="an effect of the test bend, cannot be seen"):
        identify(three_tests(2, "creep"), parse_model("zener + test-gain:bend"))


def test_a_gain_of_one_test_in_time_is_tried_once():
    tests, both = three_tests(1), [plugins().effect(name) for name in ("gain-error", "test-gain")]
    forms = [form.name for effect in both for form in at_tests(effect, tests)]
    assert forms == ["gain-error", "test-gain:relax", "test-gain:creep"]
    forms = [form.name for effect in both for form in at_tests(effect, tests[1:])]
    assert forms == ["gain-error", "test-gain:relax", "test-gain:creep"]


def test_a_test_by_itself_has_no_gain():
    gain = plugins().effect("test-gain")
    sweep, relax, creep = three_tests(1)
    assert at_tests(gain, [relax]) == []
    assert [each.name for each in at_tests(gain, [sweep, relax])] == ["test-gain:relax"]
    assert len(at_tests(gain, [relax, creep])) == 2


def test_an_effect_of_the_rig_may_be_that_of_the_sweep_alone():
    sweep, relax, creep = three_tests(1)
    inertia = plugins().effect("inertia")
    assert [_alone(each) for each in at_tests(inertia, [sweep, creep])] == [False, True, False]
    names = [each.name for each in at_tests(inertia, [relax, creep])]
    assert names == ["inertia", "inertia:relax", "inertia:creep"]
    assert [
        _alone(each) for each in at_tests(plugins().effect("parallel-dashpot"), [sweep, creep])
    ] == [False]


def _alone(effect):
    assert isinstance(effect, Effect)
    return not effect.in_time


@pytest.mark.parametrize("known", [True, False])
def test_a_misfit_of_either_part_of_a_sweep_is_seen(known):
    rng = np.random.default_rng(1)
    noise = rng.normal(size=60)
    assert not scatter_of_sweep(noise, known).misfit
    ripple = 3.0 * np.sin(0.4 * np.arange(30))
    for half in (np.s_[:30], np.s_[30:]):
        missed = noise.copy()
        missed[half] += ripple
        assert scatter_of_sweep(missed, known).misfit


@pytest.mark.soak_cases("False")
@pytest.mark.parametrize("known", [True, False])
def test_noise_of_a_sweep_is_rarely_taken_for_a_misfit(known):
    rng = np.random.default_rng(2)
    found = [
        scatter_of_sweep(rng.normal(size=2 * n), known) for n in (12, 20, 40) for _ in range(400)
    ]
    assert np.mean([each.misfit for each in found]) < 0.005


def test_a_sweep_whose_noise_was_taken_too_large_is_judged_by_its_own():
    missed = 0.5 * np.random.default_rng(3).normal(size=60)
    assert scatter_of_sweep(missed, known=False).size == pytest.approx(0.5, rel=0.2)
    assert scatter_of_sweep(missed, known=True).size == 1.0


def test_a_material_with_an_effect_of_one_test_is_fitted_to_the_others_alone_too():
    # Weights come from fits of each test alone, of which most do not have the effect.
    model = parse_model("material") + plugins().effect("test-gain").of_one("creep")
    found = identify(three_tests(3, gain="creep")[1:], model)
    assert found.parameters["test-gain:creep.g"].value == pytest.approx(0.2, abs=0.05)
