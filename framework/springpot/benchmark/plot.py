"""Line plots as inline SVG.

Sharp at every width, searchable, with nothing to load and no library to install.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10
from typing import NamedTuple

import numpy as np

from springpot.report.canvas import COLOURS, INK, QUIET
from springpot.rheology.points import Real
from springpot.writing import Html, joined, tag

from ..numerics import ALIKE


class PlotSizes(NamedTuple):
    """Of a picture: its size, its margins, and what stands at its axes, in px."""

    width: float
    height: float
    left: float
    right: float
    top: float
    bottom: float
    row: float
    names: float
    ticks: int
    """Numbers at an axis at most."""


PLOT = PlotSizes(
    width=420.0,
    height=290.0,
    left=56.0,
    right=18.0,
    top=10.0,
    bottom=40.0,
    row=19.0,
    names=150.0,
    ticks=7,
)
DASHES = ("none", "6 3", "2 2.5")
"""What tells lines of one colour apart."""
GREY = "#C4C4C4"
"""Of lines that are named under the pointer only."""


@dataclass(frozen=True)
class Pen:
    """How a line is drawn: one of 21 that differ in colour or dashes, best first; the rest grey."""

    number: int

    @property
    def told(self) -> bool:
        """Whether no other pen draws lines like it."""
        return self.number < len(COLOURS) * len(DASHES)

    @property
    def colour(self) -> str:
        """Hexadecimal."""
        if not self.told:
            return GREY
        return COLOURS[self.number % len(COLOURS)]

    @property
    def dashes(self) -> str:
        """As SVG writes them."""
        if not self.told:
            return DASHES[0]
        return DASHES[self.number // len(COLOURS)]

    @property
    def look(self) -> dict[str, str]:
        """Attributes of a line."""
        width = "1.3"
        if self.number < len(COLOURS):
            width = "2"
        return {
            "fill": "none",
            "stroke": self.colour,
            "stroke_width": width,
            "stroke_dasharray": self.dashes,
        }


@dataclass(frozen=True, eq=False)
class StepLine:
    """A step line, with a band if there is one.

    Parameters
    ----------
    label : str
        Shown under the pointer.
    x, y : ndarray, shape (n,)
        Each value holds until the next x; it is not drawn where it is infinite.
    pen : Pen
        How.
    band : ndarray, shape (2, n), optional
        Lower and upper end.
    """

    label: str
    x: Real
    y: Real
    pen: Pen
    band: Real | None = None


@dataclass(frozen=True)
class Dot:
    """One point of a scatter.

    Parameters
    ----------
    label : str
        Shown under the pointer.
    x, y : float
        Where.
    pen : Pen
        Its colour; those beyond the first colours are hollow.
    large : bool
        Whether it stands for many others.
    name : str
        Written beside it.
    """

    label: str
    x: float
    y: float
    pen: Pen
    large: bool = False
    name: str = ""


@dataclass(frozen=True)
class PlotAxis:
    """One axis.

    Parameters
    ----------
    label : str
        With its unit.
    low, high : float
        Its ends.
    logarithmic : bool
        Decades instead of equal steps.
    """

    label: str
    low: float
    high: float
    logarithmic: bool = False

    def place(self, values: Real) -> Real:
        """Values as parts of the axis, cut at its ends."""
        # At the edge rather than outside: a point that is off still counts as one.
        inside: Real = np.clip(values, self.low, self.high)
        low, high = self.low, self.high
        if self.logarithmic:
            # After the cut: below the lower end there may be zeros.
            inside, (low, high) = np.log10(inside), np.log10([low, high])
        return (inside - low) / (high - low)

    def ticks(self) -> list[float]:
        """Where numbers stand."""
        if not self.logarithmic:
            return [float(v) for v in np.linspace(self.low, self.high, 6)]
        # Rounding must not cost an end that is a decade its number.
        first, last = ceil(log10(self.low) - ALIKE), floor(log10(self.high) + ALIKE)
        step = max(1, ceil((last - first) / PLOT.ticks))
        return [10.0**power for power in range(first, last + 1, step)]


def plot(lines: Sequence[StepLine], x: PlotAxis, y: PlotAxis, title: str) -> Html:
    """The lines in one frame; the first are drawn last, above the others.

    Parameters
    ----------
    lines : sequence of StepLine
        Best first.
    x, y : PlotAxis
        The axes.
    title : str
        Read aloud where the picture cannot be seen.
    """
    # Bands below all lines: one that lay above a line would hide it.
    bands = [_band(line, x, y) for line in reversed(lines) if line.band is not None]
    drawn: list[Html] = []
    for line in reversed(lines):
        drawn += _line(line, x, y)
    return _picture(title, [*_frame(x, y), *bands, *drawn])


def _picture(
    title: str, parts: Sequence[Html], height: float = PLOT.height, width: float = PLOT.width
) -> Html:
    box = f"0 0 {width:g} {height:g}"
    return tag("svg", tag("title", title), *parts, viewBox=box, role="img", class_="plot")


def scatter(dots: Sequence[Dot], x: PlotAxis, y: PlotAxis, title: str) -> Html:
    """Points in one frame; large ones are drawn last, above the others.

    Parameters
    ----------
    dots : sequence of Dot
        The points; what lies beyond an axis is drawn at its end.
    x, y : PlotAxis
        The axes.
    title : str
        Read aloud where the picture cannot be seen.
    """
    drawn: list[Html] = []
    # `sorted` is stable: within one size the order of the caller stays.
    for dot in sorted(dots, key=lambda dot: dot.large):
        drawn += _dot(dot, x, y)
    return _picture(title, [*_frame(x, y), *drawn])


def _dot(dot: Dot, x: PlotAxis, y: PlotAxis) -> Iterator[Html]:
    across, down = float(_across(x, np.array(dot.x))), float(_down(y, np.array(dot.y)))
    # Hollow where lines of this pen are dashed: colours alone are too few.
    inside = "white"
    if dot.pen.dashes == "none":
        inside = dot.pen.colour
    radius, opacity = ("2.5", "0.35")
    if dot.large:
        radius, opacity = ("5", "1")
    yield tag(
        "circle",
        tag("title", dot.label),
        cx=f"{across:.1f}",
        cy=f"{down:.1f}",
        r=radius,
        fill=inside,
        fill_opacity=opacity,
        stroke=dot.pen.colour,
        stroke_opacity=opacity,
    )
    if dot.name:
        # In the right part of the frame a name stands to the left of its point, or it would leave
        # the frame.
        beside, anchor = (8, "start")
        if across > 0.6 * PLOT.width:
            beside, anchor = (-8, "end")
        yield _text(dot.name, across + beside, down + 4, anchor)


def key(labels: Sequence[str], pens: Sequence[Pen]) -> Html:
    """What the lines mean; those that are alike have one entry."""
    entries = [(label, pen) for label, pen in zip(labels, pens, strict=True) if pen.told]
    if alike := labels[len(entries) :]:
        entries.append((f"each of {', '.join(alike)}", pens[-1]))
    return tag("p", *(_sample(*entry) for entry in entries), class_="keys")


def _sample(label: str, pen: Pen) -> Html:
    stroke = tag("line", x1="0", y1="6", x2="26", y2="6", **pen.look)
    return joined(
        [
            tag(
                "span",
                tag("svg", stroke, width="26", height="12", aria_hidden="true"),
                label,
                class_="key",
            ),
            " ",
        ]
    )


def _tick(value: float) -> str:
    """Short: 0.001 and 10000, but 1e-4 and 1e5."""
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:g}"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")


def _across(x: PlotAxis, values: Real) -> Real:
    return PLOT.left + (PLOT.width - PLOT.left - PLOT.right) * x.place(values)


def _down(y: PlotAxis, values: Real) -> Real:
    return PLOT.height - PLOT.bottom - (PLOT.height - PLOT.top - PLOT.bottom) * y.place(values)


def _frame(x: PlotAxis, y: PlotAxis) -> Iterator[Html]:
    floor_, right = PLOT.height - PLOT.bottom, PLOT.width - PLOT.right
    for value, place in zip(x.ticks(), _across(x, np.array(x.ticks())), strict=True):
        yield _rule(place, PLOT.top, place, floor_)
        yield _text(_tick(value), place, floor_ + 15, "middle")
    for value, place in zip(y.ticks(), _down(y, np.array(y.ticks())), strict=True):
        yield _rule(PLOT.left, place, right, place)
        yield _text(_tick(value), PLOT.left - 5, place + 4, "end")
    # Every text by `tag`, which escapes it: names of optimisers come from plugins.
    yield _text(x.label, 0.5 * (PLOT.left + right), PLOT.height - 6, "middle")
    middle = 0.5 * (PLOT.top + floor_)
    turned = f"translate(12 {middle:g}) rotate(-90)"
    yield tag("text", y.label, x="0", y="0", transform=turned, text_anchor="middle", fill=INK)


def _rule(x1: float, y1: float, x2: float, y2: float, colour: str = "#E6E6E6") -> Html:
    return tag(
        "line", x1=f"{x1:.1f}", y1=f"{y1:.1f}", x2=f"{x2:.1f}", y2=f"{y2:.1f}", stroke=colour
    )


def _text(
    text: str, x: float, y: float, anchor: str, colour: str = INK, weight: str = "normal"
) -> Html:
    return tag(
        "text",
        text,
        x=f"{x:.1f}",
        y=f"{y:.1f}",
        text_anchor=anchor,
        fill=colour,
        font_weight=weight,
    )


def _line(line: StepLine, x: PlotAxis, y: PlotAxis) -> Iterator[Html]:
    # Endless where most trials have failed: the line begins where it comes into sight.
    shown = np.isfinite(line.y)
    if shown.any():
        path = _steps(_across(x, line.x[shown]), _down(y, line.y[shown]))
        yield tag("path", tag("title", line.label), d=f"M{path}", **line.pen.look)


def _steps(across: Real, down: Real) -> str:
    """Corners of a step line, without those at which nothing changes."""
    # Less does not show in the one decimal that is written.
    turns = np.flatnonzero(np.abs(np.diff(down, prepend=np.inf)) > 0.05)
    first, *rest = turns.tolist()
    corners = [
        f"{across[first]:.1f} {down[first]:.1f}",
        *(f"H{across[i]:.1f}V{down[i]:.1f}" for i in rest),
    ]
    return "".join([*corners, f"H{across[-1]:.1f}"])


def _band(line: StepLine, x: PlotAxis, y: PlotAxis) -> Html:
    assert line.band is not None
    low, high = line.band
    shown = np.isfinite(low) & np.isfinite(line.y)
    if not shown.any():
        return Html("")
    across = _across(x, line.x[shown])
    # An upper quartile without end stops at the frame.
    lower, upper = _down(y, low[shown]), _down(y, np.minimum(high[shown], y.high))
    # Steps, as the line has them: the band must not cut their corners.
    ends = np.repeat(across, 2)[1:]
    there = [f"{a:.1f} {b:.1f}" for a, b in zip(ends, np.repeat(lower, 2)[:-1], strict=True)]
    back = [
        f"{a:.1f} {b:.1f}" for a, b in zip(ends[::-1], np.repeat(upper, 2)[:-1][::-1], strict=True)
    ]
    return tag(
        "path",
        d=f"M{'L'.join(there + back)}Z",
        fill=line.pen.colour,
        fill_opacity="0.15",
        stroke="none",
    )


@dataclass(frozen=True)
class Ranked:
    """One row of a critical-difference diagram."""

    label: str
    rank: float
    low: float
    high: float


def critical_differences(
    rows: Sequence[Ranked], cliques: Sequence[tuple[int, int]], title: str
) -> Html:
    """Mean ranks with their intervals, best first.

    A bar at the right joins those that cannot be told apart.

    Parameters
    ----------
    rows : sequence of Ranked
        By rising rank.
    cliques : sequence of (int, int)
        First and last row of each bar.
    title : str
        Read aloud where the picture cannot be seen.
    """
    # Room at the right, as much as there are bars: the axis gets the rest. A long name makes the
    # picture wider; a letter of 12 px is some 7 wide.
    bars = 7.0 * len(cliques) + 8.0
    names = max(PLOT.names, 14.0 + 7.0 * max(len(row.label) for row in rows))
    width = PLOT.width + names - PLOT.names
    height = PLOT.row * len(rows) + 34.0
    # An axis of one rank alone would have no length.
    axis = PlotAxis("mean rank", 1.0, float(max(len(rows), 2)))
    inner = width - names - bars - 12.0
    places = names + inner * axis.place(np.array([[row.low, row.rank, row.high] for row in rows]))
    marks = np.unique(np.linspace(axis.low, axis.high, min(len(rows), 6)).round())
    parts = []
    for mark, place in zip(marks, names + inner * axis.place(marks), strict=True):
        parts.append(_rule(place, 4, place, height - 30))
        parts.append(_text(f"{mark:g}", place, height - 17, "middle"))
    for i, (row, (low, at, high)) in enumerate(zip(rows, places, strict=True)):
        level = 4.0 + PLOT.row * (i + 0.5)
        weight = "normal"
        if i == 0:
            weight = "600"
        parts.append(_text(row.label, names - 10, level + 4, "end", weight=weight))
        parts.append(_rule(low, level, high, level, QUIET))
        words = f"{row.label}: mean rank {row.rank:.2f} [{row.low:.2f}, {row.high:.2f}]"
        place = {"cx": f"{at:.1f}", "cy": f"{level:.1f}"}
        parts.append(tag("circle", tag("title", words), **place, r="4", fill=COLOURS[0]))
    for i, (first, last) in enumerate(cliques):
        place = width - bars + 7.0 * i
        top, bottom = 4.0 + PLOT.row * (first + 0.2), 4.0 + PLOT.row * (last + 0.8)
        ends = {"x1": place, "y1": top, "x2": place, "y2": bottom}
        shown = {name: f"{at:.1f}" for name, at in ends.items()}
        bar = tag("line", **shown, stroke=INK, stroke_width="3", stroke_linecap="round")
        parts.append(bar)
    parts.append(_text(axis.label, names + 0.5 * inner, height - 3, "middle"))
    return _picture(title, parts, height, width)
