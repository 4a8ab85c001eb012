"""The figure of a simulation.

Peaks and their bands where they are, and a damper's temperature in kelvin.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.structure import Damper, Frame, artificial, simulate
from springpot.structure.motion import Simulation, motion_of

MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=4e7, c=6e6, alpha=0.55)


def test_a_temperature_is_told_in_celsius_and_used_in_kelvin():
    assert Damper(MODEL, THETA, 1, temperature=20.0).kelvin == pytest.approx(293.15)
    assert Damper(MODEL, THETA, 1).kelvin is None


def test_the_bands_of_the_peaks_are_drawn_in_millimetres(undrawn, tmp_path):
    from springpot.structure.figures import figure_motion

    dampers = tuple(
        Damper(MODEL, THETA, storey, 0.5, np.diag((0.05 * THETA) ** 2)) for storey in (1, 2)
    )
    frame = Frame(np.full(2, 1e5), np.array([8e7, 7e7]), 0.02, dampers)
    record = artificial(np.random.default_rng(1), duration=4.0, step=0.02)
    found = simulate(frame, record, np.random.default_rng(2), draws=6)
    figure_motion(found, tmp_path / "response.svg")
    (figure,) = undrawn
    peaks = figure.axes[2]
    (bands,) = peaks.collections
    ends = np.array([segment[:, 0] for segment in bands.get_segments()])
    np.testing.assert_allclose(ends.T, 1e3 * np.array(found.band()), rtol=1e-9)
    (dots,) = peaks.get_lines()
    np.testing.assert_allclose(dots.get_xdata(), 1e3 * found.motion.peak_drift, rtol=1e-9)
    assert peaks.get_xlim()[1] == pytest.approx(1.06e3 * found.band()[1].max())
    motion, time = found.motion, record.time
    drifts, loops, _, energies = figure.axes
    drawn = [line.get_xydata() for line in (*drifts.get_lines(), *energies.get_lines())]
    wanted = [1e3 * drift for drift in motion.drift.T]
    wanted += [1e-3 * each for each in motion.energy.values()]
    for each, values in zip(drawn, wanted, strict=True):
        np.testing.assert_allclose(each, np.transpose([time, values]), rtol=1e-9)
    for i, line in enumerate(loops.get_lines()):
        loop = np.transpose([1e3 * motion.stroke[:, i], 1e-3 * motion.axial_force[:, i]])
        np.testing.assert_allclose(line.get_xydata(), loop, rtol=1e-9)
    assert [line.get_label() for line in drifts.get_lines()] == ["storey 1", "storey 2"]
    # Each in a colour of its own, which a storey shares with its damper.
    colours = [[line.get_color() for line in axes.get_lines()] for axes in figure.axes]
    assert colours[0] == colours[1]
    assert all(len(set(each)) == len(each) for each in colours)


def test_a_steady_state_is_drawn_over_hertz_in_millimetres_and_kilonewtons(undrawn, tmp_path):
    from springpot.structure.figures import figure_steady

    omega = 2.0 * np.pi * np.array([0.5, 1.0, 2.0])
    drift = np.array([[3.0 + 4.0j, 1.0], [1.0, 2.0j], [0.5, 0.1]])
    steady = SimpleNamespace(omega=omega, drift=drift, axial_force=1e6 * drift[:, :1])
    figure_steady(steady, tmp_path / "steady.svg")
    (figure,) = undrawn
    drifts, forces = ([line.get_xydata() for line in axes.get_lines()] for axes in figure.axes)
    for i, each in enumerate(drifts):
        np.testing.assert_allclose(each, np.transpose([[0.5, 1.0, 2.0], 1e3 * np.abs(drift[:, i])]))
    np.testing.assert_allclose(forces[0][:, 1], 1e3 * np.abs(drift[:, 0]))
    assert (len(drifts), len(forces)) == (2, 1)
    assert [line.get_label() for line in figure.axes[0].get_lines()] == ["storey 1", "storey 2"]
    assert figure.axes[1].get_lines()[0].get_label() == "damper 1"


@pytest.mark.parametrize("draws", [5, 40])
def test_a_band_holds_as_many_motions_as_it_says(draws):
    rng = np.random.default_rng(3)
    # Each storey is a simulation of its own, and the next draw is the building that was meant.
    peaks = rng.standard_normal((draws + 1, 20000))
    found = Simulation(simulated_nothing(), [], peaks[:-1])
    low, high = found.band()
    held = float(np.mean((low < peaks[-1]) & (peaks[-1] < high)))
    assert held == pytest.approx(found.level, abs=0.01)
    assert found.level == pytest.approx(min(0.95, (draws - 1) / (draws + 1)))


def simulated_nothing():
    frame = Frame([1e5], [8e7], 0.02)
    return motion_of(frame, artificial(np.random.default_rng(1), duration=0.1, step=0.02))


def test_peaks_of_many_records_are_drawn_in_millimetres_and_kilonewtons(undrawn, tmp_path):
    from springpot.structure.answers import RecordSuite
    from springpot.structure.figures import figure_suite

    frame = Frame(np.full(2, 1e5), np.array([8e7, 7e7]), 0.02, (Damper(MODEL, THETA, 1, 0.5),))
    record = artificial(np.random.default_rng(1), duration=2.0, step=0.02)
    one = simulate(frame, record, np.random.default_rng(2), draws=0)
    figure_suite(RecordSuite([one, one]), tmp_path / "suite.svg")
    (figure,) = undrawn
    motion = one.motion
    largest = [
        1e3 * motion.peak_drift,
        1e-3 * motion.peak_axial_force,
        1e3 * motion.peak_stroke,
    ]
    for axes, wanted in zip(figure.axes, largest, strict=True):
        # Each record, their mean and their envelope, which are all the same.
        assert len(axes.get_lines()) == 4
        for line in axes.get_lines():
            np.testing.assert_allclose(line.get_xdata(), wanted, rtol=1e-9)
            assert list(line.get_ydata()) == list(range(1, len(wanted) + 1))
        assert axes.get_xlim() == pytest.approx((0.0, 1.06 * wanted.max()))
        assert axes.get_ylim() == (0.5, len(wanted) + 0.5)
