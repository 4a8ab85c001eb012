"""The two levels against which every error is drawn.

What noise leaves, and what any material leaves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.format_numbers import number
from springpot.identification.result import Identification
from springpot.rheology.points import Real

from .numbers import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MATERIAL = "#444444"
"""Dashes in no colour that stands for a model."""
DASHES: dict[str, Any] = {"color": MATERIAL, "linestyle": "--", "linewidth": 1.4}


def beside_floors(identified: Identification) -> str:
    """The error beside what noise alone and what any material leaves, where the data can tell."""
    standing = identified.standing
    if standing is None or not standing.noise_floor > 0.0:
        return ""
    ratio = number(identified.relative_rms / standing.noise_floor, 2)
    noise = (
        f"{ratio} x the noise floor of {percent(standing.noise_floor, 2)} ({standing.noise_source})"
    )
    return f", {noise}; material floor {percent(standing.material_floor, 2)}"


def draw_floors(axes: Axes, noise: Real, material: Real, after: float = 0.0) -> None:
    """The noise floor as a band that reaches the bottom, the material floor as dashes, by place.

    Parameters
    ----------
    axes : Axes
        Whose places are 0, 1, ...
    noise, material : ndarray, shape (m,)
        In per cent of |K|.
    after : float
        Room behind the last place.
    """
    # Half a place to either side of each mark.
    ends = np.arange(len(noise) + 1) - 0.5
    ends[-1] += after
    # Each place its own level, as wide as its share of the axis: a slope between two would mean
    # nothing.
    edges = np.repeat(ends, 2)[1:-1]
    axes.fill_between(
        edges,
        np.repeat(noise, 2),
        0.0,
        color="#DDDDDD",
        linewidth=0.0,
        label="noise floor",
        zorder=0.5,
    )
    axes.hlines(
        material,
        ends[:-1],
        ends[1:],
        color=MATERIAL,
        linestyle="--",
        linewidth=1.4,
        label="material floor",
        zorder=2.5,
    )
    axes.set_xlim(edges[0], edges[-1])
