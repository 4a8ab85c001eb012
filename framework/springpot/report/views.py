"""The views that rheologists use, each drawn on one pair of axes by one function.

All take the same `Scene`, so that data and models look alike in every view: storage filled and
solid, loss open and dashed, a colour for each quantity, sweep or model, whichever there are several
of.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.rheology.points import Complex, Real

from .bands import draw_bands
from .canvas import INK, QUIET, logarithmic
from .scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDE_RANGE = 30.0
"""A linear quantity spanning more than this factor gets a logarithmic axis."""


def storage_and_loss(axes: Axes, scene: Scene) -> None:
    """Storage and loss against frequency.

    Where one is negative, its size is drawn with crosses and dots.
    """
    data = scene.measurement
    for i, sweep in enumerate(scene.sweeps):
        x = scene.axis.values[sweep.rows]
        for part, values in enumerate((data.storage, data.loss)):
            colour = scene.data_colour(i, part)
            fill = "white"
            if part == 0:
                fill = colour
            y = values[sweep.rows]
            style = {**scene.marker, "color": colour, "markerfacecolor": fill, "zorder": 3}
            # Negative values have no place on this axis; left out, they would look as if they had
            # not been measured.
            axes.plot(x, np.where(y > 0, y, np.nan), marker="o", **style)
            axes.plot(x, np.where(y < 0, -y, np.nan), marker="x", **style)
    _outliers(axes, scene)
    for j, curves in enumerate(scene.curves):
        for i, (x, stiffness) in enumerate(curves):
            for part, y in enumerate((stiffness.real, stiffness.imag)):
                colour = scene.fit_colour(j, i, part)
                stroke = "-"
                if part:
                    stroke = "--"
                axes.plot(x, np.where(y > 0, y, np.nan), color=colour, linestyle=stroke)
                axes.plot(x, np.where(y < 0, -y, np.nan), color=colour, linestyle=":")
    _scales(axes, scene)
    logarithmic(axes, "y")
    axes.set(xlabel=scene.axis.label, ylabel=f"{_both(data)} [{data.units.stiffness}]")


def _outliers(axes: Axes, scene: Scene) -> None:
    """Points that were set aside, as large open diamonds: they are data too."""
    if scene.aside is None:
        return
    x = scene.axis.of(scene.aside)
    for values in (scene.aside.storage, scene.aside.loss):
        axes.plot(
            x, np.abs(values), "D", color=INK, markerfacecolor="none", markersize=8.0, zorder=4
        )


def loss_factor(axes: Axes, scene: Scene) -> None:
    """Loss factor tan δ = K''/K' against frequency; shown where both are positive."""
    _against_axis(axes, scene, _tan_delta)
    logarithmic(axes, "y")
    axes.set(xlabel=scene.axis.label, ylabel="loss factor tan δ [-]")


def cole_cole(axes: Axes, scene: Scene) -> None:
    """Loss against storage."""
    data = scene.measurement
    _path(axes, scene, lambda k: k.real, lambda k: k.imag)
    positive = np.all(data.storage > 0) and np.all(data.loss > 0)
    # Over decades a semicircle is no longer seen at equal scales, and small values vanish at the
    # origin.
    if positive and _ratio(data.magnitude) > WIDE_RANGE:
        logarithmic(axes, "x")
        logarithmic(axes, "y")
    else:
        # At equal scales a relaxation of a single time is the semicircle that it is known by.
        axes.set_aspect("equal", adjustable="datalim")
    unit = data.units.stiffness
    axes.set(xlabel=f"{data.units.storage} [{unit}]", ylabel=f"{data.units.loss} [{unit}]")


def black(axes: Axes, scene: Scene) -> None:
    """Black diagram: magnitude against phase."""
    _path(axes, scene, _phase, np.abs)
    logarithmic(axes, "y")
    axes.set(xlabel="phase δ [deg]", ylabel=_size(scene))


def van_gurp_palmen(axes: Axes, scene: Scene) -> None:
    """Van Gurp-Palmen plot: phase against magnitude."""
    _path(axes, scene, np.abs, _phase)
    logarithmic(axes, "x")
    axes.set(xlabel=_size(scene), ylabel="phase δ [deg]")


def residual(axes: Axes, scene: Scene) -> None:
    """Measured minus fitted in % of |K|, with a band of two standard deviations where given."""
    data = scene.measurement
    for j, fit in enumerate(scene.fits):
        share = 100.0 * (data.stiffness - fit.at(data.points)) / data.magnitude
        draw_parts(axes, scene, j, share)
    axes.axhline(0.0, color=QUIET, linewidth=1.0, zorder=1)
    if data.sd is not None:
        # Two standard deviations, in per cent.
        # The larger of the two: one band serves storage and loss.
        draw_bands(axes, scene, 200.0 * np.maximum(data.sd.real, data.sd.imag) / data.magnitude)
    _scales(axes, scene)
    axes.set(xlabel=scene.axis.label, ylabel=f"measured − model\n[% of {data.units.magnitude}]")


def draw_parts(axes: Axes, scene: Scene, fit: int, values: Complex) -> None:
    """What belongs to one of the fits, along the axis of the scene.

    Real part filled, imaginary part open.
    """
    for i, sweep in enumerate(scene.sweeps):
        x = scene.axis.values[sweep.rows]
        for part, side in enumerate((values.real, values.imag)):
            colour = scene.fit_colour(fit, i, part)
            inside = "white"
            if not part:
                inside = colour
            style = {**scene.marker, "color": colour, "markerfacecolor": inside}
            axes.plot(x, side[sweep.rows], marker="o", **style)


def _against_axis(axes: Axes, scene: Scene, quantity: Callable[[Complex], Real]) -> None:
    """`quantity` of data and models along the axis of the scene."""
    for i, sweep in enumerate(scene.sweeps):
        y = quantity(scene.measurement.stiffness[sweep.rows])
        axes.plot(
            scene.axis.values[sweep.rows], y, marker="o", color=scene.data_colour(i), **scene.marker
        )
    for j, curves in enumerate(scene.curves):
        for i, (x, stiffness) in enumerate(curves):
            axes.plot(x, quantity(stiffness), color=scene.fit_colour(j, i))
    _scales(axes, scene)


def _path(
    axes: Axes, scene: Scene, across: Callable[[Complex], Real], up: Callable[[Complex], Real]
) -> None:
    """One quantity of data and models against another, without the frequency."""
    for i, sweep in enumerate(scene.sweeps):
        stiffness = scene.measurement.stiffness[sweep.rows]
        axes.plot(
            across(stiffness), up(stiffness), marker="o", color=scene.data_colour(i), **scene.marker
        )
    for j, curves in enumerate(scene.curves):
        for i, (_, stiffness) in enumerate(curves):
            axes.plot(across(stiffness), up(stiffness), color=scene.fit_colour(j, i))


def _both(data: Measurement) -> str:
    """Storage and loss as one word: ``G', G''`` or ``storage, loss stiffness``."""
    if data.units.letter:
        return f"{data.units.storage}, {data.units.loss}"
    return f"storage, {data.units.loss}"


def _size(scene: Scene) -> str:
    return f"{scene.measurement.units.magnitude} [{scene.measurement.units.stiffness}]"


def _scales(axes: Axes, scene: Scene) -> None:
    if scene.axis.logarithmic:
        logarithmic(axes, "x")


def _tan_delta(stiffness: Complex) -> Real:
    # A ratio of signs that differ is no loss factor, and has no place on a logarithmic axis.
    defined = (stiffness.real > 0) & (stiffness.imag > 0)
    ratio: Real = np.full(stiffness.shape, np.nan)
    np.divide(stiffness.imag, stiffness.real, out=ratio, where=defined)
    return ratio


def _phase(stiffness: Complex) -> Real:
    return np.degrees(np.angle(stiffness))


def _ratio(values: Real) -> float:
    if not np.min(values) > 0:
        return np.inf
    return float(np.max(values) / np.min(values))
