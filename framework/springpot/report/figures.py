"""Whole figures: a few views with one legend, written to a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.measurement.measurement import Measurement

from . import views
from .canvas import INK, blank, finished, save
from .curves import Fit
from .floors import DASHES
from .numbers import percent
from .scene import Scene
from .text import cut

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

MARK_WIDTH = 1.75
"""Inches for one entry of a legend, at least."""
LINE_WIDTH, LETTER_WIDTH = 0.6, 0.075
"""Inches for the line and for each letter of an entry."""

TITLE_WIDTH = 78
"""Characters of a title before it is cut."""


def figure_identification(
    measurement: Measurement, fits: Sequence[Fit], path: str | Path | None = None, beside: str = ""
) -> Figure | Path:
    """Storage and loss with the models' curves, and the residuals below.

    Parameters
    ----------
    measurement : Measurement
        The data.
    fits : sequence of Fit
        The models with their parameters.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    beside : str
        What the error of a single model stands beside.
    """
    scene = Scene(measurement, fits)
    with blank(7.2, 5.8) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1.4))
        views.storage_and_loss(above, scene)
        views.residual(below, scene)
        above.set_xlabel("")
        headed(figure, scene, beside=beside)
        return finished(figure, path)


def figure_comparison(measurement: Measurement, fits: Sequence[Fit], path: str | Path) -> Path:
    """All the views that rheologists use, of data and models.

    Parameters as in `figure_identification`.
    """
    scene = Scene(measurement, fits)
    drawings = (
        views.storage_and_loss,
        views.residual,
        views.loss_factor,
        views.cole_cole,
        views.black,
        views.van_gurp_palmen,
    )
    names = ("storage and loss", "residual", "loss factor", "Cole-Cole", "Black", "van Gurp-Palmen")
    with blank(11.0, 10.5) as figure:
        for axes, draw, name in zip(figure.subplots(3, 2).flat, drawings, names, strict=True):
            draw(axes, scene)
            axes.set_title(name)
        headed(figure, scene)
        return save(figure, path)


def _headline(scene: Scene, beside: str) -> str:
    """What is shown, and how well the model fits."""
    data = scene.measurement
    drawn = ""
    if scene.drawn:
        drawn = f"; {scene.drawn}"
    # Data alone have no error to tell.
    if not scene.fits:
        return f"{cut(data.name, TITLE_WIDTH)}{drawn}"
    # Of several models each has its error in the table, and its name in the legend.
    if len(scene.fits) > 1:
        return f"{cut(data.name, TITLE_WIDTH)}\npoints measured, lines fitted{drawn}"
    fit = scene.fits[0]
    # Of all points, those among them that are too many to be drawn.
    share = np.abs(fit.at(data.points) - data.stiffness) / data.magnitude
    error = percent(float(np.sqrt(np.mean(share**2))))
    fitted = cut(f"{fit.name} fitted to {data.name}", TITLE_WIDTH)
    # On a line of its own: together they are wider than the figure.
    beside = beside.replace(", ", "\n", 1)
    return (
        f"{fitted}\npoints measured, lines fitted; error {error} of"
        f" {data.units.magnitude}{drawn}{beside}"
    )


def headed(
    figure: Figure, scene: Scene, below: Scene | None = None, floors: bool = False, beside: str = ""
) -> None:
    """Headline and what the marks mean above the axes, the sweeps beside them: never over the data.

    Parameters
    ----------
    figure : Figure
        With its axes drawn.
    scene : Scene
        What they show.
    below : Scene, optional
        What further rows show, in which colours stand for sweeps though they may stand for models
        above.
    floors : bool
        Whether the material floor is drawn beside residuals.
    beside : str
        What the error of a single model stands beside.
    """
    marks = marks_of(scene)
    if floors:
        marks.append(_mark("± material floor", **DASHES))
    # A legend's own title is the one headline that the layout keeps clear of the legend.
    above = figure.legend(
        handles=marks,
        title=literal(_headline(scene, beside)),
        title_fontsize=11.0,
        alignment="left",
        loc="outside upper left",
        ncols=min(len(marks), max(1, int(figure.get_figwidth() / _width(marks)))),
        handlelength=2.6,
    )
    above.get_title().set_color(INK)
    # Outside of the axes: a dozen sweeps would cover the data.
    if scene.by_sweep:
        figure.legend(handles=sweep_marks(scene), loc="outside right upper", handlelength=1.0)
    elif below is not None and below.by_sweep:
        title = "residuals of"
        figure.legend(
            handles=sweep_marks(below), title=title, loc="outside right center", handlelength=1.0
        )


def _width(marks: Sequence[Line2D]) -> float:
    """Inches that the widest entry of a legend needs."""
    return max(
        MARK_WIDTH, *(LINE_WIDTH + LETTER_WIDTH * len(str(mark.get_label())) for mark in marks)
    )


def marks_of(scene: Scene) -> list[Line2D]:
    """What the marks and lines of a scene mean, for a legend."""
    first, second = INK, INK
    # Elsewhere a colour stands for a sweep or a model, and so for neither storage nor loss.
    if not scene.by_sweep and not scene.by_fit:
        first, second = scene.data_colour(0, 0), scene.data_colour(0, 1)
    solid, dashed, dotted = "none", "none", "none"
    if scene.fits:
        solid, dashed, dotted = "-", "--", ":"
    marks = [
        _mark("storage", first, marker="o", linestyle=solid),
        _mark("loss", second, marker="o", markerfacecolor="white", linestyle=dashed),
    ]
    # On a logarithmic axis what is negative can only be drawn by its size, which must be said.
    if np.any(scene.measurement.storage < 0) or np.any(scene.measurement.loss < 0):
        marks.append(_mark("negative: its size", INK, marker="x", linestyle=dotted))
    if scene.measurement.sd is not None and scene.fits:
        marks.append(_mark("± 2 standard deviations", "#DDDDDD", linewidth=7.0))
    if scene.by_fit:
        marks += [
            _mark(fit.name, scene.fit_colour(i, 0), linewidth=4.0)
            for i, fit in enumerate(scene.fits)
        ]
    return marks


def sweep_marks(scene: Scene) -> list[Line2D]:
    """The colours of the sweeps, for a legend."""
    return [
        _mark(sweep.label, scene.data_colour(i), marker="s", linestyle="none")
        for i, sweep in enumerate(scene.sweeps)
    ]


def _mark(label: str, color: str, **style: Any) -> Line2D:
    # Loaded when something is drawn: text needs no matplotlib.
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color, label=literal(label), **style)


def literal(text: str) -> str:
    """Text from data, in which a dollar sign must not start a formula."""
    return text.replace("$", r"\$")
