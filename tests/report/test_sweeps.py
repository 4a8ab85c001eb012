"""Sweeps: what is one curve of a figure, and which of many are drawn."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from springpot.measurement import Measurement, Units
from springpot.registry import parse_model
from springpot.report import canvas, figures, views
from springpot.report.canvas import SWEEPS, travels
from springpot.report.residuals import keys
from springpot.report.views import DrawnFit, Scene, axis_of, sweeps_of

pytest.importorskip("matplotlib")

HERTZ = np.geomspace(0.1, 30.0, 12)
WARM = DrawnFit(
    parse_model("fractional-zener + arrhenius-shift"), np.array([80.0, 400.0, 60.0, 0.5, 60.0])
)


def _measured(celsius, hertz=HERTZ, amplitude=None):
    """Exact data at each of these temperatures, given for each sweep or for each point."""
    celsius = np.asarray(celsius, dtype=float)
    sweeps = len(celsius) if celsius.ndim == 1 else celsius.shape[0]
    temperature = (np.repeat(celsius, len(hertz)) if celsius.ndim == 1 else celsius).ravel()
    conditions = {"temperature": temperature}
    if amplitude is not None:
        conditions["amplitude"] = np.broadcast_to(amplitude, (sweeps, len(hertz))).ravel()
    omega = 2.0 * np.pi * np.tile(hertz, sweeps)
    blank = Measurement(
        omega, np.ones(len(omega), complex), conditions=conditions, units=Units("kN/m", "mm")
    )
    return Measurement(
        omega, WARM.at(blank.points), conditions=conditions, units=Units("kN/m", "mm")
    )


def _labels(data):
    return [sweep.label for sweep in sweeps_of(data, axis_of(data))]


def test_of_many_sweeps_an_even_choice_is_drawn_and_said():
    data = _measured(np.linspace(-40.0, 78.0, 60))
    scene = Scene(data, [WARM])
    assert (len(scene.every_sweep), len(scene.sweeps)) == (60, SWEEPS.drawn)
    assert (scene.sweeps[0].label, scene.sweeps[-1].label) == ("-40 °C", "78 °C")
    assert scene.drawn == "12 of 60 sweeps shown"
    assert scene.drawn in keys(scene)
    assert scene.by_sweep
    with canvas.blank() as figure:
        axes = figure.subplots()
        views.storage_and_loss(axes, scene)
        lines = {
            line.get_color()
            for line in axes.lines
            if line.get_linestyle() == "-" and len(line.get_xdata()) > 50
        }
    assert len(lines) == SWEEPS.drawn


def test_a_good_fit_of_many_sweeps_looks_good():
    scene = Scene(_measured(np.linspace(-40.0, 78.0, 60)), [WARM])
    [curves] = scene.curves
    for sweep, (x, fitted) in zip(scene.sweeps, curves, strict=True):
        here = np.interp(np.log(scene.axis.values[sweep.rows]), np.log(x), np.log(np.abs(fitted)))
        np.testing.assert_allclose(here, np.log(scene.measurement.magnitude[sweep.rows]), atol=1e-3)


def test_the_headline_says_how_many_are_shown(monkeypatch):
    kept = []
    monkeypatch.setattr(
        figures,
        "finished",
        lambda figure, path: kept.append(figure.legends[0].get_title().get_text()),
    )
    figures.figure_identification(_measured(np.linspace(-40.0, 78.0, 60)), [WARM], "unused.png")
    figures.figure_identification(_measured([0.0, 20.0]), [WARM], "unused.png")
    assert ["of 60 sweeps shown" in text for text in kept] == [True, False]


def test_conditions_that_jitter_are_taken_together_by_level(rng):
    jitter = rng.uniform(-0.3, 0.3, size=(3, len(HERTZ)))
    data = _measured(np.array([[0.0], [20.0], [40.0]]) + jitter)
    scene = Scene(data, [WARM])
    assert [len(sweep.rows) for sweep in scene.sweeps] == [len(HERTZ)] * 3
    for sweep, (x, fitted) in zip(
        scene.sweeps, scene.curves[0], strict=True
    ):  # no line that jitters along
        median = np.full(len(x), np.median(data.conditions["temperature"][sweep.rows]))
        held = replace(data.points, log_omega=np.log(2.0 * np.pi * x), temperature=median + 273.15)
        np.testing.assert_allclose(fitted, WARM.at(held), rtol=1e-9)


def test_conditions_without_levels_are_taken_in_bins(rng):
    data = _measured(rng.uniform(-40.0, 60.0, size=(30, len(HERTZ))))
    found = sweeps_of(data, axis_of(data))
    assert sorted(np.concatenate([sweep.rows for sweep in found])) == list(range(len(data)))
    assert min(len(sweep.rows) for sweep in found) >= 8
    temperature = data.conditions["temperature"]
    ends = [(temperature[sweep.rows].min(), temperature[sweep.rows].max()) for sweep in found]
    assert all(one[1] <= other[0] for one, other in pairwise(ends))
    assert " to " in found[0].label
    assert Scene(data, [WARM]).drawn.startswith(f"{SWEEPS.drawn} of ")


def test_an_amplitude_that_falls_along_the_sweep_makes_no_sweeps():
    falling = np.geomspace(5.0, 0.01, len(HERTZ))
    assert _labels(_measured([0.0, 20.0, 40.0], amplitude=falling)) == ["0 °C", "20 °C", "40 °C"]


def test_amplitudes_are_told_where_they_are_set():
    data = _measured([0.0, 0.0, 20.0, 20.0], amplitude=np.array([[0.1], [1.0], [0.1], [1.0]]))
    assert _labels(data) == ["0 °C, 0.1 mm", "0 °C, 1 mm", "20 °C, 0.1 mm", "20 °C, 1 mm"]


def test_repeats_are_sweeps_of_their_own():
    one = Measurement(
        2.0 * np.pi * np.tile(HERTZ, 2), np.ones(24, complex), repeat=np.repeat([1, 2], 12)
    )
    assert _labels(one) == ["repeat 1", "repeat 2"]


@pytest.mark.parametrize(
    ("along", "column", "jumps"),
    [
        ([1, 2, 3, 4], [5, 4, 2, 1], False),
        ([1, 1, 2, 2], [5, 1, 5, 1], True),
        ([1, 2, 3, 4, 5, 6], [0, 1, 0, 1, 0, 1], True),
        ([1, 2, 3], [4, 4, 4], False),
        # Cells that were left empty.
        ([1, 2, 3, 4, 5, 6, 7, 8], [0, 1, np.nan, 0, 1, 0, 1, 0], True),
        ([1, 2, 3, 4], [5, np.nan, 2, 1], False),
        ([1, 2], [np.nan, np.nan], False),
    ],
)
def test_a_profile_follows_the_axis(along, column, jumps):
    assert travels(np.array(along, float), np.array(column, float)) is jumps


def test_the_tape_of_twenty_temperatures_is_drawn_by_temperature():
    import springpot
    from springpot.errors import SpringpotError

    try:
        data = springpot.read("3m-468mp-acrylic-tts")
    except SpringpotError:
        pytest.skip("the measured data are not here")
    scene = Scene(data, [WARM])
    assert len(scene.every_sweep) == 20
    assert (scene.sweeps[0].label, scene.sweeps[-1].label) == ("-40 °C", "150 °C")
