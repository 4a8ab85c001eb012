"""Every quantity of a cycle is the known one of loops in closed form, or its interval holds it."""

import numpy as np
import pytest
from known_loops import OMEGA, STROKE, loop, noisy

import springpot
from springpot.errors import DataError, OptionError
from springpot.testreport import LoopRecord
from springpot.testreport.record import Channel, find_cycles, polynomial_at
from springpot.testreport.summary import evaluate

KINDS = ("linear", "coulomb", "power", "bilinear")
SIZES = {"F+": 1.0, "F-": 1.0, "K_eff": 1.0 / STROKE, "K'": 1.0 / STROKE}


def size_of(name, truth, force):
    """A quantity that is nothing is measured by what it would be at the greatest force."""
    return abs(truth) or SIZES[name] * np.abs(force).max()


def evaluated(kind, **given):
    t, x, force, truth = loop(kind, **given)
    return evaluate(LoopRecord(t, x, force, "mm", "kN", kind)), truth, force


@pytest.mark.parametrize("per_cycle", [60, 200])
@pytest.mark.parametrize("kind", KINDS)
def test_loops_in_closed_form_within_a_thousandth_or_the_interval(kind, per_cycle):
    test, truth, force = evaluated(kind, per_cycle=per_cycle)
    assert [cycle.number for cycle in test.cycles] == [1, 2, 3, 4, 5, 6]
    # The first cycle of what yields begins on the virgin curve.
    for each in test.each[1:]:
        for name, expected in truth.items():
            told = each[name]
            off = abs(told.value - expected)
            assert off <= 1e-3 * size_of(name, expected, force) or told.low <= expected <= told.high
    assert test.frequency.value == pytest.approx(OMEGA / (2.0 * np.pi), rel=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_no_interval_is_an_excuse(kind):
    """Without noise, at 200 samples a cycle, intervals are as narrow as the sampling allows."""
    test, truth, force = evaluated(kind)
    # A force that jumps between two samples does so anywhere between them: K' is told by that.
    for name in truth.keys() - {"K'", "eta"}:
        told = test.means[name]
        assert told.high - told.low <= 6e-3 * size_of(name, truth[name], force), name


@pytest.mark.parametrize(("kind", "drift"), [(kind, 0.05) for kind in KINDS])
def test_slow_drift_moves_no_stiffness_and_no_energy(kind, drift, rng):
    record, truth = noisy(kind, rng, 1e-4, drift=drift)
    test = evaluate(record)
    for name in ("K_eff", "W_d", "F0", "K''"):
        told, size = test.means[name], size_of(name, truth[name], record.force)
        assert abs(told.value - truth[name]) <= max(1e-3 * size, told.high - told.value), name


@pytest.mark.soak
@pytest.mark.parametrize("kind", KINDS)
def test_intervals_hold_the_truth_as_often_as_they_say(kind):
    rng, inside, asked = np.random.default_rng(5), 0, 0
    names = ("D+", "F+", "F0", "K_eff", "W_d", "K''")
    for _ in range(12):
        record, truth = noisy(kind, rng, 5e-3, per_cycle=80, cycles=5)
        test = evaluate(record)
        for each in test.each[1:]:
            inside += sum(each[name].low <= truth[name] <= each[name].high for name in names)
            asked += len(names)
    # 288 intervals, those of one cycle not independent: three deviations of 100 of them.
    assert 0.88 <= inside / asked <= 1.0


def test_a_dead_zone_has_its_energy_and_no_force_in_its_middle():
    t, x, _, _ = loop("linear")
    play = 1.0
    force = 0.8 * np.sign(x) * np.maximum(np.abs(x) - play, 0.0)
    test = evaluate(LoopRecord(t, x, force, "mm", "kN", "play"))
    assert test.means["F+"].value == pytest.approx(0.8 * (STROKE - play), rel=1e-3)
    assert test.means["W_d"].low <= 0.0 <= test.means["W_d"].high
    assert abs(test.means["F0"].value) < 1e-3 * force.max()


@pytest.mark.parametrize("stop", [8.0, 9.0, 9.5])
def test_a_stop_shortly_before_the_end_of_the_stroke_is_seen_there(stop, rng):
    """A force that bends near its turning point is looked at in a smaller window."""
    t, x, _, _ = loop("linear", cycles=4)
    top = 0.8 * STROKE + 40.0 * (STROKE - stop)
    force = 0.8 * x + 40.0 * np.sign(x) * np.maximum(np.abs(x) - stop, 0.0)
    force = force + 1e-3 * top * rng.standard_normal(len(t))
    test = evaluate(LoopRecord(t, x, force, "mm", "kN", "stop"))
    assert test.means["F+"].value == pytest.approx(top, rel=2e-3)
    assert test.means["F-"].value == pytest.approx(-top, rel=2e-3)


@pytest.mark.parametrize("channel", ["force", "displacement"])
def test_a_clipped_channel_is_named(channel, rng):
    record, _ = noisy("linear", rng, 1e-3)
    values = getattr(record, channel)
    cut = np.clip(values, -0.9 * values.max(), 0.9 * values.max())
    channels = {"displacement": record.displacement, "force": record.force, channel: cut}
    test = evaluate(LoopRecord(record.time, **channels, displacement_unit="mm", force_unit="kN"))
    assert any(channel in note and "clipped" in note for note in test.notes)
    assert not any("clipped" in note for note in evaluate(record).notes)


def test_coarse_digits_are_not_taken_for_a_clipped_channel():
    t, x, force, _ = loop("linear")
    record = LoopRecord(t, np.round(x, 1), np.round(force, 1), "mm", "kN")
    assert not any("clipped" in note for note in evaluate(record).notes)


@pytest.mark.parametrize("noise", [0.0, 0.03])
@pytest.mark.parametrize(("phase", "whole", "words"), [
    (0.0, 6, ()),
    (np.pi, 6, ()),
    (0.5 * np.pi, 5, ("begins within", "ends within")),
    (1.2, 5, ("begins within", "ends within")),
])  # fmt: skip
def test_cycles_are_counted_from_the_first_motion_and_partial_ones_named(
    phase, whole, words, noise, rng
):
    t = np.arange(1201) / 200.0
    x = np.sin(2.0 * np.pi * t + phase) + 0.3 * t / t[-1] + noise * rng.standard_normal(len(t))
    found = find_cycles(LoopRecord(t, x, 2.0 * x, "mm", "kN"))
    assert len(found.middles) == whole
    assert [any(word in note for note in found.notes) for word in ("begins", "ends")] == [
        bool(words), bool(words)
    ]  # fmt: skip
    lengths = np.diff([bound.value for bound in found.bounds])
    assert np.all(np.abs(lengths - 1.0) < 0.03)


def test_rest_before_and_after_is_no_cycle(rng):
    t = np.arange(1600) / 200.0
    moving = (t >= 1.0) & (t <= 6.0)
    x = np.where(moving, np.sin(2.0 * np.pi * (t - 1.0)), 0.0) + 0.01 * rng.standard_normal(1600)
    found = find_cycles(LoopRecord(t, x, 2.0 * x + 0.01 * rng.standard_normal(1600), "mm", "kN"))
    assert len(found.middles) == 5
    assert found.bounds[0].value == pytest.approx(1.0, abs=0.04)
    assert found.bounds[-1].value == pytest.approx(6.0, abs=0.04)


def test_where_cycles_scatter_more_than_noise_their_scatter_counts(rng):
    """Amplitudes that differ by 2 % from cycle to cycle: the mean's interval is theirs."""
    t = np.arange(2001) / 200.0
    stiffness = (1.0 + 0.02 * rng.standard_normal(11))[np.minimum(t.astype(int), 10)]
    force = stiffness * np.sin(2.0 * np.pi * t)
    test = evaluate(LoopRecord(t, np.sin(2.0 * np.pi * t), force, "mm", "kN"), (1, 10))
    told = test.means["K_eff"]
    assert told.source == "cycles"
    each = [row["K_eff"].value for row in test.each]
    assert told.sd == pytest.approx(np.std(each, ddof=1) / np.sqrt(10.0))


def test_a_short_peak_of_force_is_seen_and_a_plateau_is_not_lifted_by_its_noise(rng):
    """Friction that breaks loose: a peak of a twentieth of a cycle."""
    record, _ = noisy("coulomb", rng, 5e-3, cycles=5)
    plain = evaluate(record).means["F_peak"]
    assert plain.low <= 5.0 <= plain.high
    away = (record.time * OMEGA / (2.0 * np.pi)) % 1.0 - 0.1
    bump = 3.0 * np.exp(-((away / 0.015) ** 2))
    force = record.force + bump
    peaked = evaluate(LoopRecord(record.time, record.displacement, force, "mm", "kN"))
    true = np.max(loop("coulomb", cycles=5)[2] + bump)
    assert true > 6.0
    assert peaked.means["F_peak"].value == pytest.approx(true, rel=0.01)


def test_a_cycle_that_runs_up_says_nothing_of_how_the_others_scatter(rng):
    """The first and last cycle have half the stroke, as test rigs begin and end."""
    t = np.arange(1201) / 200.0
    grown = np.interp(t, [0.0, 1.0, 5.0, 6.0], [0.6, 1.0, 1.0, 0.6])
    x = 10.0 * grown * np.sin(2.0 * np.pi * t)
    force = 2.0 * x + 0.02 * rng.standard_normal(len(t))
    test = evaluate(LoopRecord(t, x, force, "mm", "kN"))
    assert len(test.cycles) == 6
    assert test.means["D+"].value == pytest.approx(10.0, rel=1e-3)
    assert all(row["W_d"].high - row["W_d"].low < 2.0 for row in test.each)
    assert not any("unequal strokes" in note for note in test.notes)
    whole = evaluate(LoopRecord(t, x, force, "mm", "kN"), (1, 6))
    assert any("unequal strokes: 1, 6" in note for note in whole.notes)


def test_means_are_of_the_cycles_that_are_asked_for():
    t, x, force, _ = loop("linear", cycles=6)
    record = LoopRecord(t, x, force * (1.0 + 0.01 * np.floor(t * OMEGA / (2 * np.pi) + 1e-9)), "mm")
    assert (evaluate(record).first, evaluate(record).last) == (2, 5)
    test = evaluate(record, (3, 4))
    rows = [row["K_eff"].value for row in test.each]
    assert test.means["K_eff"].value == pytest.approx(np.mean(rows[2:4]))
    assert any("means are of 5 to 6" in note for note in evaluate(record, (5, 9)).notes)
    with pytest.raises(DataError, match="6 whole cycles, and none of 8 to 9"):
        evaluate(record, (8, 9))


def test_energy_of_the_run_is_that_of_all_cycles():
    test, truth, _ = evaluated("linear", cycles=6)
    assert test.energy.value == pytest.approx(6.0 * truth["W_d"], rel=1e-4)


def test_a_channel_that_counts_the_other_way_is_told():
    t, x, force, _ = loop("linear")
    assert any("force=-kN" in note for note in evaluate(LoopRecord(t, x, -force, "mm", "kN")).notes)


@pytest.mark.soak
def test_the_law_of_speeds_is_found_with_its_interval(rng):
    inside = 0
    for _ in range(8):
        records = []
        for i, frequency in enumerate((0.2, 0.5, 1.2, 3.0)):
            t = np.arange(241) / (60.0 * frequency)
            x = 10.0 * np.sin(2.0 * np.pi * frequency * t)
            v = 20.0 * np.pi * frequency * np.cos(2.0 * np.pi * frequency * t)
            force = 2.0 * np.sign(v) * np.abs(v) ** 0.4
            force += 0.005 * force.max() * rng.standard_normal(len(t))
            records.append(LoopRecord(t, x, force, "mm", "kN", f"test {i}"))
        law = springpot.cycles(records).law
        assert law.exponent == pytest.approx(0.4, abs=0.01)
        assert law.constant == pytest.approx(2.0, rel=0.03)
        inside += law.exponent_ends[0] <= 0.4 <= law.exponent_ends[1]
    assert inside >= 6


def test_one_speed_has_no_law(rng):
    records = [noisy("power", rng, 5e-3, per_cycle=60, cycles=4)[0] for _ in range(2)]
    assert springpot.cycles(records).law is None


def test_nothing_that_swings_is_refused_in_one_line(rng):
    t = np.linspace(0.0, 1.0, 200)
    with pytest.raises(DataError):
        evaluate(LoopRecord(t, rng.standard_normal(200), rng.standard_normal(200), "mm", "kN"))
    with pytest.raises(OptionError, match=r"3\.\.10"):
        springpot.cycles([], cycles="ten")


def test_a_polynomial_is_never_narrowed_to_fewer_samples_than_it_has_coefficients():
    """Where a channel jumps no window fits: the parabola stays one of four samples, not of two."""
    time = np.arange(-8.0, 9.0)
    told, *_ = polynomial_at(Channel(time, 5.0 * np.sign(time), 1e-3), 0.0, 8.0, 2)
    np.testing.assert_allclose(told, np.polyfit([-2, -1, 0, 1], [-5, -5, 0, 5], 2)[::-1])
