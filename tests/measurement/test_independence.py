"""How far a condition was varied by itself."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from springpot import Measurement
from springpot.measurement import independent, spread_of, steadied

OMEGA = 2.0 * np.pi * np.geomspace(0.01, 100.0, 31)
GLASSY = 1.0 / (1e-3 + 0.05 * (1j * OMEGA) ** -0.6)


def data(omega, amplitude=None, temperature=None):
    conditions = {"amplitude": amplitude, "temperature": temperature}
    given = {
        name: np.asarray(column, dtype=float)
        for name, column in conditions.items()
        if column is not None
    }
    return Measurement(omega, np.full(len(omega), 1.0 + 0.1j), conditions=given)


def grid(*axes):
    return [axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")]


def test_without_the_column_there_is_nothing_to_say():
    assert spread_of(data(OMEGA), "amplitude") is None
    assert not independent(data(OMEGA), "temperature")
    bare = data(OMEGA)
    assert steadied(bare) is bare


def test_amplitudes_at_every_frequency_are_independent_by_their_distance():
    omega, x = grid(OMEGA[::4], [1.0, 3.0])
    spread = spread_of(data(omega, x), "amplitude")
    assert spread.own == pytest.approx(np.log(3.0), rel=0.1)
    assert spread.independent


def test_a_sweep_of_amplitudes_at_one_frequency_is_independent():
    assert independent(data(np.full(15, 6.0), np.geomspace(0.01, 10.0, 15)), "amplitude")


@pytest.mark.parametrize(
    "levels", [np.geomspace(0.1, 10.0, 31), np.where(np.arange(31) % 2, 1.0, 1.3)]
)
def test_amplitudes_in_random_order_are_independent(levels):
    assert independent(data(OMEGA, np.random.default_rng(3).permutation(levels)), "amplitude")


def test_strain_that_a_rheometer_holds_within_four_per_cent_was_not_varied():
    held = data(OMEGA, 0.5 * (1.0 + 0.04 * np.sin(np.linspace(0.0, 4.0, 31))))
    spread = spread_of(held, "amplitude")
    assert not spread.varied
    steady = steadied(held)
    assert np.ptp(steady.conditions["amplitude"]) == 0.0
    assert steady.conditions["amplitude"][0] == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("resonance", [0.0, 1.0], ids=["plain", "with a resonance of the rig"])
def test_under_a_held_force_the_amplitude_only_follows_the_specimen(resonance):
    drive = 1.0 + resonance * 4.0 * np.exp(-(((np.log(OMEGA) - np.log(250.0)) / 0.3) ** 2))
    swept = data(OMEGA, 500.0 * drive / np.abs(GLASSY))
    spread = spread_of(swept, "amplitude")
    assert spread.varied
    assert not spread.independent
    assert steadied(swept) is swept


def test_two_held_forces_are_a_choice():
    follows = 500.0 / np.abs(GLASSY)
    assert independent(data(np.tile(OMEGA, 2), np.r_[follows, 3.0 * follows]), "amplitude")


def test_strain_chosen_for_each_temperature_belongs_to_the_temperature():
    omega, celsius = grid(OMEGA[::3], np.linspace(-40.0, 60.0, 6))
    chosen = data(omega, 1e-3 * 10.0 ** ((celsius + 40.0) / 50.0), celsius)
    assert not independent(chosen, "amplitude")
    assert independent(chosen, "temperature")


def test_a_ramp_of_temperature_under_a_held_force_leaves_the_amplitude_no_choice():
    celsius = np.linspace(-40.0, 60.0, 60)
    ramp = data(np.full(60, 6.28), 1e-3 * np.exp(0.05 * celsius), celsius)
    assert not independent(ramp, "amplitude")
    assert independent(ramp, "temperature")


def test_one_strain_sweep_among_many_frequency_sweeps_is_enough():
    omega, celsius = grid(OMEGA, [0.0, 25.0, 50.0])
    sweep = np.geomspace(1e-4, 1e-1, 12)
    whole = data(
        np.r_[omega, np.full(12, 62.8)],
        np.r_[np.full(len(omega), 1e-3), sweep],
        np.r_[celsius, np.full(12, 25.0)],
    )
    assert independent(whole, "amplitude")


def test_an_oven_that_drifts_or_warms_with_frequency_was_not_set():
    drifting = data(OMEGA, temperature=25.0 + np.random.default_rng(1).normal(0.0, 0.2, 31))
    warming = data(OMEGA, temperature=25.0 + np.linspace(0.0, 6.0, 31))
    assert not spread_of(drifting, "temperature").varied
    assert spread_of(warming, "temperature").varied
    assert not independent(warming, "temperature")


@pytest.mark.soak
@settings(max_examples=30, deadline=None)
@given(st.floats(1e-6, 1e6), st.integers(0, 2**32 - 1))
def test_units_and_order_of_rows_do_not_matter(factor, seed):
    rng = np.random.default_rng(seed)
    x = rng.choice([0.3, 1.0, 2.0], 31) * (1.0 + 0.1 * OMEGA**0.1)
    order = rng.permutation(31)
    one, other = (
        spread_of(data(OMEGA, x), "amplitude"),
        spread_of(data(OMEGA[order], factor * x[order]), "amplitude"),
    )
    assert other.own == pytest.approx(one.own, rel=1e-6)
    assert other.whole == pytest.approx(one.whole, rel=1e-9)
    assert other.own <= other.whole
