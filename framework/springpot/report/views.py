"""The views that rheologists use, each drawn on one pair of axes by one function.

All take the same `Scene`, so that data and models look alike in every view: storage filled and solid, loss
open and dashed, a colour for each quantity, sweep or model, whichever there are several of.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.measurement import Measurement
from springpot.rheology import Complex, Real

from .bands import draw_bands
from .canvas import COLOURS, INK, QUIET, logarithmic
from .curves import Axis, Fit, axis_of, smooth, sweeps_of
from .sweeps import Sweep, chosen

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MANY_POINTS = 2000
"""More points than this are drawn small and as pixels, even in a vector figure."""

WIDE_RANGE = 30.0
"""A linear quantity spanning more than this factor gets a logarithmic axis."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Data and fitted models that are drawn together.

    Parameters
    ----------
    measurement : Measurement
        The data.
    fits : sequence of Fit
        The models; none is fine.
    aside : Measurement, optional
        Measured points that were taken for outliers: no model was fitted to them.
    """

    measurement: Measurement
    fits: Sequence[Fit] = ()
    aside: Measurement | None = None

    @cached_property
    def axis(self) -> Axis:
        """The column along which the data are drawn."""
        return axis_of(self.measurement)

    @cached_property
    def every_sweep(self) -> list[Sweep]:
        """All sweeps along it."""
        return sweeps_of(self.measurement, self.axis)

    @cached_property
    def sweeps(self) -> list[Sweep]:
        """The sweeps that are drawn."""
        return chosen(self.every_sweep)

    @property
    def drawn(self) -> str:
        """``12 of 60 sweeps shown``; nothing where all are."""
        count = len(self.every_sweep)
        return f"{len(self.sweeps)} of {count} sweeps shown" if count > len(self.sweeps) else ""

    @cached_property
    def curves(self) -> list[list[tuple[Real, Complex]]]:
        """Smooth curves: for each fit and each sweep the places and the complex stiffness there."""
        grids = [smooth(self.measurement, self.axis, sweep) for sweep in self.sweeps]
        return [[(x, fit.at(points)) for x, points in grids] for fit in self.fits]

    @property
    def by_sweep(self) -> bool:
        """Whether a colour stands for a sweep."""
        return len(self.sweeps) > 1 and len(self.fits) < 2

    @property
    def by_fit(self) -> bool:
        """Whether a colour stands for a model."""
        return len(self.fits) > 1

    def data_colour(self, sweep: int, part: int = 0) -> str:
        """Colour of measured points of a sweep; `part` is 0 for storage and 1 for loss."""
        if self.by_sweep:
            return sweep_colours(len(self.sweeps))[sweep]
        return INK if self.by_fit else COLOURS[part]

    def fit_colour(self, fit: int, sweep: int, part: int = 0) -> str:
        """Colour of a model's curve."""
        return COLOURS[fit % len(COLOURS)] if self.by_fit else self.data_colour(sweep, part)

    @property
    def marker(self) -> dict[str, Any]:
        """How measured points look."""
        many = len(self.measurement) > MANY_POINTS
        return {"linestyle": "none", "markersize": 1.5 if many else 4.5, "rasterized": many, "markeredgewidth": 1.0}


def sweep_colours(count: int) -> list[str]:
    """Colours in order from dark to light, none too pale to see on white."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(colour) for colour in colormaps["viridis"](np.linspace(0.0, 0.85, count))]


def storage_and_loss(axes: Axes, scene: Scene) -> None:
    """Storage and loss against frequency; where one is negative, its size is drawn with crosses and dots."""
    data = scene.measurement
    for i, sweep in enumerate(scene.sweeps):
        x = scene.axis.values[sweep.rows]
        for part, values in enumerate((data.storage, data.loss)):
            colour = scene.data_colour(i, part)
            fill = colour if part == 0 else "white"
            y = values[sweep.rows]
            style = {**scene.marker, "color": colour, "markerfacecolor": fill, "zorder": 3}
            axes.plot(x, np.where(y > 0, y, np.nan), marker="o", **style)
            axes.plot(x, np.where(y < 0, -y, np.nan), marker="x", **style)
    _outliers(axes, scene)
    for j, curves in enumerate(scene.curves):
        for i, (x, stiffness) in enumerate(curves):
            for part, y in enumerate((stiffness.real, stiffness.imag)):
                colour = scene.fit_colour(j, i, part)
                axes.plot(x, np.where(y > 0, y, np.nan), color=colour, linestyle="--" if part else "-")
                axes.plot(x, np.where(y < 0, -y, np.nan), color=colour, linestyle=":")
    what = "modulus" if data.units.is_modulus else "stiffness"
    _scales(axes, scene)
    logarithmic(axes, "y")
    axes.set(xlabel=scene.axis.label, ylabel=f"storage, loss {what} [{data.units.stiffness}]")


def _outliers(axes: Axes, scene: Scene) -> None:
    """Points that were set aside, as large open diamonds: they are data too."""
    if scene.aside is None:
        return
    x = scene.axis.of(scene.aside)
    for values in (scene.aside.storage, scene.aside.loss):
        axes.plot(x, np.abs(values), "D", color=INK, markerfacecolor="none", markersize=8.0, zorder=4)


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
    if positive and _ratio(data.magnitude) > WIDE_RANGE:
        logarithmic(axes, "x")
        logarithmic(axes, "y")
    else:
        axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel=f"storage [{data.units.stiffness}]", ylabel=f"loss [{data.units.stiffness}]")


def black(axes: Axes, scene: Scene) -> None:
    """Black diagram: magnitude against phase."""
    _path(axes, scene, _phase, np.abs)
    logarithmic(axes, "y")
    axes.set(xlabel="phase δ [deg]", ylabel=f"|K| [{scene.measurement.units.stiffness}]")


def van_gurp_palmen(axes: Axes, scene: Scene) -> None:
    """Van Gurp-Palmen plot: phase against magnitude."""
    _path(axes, scene, np.abs, _phase)
    logarithmic(axes, "x")
    axes.set(xlabel=f"|K| [{scene.measurement.units.stiffness}]", ylabel="phase δ [deg]")


def residual(axes: Axes, scene: Scene) -> None:
    """Measured minus fitted in per cent of |K|, with a band of two standard deviations where they are given."""
    data = scene.measurement
    for j, fit in enumerate(scene.fits):
        share = 100.0 * (data.stiffness - fit.at(data.points)) / data.magnitude
        for i, sweep in enumerate(scene.sweeps):
            x = scene.axis.values[sweep.rows]
            for part, values in enumerate((share.real, share.imag)):
                colour = scene.fit_colour(j, i, part)
                style = {**scene.marker, "color": colour, "markerfacecolor": "white" if part else colour}
                axes.plot(x, values[sweep.rows], marker="o", **style)
    axes.axhline(0.0, color=QUIET, linewidth=1.0, zorder=1)
    if data.sd is not None:
        draw_bands(axes, scene, 200.0 * np.maximum(data.sd.real, data.sd.imag) / data.magnitude)
    _scales(axes, scene)
    axes.set(xlabel=scene.axis.label, ylabel="measured − model\n[% of |K|]")


def _against_axis(axes: Axes, scene: Scene, quantity: Callable[[Complex], Real]) -> None:
    """`quantity` of data and models along the axis of the scene."""
    for i, sweep in enumerate(scene.sweeps):
        y = quantity(scene.measurement.stiffness[sweep.rows])
        axes.plot(scene.axis.values[sweep.rows], y, marker="o", color=scene.data_colour(i), **scene.marker)
    for j, curves in enumerate(scene.curves):
        for i, (x, stiffness) in enumerate(curves):
            axes.plot(x, quantity(stiffness), color=scene.fit_colour(j, i))
    _scales(axes, scene)


def _path(axes: Axes, scene: Scene, across: Callable[[Complex], Real], up: Callable[[Complex], Real]) -> None:
    """One quantity of data and models against another, without the frequency."""
    for i, sweep in enumerate(scene.sweeps):
        stiffness = scene.measurement.stiffness[sweep.rows]
        axes.plot(across(stiffness), up(stiffness), marker="o", color=scene.data_colour(i), **scene.marker)
    for j, curves in enumerate(scene.curves):
        for i, (_, stiffness) in enumerate(curves):
            axes.plot(across(stiffness), up(stiffness), color=scene.fit_colour(j, i))


def _scales(axes: Axes, scene: Scene) -> None:
    if scene.axis.logarithmic:
        logarithmic(axes, "x")


def _tan_delta(stiffness: Complex) -> Real:
    defined = (stiffness.real > 0) & (stiffness.imag > 0)
    ratio: Real = np.full(stiffness.shape, np.nan)
    np.divide(stiffness.imag, stiffness.real, out=ratio, where=defined)
    return ratio


def _phase(stiffness: Complex) -> Real:
    return np.degrees(np.angle(stiffness))


def _ratio(values: Real) -> float:
    return float(np.max(values) / np.min(values)) if np.min(values) > 0 else np.inf
