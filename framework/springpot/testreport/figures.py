"""Loops as measured, each with its ellipse and backbone, and the law of several speeds."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from springpot.report.canvas import COLOURS, INK, QUIET, SMOOTH, blank, logarithmic, save

from .summary import EvaluatedTest, VelocityLaw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ACROSS = 3
"""Panels beside each other."""
SHOWN = 9
"""Tests that are drawn: more would be too small to be read."""


def figure_cycles(
    tests: Sequence[EvaluatedTest], law: VelocityLaw | None, path: str | Path | None = None
) -> Figure:
    """The loops of each test with their ellipse and backbone; the law of several speeds.

    Parameters
    ----------
    tests : sequence of EvaluatedTest
        The first of them are drawn.
    law : VelocityLaw or None
        Of all of them.
    path : str or Path, optional
        Where to write it.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.
    """
    shown = tests[:SHOWN]
    count = len(shown) + (law is not None)
    across = min(ceil(sqrt(count)), ACROSS)
    down = -(-count // across)
    with blank(max(4.4, 3.6 * across), 3.2 * down) as figure:
        panels = figure.subplots(down, across, squeeze=False).ravel()
        for panel, test in zip(panels, shown, strict=False):
            draw_loops(panel, test)
        if law is not None:
            _draw_law(panels[len(shown)], tests, law)
        for panel in panels[count:]:
            panel.set_axis_off()
        if path is not None:
            save(figure, path)
    return figure


def draw_loops(axes: Axes, test: EvaluatedTest) -> None:
    """The whole cycles, the ellipse of the same stroke and energy, and the backbone."""
    record = test.record
    for cycle in test.cycles:
        inside = (record.time >= cycle.start) & (record.time <= cycle.stop)
        counted = test.first <= cycle.number <= test.last
        axes.plot(
            record.displacement[inside],
            record.force[inside],
            color=COLOURS[5] if counted else QUIET,
            lw=0.7,
            zorder=2 if counted else 1,
        )
    means = {name: told.value for name, told in test.means.items()}
    centre = 0.5 * (means["D+"] + means["D-"])
    half = 0.5 * (means["D+"] - means["D-"])
    phase = np.linspace(0.0, 2.0 * np.pi, SMOOTH)
    middle = 0.5 * (means["F+"] + means["F-"])
    ellipse = means["K_eff"] * half * np.sin(phase)
    ellipse = ellipse + means["W_d"] / (np.pi * half) * np.cos(phase)
    # Force over displacement: K_eff x in phase, and as much across it as gives the same area.
    axes.plot(
        centre + half * np.sin(phase),
        middle + ellipse,
        "--",
        color=COLOURS[1],
        lw=1.2,
        label="ellipse",
    )
    axes.plot(
        [means["D-"], means["D+"]],
        [means["F-"], means["F+"]],
        "o-",
        color=INK,
        ms=3.5,
        lw=1.0,
        label="backbone",
    )
    title = test.name
    if record.timed:
        title = f"{test.name}, {test.frequency.value:.3g} Hz"
    axes.set(
        xlabel=f"displacement [{record.displacement_unit}]",
        ylabel=f"force [{record.force_unit}]",
        title=title,
    )
    axes.legend(loc="upper left")


def _draw_law(axes: Axes, tests: Sequence[EvaluatedTest], law: VelocityLaw) -> None:
    tests = [test for test in tests if {"F0", "v_peak"} <= test.means.keys()]
    speed = np.array([test.means["v_peak"].value for test in tests])
    force = [test.means["F0"] for test in tests]
    axes.errorbar(
        speed,
        [each.value for each in force],
        [[each.value - each.low for each in force], [each.high - each.value for each in force]],
        fmt="o",
        color=COLOURS[0],
    )
    at = np.geomspace(speed.min() / 1.2, speed.max() * 1.2, SMOOTH)
    low, high = law.exponent_ends
    axes.plot(at, law.force(at), color=COLOURS[1])
    record = tests[0].record
    axes.set(
        xlabel=f"peak speed [{record.units['velocity']}]",
        ylabel=f"F0 [{record.force_unit}]",
        title=f"F = C |v|^{law.exponent:.3g}  [{low:.3g}, {high:.3g}]",
    )
    logarithmic(axes, "x")
    logarithmic(axes, "y")
