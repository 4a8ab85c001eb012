"""Any linear passive material from tests in time: no model is named, and the spectrum is found."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.measurement import TimeTest
from springpot.measurement.recording import recorded
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose, identify, predict_test
from springpot.timetests.hypotheses import ScanEntry
from springpot.timetests.material import with_rates

MODEL = parse_model("fractional-zener")
THETA = np.array([1.0, 3.0, 2.0, 0.6])
T = np.geomspace(0.01, 1000.0, 200)
ANY = parse_model("material")


def scattered(values, seed):
    return values * (1.0 + 0.01 * np.random.default_rng(seed).normal(size=len(values)))


RELAXED = TimeTest.of_relaxation(T, scattered(MODEL.relaxation(THETA, T), 1), "kPa")
CREPT = TimeTest.of_compliance(T, scattered(MODEL.creep(THETA, T), 2), "kPa")


@pytest.fixture(scope="module")
def fit():
    return identify(RELAXED, parse_model("material"))


def test_its_spectrum_follows_a_relaxation_to_the_noise(fit):
    [test] = fit.tests
    assert 0.85 < test.over_floor < 1.1
    assert np.all(fit.theta >= 0.0)
    assert fit.parameters["K_e"].value == pytest.approx(1.0, rel=0.1)
    assert set(fit.parameters) == {"K_e", "c"}


def test_what_it_says_of_another_test_and_of_frequencies(fit, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    known = springpot.load(path)
    assert predict_test(known, CREPT).error < 0.02
    omega = np.geomspace(3e-3, 30.0, 20)
    exact = MODEL.stiffness(THETA, omega)
    assert np.abs(known.predict(omega=omega).stiffness / exact - 1.0).max() < 0.01


def test_relaxation_and_creep_together_though_a_creep_is_not_linear():
    both = identify([RELAXED, CREPT], parse_model("material"))
    assert all(0.8 < test.over_floor < 1.15 and test.agrees for test in both.tests)


def test_a_mass_around_it_is_found_from_a_record():
    model = parse_model("fractional-zener + inertia")
    t = np.linspace(0.0, 12.0, 600)
    x = np.sin(t**1.5)
    force = model.respond(np.append(THETA, 0.3), t, x)
    noise = 0.005 * np.abs(force).max() * np.random.default_rng(3).normal(size=len(t))
    found = identify(
        TimeTest.of_history(t, x, force + noise, "m", "N"), parse_model("material + inertia")
    )
    assert found.tests[0].over_floor < 1.1
    assert found.parameters["inertia.m"].value == pytest.approx(0.3, rel=0.05)


def relaxed_with(effect, values, noise=0.3):
    """A relaxation in kPa that an effect of the test is part of."""
    t = np.geomspace(0.01, 100.0, 120)
    zener = parse_model("fractional-zener")
    theta = np.append(zener.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.5), values)
    blank = TimeTest.of_relaxation(t, np.ones(len(t)), "kPa")
    exact = recorded(parse_model(f"fractional-zener + {effect}"), theta, blank, 293.15).value
    return TimeTest.of_relaxation(
        t, exact + noise * np.random.default_rng(3).normal(size=len(t)), "kPa"
    )


@pytest.mark.soak_cases("finite-ramp-0.05-0.002")
@pytest.mark.parametrize(
    ("effect", "size", "width"),
    [("force-drift", 0.5, 0.1), ("force-drift", -0.5, 0.1), ("finite-ramp", 0.05, 0.002)],
)
def test_what_no_material_does_is_told_beside_any_material(effect, size, width):
    found = identify(relaxed_with(effect, [size]), parse_model(f"material + {effect}"))
    [row] = [entry for name, entry in found.parameters.items() if name.startswith(effect)]
    assert abs(row.value - size) < width
    assert row.low < size < row.high
    assert 0.7 < found.tests[0].over_floor < 1.2


@pytest.mark.soak
def test_what_another_material_would_do_too_is_refused_with_what_helps():
    """A warming as slow as the material relaxes, and a clock that slows as a spectrum does."""
    for effect, values in (("thermal-force", [20.0, 30.0]), ("ageing", [0.5, 10.0])):
        with pytest.raises(
            ModelError, match=r"another material could have done the same .* name a model"
        ) as told:
            identify(relaxed_with(effect, values), parse_model(f"material + {effect}"))
        assert "\n" not in str(told.value)


@pytest.mark.soak
def test_a_drift_is_named_beside_any_material():
    effects = [
        each for each in plugins().items("effect") if each.name in ("force-drift", "thermal-force")
    ]
    found = diagnose(relaxed_with("force-drift", [0.5]), "material", effects)
    assert found.verdict == "effect-missing"
    assert found.best.effect == "force-drift"


def test_a_material_alone_takes_a_start_that_tells_nothing_of_effects(fit):
    again = identify(RELAXED, parse_model("material"), seeds=[fit.theta[:2]], thorough=False)
    assert again.cost == pytest.approx(fit.cost, rel=1e-3)


@pytest.mark.parametrize("rates", [(), (0.1,), (0.1, 1.0, 10.0)])
def test_a_start_beside_a_spectrum_of_other_lines_has_the_effect_where_it_was_seen(rates):
    """Each fit chooses its own lines: the model to be fitted may have more of them, or fewer."""
    [inertia] = parse_model("material + inertia").effects
    fit = SimpleNamespace(model=with_rates(ANY, (0.3, 3.0)), theta=np.ones(4))
    entry = ScanEntry(inertia, (2.5,), fit.theta, 1.0, 1.0, np.ones(3), True)
    model = with_rates(ANY, rates) + inertia
    start = model.named(entry.start(fit, model))
    assert start["inertia.m"] == 2.5
    assert [start[name] for name in ("K_e", "c")] == [1.0, 1.0]
    assert all(value in (0.0, 1.0) for name, value in start.items() if name.startswith("g"))


@pytest.mark.parametrize("plateau", [0.0, 100.0])
def test_what_still_relaxes_at_the_end_leaves_the_spring_open(plateau):
    """By the slopes of the chosen lines alone, 2 of 5 such intervals held the plateau."""
    t = np.geomspace(0.01, 10.0, 60)
    modulus = plateau + 100.0 * np.exp(-t / 0.1) + 50.0 * np.exp(-t / 5.0)
    for seed in (1, 2):
        told = identify(TimeTest.of_relaxation(t, scattered(modulus, seed), "Pa"), ANY)
        spring = told.parameters["K_e"]
        assert spring.low <= plateau < spring.high < plateau + 10.0


def relaxes(clock, noise):
    return TimeTest.of_relaxation(clock, (100.0 + 50.0 * clock**-0.3) * noise, "Pa")


def creeps(clock, noise):
    solid = parse_model("fractional-kelvin")
    return TimeTest.of_compliance(clock, solid.creep(BROAD, clock) * noise, "Pa")


BROAD = np.array([100.0, 50.0 * math.gamma(0.7), 0.3])
"""Of a relaxation by a power of time beside a spring, as a fractional Kelvin solid."""


@pytest.mark.parametrize("seen", [relaxes, creeps])
@pytest.mark.parametrize(
    ("draws", "least"), [(2, 2), pytest.param(40, 35, marks=pytest.mark.soak)], ids=["few", "many"]
)
def test_intervals_of_a_free_material_hold_what_other_lines_would_do(draws, least, seen):
    """Lines that carry nothing may, and those that carry may lie elsewhere."""
    hertz, clock = 0.05, np.geomspace(0.1, 100.0, 60)
    exact = BROAD[0] + BROAD[1] * (2j * np.pi * hertz) ** BROAD[2]
    held = 0
    for seed in range(draws):
        noise = 1.0 + 0.005 * np.random.default_rng(seed).normal(size=len(clock))
        found = springpot.identify(seen(clock, noise), "material")
        told = {row.name: row.value for row in springpot.quantities(found, frequency=hertz)}
        damping = told["loss factor"]
        # No wider than what the measured range leaves, either.
        assert damping.high - damping.low < 0.4 * damping.value
        held += damping.low <= exact.imag / exact.real <= damping.high
    print(f"{seen.__name__}: {held} of {draws} intervals of the loss factor hold the truth")
    assert held >= least


def test_whatever_intervals_are_asked_for_other_lines_are_free():
    """Fits of simulated tests would hold them where one test has put them."""
    clock = np.geomspace(0.1, 100.0, 20)
    noise = 1.0 + 0.005 * np.random.default_rng(0).normal(size=len(clock))
    fits = {
        kind: springpot.identify(relaxes(clock, noise), "material", intervals=kind)
        for kind in ("jacobian", "profile", "bootstrap")
    }
    for kind, found in fits.items():
        np.testing.assert_array_equal(found.low, fits["jacobian"].low)
        assert ("as wide as other lines" in " ".join(found.notes)) is (kind == "bootstrap")
    assert fits["jacobian"].low[0] < 100.0 < fits["jacobian"].high[0]
