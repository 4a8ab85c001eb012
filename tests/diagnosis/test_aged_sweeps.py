"""A few sweeps of one specimen, each at an age that was chosen.

The age is what the misfit goes with.
"""

import numpy as np
import pytest

import springpot
from springpot.measurement import settings_of

ROUND = np.geomspace(0.5, 10.0, 8)
AGES = np.array([5.0, 20.0, 30.0, 40.0, 50.0])
OMEGA, MINUTES = np.tile(ROUND, len(AGES)), np.repeat(AGES, len(ROUND))


def setting_gel(omega, minutes):
    """A liquid that becomes a gel at the end."""
    return 0.006 * np.exp(minutes / 15.0) * (1j * omega) ** (1.0 - minutes / 120.0)


def table(stiffness, omega=OMEGA, minutes=MINUTES, seed=1):
    scatter = np.random.default_rng(seed).normal(0.0, 0.01, (2, len(omega)))
    return springpot.Measurement(
        omega,
        stiffness * (1.0 + scatter[0] + 1j * scatter[1]),
        conditions={"time": minutes},
        units=springpot.Units("Pa", "-"),
        provenance={"unit time": "min"},
    )


@pytest.fixture(scope="module")
def found():
    some = ["inertia", "gain-error", "phase-error"]
    return springpot.diagnose(table(setting_gel(OMEGA, MINUTES)), only=some)


@pytest.mark.soak
def test_the_age_is_named_as_what_the_misfit_goes_with(found):
    assert found.verdict == "unexplained"
    assert "it goes with time, the specimen is another in each sweep" in found.says
    assert not any("measuring chain" in note for note in found.notes)


@pytest.mark.soak
def test_one_age_can_be_chosen_by_the_next_step(found):
    assert any("choose one by '@time=5'" in note for note in found.notes)
    chosen = springpot.measurement.select(table(setting_gel(OMEGA, MINUTES)), {"time": "5"})
    assert springpot.diagnose(chosen).verdict == "adequate"


@pytest.mark.soak
def test_ages_of_a_specimen_that_stays_are_told_of_nothing():
    told = springpot.diagnose(table(setting_gel(OMEGA, np.full(len(OMEGA), 30.0))))
    assert told.verdict == "adequate"
    assert "goes with time" not in told.says


def test_a_time_that_was_rounded_within_one_sweep_is_no_age():
    """Nine frequencies in three minutes, to the minute."""
    omega = np.geomspace(100.0, 0.1, 9)
    data = table(setting_gel(omega, 30.0), omega, np.repeat([1.0, 2.0, 3.0], 3))
    assert settings_of(data) == {}


def test_a_note_on_negative_values_is_not_told_of_rows_that_have_none():
    data = table(setting_gel(OMEGA, MINUTES))
    stiffness = np.where(MINUTES == 5.0, -data.stiffness, data.stiffness)
    notes = {"note storage": "negative in 8 of 40 rows", "note loss": "negative in 8 of 40 rows"}
    noted = springpot.Measurement(
        OMEGA, stiffness, conditions=dict(data.conditions), provenance=notes
    )
    assert dict(noted.subset(MINUTES == 50.0).provenance) == {}
    assert "note loss" in noted.subset(MINUTES < 30.0).provenance
