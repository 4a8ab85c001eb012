"""Faults of the measuring chain that no effect of the library is.

Told as such, not given the nearest name.
"""

import numpy as np
import pytest
from hidden_data import KELVIN, ZENER, design, exact, hidden, measured

import springpot
from soaked import soaked

SWEEP = design(60, 0.1, 100.0)
FIELD = design(12, 0.3, 30.0, temperatures=(5.0, 20.0, 35.0, 50.0))


def gain(at, kind):
    """A real factor near one: a step of the range, creep along frequency, creep from row to row."""
    x = np.log(at.omega)
    x = (x - x.min()) / np.ptp(x)
    if kind == "steps":
        return 1.0 + 0.05 * (at.omega > 2.0 * np.pi * 5.0)
    return 1.0 + 0.15 * (1.0 - np.exp(-x / 0.3))


def told(diagnosis, words):
    return [note for note in diagnosis.notes if words in note]


@pytest.mark.soak_cases("base0-steps", "base1-changes slowly")
@pytest.mark.parametrize(
    ("base", "kind"),
    [
        (KELVIN, "steps"),
        (ZENER, "changes slowly"),
        soaked(ZENER, "steps"),
        soaked(KELVIN, "changes slowly"),
    ],
)
def test_a_gain_that_steps_or_creeps_is_the_chain_and_no_effect(base, kind):
    stiffness = exact(base, SWEEP) * gain(SWEEP, kind)
    diagnosis = springpot.diagnose(measured(SWEEP, stiffness, level=0.004), base.name)
    assert diagnosis.verdict == "unexplained"
    assert diagnosis.where
    assert not [c.effect for c in diagnosis.candidates if c.verdict == "missing"]
    assert diagnosis.evidence["unknown"] > 0.95
    (note,) = told(diagnosis, f"a gain that {kind}")
    assert told(diagnosis, "the measuring chain")
    if kind == "steps":
        assert placed(note) == pytest.approx(5.0, rel=0.15)


def placed(note):
    """The frequency in Hz at which a step is told."""
    return float(note.partition("steps at ")[2].partition(" Hz")[0])


@pytest.mark.soak
def test_a_gain_that_creeps_with_time_is_no_temperature_effect():
    """Temperatures are measured one after the other, so that time and temperature go together."""
    order = np.lexsort((FIELD.omega, FIELD.celsius))
    at = type(FIELD)(FIELD.omega[order], None, FIELD.celsius[order])
    creep = 1.0 + 0.12 * (1.0 - np.exp(-np.arange(len(order)) / (0.3 * len(order))))
    diagnosis = springpot.diagnose(
        measured(at, exact(KELVIN, at) * creep, level=0.003), KELVIN.name
    )
    assert diagnosis.verdict == "unexplained"
    assert told(diagnosis, "from row to row")


@pytest.mark.soak_cases("time-delay")
@pytest.mark.parametrize(
    "effect",
    ["time-delay", "phase-error", *map(soaked, ("inertia", "parallel-dashpot", "series-spring"))],
)
def test_an_effect_is_not_taken_for_a_fault_of_the_chain(effect):
    base = ZENER if effect == "inertia" else KELVIN
    diagnosis = springpot.diagnose(hidden(base, SWEEP, effect, 1000.0), base.name)
    assert diagnosis.verdict == "effect-missing"
    # Of a dashpot beside the springpot it is 0.02, of the others below 0.01.
    assert diagnosis.evidence["unknown"] < 0.05
    assert not told(diagnosis, "the measuring chain")


@pytest.mark.soak
def test_a_step_is_sought_among_many_frequencies_too(monkeypatch):
    """Of many places some are tried.

    Here of forty-five a third, as few of them are as much of a test.
    """
    monkeypatch.setattr("springpot.diagnosis.marginal.MOST_STEPS", 15)
    dense = design(45, 0.1, 100.0)
    (note,) = told(
        springpot.diagnose(
            measured(dense, exact(KELVIN, dense) * gain(dense, "steps"), level=0.01), KELVIN.name
        ),
        "steps at",
    )
    assert placed(note) == pytest.approx(5.0, rel=0.15)


@pytest.mark.soak
def test_an_effect_that_is_needed_twice_may_be_a_part_of_another_shape():
    """A skewed spectrum (Havriliak and Negami 1967) looks like two modes or more."""
    omega, rng = np.geomspace(0.01, 1000.0, 60), np.random.default_rng(1)
    exact = 1000.0 + 9000.0 * (1.0 - (1.0 + (1j * omega) ** 0.7) ** -0.75)
    noise = 0.003 * (rng.normal(size=60) + 1j * rng.normal(size=60))
    found = springpot.diagnose(
        springpot.Measurement(omega, exact * (1.0 + noise)), "fractional-zener"
    )
    assert found.verdict == "effect-missing"
    assert found.candidates[0].probability < 0.8
    assert "in their place" in found.says
    assert found.evidence["unknown"] == pytest.approx(0.3, abs=0.05)
