"""The spectrum of any material: a picture with its band, and a sentence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from springpot.format_numbers import number
from springpot.identification.regularisation import Spectrum
from springpot.identification.result import Identification

from . import views
from .canvas import COLOURS, QUIET, blank, finished, logarithmic
from .curves import Fit
from .figures import headed
from .floors import beside_floors
from .scene import Scene
from .views import WIDE_RANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DECADES = 4.0
"""Decades of H below its peak that a logarithmic axis shows: what is smaller is as good as nothing.
"""
MOST_PEAKS = 4
"""Peaks that the sentence names, the highest."""


def figure_material(identified: Identification, path: str | Path | None = None) -> Figure | Path:
    """Data and fit, the residuals, and the regularised spectrum with its band below.

    Parameters
    ----------
    identified : Identification
        Of a model whose spectrum the data choose.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    scene = Scene(identified.measurement, [Fit(identified.model, identified.theta)])
    with blank(7.2, 8.6) as figure:
        above, middle, below = figure.subplots(3, 1, height_ratios=(3, 1.4, 2.6))
        views.storage_and_loss(above, scene)
        views.residual(middle, scene)
        # The rates of the spectrum are no frequencies of the test: only these two share an axis.
        middle.sharex(above)
        above.set_xlabel("")
        if identified.spectrum is not None:
            draw_spectrum(below, identified.spectrum, identified.measurement.units.stiffness)
        headed(figure, scene, beside=beside_floors(identified))
        return finished(figure, path)


def draw_spectrum(axes: Axes, spectrum: Spectrum, unit: str) -> None:
    """H(r) with its band; grey where no frequency was measured."""
    rates, density = spectrum.rates, spectrum.density
    axes.fill_between(
        rates,
        spectrum.low,
        spectrum.high,
        color=COLOURS[0],
        alpha=0.25,
        linewidth=0.0,
        label="95 % of noise",
    )
    axes.plot(rates, density, color=COLOURS[0], label="smoothest H that the data allow")
    for start, stop, label in (
        (rates[0], spectrum.seen[0], "not measured"),
        (spectrum.seen[1], rates[-1], None),
    ):
        axes.axvspan(start, stop, color=QUIET, alpha=0.18, linewidth=0.0, label=label, zorder=0.5)
    axes.set_xlim(rates[0], rates[-1])
    logarithmic(axes, "x")
    # What lies beyond the measured frequencies is the smoothest guess, and must not set the axis.
    inside = density[(rates >= spectrum.seen[0]) & (rates <= spectrum.seen[1])]
    top = float(spectrum.high.max())
    if len(inside) and inside.max() > WIDE_RANGE * inside.min():
        axes.set_ylim(max(0.3 * float(inside.min()), top * 10.0**-DECADES), 3.0 * top)
        logarithmic(axes, "y")
    else:
        axes.set_ylim(0.0, 1.25 * top)
    axes.set(xlabel="rate r [rad/s]", ylabel=f"H(r) [{unit}]")
    axes.legend(loc="best")


def in_words(spectrum: Spectrum, unit: str) -> str:
    """Where the relaxing stiffness lies, and the peaks of H that the data bear out."""
    total = float(np.sum(spectrum.density)) * spectrum.step
    if not total > 0.0:
        return "nothing relaxes: a spring beside a dashpot"
    low, high = (number(end, 2) for end in spectrum.within(0.5))
    half = f"half of the relaxing {number(total, 3)} {unit} at rates from {low} to {high} rad/s"
    # Two digits: no peak of such a spectrum is known better.
    shown = [f"{number(spectrum.rates[i], 2)}" for i in spectrum.peaks[:MOST_PEAKS]]
    if not shown:
        return f"{half}; no peak within what was measured"
    word = "the peak"
    if len(shown) > 1:
        word = f"{len(shown)} peaks, the highest first,"
    height = number(float(spectrum.density[spectrum.peaks[0]]), 2)
    return f"{half}; {word} of H at {', '.join(shown)} rad/s, {height} {unit} high"
