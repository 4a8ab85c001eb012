"""An amplitude sweep that fits best where a specimen would be hotter than any.

Something is missing, by no name.
"""

import numpy as np
import pytest

import springpot

STRAIN = np.geomspace(0.01, 1.0, 21)
TRUTH = {"k1": 300.0, "k2": 300.0, "c": 60.0, "self-heating.s": 0.03}
YIELDING = {"k": 190.0, "F": 80.0, "n": 1.1, "beta": 0.19}


@pytest.fixture(scope="module")
def diagnosis():
    model = springpot.parse_model("zener + smooth-hysteresis + self-heating")
    known = {**TRUTH, **{f"smooth-hysteresis.{name}": value for name, value in YIELDING.items()}}
    omega = np.full(len(STRAIN), 2.0 * np.pi)
    still = springpot.Measurement(
        omega, np.ones(len(STRAIN), complex), conditions={"amplitude": STRAIN}
    )
    exact = model.stiffness(np.array([known[name] for name in model.names]), still.points)
    real, imaginary = 0.0005 * np.random.default_rng(1).normal(size=(2, len(STRAIN)))
    return springpot.diagnose(
        springpot.Measurement(
            omega,
            exact * (1.0 + real + 1j * imaginary),
            conditions={"amplitude": STRAIN},
            units=springpot.Units("Pa", "-"),
        )
    )


@pytest.mark.soak
def test_it_is_told_but_not_named(diagnosis):
    assert any("no specimen reaches" in note for note in diagnosis.notes)
    assert "self-heating" not in diagnosis.says
    assert "self-heating" not in diagnosis.leading


@pytest.mark.soak
def test_its_place_is_that_of_the_unknown(diagnosis):
    assert diagnosis.verdict == "unexplained"
    assert all(row.verdict != "missing" for row in diagnosis.candidates)
