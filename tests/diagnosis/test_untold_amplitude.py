"""What an amplitude would tell is not named with certainty where no column tells the amplitude."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_data import KELVIN, design, exact, measured

import springpot
from springpot.diagnosis.grown import untold_in_place

AT = design(30, 0.1, 50.0)
LIBRARY = ["hysteretic-loss", "friction", "inertia", "time-delay", "cubic-stiffness"]


def diagnosed(stiffness, only=LIBRARY, conditions=None):
    data = measured(AT, stiffness, 1, 0.01)
    if conditions:
        data = springpot.Measurement(
            data.omega, data.stiffness, sd=data.sd, conditions=conditions, name="held"
        )
    return springpot.diagnose(data, "fractional-kelvin", only=only)


LOSS = exact(KELVIN, AT) + 1j * 0.2 * np.median(np.abs(exact(KELVIN, AT)))


def test_a_constant_loss_may_be_dry_friction_at_one_amplitude():
    found = diagnosed(LOSS)
    assert found.verdict == "effect-missing"
    assert found.candidates[0].effect == "hysteretic-loss"
    assert found.candidates[0].probability == pytest.approx(0.7, abs=0.01)
    assert "or in place of hysteretic-loss friction, the same curve" in found.says
    assert "in a column amplitude" in found.next_experiment.says


@pytest.mark.soak
def test_a_rung_says_what_it_may_be_as_well():
    data = measured(AT, LOSS, 1, 0.01)
    ladder = springpot.discover(data, "fractional-kelvin", only=LIBRARY, accept="hysteretic-loss")
    assert ladder.steps[-1].alike == ("hysteretic-loss", "friction")


def test_one_amplitude_that_is_told_makes_them_rivals():
    found = diagnosed(LOSS, conditions={"amplitude": np.full(len(AT.omega), 0.5e-3)})
    assert set(found.classes[0]) == {"friction", "hysteretic-loss"}
    assert "no column" not in found.says


@pytest.mark.suite_cases("a user who knows that there is no friction")
@pytest.mark.parametrize(
    ("hidden", "only"),
    [
        (exact(KELVIN, AT) - 2.0 * AT.omega**2, LIBRARY),
        (LOSS, ["hysteretic-loss", "inertia"]),
    ],
    ids=["another curve", "a user who knows that there is no friction"],
)
def test_nothing_else_is_doubted(hidden, only):
    found = diagnosed(hidden, only)
    assert found.verdict == "effect-missing"
    assert found.candidates[0].probability > 0.95
    assert "no column" not in found.says


def test_without_a_grown_model_nothing_is_asked():
    class Nothing:
        class base:
            class fit:
                measurement = springpot.Measurement([1.0], [1.0 + 1.0j])

        grown = ()

    assert untold_in_place(Nothing, []) is None
