"""What a diagnosis in time prints as the error after an effect is what its acceptance gives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import springpot
from springpot.measurement.opening import Test
from springpot.misfit.error import percent

pytestmark = pytest.mark.usefixtures("asked_once")

CLOCK = np.geomspace(0.02, 200.0, 30)
NOISE = 0.004


def relaxation(rng: np.random.Generator) -> springpot.TimeTest:
    """A standard solid with a second mode that its model lacks."""
    force = 2.0 + 3.0 * np.exp(-CLOCK / 0.5) + 1.0 * np.exp(-CLOCK / 20.0)
    return springpot.TimeTest.of_relaxation(
        CLOCK, force * (1.0 + NOISE * rng.standard_normal(len(CLOCK)))
    )


def creep(rng: np.random.Generator) -> springpot.TimeTest:
    """A standard solid that flows slowly."""
    moved = 1.0 - 0.6 * np.exp(-CLOCK / 2.0) + 0.004 * CLOCK
    return springpot.TimeTest.of_compliance(
        CLOCK, moved * (1.0 + NOISE * rng.standard_normal(len(CLOCK)))
    )


def record(rng: np.random.Generator) -> springpot.TimeTest:
    """A standard solid that is moved to and fro, and carries a mass."""
    clock = np.linspace(0.0, 12.0, 300)
    moved = np.sin(1.5 * clock) * (1.0 - np.exp(-clock))
    model = springpot.parse_model("zener + inertia")
    force = model.respond(model.theta(k1=2.0, k2=3.0, c=1.5, inertia__m=0.15), clock, moved)
    noise = NOISE * np.std(force) * rng.standard_normal(len(clock))
    return springpot.TimeTest.of_history(clock, moved, force + noise, "mm", "N")


def sweep(rng: np.random.Generator) -> springpot.Measurement:
    """The first of them at frequencies."""
    omega = np.geomspace(0.05, 50.0, 16)
    stiffness = 2.0 + 3.0 * omega / (omega - 2.0j) + omega / (omega - 0.05j)
    noise = 1.0 + NOISE * (rng.standard_normal(16) + 1j * rng.standard_normal(16))
    return springpot.Measurement(omega, stiffness * noise)


FEW = ["inertia", "parallel-springpot", "parallel-dashpot", "series-spring", "force-drift"]


@pytest.mark.suite_cases("record")
@pytest.mark.parametrize("kind", ["relaxation", "creep", "record", "joint"])
def test_what_is_printed_as_after_is_what_acceptance_gives(
    kind: str, rng: np.random.Generator
) -> None:
    tests: Sequence[Test] = {
        "relaxation": lambda: [relaxation(rng)],
        "creep": lambda: [creep(rng)],
        "record": lambda: [record(rng)],
        "joint": lambda: [relaxation(rng), sweep(rng)],
    }[kind]()
    found = springpot.diagnose(tests, "zener", only=FEW)
    fitted = [each for each in found.candidates if np.isfinite(each.error_after)]
    assert fitted
    # Of several tests before and after are of the one that the model misses most.
    at = max(range(len(tests)), key=lambda i: found.tests[i].over_floor)
    assert found.error.relative_rms == found.tests[at].relative_rms
    for each in fitted[:3]:
        accepted = springpot.identify(tests, f"zener + {each.effect}").tests[at]
        assert accepted.relative_rms == pytest.approx(each.error_after, rel=0.02)
        ratio = each.error_after / found.error.noise_floor
        assert each.over_floor == pytest.approx(ratio, rel=1e-6)


def late(rng: np.random.Generator, noise: float = 0.001) -> springpot.Measurement:
    """A standard solid at frequencies, whose channels are sampled at different instants."""
    omega = np.geomspace(0.5, 200.0, 20)
    stiffness = (2.0 + 3.0 * omega / (omega - 2.0j)) * np.exp(3e-3j * omega)
    scatter = 1.0 + noise * (rng.standard_normal(20) + 1j * rng.standard_normal(20))
    return springpot.Measurement(omega, stiffness * scatter, name="late")


@pytest.mark.soak
def test_numbers_of_one_line_are_of_the_test_that_is_missed_most(
    rng: np.random.Generator,
) -> None:
    # The sweep lacks a delay that no step can have; the steps are those of the model, with noise.
    force = 2.0 + 3.0 * np.exp(-CLOCK / 0.5)
    steps = springpot.TimeTest.of_relaxation(
        CLOCK, force * (1.0 + 0.02 * rng.standard_normal(len(CLOCK))), name="steps"
    )
    ladder = springpot.discover([steps, late(rng)], "zener", accept=["time-delay"])
    first, last = ladder.steps
    found = first.diagnosis
    assert (found.error.test, first.test, found.best.effect) == ("late", "late", "time-delay")
    sweep = next(test for test in last.tests if test.name == "late")
    # What noise leaves is no more than what a model leaves, of the same test.
    assert found.best.error_after > 0.9 * found.error.noise_floor
    assert found.best.error_after == pytest.approx(sweep.relative_rms, rel=0.02)
    after = percent(sweep.relative_rms)
    assert f"-> {after} with time-delay, {found.best.over_floor:.1f} x floor" in str(found)
    assert f"error of late {percent(first.relative_rms)} -> {after}, " in str(ladder)
    assert str(springpot.Diagnosis.from_dict(found.to_dict())) == str(found)


def test_places_of_the_test_that_is_missed_most_come_first(rng: np.random.Generator) -> None:
    found = springpot.diagnose([relaxation(rng), late(rng)], "zener", only=["time-delay"])
    ratios = {test.name: test.over_floor for test in found.tests}
    named = [ratios[place.condition] for place in found.where]
    assert named[0] == max(ratios.values())
    assert named == sorted(named, reverse=True)
    place = next(place for place in found.where if place.condition == "late")
    # A delay grows with frequency and takes from the loss.
    assert place.high == pytest.approx(200.0 / (2.0 * np.pi))
    assert "late: loss " in place.says


@pytest.mark.soak
def test_what_was_not_fitted_is_foretold_and_not_after(rng: np.random.Generator) -> None:
    for each in springpot.diagnose([relaxation(rng)], "zener").candidates:
        assert np.isfinite(each.error_after) != np.isfinite(each.predicted_error)
        assert bool(each.parameters) == np.isfinite(each.error_after)
