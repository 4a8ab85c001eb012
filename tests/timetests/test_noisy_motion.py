"""Records of a motion that is smooth, does not repeat and was read with noise or in digits."""

import numpy as np
import pytest

import springpot
from springpot.measurement import Loading, TimeTest
from springpot.misfit.residuals_of_tests import part_of
from springpot.registry import plugins
from springpot.timetests.hypotheses import noise_answer

STEP, COUNT = 0.002, 1500
SPRING, DASHPOT = 200.0, 0.8


def moved(rng):
    """Place, speed and acceleration of forty waves up to 20 Hz, in mm."""
    t = STEP * np.arange(COUNT)
    turns = 2.0 * np.pi * rng.uniform(0.2, rng.uniform(5.0, 20.0), 40)
    waves = rng.normal(size=40) / (1.0 + turns / 6.0)
    turned = waves[:, None] * np.exp(1j * (np.outer(turns, t) + rng.uniform(0.0, 6.0, (40, 1))))
    place = turned.sum(0).imag
    return [
        part / np.std(place) for part in (place, (turns @ turned).real, -(turns**2 @ turned).imag)
    ]


def read_and_force(rng, mass, digits, share):
    """What transducers say of a spring and a dashpot beside a mass in kg."""
    place, speed, push = moved(rng)
    force = SPRING * place + DASHPOT * speed + 1e-3 * mass * push
    read = place + share * rng.normal(size=COUNT)
    if digits:
        read = np.round(place, 3)
    return read, force + 0.01 * np.std(force) * rng.normal(size=COUNT)


def record(rng, mass, digits, share):
    """The same as a record."""
    read, force = read_and_force(rng, mass, digits, share)
    return TimeTest.of_history(STEP * np.arange(COUNT), read, force, "mm", "N")


def mass_of(test):
    return springpot.identify(test, "kelvin + inertia").parameters["inertia.m"]


@pytest.mark.soak
def test_a_mass_is_found_that_a_motion_as_it_was_read_hides():
    t = STEP * np.arange(COUNT)
    read, force = read_and_force(np.random.default_rng(1), 100.0, False, 0.005)
    as_read = TimeTest(t, force, Loading(t, read, sampled=True), "displacement", "mm", "N")
    hidden, found = mass_of(as_read), mass_of(TimeTest.of_history(t, read, force, "mm", "N"))
    print(*(f"{each.value:.4g} [{each.low:.4g}, {each.high:.4g}] kg" for each in (hidden, found)))
    assert hidden.high < 50.0
    assert found.low < 100.0 < found.high < 1.02 * found.low


def test_samples_may_be_left_out_of_a_record_whose_motion_was_noisy():
    test = record(np.random.default_rng(1), 100.0, False, 0.005)
    some = test.subset(np.arange(COUNT) % 10 > 0)
    mass = mass_of(some)
    assert mass.low < 100.0 < mass.high < 1.02 * mass.low


@pytest.mark.soak
@pytest.mark.parametrize("digits", [False, True])
def test_intervals_hold_what_noise_of_the_motion_would_hide(digits):
    held, count = 0, 30
    for seed in range(count):
        rng = np.random.default_rng(seed)
        mass = rng.uniform(20.0, 150.0)
        test = record(rng, mass, digits, 10.0 ** rng.uniform(-3.2, -1.8))
        told = mass_of(test)
        held += told.low <= mass <= told.high
    print(f"{held} of {count} intervals hold the mass, digits {digits}")
    assert held >= 0.85 * count


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(4))
def test_a_mass_is_named_where_it_is_and_not_where_it_is_not(seed):
    rng = np.random.default_rng(seed)
    with_mass, without = (record(rng, mass, False, 0.005) for mass in (100.0, 0.0))
    found = springpot.diagnose(with_mass, "kelvin")
    assert found.verdict == "effect-missing"
    assert "inertia" in found.leading
    assert springpot.diagnose(without, "kelvin").verdict in {"adequate", "inconclusive"}


def test_what_is_answered_to_noise_is_told_of_a_record_of_few_samples():
    rng, t = np.random.default_rng(1), STEP * np.arange(40)
    place = np.sin(60.0 * t)
    read, force = (part + 0.01 * rng.normal(size=40) for part in (place, place))
    part = part_of(TimeTest.of_history(t, read, SPRING * force, "mm", "N"))
    answer = noise_answer(part, plugins().model("kelvin"), np.array([SPRING, DASHPOT]), 293.15)
    assert part.imposed.noise > 0.0
    assert np.isfinite(answer).all()
    assert answer.any()
