"""A structure under a record.

Drift with its band, the loops of the dampers, and where the energy went.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from springpot.report.canvas import COLOURS, QUIET, blank, logarithmic, save

from .answers import RecordSuite
from .frame import SteadyState
from .motion import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOM = 1.06
"""Axis over its largest value: half a marker and its margin."""


def figure_motion(simulation: Simulation, path: str | Path | None = None) -> Figure:
    """Drift of the lowest storey, loops of the dampers, energies.

    Parameters
    ----------
    simulation : Simulation
        What happened.
    path : str or Path, optional
        Where to write it.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.
    """
    # Four questions of an engineer: how far, how hard, how sure, and who took the energy.
    motion = simulation.motion
    time, energy = motion.record.time, motion.energy
    low, high = simulation.band()
    with blank(9.0, 6.0) as figure:
        drifts, loops, peaks, energies = figure.subplots(2, 2).ravel()
        for i, drift in enumerate(motion.drift.T):
            drifts.plot(
                time, 1e3 * drift, color=COLOURS[i % len(COLOURS)], lw=0.9, label=f"storey {i + 1}"
            )
        drifts.set(xlabel="t [s]", ylabel="drift [mm]")
        drifts.legend()
        for i, damper in enumerate(motion.frame.dampers):
            # In the colour of its storey, whose drift it shares.
            way, force = 1e3 * motion.stroke[:, i], 1e-3 * motion.axial_force[:, i]
            loops.plot(way, force, color=COLOURS[(damper.storey - 1) % len(COLOURS)], lw=0.7)
        loops.set(xlabel="stroke [mm]", ylabel="axial force of a damper [kN]")
        storey = range(1, len(motion.frame) + 1)
        peaks.hlines(storey, 1e3 * low, 1e3 * high, color=QUIET, lw=4)
        peaks.plot(1e3 * motion.peak_drift, storey, "o", color=COLOURS[0])
        band = f", band {100 * simulation.level:.0f} %" if simulation.level else ""
        peaks.set(xlabel=f"peak drift [mm]{band}", ylabel="storey", yticks=list(storey))
        # From zero, as a band is small or large beside the drift itself, to where the largest is
        # seen whole.
        peaks.set_xlim(0.0, ROOM * 1e3 * max(high.max(), motion.peak_drift.max()))
        peaks.set_ylim(0.5, len(motion.frame) + 0.5)
        for i, (name, each) in enumerate(energy.items()):
            energies.plot(time, 1e-3 * each, color=COLOURS[i], label=name)
        energies.set(xlabel="t [s]", ylabel="energy [kJ]")
        energies.legend()
        if path is not None:
            save(figure, path)
    return figure


def figure_steady(steady: SteadyState, path: str | Path | None = None) -> Figure:
    """Drift of each storey and force of each damper over the frequency of the ground.

    The path, and what is returned, as of `figure_motion`.
    """
    frequency = steady.omega / (2.0 * np.pi)
    with blank(9.0, 3.6) as figure:
        drifts, forces = figure.subplots(1, 2)
        for i, drift in enumerate(np.abs(steady.drift).T):
            drifts.plot(
                frequency, 1e3 * drift, color=COLOURS[i % len(COLOURS)], label=f"storey {i + 1}"
            )
        for i, force in enumerate(np.abs(steady.axial_force).T):
            forces.plot(
                frequency, 1e-3 * force, color=COLOURS[i % len(COLOURS)], label=f"damper {i + 1}"
            )
        drifts.set(xlabel="f [Hz]", ylabel="drift [mm] at 1 m/s$^2$")
        forces.set(xlabel="f [Hz]", ylabel="axial force of a damper [kN] at 1 m/s$^2$")
        for axes in (drifts, forces):
            logarithmic(axes, "x")
            logarithmic(axes, "y")
        drifts.legend()
        if path is not None:
            save(figure, path)
    return figure


def figure_suite(suite: RecordSuite, path: str | Path | None = None) -> Figure:
    """Largest drift, force and stroke under each record, with their mean and envelope.

    The path, and what is returned, as of `figure_motion`.
    """
    shown = {
        "drift": ("peak drift [mm]", "storey", 1e3),
        "axial_force": ("axial force of a damper [kN]", "damper", 1e-3),
        "stroke": ("stroke [mm]", "damper", 1e3),
    }
    with blank(9.0, 3.6) as figure:
        for axes, (name, (title, of, factor)) in zip(
            figure.subplots(1, len(shown)), shown.items(), strict=True
        ):
            each = factor * suite.largest(name)
            place = range(1, each.shape[1] + 1)
            for values in each:
                axes.plot(values, place, ".-", color=QUIET, lw=0.7)
            for i, (label, values) in enumerate(
                {"mean": suite.mean(name), "envelope": suite.envelope(name)}.items()
            ):
                axes.plot(factor * values, place, "o-", color=COLOURS[i], label=label)
            axes.set(xlabel=title, ylabel=of, yticks=list(place))
            if each.size:
                axes.set_xlim(0.0, ROOM * each.max() or None)
            axes.set_ylim(0.5, each.shape[1] + 0.5)
        figure.axes[0].legend()
        if path is not None:
            save(figure, path)
    return figure
