"""Blank figures in one style, how they reach a file, and which of many curves stand on them.

The one place that sets matplotlib up. A figure shows itself at the end of a notebook's cell,
without pyplot's global state.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.errors import OutputError
from springpot.files import require_writable, write_with
from springpot.measurement.conversion import levels_in_words
from springpot.measurement.independence import ranges
from springpot.measurement.measurement import Measurement, held_levels, numbers_of_levels
from springpot.numerics import evenly
from springpot.rheology.levels import levels_of
from springpot.rheology.points import Real
from springpot.thresholds import VARIED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Canvas(NamedTuple):
    """What all pictures share."""

    screen: int
    """Dots per inch of a picture in a notebook: text of 10 points stays readable at a column's
    width.
    """
    smooth: int
    """Points of a drawn curve: hardly fewer than a picture has columns."""
    tenfold: float
    """Values that differ by more than this are drawn on a logarithmic axis."""
    narrow: float
    """A logarithmic axis whose ends differ by less than this factor is also labelled at 2 and 5."""
    plain: tuple[float, float]
    """Sizes between which numbers stand without a power of ten."""


CANVAS = Canvas(screen=110, smooth=200, tenfold=10.0, narrow=300.0, plain=(1e-3, 1e6))


@cache
def picture() -> type[Figure]:
    """The class of a figure of its own; notebooks ask it for its PNG."""
    # Only who draws waits for the library, which takes as long as all else that a worker imports.
    from matplotlib.figure import Figure

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            stream = BytesIO()
            self.savefig(stream, format="png", dpi=CANVAS.screen)
            return stream.getvalue()

    return Picture


SUFFIXES = (".png", ".svg", ".pdf")
MOVING = (*SUFFIXES, ".gif")
"""Of what comes about in steps."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Told apart by the colour-blind; doi:10.1038/nmeth.1618."""


INK, QUIET = "#222222", "#8A8A8A"

STYLE: dict[Any, Any] = {
    "font.size": 10.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 10.0,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "mathtext.default": "regular",
    # The same figure gives the same bytes, so that a changed file means a changed result.
    "svg.hashsalt": "springpot",
    # Text in an SVG stays text: it can be searched and read aloud.
    "svg.fonttype": "none",
}


def check_figure_path(path: str | Path, suffixes: Sequence[str] = SUFFIXES) -> Path:
    """`path`, after a check that a figure can be written there.

    Called before long work, not after it.

    Parameters
    ----------
    path : str or Path
        Of the figure.
    suffixes : sequence of str
        The ends of its name that there are.

    Raises
    ------
    OutputError
        If matplotlib is missing, the format is unknown or the place cannot be written.
    """
    path = Path(path)
    # The name first: whoever mistypes it need not install anything to be told.
    if path.suffix.lower() not in suffixes:
        raise OutputError(f"cannot draw {path}: a figure's name must end in {', '.join(suffixes)}")
    require_matplotlib()
    return require_writable(path)


def check_moving_path(path: str | Path) -> Path:
    """The same of a figure that may be played."""
    return check_figure_path(path, MOVING)


def require_matplotlib() -> None:
    """Check that figures can be drawn.

    Raises
    ------
    OutputError
        If matplotlib is not installed.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise OutputError("figures need matplotlib: pip install 'springpot[figures]'") from error


@contextmanager
def blank(width: float = 7.2, height: float = 5.4) -> Iterator[Figure]:
    """An empty figure of a size in inches in the house style, without pyplot's global state."""
    require_matplotlib()
    from matplotlib import rc_context

    # Only while it is drawn: the style of a user's own figures stays as it is.
    with rc_context(STYLE):
        yield picture()(figsize=(width, height), layout="constrained")


def logarithmic(axes: Axes, direction: Literal["x", "y"]) -> None:
    """Scale one axis by decades, with numbers as people write them.

    0.1, 1, 10 rather than powers of ten.
    """
    from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation, LogLocator, NullFormatter

    axes.set(**{f"{direction}scale": "log"})
    axis = getattr(axes, f"{direction}axis")
    # An axis may run from right to left.
    low, high = sorted(map(abs, axis.get_view_interval()))
    if low > 0 and high < CANVAS.narrow * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    plain = CANVAS.plain[0] <= low and high <= CANVAS.plain[1]
    powers = LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(inf, inf))
    if plain:
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    else:
        axis.set_major_formatter(powers)
    # Otherwise an axis of less than a decade would be labelled twice.
    axis.set_minor_formatter(NullFormatter())


def finished(figure: Figure, path: str | Path | None) -> Figure | Path:
    """The figure itself, or where it was written if there is a path.

    What all functions ``figure_...`` end with.

    Parameters
    ----------
    figure : Figure
        Drawn in `blank`.
    path : str or Path or None
        Where to write; the suffix (.png, .svg, .pdf) chooses the format.

    Returns
    -------
    Figure or Path
        The figure, or where it was written.

    Raises
    ------
    OutputError
        If matplotlib is missing or the file cannot be written.
    """
    if path is None:
        return figure
    return save(figure, path)


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure in the format that the suffix names, whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    path = check_figure_path(path)
    kind = path.suffix.lower()[1:]
    # With a date in it the same figure would give other bytes each day.
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    return write_with(
        path, lambda file: figure.savefig(file, format=kind, dpi=160, metadata=undated)
    )


Rows = NDArray[np.int64]
Words = NDArray[np.str_]


class Drawing(NamedTuple):
    """Which of many curves are drawn, and what one is."""

    drawn: int
    """Sweeps drawn at most; of more, evenly many are chosen.

    More colours than this cannot be told apart.
    """
    varies: float
    """A frequency or amplitude varies if its largest value exceeds its smallest by this factor."""
    profile: float
    """Ranges that a condition travels at most if it changes along a sweep, not between sweeps."""
    bin: int
    """Points of a bin of a condition that was never held."""
    bins: int
    """Bins at most, however many points there are."""


SWEEPS = Drawing(drawn=12, varies=1.2, profile=3.0, bin=8, bins=40)


@dataclass(frozen=True, eq=False)
class DrawnSweep:
    """Rows measured under the same conditions, in order along the axis.

    Parameters
    ----------
    label : str
        The conditions.
    rows : ndarray of int
        Which rows.
    """

    label: str
    rows: Rows


def varies(name: str, column: Real) -> bool:
    """Whether a condition changes by more than a set value does while it is held."""
    low, high = float(np.min(column)), float(np.max(column))
    # Degrees have no zero of their own, so that their ratio means nothing.
    if name == "temperature":
        return high - low > VARIED.temperature_wanders
    return high > SWEEPS.varies * low


def travels(along: Real, column: Real) -> bool:
    """Whether `column` (n,) jumps to and fro along the axis, unlike within one sweep."""
    # Instruments leave cells empty: those without a value say nothing of a jump.
    known = np.isfinite(column)
    if not np.any(known):
        return False
    along, column = along[known], column[known]
    # Length of the way, over its range: one rise is 1, and a jump at each point as many as there
    # are points.
    way = float(np.sum(np.abs(np.diff(column[np.argsort(along, kind="stable")]))))
    _, place = np.unique(along, return_inverse=True)
    low, high = np.full(place.max() + 1, np.inf), np.full(place.max() + 1, -np.inf)
    np.minimum.at(low, place.ravel(), column)
    np.maximum.at(high, place.ravel(), column)
    whole = float(np.ptp(column))
    return way > SWEEPS.profile * whole or float(np.max(high - low)) > 0.5 * whole > 0.0


def all_sweeps(
    measurement: Measurement, column: str, along: Real, own: Collection[str] = ()
) -> list[DrawnSweep]:
    """Every sweep of a measurement, by repeat, temperature and amplitude in ascending order.

    Where a condition was not held but wandered, its points are taken together in levels or, if
    there are none, in bins of equally many points.

    Parameters
    ----------
    measurement : Measurement
        The data.
    column : str
        What the axis shows, which no sweep holds.
    along : ndarray, shape (n,)
        Where each point stands on it.
    own : collection of str
        Further columns that set sweeps apart, as levels do of which a model has parameters.
    """
    parts = [np.arange(len(measurement))]
    # Only what tells sweeps from one another is worth a word in their labels.
    telling: list[tuple[str, Real | Words]] = []
    further: list[tuple[str, Real | Words]] = []
    for name in sorted(set(own) - {"temperature", "amplitude"}):
        number, told = _further(measurement, name)
        parts = [one for part in parts for one in _alike(part, number[part])]
        further.append((name, told))
    if measurement.repeat is not None:
        again = [one for part in parts for one in _alike(part, measurement.repeat[part])]
        # Specimens are repeats already.
        if len(again) > len(parts):
            telling.append(("repeat", measurement.repeat.astype(float)))
        parts = again
    for name in ("temperature", "amplitude"):
        values = measurement.conditions.get(name)
        if values is None or name == column:
            continue
        finer: list[Rows] = []
        for part in parts:
            finer += _split(name, values, along, part)
        # What is the same for all sweeps tells none from another.
        if len(finer) > len(parts):
            telling.append((name, values))
        parts = finer
    telling += further
    ordered = [rows[np.argsort(along[rows], kind="stable")] for rows in parts]
    return [
        DrawnSweep(_label(rows, telling, measurement.units.amplitude), rows) for rows in ordered
    ]


def _further(measurement: Measurement, name: str) -> tuple[Rows, Real | Words]:
    """The level (n,) of each row of a further column, and the words or numbers that tell it."""
    if name in measurement.labels:
        label = measurement.labels[name]
        places = {word: i for i, word in enumerate(dict.fromkeys(label.tolist()))}
        return np.array([places[word] for word in label.tolist()]), label
    values = measurement.conditions[name]
    words = levels_in_words(measurement, name)
    told = values if words is None else np.array(words)[values.astype(int) - 1]
    return levels_of(name, values), told


def chosen(sweeps: list[DrawnSweep]) -> list[DrawnSweep]:
    """At most `SWEEPS.drawn` of the sweeps, evenly spread, the first and the last among them."""
    # Both ends among them: they show how much a condition changes.
    return [sweeps[i] for i in evenly(len(sweeps), SWEEPS.drawn)]


def _split(name: str, values: Real, along: Real, rows: Rows) -> list[Rows]:
    """Rows of each level of a condition; all of them where it is held or follows the axis."""
    here = values[rows]
    if not varies(name, here):
        return [rows]
    profile = not travels(along[rows], here)
    # A rig that cannot keep its amplitude lets it fall along the sweep; a temperature that changes
    # was set.
    if profile and name == "amplitude":
        return [rows]
    levels = held_levels(name, here)
    low, high = ranges(levels, here)
    wide = np.maximum(high - low, np.roll(high - low, -1))[:-1]
    # Neighbours that are each near the next may make a chain as wide as what lies between: then
    # those are a level that are the same.
    if len(low) == 1 or np.any(wide > low[1:] - high[:-1]):
        levels = numbers_of_levels(here, 0.0)
    # With fewer than two points in most levels there are none.
    if levels.max() < max(1, len(here) // 2):
        return _alike(rows, levels)
    if profile:
        return [rows]
    return _alike(rows, _bins(here))


def _alike(rows: Rows, numbers: NDArray[np.int64]) -> list[Rows]:
    """Rows (n,) of each number (n,) that some of them have."""
    return [rows[numbers == number] for number in np.unique(numbers)]


def _bins(values: Real) -> NDArray[np.int64]:
    """Number of the bin of each value, bins holding equally many."""
    count = int(np.clip(len(values) // SWEEPS.bin, 1, SWEEPS.bins))
    # By rank, so that bins hold equally many wherever the values crowd.
    rank = np.empty(len(values), dtype=np.int64)
    rank[np.argsort(values, kind="stable")] = np.arange(len(values))
    return rank * count // len(values)


def _label(rows: Rows, telling: list[tuple[str, Real | Words]], unit: str) -> str:
    """``20 °C, 0.5 mm``, or the range of a bin; ``all`` where nothing is told."""
    return ", ".join(_condition(name, values[rows], unit) for name, values in telling) or "all"


def _condition(name: str, values: Real | Words, unit: str) -> str:
    # Rows of one sweep have one word.
    if values.dtype.kind == "U":
        return f"{name} {values[0]}"
    numbers = values.astype(float)
    low, high = float(np.min(numbers)), float(np.max(numbers))
    mean = float(np.mean(numbers))
    if name == "temperature":
        mean = round(mean, 1)
    shown = f"{mean:.4g}"
    if name != "repeat" and varies(name, numbers):
        shown = f"{low:.3g} to {high:.3g}"
    if name == "temperature":
        return f"{shown} °C"
    if name == "amplitude" and unit != "-":
        return f"{shown} {unit}"
    # An amplitude without a unit is one of length over length.
    if name == "amplitude":
        return f"strain {shown}"
    return f"{name} {shown}"
