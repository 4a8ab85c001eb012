"""Step one: signals whose stiffness is known, disturbed in every way a test rig disturbs them."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

from soaked import soaked
from springpot.errors import DataError
from springpot.measurement import (
    Signals,
    from_signals,
    harmonics_of,
    measurement_from_signals,
    steady,
)
from springpot.measurement.signals import highest_of_noise
from springpot.thresholds import SIGNALS

STIFFNESS = 300.0 + 120.0j


def signals(rng=None, *, n=2000, cycles=12.3, omega=5.0, noise=0.0, time=None):
    t = np.linspace(0.0, 2 * np.pi * cycles / omega, n) if time is None else time
    turn = np.exp(1j * (omega * t + 0.7))
    q = 2.0 * turn.real + 0.3 + 0.002 * omega * t
    u = (STIFFNESS * 2.0 * turn).real + 5.0 - 0.04 * omega * t
    if noise:
        q = q + noise * rng.normal(size=len(t)) * 2.0
        u = u + noise * rng.normal(size=len(t)) * 600.0
    return t, q, u


def test_exact_signals_give_exact_stiffness_frequency_offset_and_drift():
    found = harmonics_of(*signals())
    assert found.omega == pytest.approx(5.0, rel=1e-9)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-8)
    assert found.amplitude == pytest.approx(2.0, rel=1e-8)
    middle = 0.5 * (found.start + found.stop)
    np.testing.assert_allclose(found.level, [0.3 + 0.01 * middle, 5.0 - 0.2 * middle], rtol=1e-7)


def test_a_given_frequency_is_kept():
    found = harmonics_of(*signals(), omega=5.0)
    assert found.omega == 5.0
    assert found.omega_sd == 0.0
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-10)


@pytest.mark.soak
@given(
    cycles=st.floats(1.6, 200.0),
    per_cycle=st.floats(9.0, 100.0),
    omega=st.floats(1e-3, 1e4),
)
@settings(max_examples=60, deadline=None)
def test_any_frequency_and_sampling(cycles, per_cycle, omega):
    n = max(int(cycles * per_cycle), 24)
    found = harmonics_of(*signals(n=n, cycles=cycles, omega=omega))
    assert found.omega == pytest.approx(omega, rel=1e-5)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-5)


@pytest.mark.parametrize(
    "case", ["reversed", "shuffled", "missing", "duplicated", "irregular", "unequal"]
)
def test_disorder_changes_nothing(case, rng):
    t, q, u = signals(time=np.sort(rng.uniform(0, 15.0, 3000)) if case == "irregular" else None)
    if case == "reversed":
        t, q, u = t[::-1], q[::-1], u[::-1]
    if case == "shuffled":
        order = rng.permutation(len(t))
        t, q, u = t[order], q[order], u[order]
    if case == "missing":
        q, u = q.copy(), u.copy()
        q[rng.integers(0, len(q), 200)] = np.nan
        u[700:800] = np.nan
    if case == "duplicated":
        t, q, u = np.repeat(t, 2), np.repeat(q, 2), np.repeat(u, 2)
    if case == "unequal":
        u = u[:-37]
    found = harmonics_of(t, q, u)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-7)
    assert any("order" in note or "length" in note for note in found.notes) == (
        case in ("reversed", "shuffled", "unequal")
    )


def test_the_steady_part_is_found_between_ramps_and_rest(rng):
    t, q, u = signals(n=6000, cycles=20)
    envelope = np.interp(t, [0, 4, 20, 22], [0, 1, 1, 0])
    # On the ramps the force is a different one, as in a friction device.
    found = harmonics_of(t, q * envelope, u * envelope**1.5)
    assert 3.5 < found.start < 6.0
    assert 18.0 < found.stop < 20.5
    assert found.stiffness == pytest.approx(STIFFNESS, rel=3e-3)
    assert found.cycles == pytest.approx(round(found.cycles), abs=1e-2)


def test_an_initial_transient_of_the_force_is_left_out():
    t, q, u = signals(n=6000, cycles=24)
    found = harmonics_of(t, q, u * (1 + 2.0 * np.exp(-t / 1.0)))
    assert found.start > 2.0
    assert found.stiffness == pytest.approx(STIFFNESS, rel=2e-2)


def test_a_given_window_is_used():
    found = harmonics_of(*signals(), window=(3.0, 9.0))
    assert (found.start, found.stop) == (3.0, 9.0)


def test_coulomb_friction_has_a_third_harmonic_of_one_third():
    t = np.linspace(0, 20 * np.pi, 40_001)
    found = harmonics_of(t, np.cos(t + 0.4), -np.sign(np.sin(t + 0.4)), n_harmonics=7)
    assert found.stiffness == pytest.approx(4j / np.pi, abs=2e-3)
    np.testing.assert_allclose(found.relative, [0, 1 / 3, 0, 1 / 5, 0, 1 / 7], atol=2e-3)


@pytest.mark.soak_cases("0.0-3.4-300", "0.9-12.3-1200")
@pytest.mark.parametrize(
    ("correlation", "cycles", "n"), [soaked(0.0, 12.3, 1200), (0.9, 12.3, 1200), (0.0, 3.4, 300)]
)
def test_standard_deviations_are_those_of_repeated_tests(correlation, cycles, n, rng):
    errors, told = [], []
    for _ in range(150):
        t, q, u = signals(n=n, cycles=cycles)
        white = rng.normal(size=n + 200)
        coloured = np.convolve(white, correlation ** np.arange(100), "full")[200 : n + 200]
        found = harmonics_of(t, q, u + 20.0 * coloured)
        errors.append(found.stiffness - STIFFNESS)
        told.append(found.sd)
    errors, told = np.array(errors), np.array(told)
    for part in (np.real, np.imag):
        assert np.sqrt(np.mean(part(told) ** 2)) == pytest.approx(np.std(part(errors)), rel=0.25)
        assert np.mean(np.abs(part(errors)) < 1.96 * part(told)) > 0.87


def test_cycles_that_differ_raise_the_uncertainty(rng):
    t, q, u = signals(n=8000, cycles=40)
    cycle = (5.0 * t / (2 * np.pi)).astype(int)
    found = harmonics_of(t, q, u * (1 + 0.05 * rng.normal(size=41)[cycle]))
    assert found.sd.real == found.sd_cycles.real > found.sd_residual.real
    assert any("cycles differ" in note for note in found.notes)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, q, u: (t, 0 * q, u), "does not move"),
        (lambda t, q, u: (t, q * np.nan, u), "complete samples"),
        (lambda t, q, u: (t[:5], q[:5], u[:5]), "complete samples"),
        (lambda t, q, u: (0 * t, q, u), "stands still"),
    ],
)
def test_signals_that_say_nothing_are_refused(change, message):
    with pytest.raises(DataError, match=message):
        harmonics_of(*change(*signals()))


def test_options_are_checked():
    with pytest.raises(DataError, match="positive"):
        harmonics_of(*signals(), omega=-1.0)
    with pytest.raises(DataError, match="window"):
        harmonics_of(*signals(), window=(500.0, 600.0))
    with pytest.raises(DataError, match="harmonic"):
        harmonics_of(*signals(), n_harmonics=0)
    with pytest.raises(DataError, match="cycle"):
        harmonics_of(*signals(), omega=0.05)


@given(
    st.lists(st.floats(allow_nan=True, allow_infinity=True, width=32), min_size=0, max_size=60),
    st.integers(0, 99),
)
@settings(max_examples=150, deadline=None)
def test_any_numbers_give_an_answer_or_a_data_error(values, seed):
    rng = np.random.default_rng(seed)
    moved = np.array(values, dtype=float)
    try:
        found = harmonics_of(np.arange(len(moved)), moved, rng.permutation(moved))
    except DataError:
        return
    assert np.isfinite(found.stiffness)


@pytest.mark.soak
def test_long_records_are_worked_on_in_blocks(rng):
    """More than one block and more than the excerpt for the frequency: the same answer."""
    found = harmonics_of(*signals(rng, n=300_000, cycles=900.4, noise=0.01))
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-3)
    assert abs(found.stiffness - STIFFNESS) < 5 * abs(found.sd)


@pytest.mark.soak_cases("4321.7", "5091.3")
@pytest.mark.parametrize("cycles", [4321.7, 5091.3, 5737.9])
def test_the_frequency_of_a_record_far_longer_than_what_it_is_first_read_from(
    cycles, rng, monkeypatch
):
    monkeypatch.setattr(steady, "EXCERPT", 256)
    found = harmonics_of(*signals(rng, n=100_000, cycles=cycles, noise=0.01))
    assert found.omega == pytest.approx(5.0, rel=1e-7)
    assert found.amplitude == pytest.approx(2.0, rel=1e-3)
    assert found.cycles > 0.98 * cycles
    assert not found.notes


def test_a_record_of_many_periods_is_looked_at_more_coarsely(rng, monkeypatch):
    t, q, u = signals(rng, n=60_000, cycles=3000.0, noise=0.001)
    rest = t < 0.2 * t[-1]
    q, u = np.where(rest, 0.3, q), np.where(rest, 5.0, u)
    fine = harmonics_of(t, q, u)
    monkeypatch.setattr(steady, "MOST", 256)
    found = harmonics_of(t, q, u)
    assert found.start > 0.2 * t[-1]
    assert found.cycles == pytest.approx(fine.cycles, rel=0.03)
    assert found.omega == pytest.approx(5.0, rel=1e-6)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=1e-3)


def test_a_measurement_of_several_tests_keeps_units_names_and_harmonics():
    tests = [Signals(*signals(omega=w), "mm", "kN", f"run-{w:g}.csv") for w in (2.0, 5.0)]
    measured = measurement_from_signals(tests)
    assert measured.units.stiffness == "kN/mm"
    np.testing.assert_allclose(measured.omega, [2.0, 5.0], rtol=1e-8)
    assert measured.labels["file"].tolist() == ["run-2", "run-5"]
    assert measured.harmonics.shape == (2, 4)
    assert measured.sd is not None


def test_strain_in_percent_and_stress_give_a_modulus():
    t, q, u = signals()
    measured = measurement_from_signals([Signals(t, q, u, "%", "Pa", "a")])
    assert measured.stiffness[0] == pytest.approx(100 * STIFFNESS, rel=1e-8)
    assert measured.units.stiffness == "Pa"
    with pytest.raises(DataError, match="no stiffness"):
        measurement_from_signals([Signals(t, q, u, "%", "N", "a")])
    with pytest.raises(DataError, match="different units"):
        measurement_from_signals(
            [Signals(t, q, u, "%", "Pa", "a"), Signals(t, q, u, "mm", "N", "b")]
        )
    with pytest.raises(DataError, match="no signals"):
        measurement_from_signals([])


def started(rng, *, cycles=11, relative=0.003, n=1600, omega=5.0, slow=0.3):
    """A force that starts with a transient, noise on both channels, and the least sd possible."""
    t = np.linspace(0.0, 2 * np.pi * cycles / omega, n, endpoint=False)
    turn = np.exp(1j * (omega * t + rng.uniform(0, 2 * np.pi)))
    size = 2.0 * abs(STIFFNESS)
    u = (STIFFNESS * 2.0 * turn).real + slow * size * np.exp(
        -t * omega / (2 * np.pi) / rng.uniform(0.2, 0.6)
    )
    share = relative / np.sqrt(2)
    q = 2.0 * (turn.real + share * rng.normal(size=n))
    return (t, q, u + size * share * rng.normal(size=n)), relative * abs(STIFFNESS) * np.sqrt(2 / n)


@pytest.mark.soak_cases("11-0.3")
@pytest.mark.parametrize(
    ("cycles", "slow"), [(11, 0.3), soaked(14, -0.1), soaked(8, 0.3), soaked(11, 0.0)]
)
def test_a_start_up_transient_costs_little_and_is_not_taken_for_noise(cycles, slow, rng):
    errors, told = [], []
    for _ in range(80):
        channels, ideal = started(rng, cycles=cycles, slow=slow)
        found = harmonics_of(*channels)
        errors.append(found.stiffness - STIFFNESS)
        told.append(found.sd)
    scatter = np.sqrt(np.mean(np.abs(errors) ** 2) / 2)
    # 160 numbers give the scatter to 6 %; a fit that takes the transient for steady motion is 5 to
    # 20 times off.
    assert scatter < 1.25 * ideal
    assert np.sqrt(np.mean(np.abs(told) ** 2) / 2) == pytest.approx(scatter, rel=0.2)


def test_first_cycles_of_another_stiffness_are_left_out(rng):
    t, q, u = signals(n=5000, cycles=24)
    u = u * (1 + 0.3 * np.exp(-t)) + 2.0 * rng.normal(size=len(t))
    found = harmonics_of(t, q, u)
    assert found.start > 3.0
    assert found.stiffness == pytest.approx(STIFFNESS, rel=2e-3)
    assert any("settles only" in note for note in found.notes)
    whole = harmonics_of(t, q, u, window=(0.0, t[-1]))
    assert abs(whole.stiffness - STIFFNESS) > 3 * abs(found.stiffness - STIFFNESS)


def test_slow_wander_and_unfitted_harmonics_do_not_widen_the_uncertainty(rng):
    """Neither moves the first harmonic; only the noise at its own frequency does."""
    t, q, u = signals(n=3000, cycles=15)
    quiet = u + 5.0 * rng.normal(size=len(t))
    busy = quiet + 20.0 * np.cos(0.2 * t) + 20.0 * np.cos(9 * 5.0 * t)
    alone, among = harmonics_of(t, q, quiet), harmonics_of(t, q, busy)
    assert among.residual[1] > 2 * alone.residual[1]
    assert abs(among.sd) < 1.3 * abs(alone.sd)


def test_a_vibration_that_the_force_follows_says_nothing_against_the_stiffness():
    """Beside the test frequency, of the same K or of the opposite one.

    Only the second is noise of K.
    """
    t, q, u = signals(n=3000, cycles=15)
    other = 0.1 * np.exp(1j * 0.8 * 5.0 * t)
    same, opposite = (
        harmonics_of(
            t, q + other.real, u + (sign * STIFFNESS * other).real, omega=5.0, window=(0.0, t[-1])
        )
        for sign in (1, -1)
    )
    assert same.residual == pytest.approx(opposite.residual, rel=1e-2)
    assert abs(same.sd_residual) < 0.1 * abs(opposite.sd_residual)


@pytest.mark.parametrize("wrong", [1.7, 6.5, 10.0, 33.0])
def test_a_frequency_at_which_nothing_oscillates_is_refused(wrong, rng):
    with pytest.raises(
        DataError, match=r"does not oscillate at .* rad/s \(.* Hz\); give the frequency"
    ) as refused:
        harmonics_of(*signals(rng, cycles=20, noise=0.01), omega=wrong)
    assert "\n" not in str(refused.value)
    assert (
        "5 rad/s" in str(refused.value)
        or "5.0" in str(refused.value)
        or "4.99" in str(refused.value)
    )


@pytest.mark.parametrize("samples", [40, 400, 3000])
def test_a_record_in_which_nothing_oscillates_is_refused(samples, rng):
    """A static test: of all frequencies of noise one is the strongest, and no stiffness."""
    for _ in range(5):
        t = np.arange(samples) / 300.0
        with pytest.raises(DataError) as refused:
            harmonics_of(
                t, 27.0 + 0.02 * rng.normal(size=samples), -112.0 + 0.1 * rng.normal(size=samples)
            )
        assert "\n" not in str(refused.value)
        assert re.search(
            "nothing oscillates|no frequency found|one is needed|too few", str(refused.value)
        )


def test_a_faint_oscillation_is_not_taken_for_nothing(rng):
    """A fifth of the noise of a single sample, in 4000 of them."""
    t = np.linspace(0.0, 40.0, 4000)
    q, u = np.cos(5.0 * t), (STIFFNESS * np.exp(5j * t)).real
    found = harmonics_of(
        t, q + 5.0 * rng.normal(size=4000), u + 5.0 * rng.normal(size=4000), window=(0.0, 40.0)
    )
    assert found.omega == pytest.approx(5.0, rel=0.02)


def test_a_weak_but_real_second_tone_can_be_asked_for(rng):
    t, q, u = signals(rng, cycles=20, noise=0.01)
    tone = np.exp(1j * 13.0 * t)
    found = harmonics_of(
        t, q + 0.1 * tone.real, u + 0.1 * (200j * tone).real, omega=13.0, window=(0.0, t[-1])
    )
    assert abs(found.stiffness - 200j) < 4 * abs(found.sd)


def told(force, **options):
    """What is told of a displacement cos(2 t) and this force."""
    time = np.linspace(0.0, 40.0, 4000)
    test = Signals(time, np.cos(2.0 * time), force(2.0 * time), name="run")
    return " ".join(measurement_from_signals([test], **options).provenance.values())


@pytest.mark.parametrize(
    ("force", "says"),
    [
        (lambda x: 3.0 * np.cos(x + 0.4), ""),
        (lambda x: -3.0 * np.cos(x + 0.4), "storage and loss are negative"),
        (lambda x: 3.0 * np.cos(x - 0.4), "gives work away"),
        (lambda x: 3.0 * np.cos(x + 2.8), "the storage is negative"),
    ],
)
def test_a_damper_that_gives_work_away_is_told(force, says):
    found = told(force)
    assert says in found
    assert says or "negative" not in found


def test_the_work_of_a_cycle_counts_all_harmonics():
    time = np.linspace(0.0, 40.0, 40_000)
    moved, pulled = (
        np.cos(2 * time) + 0.1 * np.cos(6 * time),
        3 * np.cos(2 * time + 0.5) + np.cos(6 * time + 1.0),
    )
    found = harmonics_of(time, moved, pulled)
    expected = np.pi * (3 * np.sin(0.5) + 3 * 0.1 * np.sin(1.0))
    np.testing.assert_allclose(found.work, expected, rtol=1e-6)


def test_rows_are_in_the_order_of_frequency_then_of_amplitude():
    time = np.linspace(0.0, 40.0, 4000)
    cases = (("c", 5.0, 1.0), ("b", 2.0, 3.0), ("a", 2.0, 1.0))
    tests = [
        Signals(time, x * np.cos(w * time), x * np.cos(w * time + 0.3), name=n) for n, w, x in cases
    ]
    measured = measurement_from_signals(tests)
    assert measured.labels["file"].tolist() == ["a", "b", "c"]
    np.testing.assert_allclose(measured.conditions["amplitude"], [1.0, 3.0, 1.0], rtol=1e-6)


def test_the_longest_records_have_a_threshold():
    """A chance of 0.1 % among 1e14 candidates is lost beside one.

    The tail of F with two degrees is exponential.
    """
    samples = 1e7
    highest = highest_of_noise(samples, 0.5 * samples**2)
    assert highest == pytest.approx(np.log(0.5 * samples**2 / (1.0 - SIGNALS.motion)), rel=1e-4)
    # Where nothing is lost, the tables of F say the same.
    assert highest_of_noise(20.0, 30.0) == pytest.approx(
        stats.f.ppf(1.0 - (1.0 - SIGNALS.motion) / 30.0, 2, 20.0), rel=1e-9
    )


def test_a_force_that_is_zero_throughout_is_told():
    time = np.linspace(0.0, 10.0, 1000)
    silent = Signals(time, np.sin(2.0 * np.pi * time), np.zeros(1000), "mm", "N", name="silent")
    with pytest.raises(DataError, match="silent: the force is zero throughout"):
        measurement_from_signals([silent])


def test_a_spring_that_is_known_exactly_gives_no_work_away():
    """Neither a loss of nothing nor a storage of nothing is negative."""
    for stiffness in (3.0 + 0.0j, 0.0 + 3.0j):
        row = SimpleNamespace(stiffness=stiffness, sd=0j, amplitude=1.0, work=0.0)
        assert from_signals._doubts_of_sign(row, "N") == []


def test_half_a_cycle_is_told_to_be_too_few():
    """Of 2 rad/s for 1.5 s: 0.48 cycles."""
    time = np.linspace(0.0, 1.5, 400)
    with pytest.raises(DataError, match=r"0\.48 cycles of 2 rad/s where one is needed"):
        harmonics_of(time, np.cos(2.0 * time), 3.0 * np.cos(2.0 * time + 0.4), omega=2.0)


def test_a_frequency_that_nothing_determines_is_refused_without_a_warning():
    """Of a single loading in a straight line."""
    t = np.arange(20.0)
    with pytest.raises(DataError, match="nothing oscillates in this record"):
        harmonics_of(t, 2.0 - 0.01 * t, np.cos(7.0 * t))
