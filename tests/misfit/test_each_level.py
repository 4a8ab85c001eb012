"""Each temperature by itself: what is no material there, and what no shift can join."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import springpot
from soaked import soaked
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.frame import NoiseFrame
from springpot.misfit.material import notes_on_levels
from springpot.registry import plugins

OMEGA = np.geomspace(0.1, 100.0, 16)
CELSIUS = np.array([-10.0, 0.0, 10.0, 20.0, 30.0])
MODEL = springpot.parse_model("fractional-zener")
TRUTH = np.array([100.0, 900.0, 60.0, 0.5])


def melt(seed, slow=0.0, phase=0.0):
    """Five sweeps with 0.3 % noise.

    `slow` moves a second process by its own factor, `phase` turns the coldest.
    """
    rng = np.random.default_rng(seed)
    omega, celsius = np.tile(OMEGA, 5), np.repeat(CELSIUS, 16)
    shift = np.exp(-0.12 * (celsius - 10.0))
    stiffness = MODEL.stiffness(TRUTH, omega * shift)
    if slow:
        other = omega * shift**slow
        stiffness = stiffness + 80.0 * 1j * other / (1.0 + 1j * other)
    coldest = celsius == CELSIUS[0]
    stiffness = stiffness * np.exp(1j * phase * coldest * np.log(omega / OMEGA[0]))
    noise = 0.003 * (rng.normal(size=80) + 1j * rng.normal(size=80))
    return springpot.Measurement(
        omega, stiffness * (1.0 + noise), conditions={"temperature": celsius}
    )


def notes(measurement):
    base = fitted_to_floor(springpot.parse_model("material + wlf-shift"), measurement, [])
    return list(notes_on_levels(base, list(plugins().items("effect"))))


@pytest.mark.soak_cases("1", "2", "0", "3", "4")
@pytest.mark.parametrize("seed", [*range(5), *map(soaked, range(5, 20))])
def test_nothing_is_told_of_a_melt_that_one_shift_joins(seed):
    assert notes(melt(seed)) == []


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(3))
def test_a_level_that_is_no_material_is_named_and_no_other(seed):
    (told,) = notes(melt(seed, phase=0.02))
    assert told.startswith("no linear passive material behaves as at -10 degC: ")


@pytest.mark.soak_cases("0", "1", "2")
@pytest.mark.parametrize("seed", range(3))
def test_two_processes_that_shift_apart_are_told(seed):
    (told,) = notes(melt(seed, slow=0.3))
    assert told.startswith("no shift of times and moduli lays the temperatures over one another")
    assert "not thermorheologically simple" in told


def test_a_single_temperature_tells_nothing_of_shifts():
    data = melt(0, slow=0.3)
    assert notes_free(data.subset(np.arange(16))) == []


def notes_free(measurement):
    base = fitted_to_floor(springpot.parse_model("material"), measurement, [])
    return list(notes_on_levels(base, list(plugins().items("effect"))))


def test_at_zero_degrees_throughout_nothing_goes_with_the_temperature(recwarn):
    data = melt(0).subset(np.arange(16))
    at_zero = replace(data, conditions={"temperature": np.zeros(16)})
    k = data.stiffness
    frame = NoiseFrame(at_zero, k, np.full(16, 1.0 + 1.0j), k[None])
    assert not frame.trends["temperature"].size
    assert not recwarn.list
