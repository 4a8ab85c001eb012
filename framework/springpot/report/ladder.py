"""The picture of a discovery.

The error after each accepted effect against the noise floor and the material floor.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from springpot.diagnosis.ladder import Ladder, Step
from springpot.misfit.words import plain

from .canvas import COLOURS, INK, QUIET, blank, finished, logarithmic
from .figures import draw_floors
from .numbers import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LEVEL = 5
"""Steps whose names are set level; of more, they are slanted."""
LETTERS = 14
"""Letters of a name's line before it is broken."""
AFTER = 0.4
"""Room for the words at the last step, in steps."""
ROOM = 2.5
"""The error axis reaches this factor below the floor and above the largest error."""


def figure_ladder(ladder: Ladder, path: str | Path | None = None) -> Figure | Path:
    """The ladder as a figure, which is written to `path` if there is one.

    Parameters
    ----------
    ladder : Ladder
        The discovery.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    with blank(max(6.4, 1.15 * len(ladder.steps) + 1.2), 4.4) as figure:
        axes = figure.subplots()
        draw_ladder(axes, ladder)
        entitled(axes, f"{ladder.steps[0].model.name} of {ladder.data}")
        return finished(figure, path)


def draw_ladder(axes: Axes, ladder: Ladder) -> None:
    """Error, forecast, noise floor and material floor of each step on a logarithmic axis."""
    steps = ladder.steps
    place = np.arange(len(steps))
    error = 100.0 * np.array([step.relative_rms for step in steps])
    floor = 100.0 * np.array([step.noise_floor for step in steps])
    material = 100.0 * np.array([step.material_floor for step in steps])
    draw_floors(axes, floor, material, AFTER)
    _forecast(axes, steps, error)
    axes.plot(place, error, "o-", color=COLOURS[0], label="error", zorder=4, markersize=6.0)
    for x, step in enumerate(steps):
        words = f"{percent(step.relative_rms, 2)}\n{_ratio(step)}"
        beside_mark(axes, (x, error[x]), words)
    _names(axes, steps)
    logarithmic(axes, "y")
    lines = np.concatenate([floor, material, error])
    # A floor of exact data is zero, which has no place on a logarithmic axis.
    drawn = lines[lines > 0]
    axes.set_ylim(float(drawn.min()) / ROOM, float(drawn.max()) * ROOM)
    # Again: which numbers stand at the axis depends on its ends.
    logarithmic(axes, "y")
    axes.set_ylabel("error [%]")
    axes.legend(loc="upper right")


def entitled(axes: Axes, title: str) -> None:
    """Set the title of a picture of one panel, as it stands.

    A dollar sign in a file's name begins no formula.
    """
    axes.set_title(title.replace("$", r"\$"), fontsize=11.0)


def beside_mark(axes: Axes, place: tuple[float, float], words: str) -> None:
    """Write words to the upper right of a mark."""
    axes.annotate(
        words, place, (7, 5), textcoords="offset points", fontsize=9.0, color=INK, zorder=5
    )


def _ratio(step: Step) -> str:
    if not step.noise_floor > 0:
        return "no noise"
    return f"{plain(step.relative_rms / step.noise_floor, 2)} × floor"


def _forecast(
    axes: Axes, steps: tuple[Step, ...], error: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> None:
    forecasts = [
        (x, 100.0 * step.predicted_error) for x, step in enumerate(steps) if step.predicted_error
    ]
    for i, (x, predicted) in enumerate(forecasts):
        # From the step before, where it was made.
        axes.plot(
            [x - 1, x], [error[x - 1], predicted], ":", color=COLOURS[1], linewidth=1.2, zorder=2
        )
        # A legend names each kind of mark once.
        label: str | None = None
        if i == 0:
            label = "predicted"
        hidden = 0.97 < predicted / error[x] < 1.03
        size = 6.0
        # Around the error's own mark, where both fall together.
        if hidden:
            size = 10.0
        axes.plot(
            x,
            predicted,
            "D",
            color=COLOURS[1],
            markerfacecolor="white",
            label=label,
            zorder=3,
            markersize=size,
        )


def _names(axes: Axes, steps: tuple[Step, ...]) -> None:
    names = [broken(_name(step)) for step in steps]
    axes.set_xticks(range(len(steps)), names, color=INK)
    if len(steps) > MOST_LEVEL:
        axes.tick_params(axis="x", labelrotation=30)
    axes.tick_params(axis="x", length=0)
    axes.grid(False, axis="x")
    axes.spines["bottom"].set_color(QUIET)


def _name(step: Step) -> str:
    if step.accepted is None:
        return step.model.base
    # A leading hyphen marks an effect that was dropped again.
    if step.accepted.startswith("-"):
        return f"− {step.accepted[1:]}"
    return f"+ {step.accepted}"


def broken(name: str) -> str:
    """A long name on several lines, broken behind hyphens."""
    lines = [""]
    # The hyphen stays at the end of its line.
    for part in name.replace("-", "-\0").split("\0"):
        if lines[-1] and len(lines[-1]) + len(part) > LETTERS:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)
