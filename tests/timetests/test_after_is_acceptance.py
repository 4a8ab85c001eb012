"""What a diagnosis in time prints as the error after an effect is what its acceptance gives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import springpot
from springpot.measurement.opening import Test

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
    for each in fitted[:3]:
        accepted = springpot.identify(tests, f"zener + {each.effect}").tests
        # Of several tests the one that is missed most.
        worst = max(accepted, key=lambda test: test.over_floor)
        assert worst.relative_rms == pytest.approx(each.error_after, rel=0.02)


def test_what_was_not_fitted_is_foretold_and_not_after(rng: np.random.Generator) -> None:
    for each in springpot.diagnose([relaxation(rng)], "zener").candidates:
        assert np.isfinite(each.error_after) != np.isfinite(each.predicted_error)
        assert bool(each.parameters) == np.isfinite(each.error_after)
