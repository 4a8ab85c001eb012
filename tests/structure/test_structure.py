"""A structure with fractional dampers: closed forms, Fourier transform, balance of energy."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError
from springpot.registry import parse_model
from springpot.structure import (
    Damper,
    Frame,
    GroundMotion,
    artificial,
    modes_of,
    motion_of,
    simulate,
    steady_of,
    steady_state,
)

MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=4e7, c=6e6, alpha=0.55)
KELVIN = parse_model("kelvin")
OMEGA = 2 * np.pi * 1.5


def oscillator(*dampers, damping=0.02):
    return Frame(np.array([1e5]), np.array([1e5 * OMEGA**2]), damping, dampers)


def frame(factor=0.5, covariance=None):
    dampers = tuple(Damper(MODEL, THETA, storey, factor, covariance) for storey in (1, 2, 3))
    return Frame(np.full(3, 1e5), np.array([8e7, 7e7, 6e7]), 0.02, dampers)


def shaken(step=0.01):
    return artificial(np.random.default_rng(1), duration=15.0, step=step)


def test_a_bare_oscillator_is_the_textbook_one():
    """A constant acceleration from rest: the step response of a damped oscillator."""
    bare, t = oscillator(), np.arange(400) * 0.01
    found = motion_of(bare, GroundMotion(0.01, np.ones(400))).displacement[:, 0]
    damped = OMEGA * np.sqrt(1 - 0.02**2)
    swing = np.cos(damped * t) + 0.02 / np.sqrt(1 - 0.02**2) * np.sin(damped * t)
    assert found == pytest.approx(-(1 - np.exp(-0.02 * OMEGA * t) * swing) / OMEGA**2, abs=1e-12)


def test_a_kelvin_damper_adds_to_stiffness_and_damping():
    """Its motion is that of a bare frame of more stiffness and damping."""
    k, c = 2e6, 1e5
    with_damper = oscillator(
        Damper(KELVIN, KELVIN.vector(dict(zip(KELVIN.names, (k, c), strict=True)))), damping=0.0
    )
    omega = np.sqrt((1e5 * OMEGA**2 + k) / 1e5)
    same = Frame(np.array([1e5]), np.array([1e5 * omega**2]), c / (2e5 * omega))
    assert motion_of(with_damper, shaken()).displacement == pytest.approx(
        motion_of(same, shaken()).displacement, abs=1e-9
    )
    [mode] = modes_of(with_damper)
    assert mode.damping == pytest.approx(c / (2e5 * omega), rel=1e-9)
    assert mode.frequency == pytest.approx(omega / (2 * np.pi), rel=1e-9)


@pytest.mark.parametrize(
    "structure", [oscillator(Damper(MODEL, THETA)), frame()], ids=["oscillator", "frame"]
)
def test_the_motion_is_the_inverse_fourier_transform_of_the_steady_state(structure):
    """The transform is another road.

    No spectrum, no exponentials, the network itself at each frequency.
    """
    record = shaken(0.005)
    count, n = 2**15, len(record.acceleration)
    padded = np.zeros(count)
    padded[:n] = record.acceleration
    omega = 2 * np.pi * np.fft.rfftfreq(count, record.step)
    omega[0] = 1e-9
    # The acceleration is straight between samples, which takes the high frequencies off.
    straight = np.sinc(omega * record.step / (2 * np.pi)) ** 2
    whole = steady_state(structure, omega) * (straight * np.fft.rfft(padded))[:, None]
    exact = np.fft.irfft(whole, count, axis=0)[:n]
    found = motion_of(structure, record).displacement
    assert np.abs(found - exact).max() < 1e-3 * np.abs(exact).max()


def test_energy_is_neither_made_nor_lost():
    motion = motion_of(frame(), shaken(0.005))
    energy = motion.energy
    kinetic = 0.5 * (motion.velocity**2 @ motion.frame.mass)
    strain = 0.5 * np.einsum(
        "ti,ij,tj->t", motion.displacement, motion.frame.elastic, motion.displacement
    )
    gone = energy["dampers"] + energy["frame"] + kinetic + strain
    assert gone == pytest.approx(energy["input"], abs=2e-3 * energy["input"].max())
    assert energy["dampers"][-1] > 0.3 * energy["input"][-1]


def test_modes_solve_the_nonlinear_problem_and_tell_how_free_vibrations_fade():
    structure = frame()
    for mode in modes_of(structure):
        [value], _ = structure.dynamic(np.array([mode.s]))
        assert np.abs(value @ mode.shape).max() < 1e-9 * np.abs(value).max()
        assert mode.damping > 0.02
    one = oscillator(Damper(MODEL, THETA, 1, 0.1))
    [mode] = modes_of(one)
    pulse = np.zeros(3000)
    pulse[:10] = 1.0
    fading = motion_of(one, GroundMotion(0.001, pulse)).displacement[:, 0]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(fading))) != 0) + 1
    # From turn to turn, so that what creeps back slowly beside the swing does not count.
    ways = np.abs(np.diff(fading[turns[2:7]]))
    decrement = np.log(ways[0] / ways[2]) / (0.001 * (turns[4] - turns[2]))
    assert decrement == pytest.approx(-mode.s.real, rel=0.05)


def test_more_dampers_drift_less():
    drifts = [motion_of(frame(factor), shaken()).peak_drift.max() for factor in (0.2, 0.5, 1.0)]
    assert drifts == sorted(drifts, reverse=True)


@pytest.mark.soak
def test_what_is_not_known_of_a_damper_is_a_band_of_the_drift():
    covariance = np.diag((THETA * np.array([0.1, 0.1, 0.03])) ** 2)
    record = shaken(0.02)
    found = simulate(frame(0.5, covariance), record, np.random.default_rng(2), draws=12)
    low, high = found.band()
    assert np.all(low < high)
    assert np.all((low < found.motion.peak_drift * 1.02) & (high > found.motion.peak_drift * 0.98))
    again = simulate(frame(0.5, covariance), record, np.random.default_rng(2), draws=12)
    assert np.array_equal(again.drifts, found.drifts)
    sure = simulate(frame(), record, np.random.default_rng(2), draws=12)
    assert np.array_equal(*sure.band())


def test_what_makes_no_structure_is_refused():
    with pytest.raises(ModelError, match="braces storey 2 of a frame of 1"):
        oscillator(Damper(MODEL, THETA, 2))
    with pytest.raises(ModelError, match="belongs to the rig"):
        Damper(MODEL + "time-delay", np.append(THETA, 0.001))
    with pytest.raises(ModelError, match="'slip' is known by its first harmonic alone"):
        Damper(MODEL + springpot.law("parallel: i*k*X^n", "slip"), np.append(THETA, [9.0, 1.0]))
    with pytest.raises(ModelError, match="above zero"):
        Frame(np.array([-1.0]), np.array([1.0]))
    with pytest.raises(ModelError, match="count is above zero"):
        Damper(MODEL, THETA, count=-4.0)
    with pytest.raises(ModelError, match="less than 90 degrees"):
        Damper(MODEL, THETA, cosine=np.cos(np.radians(90.0)))
    with pytest.raises(DataError, match=r"steps are not equal \(0.5 s after sample 2"):
        GroundMotion.of(np.array([0.0, 0.1, 0.6, 0.7]), np.zeros(4))
    with pytest.raises(DataError, match="sample 2 is no number"):
        GroundMotion.of(np.array([0.0, 0.1]), np.array([0.0, np.nan]))


SLOPE = np.radians(60.0)


def test_an_inclined_damper_is_in_equilibrium_with_its_frame_by_hand():
    """A spring of 2 kN/mm at 60 degrees, statically.

    It feels x cos and pulls k x cos along its axis, k x cos^2 along
    the floor; the frame's own storey takes the rest of m a. What is felt is 1 / cos of what the
    floor gets.
    """
    spring = parse_model("spring")
    k, storey, mass, a = 2e6, 3e6, 1e4, 1.5
    frame = Frame(
        [mass], [storey], 0.3, (Damper(spring, np.array([k]), count=3.0, cosine=np.cos(SLOPE)),)
    )
    # A load that rises within many periods ends at rest.
    motion = motion_of(frame, GroundMotion(0.1, a * np.minimum(np.arange(2000) / 1000.0, 1.0)))
    x = mass * a / (storey + 3.0 * k * np.cos(SLOPE) ** 2)
    assert motion.drift[-1, 0] == pytest.approx(-x, rel=1e-9)
    assert motion.stroke[-1, 0] == pytest.approx(-x * np.cos(SLOPE), rel=1e-9)
    assert motion.axial_force[-1, 0] == pytest.approx(-k * x * np.cos(SLOPE), rel=1e-9)
    [along_floor] = motion.force[-1]
    assert along_floor + storey * motion.drift[-1, 0] == pytest.approx(-mass * a, rel=1e-9)
    assert along_floor == pytest.approx(3.0 * motion.axial_force[-1, 0] * np.cos(SLOPE), rel=1e-9)
    assert motion.peak_storey_force == pytest.approx(3.0 * motion.peak_axial_force * np.cos(SLOPE))


def braced(*, friction: bool = False):
    """Two kinds of damper in the lower storey and one in the upper."""
    model, theta = MODEL, THETA
    if friction:
        model = MODEL + "friction"
        theta = model.vector({**dict(zip(MODEL.names, THETA, strict=True)), "friction.F": 2e4})
    dampers = (
        Damper(model, theta, 1, 2.0, cosine=np.cos(SLOPE)),
        Damper(MODEL, THETA, 1, 0.5, cosine=np.cos(0.5)),
        Damper(MODEL, THETA, 2, 1.0),
    )
    return Frame(np.full(2, 1e5), np.array([8e7, 7e7]), 0.02, dampers)


@pytest.mark.soak_cases("True")
@pytest.mark.parametrize("friction", [False, True])
def test_what_the_dampers_take_is_axial_force_times_stroke_of_each(friction: bool):
    record = GroundMotion(0.0025, shaken(0.0025).acceleration[:2500])
    motion = motion_of(braced(friction=friction), record)
    work = 0.0
    for i, damper in enumerate(motion.frame.dampers):
        force, stroke = motion.axial_force[:, i], motion.stroke[:, i]
        work += damper.count * np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(stroke))
    assert work == pytest.approx(motion.energy["dampers"][-1], rel=2e-3)
    kinetic = 0.5 * (motion.velocity**2 @ motion.frame.mass)
    strain = 0.5 * np.einsum(
        "ti,ij,tj->t", motion.displacement, motion.frame.elastic, motion.displacement
    )
    gone = motion.energy["dampers"] + motion.energy["frame"] + kinetic + strain
    assert gone == pytest.approx(motion.energy["input"], abs=5e-3 * motion.energy["input"].max())


@pytest.mark.suite_cases("False")
@pytest.mark.parametrize("friction", [False, True])
def test_peaks_between_samples_are_found(friction: bool):
    """A record at a quarter of the first period.

    Its samples miss the peak by up to a third, the method by 0.1 %.
    """
    frame, step = braced(friction=friction), 0.08
    record = GroundMotion(step, shaken(step).acceleration[:60])
    coarse, fine = motion_of(frame, record), motion_of(frame, record.finer(100))
    exact = np.abs(fine.drift).max(axis=0)
    within = 3e-3 if friction else 2e-4
    assert coarse.peak_drift == pytest.approx(exact, rel=within)
    assert coarse.peak_axial_force == pytest.approx(
        np.abs(fine.axial_force).max(axis=0), rel=within
    )
    sums = fine.force @ frame.storeys_of_dampers.T
    assert coarse.peak_storey_force == pytest.approx(np.abs(sums).max(axis=0), rel=within)
    assert np.any(np.abs(coarse.drift).max(axis=0) < 0.97 * exact)


def test_a_steady_state_has_the_same_axial_force_and_stroke():
    steady = steady_of(braced(), np.array([5.0, 20.0]))
    own = steady.energy / np.pi
    lag = np.imag(steady.axial_force * np.conj(steady.stroke))
    counts = np.array([damper.count for damper in steady.frame.dampers])
    assert counts * lag == pytest.approx(own, rel=1e-9)
    assert steady.storey_force[:, 0] == pytest.approx(steady.force[:, :2].sum(axis=1))


def test_the_drift_figure_shows_its_largest_point_whole():
    pytest.importorskip("matplotlib")
    from springpot.structure.shown import figure_motion

    for frame in (oscillator(Damper(MODEL, THETA)), braced()):
        found = simulate(frame, shaken(0.02), np.random.default_rng(1))
        axes = figure_motion(found).axes[2]
        left, right = axes.get_xlim()
        bottom, top = axes.get_ylim()
        for line in axes.lines:
            assert np.all(line.get_xdata() < right - 0.03 * (right - left))
            assert np.all((line.get_ydata() > bottom + 0.1) & (line.get_ydata() < top - 0.1))


@pytest.mark.parametrize("stiffness", [[1e6], [1e6, 2e6]])
def test_at_its_own_frequency_a_frame_that_nothing_damps_has_no_steady_state(stiffness):
    undamped = Frame([1000.0] * len(stiffness), stiffness, damping=0.0)
    own = modes_of(undamped)[0].s.imag
    with pytest.raises(ModelError, match="nothing damps the frame, which swings ever higher"):
        steady_state(undamped, np.array([0.5 * own, own]))
    assert np.isfinite(steady_state(undamped, np.array([0.999 * own, 1.001 * own]))).all()
