"""The views that rheologists use, each drawn on one pair of axes by one function.

All take the same `Scene`, so that data and models look alike in every view: storage filled and
solid, loss open and dashed, a colour for each quantity, sweep or model, whichever there are several
of. A view of residuals has a band about zero that noise explains, for each sweep its own where
sweeps differ.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.numerics import ENOUGH
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Points, Real

from .canvas import (
    CANVAS,
    COLOURS,
    INK,
    QUIET,
    DrawnSweep,
    all_sweeps,
    chosen,
    logarithmic,
    travels,
    varies,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


ALONG_CLOCK = {"Hz": "frequency f [Hz]", "rad/s": "angular frequency ω [rad/s]"}
"""What the axis of frequencies is called, as these are told."""


@dataclass(frozen=True, eq=False)
class DrawnFit:
    """A model with its identified parameters.

    Parameters
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its element parameters, in the units of the measurement.
    label : str
        Shown in legends; the model's name by default.
    """

    model: Model
    theta: Real
    label: str = ""

    @property
    def name(self) -> str:
        """The label, or the model's name."""
        return self.label or self.model.name

    def at(self, points: Points) -> Complex:
        """Complex stiffness (n,) at `points`."""
        return self.model.stiffness(self.theta, points)


@dataclass(frozen=True, eq=False)
class DrawnAxis:
    """The column against which data are drawn.

    Parameters
    ----------
    column : str
        ``frequency``, ``amplitude`` or ``temperature``.
    label : str
        With its unit.
    values : ndarray, shape (n,)
        Where each measured point stands.
    logarithmic : bool
        How the axis is scaled.
    """

    column: str
    label: str
    values: Real
    logarithmic: bool = True

    def of(self, other: Measurement) -> Real:
        """Where the points of another measurement stand on this axis."""
        if self.column == "frequency":
            return other.units.on_clock(other.frequency)
        return other.conditions[self.column]


def axis_of(measurement: Measurement) -> DrawnAxis:
    """The frequency if it varies, else the amplitude or the temperature, whichever does."""
    units = measurement.units
    along_frequency = DrawnAxis(
        "frequency", ALONG_CLOCK[units.clock], units.on_clock(measurement.frequency)
    )
    if varies("frequency", measurement.frequency):
        return along_frequency
    # Tests at one frequency: what was varied instead is what a reader wants to see.
    labels = {
        "amplitude": f"amplitude [{measurement.units.amplitude}]",
        "temperature": "temperature [°C]",
    }
    for name, label in labels.items():
        column = measurement.conditions.get(name)
        if column is not None and varies(name, column):
            return DrawnAxis(
                name, label, column, logarithmic=name == "amplitude" and bool(np.all(column > 0))
            )
    return along_frequency


def sweeps_of(
    measurement: Measurement, axis: DrawnAxis, own: Collection[str] = ()
) -> list[DrawnSweep]:
    """Every sweep along `axis`, of `own` columns too; one of everything where nothing was held."""
    return all_sweeps(measurement, axis.column, axis.values, own)


def smooth(measurement: Measurement, axis: DrawnAxis, sweep: DrawnSweep) -> tuple[Real, Points]:
    """Places along the axis between a sweep's ends, and the conditions there.

    A condition that follows the axis is interpolated; one that only scatters about its setting is
    taken to be held.
    """
    along = axis.values[sweep.rows]
    # Evenly on the paper, not in the numbers: a curve over decades would be coarse at its lower
    # end.
    place = along
    if axis.logarithmic:
        place = np.log(along)
    # Repeats stand at one place, where interpolation can take one value only.
    known, first = np.unique(place, return_index=True)
    fine: Real = known
    if len(known) > 1:
        fine = np.linspace(known[0], known[-1], CANVAS.smooth)

    def between(column: Real) -> Real:
        here = column[sweep.rows]
        # Through values that jump to and fro a curve would jump as well, and no model would follow
        # it.
        if travels(along, here):
            return np.full(len(fine), float(np.median(here)))
        return np.interp(fine, known, here[first])

    points = measurement.points
    # In the logarithm, as the models take it.
    log_omega = np.interp(fine, known, points.log_omega[sweep.rows][first])
    there = replace(points.mapped(between), log_omega=log_omega)
    if axis.logarithmic:
        fine = np.exp(fine)
    return fine, there


@dataclass(frozen=True, eq=False)
class Scene:
    """Data and fitted models that are drawn together.

    Parameters
    ----------
    measurement : Measurement
        The data.
    fits : sequence of DrawnFit
        The models; none is fine.
    aside : Measurement, optional
        Measured points that were taken for outliers: no model was fitted to them.
    """

    measurement: Measurement
    fits: Sequence[DrawnFit] = ()
    aside: Measurement | None = None

    @cached_property
    def axis(self) -> DrawnAxis:
        """The column along which the data are drawn."""
        return axis_of(self.measurement)

    @cached_property
    def every_sweep(self) -> list[DrawnSweep]:
        """All sweeps along it."""
        # A law of a further column has another curve at each of its levels.
        asked = {column for fit in self.fits for column in fit.model.needs}
        own = {column for fit in self.fits for column in fit.model.own.values()}
        own |= asked - set(CONDITIONS)
        return sweeps_of(self.measurement, self.axis, own)

    @cached_property
    def sweeps(self) -> list[DrawnSweep]:
        """The sweeps that are drawn."""
        return chosen(self.every_sweep)

    @property
    def drawn(self) -> str:
        """``12 of 60 sweeps shown``; nothing where all are."""
        count = len(self.every_sweep)
        # What is left out must be said: a picture looks complete.
        if count <= len(self.sweeps):
            return ""
        return f"{len(self.sweeps)} of {count} sweeps shown"

    @cached_property
    def curves(self) -> list[list[tuple[Real, Complex]]]:
        """Smooth curves: for each fit and each sweep the places and the complex stiffness there."""
        # The places are those of the data, so that all models share them.
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
        # Where colours stand for models, data that are fitted by all of them have none.
        if self.by_fit:
            return INK
        return COLOURS[part]

    def fit_colour(self, fit: int, sweep: int, part: int = 0) -> str:
        """Colour of a model's curve."""
        if self.by_fit:
            return COLOURS[fit % len(COLOURS)]
        return self.data_colour(sweep, part)

    @property
    def marker(self) -> dict[str, Any]:
        """How measured points look."""
        many = len(self.measurement) > ENOUGH
        size = 4.5
        if many:
            size = 1.5
        # Points only: a line through measured points would claim that it is known what lies
        # between.
        return {"linestyle": "none", "markersize": size, "rasterized": many, "markeredgewidth": 1.0}


def sweep_colours(count: int) -> list[str]:
    """Colours in order from dark to light, none too pale to see on white."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(colour) for colour in colormaps["viridis"](np.linspace(0.0, 0.85, count))]


SHARED = "#DDDDDD"
ALIKE = 1.5
"""Bands of all sweeps within this factor of each other are drawn as one."""


def draw_bands(axes: Axes, scene: Scene, width: Real) -> None:
    """Bands of half-width `width` about zero.

    One grey band where the sweeps shown have about the same, else each in the light of its sweep's
    colour with a thin rim, so that points are held against the band of their own colour.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    scene : Scene
        What is drawn there.
    width : ndarray, shape (n,)
        Half-width at each measured point, in the unit of the axis.
    """
    # Of the sweeps that are drawn only: a band without points would mean nothing.
    bands = [_along(scene.axis.values[sweep.rows], width[sweep.rows]) for sweep in scene.sweeps]
    if not any(np.any(half > 0) for _, half in bands):
        return
    if alike(bands):
        places = np.concatenate([x for x, _ in bands])
        widths = np.concatenate([half for _, half in bands])
        x, half = _along(places, widths)
        axes.fill_between(x, -half, half, color=SHARED, linewidth=0.0, zorder=0.5)
        return
    # Where all lie over each other, points must still be seen.
    light = min(0.08, 0.5 / len(bands))
    order = sorted(range(len(bands)), key=lambda i: -float(np.median(bands[i][1])))
    # Wide ones first, or they would cover the narrow ones.
    for place, i in enumerate(order):
        x, half = bands[i]
        colour = "#999999"
        if scene.by_sweep:
            colour = scene.data_colour(i)
        level = 0.5 + 0.01 * place
        axes.fill_between(x, -half, half, color=colour, alpha=light, linewidth=0.0, zorder=level)
        # Where bands lie over each other their ends are seen by the rims alone.
        for side in (-half, half):
            axes.plot(x, side, color=colour, linewidth=0.9, alpha=0.6, zorder=level)


def alike(bands: list[tuple[Real, Real]]) -> bool:
    """Whether bands, given by places and half-widths, are about the same wherever they overlap."""
    if len(bands) == 1:
        return True
    places = np.unique(np.concatenate([x for x, _ in bands]))
    # Sweeps begin and end at different places: outside of its own a band says nothing.
    half = np.array([np.interp(places, x, y, left=np.nan, right=np.nan) for x, y in bands])
    shown = ~np.isnan(half)
    both = shown.sum(axis=0) > 1
    widest = np.max(np.where(shown, half, 0.0), axis=0)[both]
    narrowest = np.min(np.where(shown, half, np.inf), axis=0)[both]
    return bool(np.all(widest <= ALIKE * narrowest))


def _along(x: Real, width: Real) -> tuple[Real, Real]:
    """Places in ascending order, and the widest of each."""
    places, which = np.unique(x, return_inverse=True)
    half = np.zeros(len(places))
    # The widest, where repeats stand at one place: a band that is too narrow would accuse noise.
    np.maximum.at(half, which.ravel(), width)
    return places, half


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
    if positive and _ratio(data.magnitude) > CANVAS.tenfold:
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
