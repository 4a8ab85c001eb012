"""The look of the studies' figures.

The house style, saved as PNG and SVG, left out where matplotlib is missing.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot import Measurement, parse_model
from springpot.errors import OutputError
from springpot.report.canvas import COLOURS, INK, blank, logarithmic, require_matplotlib, save
from springpot.rheology import Complex, Real

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "COLOURS",
    "INK",
    "MARKERS",
    "Curve",
    "can_draw",
    "legend_above",
    "logarithmic",
    "moduli",
    "sheet",
]

MARKERS = ("D", "^", "s", "o", "v", "P", "X")
"""Diamonds, triangles, squares and circles in the order of the paper's Figure 11."""


def can_draw(folder: Path) -> bool:
    """Whether figures can be drawn; says so if not."""
    try:
        require_matplotlib()
    except OutputError as error:
        print(f"no figures in {folder}: {error}", file=sys.stderr)
        return False
    return True


@contextmanager
def sheet(
    folder: Path,
    stem: str,
    width: float = 7.2,
    height: float = 4.4,
    suffixes: Sequence[str] = (".png", ".svg"),
) -> Iterator[Figure]:
    """An empty figure that is written to ``stem.png`` and ``stem.svg`` at the end."""
    with blank(width, height) as figure:
        yield figure
        for suffix in suffixes:
            save(figure, folder / f"{stem}{suffix}")


def legend_above(
    figure: Figure, source: Axes | Sequence[Any], title: str, columns: int = 3
) -> None:
    """A headline and the legend over the axes, never over the data."""
    handles = (
        list(source) if isinstance(source, Sequence) else source.get_legend_handles_labels()[0]
    )
    legend = figure.legend(
        handles=handles,
        title=title,
        title_fontsize=11.0,
        alignment="left",
        loc="outside upper left",
        ncols=columns,
        handlelength=2.4,
    )
    legend.get_title().set_color(INK)


@dataclass(frozen=True)
class Curve:
    """A model with its parameters, drawn as a line with markers.

    Parameters
    ----------
    label : str
        Shown in the legend.
    model : str
        Model expression.
    theta : dict of str to float
        Its parameters.
    style : dict
        Further properties of the line.
    """

    label: str
    model: str
    theta: Mapping[str, float]
    style: dict[str, Any] = field(default_factory=dict)

    def at(self, omega: Real) -> Complex:
        """Complex stiffness (n,)."""
        model = parse_model(self.model)
        stiffness: Complex = model.stiffness(model.vector(self.theta), omega)
        return stiffness


def moduli(
    axes: Axes, data: Measurement, curves: Sequence[Curve], part: str, log: bool = True
) -> None:
    """One modulus (``storage`` or ``loss``) against frequency.

    Data as crosses, models as lines with markers.
    """
    spaced = np.geomspace if log else np.linspace
    hertz = spaced(data.frequency.min(), data.frequency.max(), 121)
    for i, curve in enumerate(curves):
        stiffness = curve.at(2.0 * np.pi * hertz)
        style = {
            "color": COLOURS[i],
            "marker": MARKERS[i],
            "markerfacecolor": "white",
            "markevery": (5 * i, 24),
        }
        axes.plot(
            hertz, getattr(stiffness, _PART[part]), label=curve.label, **{**style, **curve.style}
        )
    axes.plot(
        data.frequency, getattr(data, part), "+", color=INK, markersize=7, zorder=4, label="data"
    )
    if log:
        logarithmic(axes, "x")
        logarithmic(axes, "y")
    what = "modulus" if data.units.is_modulus else "stiffness"
    axes.set(xlabel="frequency f [Hz]", ylabel=f"{part} {what} [{data.units.stiffness}]")


_PART = {"storage": "real", "loss": "imag"}
