"""What is drawn together.

The data, their sweeps and fitted models, and which colour stands for what.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.rheology.points import Complex, Real

from .canvas import COLOURS, INK
from .curves import Axis, Fit, axis_of, smooth, sweeps_of
from .sweeps import Sweep, chosen

MANY_POINTS = 2000
"""More points than this are drawn small and as pixels, even in a vector figure."""


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
        many = len(self.measurement) > MANY_POINTS
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
