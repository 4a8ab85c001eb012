"""What noise explains in a plane of residuals.

A band about zero, for each sweep its own where sweeps differ.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from springpot.rheology.points import Real

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .scene import Scene

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
