"""Records of a cyclic motion: of one that had gone on before, and of one that began at rest."""

import numpy as np
import pytest

import springpot
from springpot.measurement import TimeTest
from springpot.measurement.imposed import Loading
from springpot.measurement.steady_start import gone_on, stepped_to
from springpot.timetests import diagnose, identify, recorded

HERTZ, PERIOD = 50.0, 1.0
T = np.arange(int(8 * HERTZ)) / HERTZ
MODEL = springpot.parse_model("fractional-zener")
THETA = MODEL.theta(k1=20.0, k2=60.0, c=8.0, alpha=0.6)


def moved(t):
    return np.sin(2.0 * np.pi * t / PERIOD) + 0.4 * np.sin(4.0 * np.pi * t / PERIOD + 1.0)


def rest():
    """Force of the material that began to move at the first sample."""
    return recorded(MODEL, THETA, TimeTest.planned(T, moved(T), "mm")).value


def for_ever():
    """Force of the material that has moved like that for ever, from its K."""
    omega = 2.0 * np.pi / PERIOD * np.array([1.0, 2.0])
    amplitude = np.array([1.0, 0.4 * np.exp(1j)]) / 1j
    waves = MODEL.stiffness(THETA, omega) * amplitude * np.exp(1j * omega * T[:, None])
    return waves.real.sum(axis=1)


def record(force):
    noise = 0.004 * np.std(force) * np.random.default_rng(5).normal(size=len(T))
    return TimeTest.of_history(T, moved(T), force + noise, "mm", "N", control="displacement")


@pytest.fixture(scope="module")
def steady():
    return record(for_ever())


def test_a_record_of_a_motion_that_had_gone_on_begins_before_its_first_sample(steady):
    loading = steady.loading
    assert loading.before == len(loading.time) - len(T) >= len(T) // 2
    assert loading.time[0] == pytest.approx(-loading.before / HERTZ)
    # In its last cycle before the record it goes as it goes in the record.
    cycle = int(HERTZ * PERIOD)
    last = slice(loading.before - cycle, loading.before)
    assert loading.value[last] == pytest.approx(moved(T[:cycle]), abs=1e-9)
    assert np.array_equal(loading.recorded.time, T)
    assert (steady.start, steady.kind) == (0.0, "history")


@pytest.mark.soak
def test_nothing_is_missing_from_the_model_of_a_steady_record(steady):
    """From rest it would miss what the specimen remembers, by many times the noise."""
    fit = identify(steady, MODEL)
    assert fit.tests[0].over_floor == pytest.approx(1.0, abs=0.1)
    library = [springpot.plugins().effect(name) for name in ("parallel-dashpot", "friction")]
    found = diagnose(steady, MODEL, library)
    assert found.verdict == "adequate"
    told = "history repeats from its first cycle on: taken to have gone on before the record"
    assert told in found.notes
    assert told in fit.notes


def test_how_a_held_load_rose_before_its_first_sample_is_told_unless_it_is_known():
    """A step at t = 0 that is read as a rise until 0.1 s has a stiffness too low by a tenth."""
    t = np.geomspace(0.1, 100.0, 40)
    force = 300.0 + 200.0 * np.exp(-t / 0.5)
    told = [
        TimeTest.of_history(t, np.ones(40), force, "mm", "N", name="held", rise=rise).said_of_start
        for rise in (None, 0.0, 0.05)
    ]
    assert "held from its first sample at 0.1 s on: taken to have risen evenly" in told[0]
    assert told[1:] == ["", ""]


@pytest.mark.parametrize("count", [24, 60])
def test_a_fluid_under_a_ramp_whose_first_sample_comes_later_rose_from_nothing(count):
    """Held at its first value before, it would have flowed without end."""
    t = np.arange(1.0, count + 1.0)
    for noise in (0.0, 0.003 * np.random.default_rng(2).normal(size=count)):
        force = t / count + noise
        record = TimeTest.of_history(t, t / 2.0 + t**2 / 20.0, force, "mm", "N", control="force")
        assert (record.loading.before, record.start) == (1, 0.0)
        assert record.said_of_start == ""
        fit = identify(record, springpot.parse_model("maxwell"))
        assert fit.parameters["c"].value == pytest.approx(10.0 / count, rel=0.01)


def test_what_was_held_before_a_ramp_is_no_rise_from_nothing():
    t = np.arange(1.0, 61.0)
    moved = 1.5 + 0.1 * np.maximum(t - 10.0, 0.0)
    record = TimeTest.of_history(t + 4815.0, moved, 2.0 * moved, "mm", "N", control="displacement")
    assert record.loading.before == 0


def test_a_load_that_is_held_at_a_late_hour_began_with_the_record():
    t = np.linspace(0.0, 100.0, 60)
    strain = 0.02 - 0.01 * np.exp(-t / 10.0)
    record = TimeTest.of_history(t + 4815.0, strain, np.full(60, 7.0), "-", "Pa")
    assert record.loading.jumps == ([4815.0], [7.0])
    assert record.kind == "creep"
    assert "held from its first sample at 4815 s on: stepped to then" in record.said_of_start
    alone = TimeTest.of_compliance(t + 4815.0, strain, "Pa")
    assert "is read 4815 s after its step and later" in alone.said_of_start
    # Of few samples the first comes late beside the last, and soon beside the next.
    few = TimeTest.of_history(t[1:10], strain[1:10], np.full(9, 7.0), "-", "Pa")
    assert (few.kind, few.loading.time[0]) == ("creep", 0.0)


def test_a_record_that_began_at_rest_stays_as_it_is():
    assert record(rest()).loading.before == 0


@pytest.mark.parametrize(
    "moved",
    [
        pytest.param(np.sin(2.0 * np.pi * T**1.5), id="a chirp"),
        pytest.param(np.sin(2.0 * np.pi * T / 4.0), id="two periods"),
        pytest.param(np.cumsum(np.random.default_rng(3).normal(size=len(T))), id="chance"),
        pytest.param(np.minimum(T, 2.0), id="a ramp"),
        pytest.param(np.zeros(len(T)), id="nothing"),
    ],
)
def test_what_does_not_repeat_has_no_cycles_before(moved):
    noise = np.random.default_rng(4).normal(size=len(T))
    assert gone_on(Loading(T, moved, sampled=True), moved + 0.01 * noise).before == 0


def test_a_period_need_not_be_a_whole_number_of_samples():
    x = np.sin(2.0 * np.pi * T / 0.773)
    noise = np.random.default_rng(4).normal(size=len(T))
    lagging = np.sin(2.0 * np.pi * T / 0.773 - 0.3)
    loading = gone_on(Loading(T, x, sampled=True), lagging + 0.01 * noise)
    late = loading.time > -2.0
    assert loading.before
    assert loading.value[late] == pytest.approx(
        np.sin(2.0 * np.pi * loading.time[late] / 0.773), abs=0.02
    )


def test_a_fluid_that_swings_from_nothing_began_with_its_record():
    """It repeats from its first cycle on, about where it began and not where it had always been."""
    force, noise = np.sin(2.0 * np.pi * T), 0.002 * np.random.default_rng(4).normal(size=len(T))
    moved = 2.0 * force + 1.0 - np.cos(2.0 * np.pi * T) + noise
    test = TimeTest.of_history(T, moved, force, "mm", "N", control="force")
    assert test.loading.before == 0
    fit = identify(test, springpot.parse_model("maxwell"))
    assert fit.parts[0].over_floor < 1.1
    assert fit.parameters["k"].value == pytest.approx(0.5, rel=0.01)


def test_uneven_samples_and_what_was_not_measured_stay():
    x = np.sin(2.0 * np.pi * T)
    noise = 0.01 * np.random.default_rng(4).normal(size=len(T))
    uneven = Loading(T + 0.2 * noise, x, sampled=True)
    assert gone_on(uneven, x + noise).before == 0
    assert gone_on(Loading(T, x, sampled=True), np.zeros(len(T))).before == 0


@pytest.mark.soak
def test_a_motion_before_a_record_that_does_not_repeat_is_an_effect_of_it():
    model = springpot.parse_model("zener")
    theta = model.theta(k1=15.0, k2=20.0, c=30.0)
    long = np.concatenate([-np.arange(1, 200)[::-1] / HERTZ, T])
    x = np.sin(2.0 * np.pi * long) + 0.5 * np.sin(2.0 * np.pi * 0.37 * long + 1.0)
    force = recorded(model, theta, TimeTest.planned(long, x, "mm")).value[-len(T) :]
    force += 0.1 * np.random.default_rng(5).normal(size=len(T))
    test = TimeTest.of_history(T, x[-len(T) :], force, "mm", "N", control="displacement")
    names = ("earlier-motion", "friction", "inertia", "thermal-force", "force-drift")
    found = diagnose(test, model, [springpot.plugins().effect(name) for name in names])
    assert (found.verdict, found.leading) == ("effect-missing", ("earlier-motion",))
    assert found.best.over_floor == pytest.approx(1.0, abs=0.1)
    # What begins at rest has none.
    assert (
        not springpot.plugins()
        .effect("earlier-motion")
        .applies_to(TimeTest.of_history(T, T**2, force, "mm", "N", control="displacement"))
    )


@pytest.mark.soak
def test_so_is_a_load_before_a_record_under_an_imposed_force():
    """A material that flows could not have stood under that load: others are followed."""
    long = np.concatenate([-np.arange(1, 1001)[::-1] / HERTZ, T])
    force = 300.0 * np.sin(2.0 * np.pi * long) + 120.0 * np.sin(5.4 * np.pi * long)
    crept = ZENER.respond_force(SOLID, long, force)
    x = crept[-len(T) :] + 0.003 * np.random.default_rng(5).normal(size=len(T))
    test = TimeTest.of_history(T, x, force[-len(T) :], "mm", "N", control="force")
    effects = [springpot.plugins().effect(each) for each in ("earlier-load", "displacement-drift")]
    found = diagnose(test, ZENER, effects)
    assert (found.verdict, found.leading) == ("effect-missing", ("earlier-load",))
    assert found.best.over_floor == pytest.approx(1.0, abs=0.1)
    assert identify(test, springpot.parse_model("material")).tests[0].over_floor > 5.0


ZENER = springpot.parse_model("zener")
SOLID = ZENER.theta(k1=200.0, k2=300.0, c=30.0)


def wave(bias=0.0):
    """Displacement of a solid that a sine of the force has moved for ever, and the force."""
    omega = 2.0 * np.pi / PERIOD
    turned = omega * T + 0.7
    gain = 1.0 / ZENER.stiffness(SOLID, np.array([omega]))[0]
    moved = abs(gain) * 300.0 * np.sin(turned + np.angle(gain)) + bias / 200.0
    noise = 0.005 * np.std(moved) * np.random.default_rng(3).normal(size=len(T))
    return moved + noise, 300.0 * np.sin(turned) + bias


@pytest.mark.parametrize("control", ["force", "displacement"])
def test_what_repeats_without_noise_had_gone_on(control):
    """A force that a machine was told has no scatter from cycle to cycle."""
    moved, force = wave()
    test = TimeTest.of_history(T, moved, force, "mm", "N", control=control)
    assert test.loading.before >= len(T) // 2
    fit = springpot.identify(test, ZENER)
    assert fit.tests[0].over_floor == pytest.approx(1.0, abs=0.1)


def test_one_frequency_tells_two_numbers_and_not_three():
    """Any spring in parallel up to the storage fits as well, with the others going along."""
    moved, force = wave()
    test = TimeTest.of_history(T, moved, force, "mm", "N", control="force")
    fit = springpot.identify(test, ZENER)
    assert not any(value.determined for value in fit.parameters.values())
    size = next(row.value for row in fit.quantities.rows if row.name == "|K|")
    assert size.low < abs(ZENER.stiffness(SOLID, np.array([2.0 * np.pi]))[0]) < size.high


def test_the_place_that_a_force_holds_it_at_tells_the_spring():
    moved, force = wave(bias=200.0)
    test = TimeTest.of_history(T, moved, force, "mm", "N", control="force")
    fit = springpot.identify(test, ZENER)
    for name, true in zip(ZENER.names, SOLID, strict=True):
        assert fit.parameters[name].low < true < fit.parameters[name].high
        assert fit.parameters[name].determined


def test_what_flows_on_under_a_force_had_no_place_before():
    moved, force = wave(bias=200.0)
    test = TimeTest.of_history(T, moved + 0.5 * T, force, "mm", "N", control="force")
    assert test.loading.before == 0


def test_a_force_without_noise_beside_a_displacement_that_has_some_was_imposed():
    """Read the other way, what a model answers to the noise took the names of effects."""
    noise = 0.003 * np.random.default_rng(5).normal(size=len(T))
    ramps = np.interp(T, [0.0, 2.3, 5.1, 7.0, 8.0], [0.0, 1.0, -0.6, 0.8, 0.1])
    # Straight lines tell it even where both are noisy; swings do not.
    for force, if_noisy in ((moved(T), "displacement"), (ramps, "force")):
        crept = recorded(MODEL, THETA, TimeTest.of_history(T, T, force, "mm", "N", control="force"))
        written = np.array([float(f"{each:.5g}") for each in force])
        for column, control in ((written, "force"), (force + noise, if_noisy)):
            test = TimeTest.of_history(T, crept.value + noise / 60.0, column, "mm", "N")
            assert test.control == control
            assert ("note control" in test.provenance) == (control == "force")
        assert TimeTest.of_history(T, force, force + noise, "mm", "N").control == "displacement"


def test_whether_a_dashpot_is_felt_at_the_first_sample_of_a_ramp_nobody_knows():
    """With noise in proportion to the force that one sample weighed more than all others."""
    motion, model = np.interp(T, [0.0, 3.0, 8.0], [0.0, 1.0, 0.2]), springpot.parse_model("kelvin")
    force = 2.0 * motion + 0.5 * np.gradient(motion, T)
    force[0] = 0.0
    force *= 1.0 + 0.005 * np.random.default_rng(5).normal(size=len(T))
    fit = identify(TimeTest.of_history(T, motion, force, "mm", "N"), model)
    assert fit.tests[0].over_floor == pytest.approx(1.0, abs=0.1)
    assert fit.parameters["c"].value == pytest.approx(0.5, rel=0.02)


def test_what_creeps_from_its_first_sample_on_was_loaded_just_then():
    time = 2.5 * np.arange(120)
    held = np.where(time < 148.0, 2.0, 0.0)
    creep = np.where(time < 148.0, 1.0 + 0.004 * time, 0.3)
    noise = 0.002 * np.random.default_rng(2).normal(size=120)
    test = TimeTest.of_history(time, creep + noise, held, "mm", "N")
    assert (test.kind, test.control) == ("recovery", "force")
    assert [each.tolist() for each in test.loading.jumps] == [[0.0], [2.0]]
    # What had been held for long before is at rest until it is let go.
    rested = TimeTest.of_history(time, np.where(held > 0.0, 1.0, 0.3) + noise, held, "mm", "N")
    assert len(rested.loading.jumps[0]) == 0


@pytest.mark.parametrize("control", ["force", "displacement"])
@pytest.mark.parametrize("lead", [-0.01, 0.0, 0.02])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_swing_recorded_from_its_end_on_is_not_held(control, lead, sign):
    time = np.arange(2000) / 1000.0
    moved = 3.0 + np.cos(2.0 * np.pi * (time + lead))
    noise = 0.003 * np.random.default_rng(5).normal(size=len(time))
    answer = sign * np.cos(2.0 * np.pi * (time + lead) + 0.4) + noise
    loading = Loading(time, moved + noise, sampled=True)
    assert stepped_to(loading, control, answer) is loading


def test_a_ramp_after_what_is_held_does_not_hide_that_it_was_held():
    time = 2.5 * np.arange(120)
    held = np.clip(2.0 - 0.003 * (time - 120.0), 0.0, 2.0)
    creep = 1.0 + 0.3 * np.log1p(time) + 0.002 * np.random.default_rng(2).normal(size=120)
    assert stepped_to(Loading(time, held, sampled=True), "force", creep).jumps[1] == [2.0]


def test_a_force_that_sets_off_ever_faster_does_not_relax():
    time = np.arange(400) / 300.0
    moved = 3.0 + np.where(time < 0.1, 0.0, np.cos(2.0 * np.pi * (time - 0.1)) - 1.0)
    noise = 0.003 * np.random.default_rng(5).normal(size=len(time))
    loading = Loading(time, moved + noise, sampled=True)
    assert stepped_to(loading, "displacement", -30.0 * time**2 + noise) is loading
    relaxes = 1.0 + np.exp(-30.0 * time) + noise
    assert stepped_to(loading, "displacement", relaxes).jumps[1] == pytest.approx([3.0], abs=0.01)


def loop(noise, felt=0.0, grows=0.0):
    """A mass on a damper under a sine, whose transducer has noise; some of it may be felt."""
    rng, t = np.random.default_rng(7), np.arange(1000) / 2000.0
    model = springpot.parse_model("kelvin + inertia")
    theta = model.theta(k=0.2, c=5e-4, **{"inertia.m": 6e-7})
    moved = 2.0 * np.sin(40.0 * np.pi * t) * (1.0 + grows * t) + felt * rng.normal(size=1000)
    turned = model.stiffness(theta, np.array([40.0 * np.pi]))[0]
    force = 2.0 * abs(turned) * np.sin(40.0 * np.pi * t + np.angle(turned))
    force += 1e-3 * rng.normal(size=1000) + 0.2 * (moved - 2.0 * np.sin(40.0 * np.pi * t))
    read = moved + noise * rng.normal(size=1000)
    return moved, TimeTest.of_history(t, read, force, "mm", "kN")


def test_a_steady_motion_is_known_without_the_noise_of_its_transducer():
    moved, test = loop(0.004)
    np.testing.assert_allclose(test.loading.recorded.value, moved, atol=1e-3)
    assert "0.28 % of white noise that nothing answers to" in test.provenance["motion"]
    fit = springpot.identify(test, "kelvin")
    assert fit.tests[0].over_floor == pytest.approx(1.0, abs=0.1)
    # A mass would make 12 N of that noise, and a fit to what was read would be too soft.
    assert fit.parameters["k"].value == pytest.approx(0.2 - 6e-7 * (40.0 * np.pi) ** 2, rel=2e-3)
    assert any("taken off" in note for note in fit.notes)


@pytest.mark.parametrize("changes", [{"felt": 0.02}, {"noise": 0.0}])
def test_what_was_felt_stays(changes):
    moved, test = loop(**({"noise": 1e-4} | changes))
    assert "motion" not in test.provenance
    np.testing.assert_allclose(test.loading.recorded.value, moved, atol=6e-4)
