"""A law goes with what was set, never with a column that tells again what was measured."""

from __future__ import annotations

import numpy as np
import pytest
from lawful_data import AMPLITUDE, OMEGA, lossy, material, swept

import springpot
from springpot.invention.inventing import conditions_of

LEVELS = np.repeat([0.5, 1.0, 1.5, 2.0, 2.5, 3.0], 8)


def with_column(column: np.ndarray) -> list[str]:
    known = {"amplitude": AMPLITUDE, "extra": column}
    return conditions_of(swept(lossy, conditions=known))


K = swept(lossy, seed=9).stiffness
REPEATS = {
    "force": np.abs(K) * AMPLITUDE,
    "storage of another instrument": 1.7 * K.real,
    "lost energy": np.pi * K.imag * AMPLITUDE**2,
    "speed": OMEGA * AMPLITUDE,
    "nominal frequency": np.round(OMEGA / 2.0 / np.pi, 1),
    "number of cycles": np.ceil(OMEGA),
}


@pytest.mark.parametrize("what", REPEATS)
def test_what_repeats_the_measurement_is_no_condition(what: str):
    assert with_column(REPEATS[what]) == ["amplitude"]


def test_what_was_set_is_one_even_where_the_stiffness_tells_it():
    current = np.tile([0.5, 1.0, 1.5], 16)
    data = swept(lambda k, x: k * current, 0.001, conditions={"current": current})
    assert conditions_of(data) == ["current"]
    wandering = LEVELS * (1.0 + 0.01 * np.random.default_rng(2).normal(size=len(LEVELS)))
    assert with_column(wandering * np.tile(np.linspace(1.0, 2.0, 8), 6)[::-1]) == [
        "amplitude",
        "extra",
    ]


def test_tables_beside_a_measurement_are_not_taken_for_conditions():
    assert conditions_of(springpot.read("nist-srm2491")) == ["temperature"]


def test_a_column_that_goes_with_the_frequency_of_a_long_sweep_is_no_condition():
    """Where no frequency returns there is no step at each: a smooth course tells what follows."""
    omega = np.geomspace(0.1, 100.0, 48)
    course = np.exp(0.3 * np.log(omega) ** 2)
    set_by_hand = np.random.default_rng(4).uniform(1.0, 2.0, 48)
    known = {"amplitude": set_by_hand, "extra": course}
    assert conditions_of(springpot.Measurement(omega, material(omega), conditions=known)) == [
        "amplitude"
    ]


@pytest.mark.parametrize(("frequencies", "told"), [(16, []), (17, ["extra"])])
def test_steps_at_each_frequency_need_three_rows_of_each(frequencies, told):
    """Fewer would let any column go with the frequency."""
    rng = np.random.default_rng(5)
    omega = np.resize(np.geomspace(0.1, 100.0, frequencies), 48)
    by_frequency = np.resize(rng.uniform(1.0, 2.0, frequencies), 48)
    known = {"extra": by_frequency}
    assert conditions_of(springpot.Measurement(omega, material(omega), conditions=known)) == told
