"""What noise explains in a plane of residuals: a band about zero, for each sweep its own where sweeps differ."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from springpot.rheology import Real

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .scene import Scene

SHARED = "#DDDDDD"
ALIKE = 1.5
"""Bands of all sweeps within this factor of each other are drawn as one."""


def draw_bands(axes: Axes, scene: Scene, width: Real) -> None:
    """Bands of half-width `width` about zero.

    One grey band where the sweeps shown have about the same, else each in the light of its sweep's colour with a thin
    rim, so that points are held against the band of their own colour.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    scene : Scene
        What is drawn there.
    width : ndarray, shape (n,)
        Half-width at each measured point, in the unit of the axis.
    """
    bands = [_along(scene.axis.values[sweep.rows], width[sweep.rows]) for sweep in scene.sweeps]
    if not any(np.any(half > 0) for _, half in bands):
        return
    if alike(bands):
        x, half = _along(np.concatenate([x for x, _ in bands]), np.concatenate([half for _, half in bands]))
        axes.fill_between(x, -half, half, color=SHARED, linewidth=0.0, zorder=0.5)
        return
    light = min(0.08, 0.5 / len(bands))  # where all lie over each other, points must still be seen
    order = sorted(range(len(bands)), key=lambda i: -float(np.median(bands[i][1])))
    for place, i in enumerate(order):  # wide ones first, or they would cover the narrow ones
        x, half = bands[i]
        colour = "#999999"
        if scene.by_sweep:
            colour = scene.data_colour(i)
        level = 0.5 + 0.01 * place
        axes.fill_between(x, -half, half, color=colour, alpha=light, linewidth=0.0, zorder=level)
        for side in (-half, half):
            axes.plot(x, side, color=colour, linewidth=0.9, alpha=0.6, zorder=level)


def alike(bands: list[tuple[Real, Real]]) -> bool:
    """Whether bands, given by their places and half-widths, are about the same wherever they overlap."""
    if len(bands) == 1:
        return True
    places = np.unique(np.concatenate([x for x, _ in bands]))
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
    np.maximum.at(half, which.ravel(), width)
    return places, half
