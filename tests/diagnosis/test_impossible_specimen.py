"""A misfit that a wave in a specimen would follow best if that were a metre thick.

Not named, and told.
"""

import numpy as np
import pytest

import springpot

HERTZ = np.geomspace(1.0, 30.0, 21)
TRUTH = {"k1": 2e6, "k2": 1e6, "c": 2e4}


def diagnosed(effect, mass, hertz=HERTZ, unit="Pa"):
    """A measured solid in which a wave runs; its mass in kg/m."""
    model = springpot.parse_model(f"zener + {effect}")
    known = {**TRUTH, f"{effect}.m": mass}
    still = springpot.Measurement(2.0 * np.pi * hertz, np.ones(len(hertz), complex))
    exact = model.stiffness(np.array([known[name] for name in model.names]), still.points)
    real, imaginary = 0.001 * np.random.default_rng(1).normal(size=(2, len(hertz)))
    units = springpot.Units(unit, "-")
    scale = {"Pa": 1.0, "MPa": 1e-6}[unit]
    stiffness = scale * exact * (1.0 + real + 1j * imaginary)
    data = springpot.Measurement(still.omega, stiffness, units=units)
    few = ["specimen-inertia", "specimen-inertia-fixed", "inertia", "series-spring", "time-delay"]
    return springpot.diagnose(data, springpot.parse_model("zener"), only=few)


@pytest.mark.soak_cases("specimen-inertia-fixed-MPa", "specimen-inertia-Pa")
@pytest.mark.suite_cases("specimen-inertia-Pa", "specimen-inertia-fixed-MPa")
@pytest.mark.parametrize("unit", ["Pa", "MPa"])
@pytest.mark.parametrize("effect", ["specimen-inertia", "specimen-inertia-fixed"])
def test_a_specimen_a_metre_thick_is_not_named(effect, unit):
    found = diagnosed(effect, 1000.0 * 0.7**2, unit=unit)
    assert effect not in found.leading
    assert any(
        f"{effect} would explain much" in note and "unit of the modulus" in note
        for note in found.notes
    )


@pytest.mark.soak
def test_a_specimen_of_a_few_centimetres_is():
    found = diagnosed("specimen-inertia", 1000.0 * 0.05**2, hertz=10.0 * HERTZ)
    assert "specimen-inertia" in found.leading
