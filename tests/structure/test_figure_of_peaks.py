"""The figure of a simulation.

Peaks and their bands where they are, and a damper's temperature in kelvin.
"""

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
    from springpot.structure.figures import figure_suite
    from springpot.structure.suites import RecordSuite

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
