"""The picture of a diagnosis.

The model's error, and what each effect that matters would leave of it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from springpot.diagnosis.result import Diagnosis

from .answers import worth_showing
from .canvas import COLOURS, blank, finished, logarithmic
from .floors import draw_floors
from .ladder import ROOM, beside_mark, broken, entitled
from .numbers import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def figure_diagnosis(diagnosis: Diagnosis, path: str | Path | None = None) -> Figure | Path:
    """The diagnosis as a figure, which is written to `path` if there is one.

    Parameters
    ----------
    diagnosis : Diagnosis
        What to draw.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    with blank(6.4, 4.4) as figure:
        axes = figure.subplots()
        draw_diagnosis(axes, diagnosis)
        entitled(axes, f"{diagnosis.model.name} of {diagnosis.data}: {diagnosis.verdict}")
        return finished(figure, path)


def draw_diagnosis(axes: Axes, diagnosis: Diagnosis) -> None:
    """Error of the model as it is and with each leading effect alone, beside both floors."""
    shown = []
    # Where nothing is missing, remedies would be read as if something were.
    if diagnosis.verdict != "adequate":
        shown = worth_showing(diagnosis)
    own = diagnosis.error
    after = 100.0 * np.array([own.relative_rms, *(one.error_after for one in shown)])
    predicted = 100.0 * np.array([one.predicted_error for one in shown])
    places = np.arange(len(after))
    noise, material = 100.0 * own.noise_floor, 100.0 * own.material_floor
    # What any material reaches is known for the model as it is: with another effect it would be
    # another level.
    draw_floors(axes, np.full(len(after), noise), np.where(places == 0, material, np.nan))
    axes.plot(places, after, "o", color=COLOURS[0], label="error", zorder=4, markersize=6.0)
    if shown:
        axes.plot(
            places[1:],
            predicted,
            "D",
            color=COLOURS[1],
            markerfacecolor="white",
            label="predicted",
            zorder=3,
        )
    for x, error in enumerate(after):
        beside_mark(axes, (x, error), percent(error / 100.0, 2))
    axes.set_xticks(places, ["as it is", *(broken(f"+ {one.effect}") for one in shown)])
    axes.tick_params(axis="x", length=0)
    axes.grid(False, axis="x")
    levels = np.array([noise, material, *after, *predicted])
    # Exact data have no noise floor, and what could not be fitted has no error.
    drawn = levels[np.isfinite(levels) & (levels > 0.0)]
    axes.set_ylim(float(drawn.min()) / ROOM, float(drawn.max()) * ROOM)
    logarithmic(axes, "y")
    axes.set_ylabel("error [%]")
    axes.legend(loc="upper right")
