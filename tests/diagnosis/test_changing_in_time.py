"""Specimens that cure, dry or break down while they are measured, by a column of times.

And those that do not.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import springpot
from soaked import soaked
from springpot.misfit.drift_search import change_in_order

LONG = np.linspace(60.0, 3600.0, 60)
ROUND = np.array([0.5, 1.0, 2.0, 5.0, 10.0])
HERTZ, TIMES = np.tile(ROUND, 20), 60.0 + 30.0 * np.arange(100)


def network(hertz):
    return 1000.0 * (1j * hertz) ** 0.3


def cured(time):
    """A gel that sets half an hour after it was mixed, a hundred times as stiff."""
    return 0.01 + 1.0 / (1.0 + np.exp(-(time - 1800.0) / 250.0))


def broken_down(time):
    return np.exp(-time / 2000.0)


def dried(time):
    return 1.0 + 0.3 * time / 3600.0


def measured(hertz, stiffness, time, seed=1, noise=0.01, unit="s", **columns):
    scatter = np.random.default_rng(seed).standard_normal((2, len(time)))
    return springpot.Measurement(
        2.0 * np.pi * hertz,
        stiffness * (1.0 + noise * (scatter[0] + 1j * scatter[1])),
        conditions={"time": time, **columns},
        units=springpot.Units("Pa", "-"),
        provenance={"unit time": unit},
    )


def said(found):
    return f"{found.says} {' '.join(found.notes)}"


@pytest.mark.soak_cases("broken_down-falls-breaks down", "cured-rises-cures")
@pytest.mark.parametrize(
    ("course", "verb", "meaning"),
    [
        (cured, "rises", "cures"),
        (broken_down, "falls", "breaks down"),
        soaked(dried, "rises", "dries"),
    ],
)
def test_a_modulus_that_moves_with_time_at_one_frequency_is_told_of_from_start_to_end(
    course, verb, meaning
):
    stiffness = 1000.0 * course(LONG) + 1j * (30.0 + 200.0 * course(LONG))
    found = springpot.diagnose(measured(np.ones(60), stiffness, LONG))
    assert found.verdict == "unexplained"
    assert f"the specimen changes with time: storage {verb} from" in found.says
    assert "between 60 and 3600 s at 1 Hz" in found.says
    assert meaning in said(found)
    # Neither an effect nor a gain of the measuring chain in its place.
    assert found.leading == ()
    assert found.best is None
    assert "measuring chain" not in said(found)
    assert "stand still" in found.next_experiment.says


@pytest.mark.soak
def test_the_first_and_the_last_moduli_are_those_of_the_data():
    found = springpot.diagnose(
        measured(np.ones(60), 1000.0 * cured(LONG) * (1.0 + 0.2j), LONG, noise=1e-4)
    )
    first, last = 1000.0 * cured(LONG)[:6].mean(), 1000.0 * cured(LONG)[-6:].mean()
    told = re.search(r"storage rises from (\S+) to (\S+) Pa \((\S+) times\)", found.says)
    np.testing.assert_allclose(
        [float(each) for each in told.groups()], [first, last, last / first], rtol=0.01
    )


@pytest.mark.soak
def test_a_round_of_frequencies_that_is_measured_again_and_again_is_judged_by_its_last():
    found = springpot.diagnose(measured(HERTZ, network(HERTZ) * cured(TIMES), TIMES))
    assert "the specimen changes with time" in found.says
    assert found.one_test == "time=2910..3030"
    assert "free-vertical-shift" in said(found)


@pytest.mark.soak_cases("0.001", "1.0")
@pytest.mark.parametrize("hertz", [1.0, 1e-3])
def test_the_change_within_one_period_is_told(hertz):
    """At a rate of 1/2000 s a period of 1 s sees 0.05 %, one of 1000 s half of the modulus."""
    found = springpot.diagnose(
        measured(np.full(60, hertz), (1000.0 + 200.0j) * broken_down(LONG), LONG)
    )
    told = re.search(r"changes by at most (\S+) % within one period", said(found))
    assert float(told[1]) == pytest.approx(100.0 / (2000.0 * hertz), rel=0.2)
    assert ("a steady state" in said(found)) == (hertz < 0.01)
    assert "10.1007/BF00369354" in said(found)


@pytest.mark.soak
def test_points_that_came_in_pairs_make_no_change_quicker():
    time = np.repeat(60.0 + 100.0 * np.arange(30), 2) + np.tile([0.0, 0.1], 30)
    found = springpot.diagnose(measured(np.ones(60), (1000.0 + 200.0j) * broken_down(time), time))
    told = re.search(r"changes by at most (\S+) % within one period", said(found))
    assert float(told[1]) == pytest.approx(100.0 / 2000.0, rel=0.3)


@pytest.mark.soak
def test_a_phase_that_moves_while_the_size_stays_is_no_cure():
    found = springpot.diagnose(
        measured(np.ones(60), 1000.0 * np.exp(1j * (0.1 + LONG / 3600.0)), LONG, noise=0.003)
    )
    assert "the specimen changes (its phase, while |K| stays)" in said(found)


@pytest.mark.soak_cases("1")
@pytest.mark.parametrize("seed", [1, *map(soaked, range(2, 6))])
def test_where_nothing_changes_with_time_nothing_is_said_of_it(seed):
    for data in (
        measured(np.ones(60), np.full(60, 1000.0 + 200.0j), LONG, seed),
        measured(HERTZ, network(HERTZ), TIMES, seed),
    ):
        found = springpot.diagnose(data)
        assert found.verdict == "adequate"
        assert "time" not in said(found)


@pytest.mark.soak
def test_where_no_point_was_measured_twice_no_start_and_no_end_are_made_up():
    hertz, celsius = (
        each.ravel() for each in np.meshgrid(np.geomspace(0.1, 10.0, 8), np.linspace(20.0, 60.0, 5))
    )
    order = np.random.default_rng(2).permutation(40)
    hertz, celsius, time = hertz[order], celsius[order], 30.0 * np.arange(40)
    found = springpot.diagnose(
        measured(hertz, (1000.0 + 200.0j * hertz) * broken_down(time), time, temperature=celsius),
        "kelvin",
    )
    assert "the specimen changes with time" in found.says
    assert "no point was measured again" in found.says
    # One point is neither a start nor an end, and a row of each frequency at any temperature is no
    # test.
    assert "stays near" not in found.says
    assert "breaks down" not in said(found)
    assert found.one_test == ""


def test_what_was_left_empty_in_a_column_has_no_place_in_the_order_of_time():
    batch = np.repeat([1.0, np.nan, 2.0], 20)
    data = measured(np.ones(60), (1000.0 + 200.0j) * dried(LONG), LONG, batch=batch)
    assert "storage rises from" in change_in_order(data, "batch")


@pytest.mark.soak_cases("True")
@pytest.mark.parametrize("upwards", [True, soaked(False)])
def test_one_sweep_cannot_tell_time_from_frequency(upwards):
    hertz = np.geomspace(0.1, 10.0, 25)[:: 1 if upwards else -1]
    time = np.cumsum(5.0 / hertz)
    found = springpot.diagnose(
        measured(hertz, network(hertz) * (1.0 + 2.0 * time / time[-1]), time)
    )
    assert found.verdict == "unexplained"
    assert "the specimen changes with time" not in found.says
    assert "the time was not varied by itself but goes with the frequency" in said(found)


@pytest.mark.soak
def test_sweeps_at_several_temperatures_one_after_another_are_no_course_in_time():
    hertz, celsius = (
        np.tile(np.geomspace(0.1, 10.0, 10), 6),
        np.repeat(np.arange(0.0, 90.0, 15.0), 10),
    )
    # Each by a factor that no law gives.
    factor = np.repeat([1.0, 1.3, 0.8, 1.2, 0.7, 1.5], 10)
    found = springpot.diagnose(
        measured(hertz, factor * network(hertz), 30.0 * np.arange(60), temperature=celsius)
    )
    assert "changes with time" not in said(found)


def held_force(hertz, stiffness, time):
    """Strain as a constant stress makes it: the specimen's answer, noise and all."""
    data = measured(hertz, stiffness, time)
    scatter = np.random.default_rng(2).standard_normal(len(time))
    strain = 10.0 / np.abs(data.stiffness) * (1.0 + 1e-3 * scatter)
    return measured(hertz, stiffness, time, amplitude=strain)


@pytest.mark.soak
def test_strain_that_a_held_stress_makes_of_a_curing_gel_is_no_cause():
    found = springpot.diagnose(held_force(np.ones(60), (1000.0 + 200.0j) * cured(LONG), LONG))
    assert "the specimen changes with time" in found.says
    assert found.leading == ()


@pytest.mark.soak
def test_strains_that_were_set_one_after_another_are_the_cause():
    strain = np.geomspace(0.01, 5.0, 20)
    for stiffness, name in (
        ((1000.0 + 200.0j) / (1.0 + strain**1.5), "strain-softening"),
        (20.0 + 5.0j + 4j * 50.0 / (np.pi * strain), "friction"),
    ):
        found = springpot.diagnose(
            measured(np.ones(20), stiffness, 30.0 * np.arange(20.0), amplitude=strain)
        )
        assert found.best.effect == name


@pytest.mark.soak
def test_an_effect_that_is_there_at_all_times_is_named():
    hertz = np.tile(np.geomspace(0.1, 30.0, 13), 4)
    stiffness = network(hertz) - 0.05 * (2.0 * np.pi * hertz) ** 2
    found = springpot.diagnose(measured(hertz, stiffness, 20.0 * np.arange(52.0)))
    assert found.verdict == "effect-missing"
    assert "inertia" in found.best.alike


@pytest.mark.soak
def test_sweeps_that_are_numbered_as_repeats_are_no_noise_where_they_go_with_time():
    hertz, time = np.tile(np.geomspace(0.1, 10.0, 13), 6), 20.0 * np.arange(78.0)
    data = measured(hertz, network(hertz) * (1.0 + time / 1000.0), time)
    repeats = springpot.Measurement(
        data.omega,
        data.stiffness,
        conditions=data.conditions,
        repeat=np.repeat(np.arange(1, 7), 13),
    )
    assert "the specimen changes with time" in springpot.diagnose(repeats).says


@pytest.mark.soak
def test_a_column_whose_values_follow_one_another_in_time_is_told_as_such():
    hertz, time = np.tile(np.geomspace(0.1, 10.0, 13), 6), 20.0 * np.arange(78.0)
    cycle = np.repeat(np.arange(1.0, 7.0), 13)
    found = springpot.diagnose(
        measured(hertz, network(hertz) * (1.0 + time / 1000.0), time, cycle=cycle)
    )
    assert "it goes with cycle" in found.says
    assert "in the order of time, as which cycle stands, storage rises from" in said(found)


@pytest.mark.soak
def test_discovery_accepts_no_effect_in_its_place():
    ladder = springpot.discover(measured(HERTZ, network(HERTZ) * cured(TIMES), TIMES))
    assert [step.accepted for step in ladder.steps] == [None]


@pytest.mark.soak
def test_a_time_of_another_name_is_known_by_its_unit(tmp_path):
    stiffness = (1000.0 + 200.0j) * dried(LONG)
    scatter = np.random.default_rng(1).standard_normal((2, 60))
    noisy = stiffness * (1.0 + 0.01 * (scatter[0] + 1j * scatter[1]))
    rows = zip(LONG / 60.0, noisy.real, noisy.imag, strict=True)
    lines = [f"1,{k1:.6g},{k2:.6g},{t:.6g}" for t, k1, k2 in rows]
    path = tmp_path / "drying.csv"
    path.write_text("\n".join(["frequency [Hz],storage [Pa],loss [Pa],elapsed time [min]", *lines]))
    assert "between 1 and 60 min" in springpot.diagnose(springpot.read(path)).says


@pytest.mark.soak
def test_factors_at_each_time_can_be_diagnosed():
    """The next experiment has a time of its own.

    Before, it had none and the diagnosis ended in a fault.
    """
    hertz, time = np.tile(np.geomspace(0.1, 10.0, 13), 6), 20.0 * np.repeat(np.arange(6.0), 13)
    data = measured(hertz, network(hertz) * (1.0 + time / 100.0), time + 1.0)
    found = springpot.diagnose(data, "material + free-vertical-shift:time")
    assert found.error.relative_rms < 1.5 * found.error.noise_floor
