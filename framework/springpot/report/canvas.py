"""Blank figures in one style, and how they reach a file: the one place that sets matplotlib up.

A figure shows itself at the end of a notebook's cell, without pyplot's global state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from springpot.errors import OutputError
from springpot.files import require_writable, write_with

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
