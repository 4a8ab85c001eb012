"""A master curve for people: as text, and as a picture of curve, factors and what is left."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.identification.value import noun
from springpot.rheology.levels import level_text
from springpot.rheology.points import KELVIN, Points, Real
from springpot.superposition.curve import MasterCurve
from springpot.superposition.laws import LawFit
from springpot.writing import LISTED, number

from ..numerics import ALIKE
from ..thresholds import SUPERPOSITION
from .canvas import CANVAS, COLOURS, INK, QUIET, blank, finished, logarithmic
from .text import Listing, Passage, Prose, TextTable, percent, seconds, with_interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WORDS = {
    "simple": "one curve holds: nothing is left but noise",
    "nearly-simple": (
        "one curve nearly holds: it adds {added} to the error, which is little but no noise"
    ),
    "beside": (
        "one curve nearly holds: it adds {added} to the error, which is no noise, beside {alone}"
        " that the levels leave by themselves"
    ),
    "not-simple": "one curve does not hold: it adds {added} to the error",
    "not-judged": "no level has points enough to judge whether one curve holds",
}
REDUCED = {"Hz": "a f [Hz]", "rad/s": "a ω [rad/s]"}
EXACT = "exact by construction"
"""How far a law with as many constants as factors is off."""


def mastercurve_document(master: MasterCurve) -> list[Passage]:
    """Factors level by level, laws, and whether one curve is enough.

    Told as a_T and b_T where temperature shifts.
    """
    rest = master.simplicity
    reference = level_text(master.factors.column, master.reference)
    places = [failure.says for failure in rest.failures[:LISTED]]
    if len(rest.failures) > LISTED:
        places.append(f"and {len(rest.failures) - LISTED} places more, see --json")
    laws: Passage = Prose()
    if master.laws:
        laws = _laws(master)
    words = WORDS[rest.verdict]
    # Little is said of an error itself, not of what it is beside a larger one.
    if rest.verdict == "nearly-simple" and rest.added > SUPERPOSITION.added:
        words = WORDS["beside"]
    holds = words.format(added=percent(rest.added, 2), alone=percent(rest.alone, 2))
    return [
        Prose(
            f"master curve of {master.data.name} at {reference}, {len(master.data)} points,"
            f" {seconds(master.seconds)}",
            f"error       {percent(rest.error)} of"
            f" {master.data.units.magnitude}{_other_errors(master)}",
        ),
        _levels(master),
        laws,
        Listing(
            places,
            f"superposition   {holds}",
            "  - ",
        ),
        Listing(master.notes, mark="note: "),
    ]


def _factor(master: MasterCurve, letter: str) -> str:
    """``a_T``, as the field writes it; ``a`` along other columns."""
    if master.factors.column == "temperature":
        return f"{letter}_T"
    return letter


def _other_errors(master: MasterCurve) -> str:
    text = ""
    if master.vertical:
        text = f"; a shift alone {percent(master.error_without_vertical)}"
    if np.isfinite(master.simplicity.alone):
        text += f"; each level by itself {percent(master.simplicity.alone)}"
    return text


def _levels(master: MasterCurve) -> TextTable:
    a_name, b_name = _factor(master, "a"), _factor(master, "b")
    headers = [
        f"{master.factors.column}{_in_unit(master.unit)}",
        a_name,
        "95 %",
        b_name,
        "95 %",
        "determined",
        "error",
        "alone",
    ]
    rows = []
    for level in master.levels:
        a, a_between = with_interval(level.a, level.a_low, level.a_high)
        b, b_between = with_interval(level.b, level.b_low, level.b_high)
        # Factors at the reference are one by definition: an interval would look like a measurement.
        if level.value == master.reference:
            a, a_between, b, b_between = "1", "reference", "1", ""
        name = level_text(master.factors.column, level.value).removesuffix(" degC")
        name = name.removeprefix(f"{master.factors.column} ")
        why = "no: " + level.reason
        if level.determined:
            why = "yes"
        rows.append(
            [
                name,
                a,
                a_between,
                b,
                b_between,
                why,
                percent(level.error, 2),
                percent(level.alone, 2),
            ]
        )
    # Otherwise all of them would be one.
    if not master.vertical:
        headers = [*headers[:3], *headers[5:]]
        rows = [[*row[:3], *row[5:]] for row in rows]
    if np.all(master.determined):
        at = headers.index("determined")
        headers = [*headers[:at], *headers[at + 1 :]]
        rows = [[*row[:at], *row[at + 1 :]] for row in rows]
    return TextTable(
        headers, rows, frozenset({headers[0], a_name, b_name, "error", "alone"}), ("alone",)
    )


def _in_unit(unit: str) -> str:
    if not unit:
        return ""
    return f" [{unit}]"


def _laws(master: MasterCurve) -> TextTable:
    headers = ["law", "of", "parameters", "off by", "most at", "chance", "verdict"]
    rows = []
    for law in master.laws:
        parameters = zip(law.law.element.parameters, law.values, law.low, law.high, strict=True)
        words = []
        for parameter, value, low, high in parameters:
            middle, between = with_interval(float(value), float(low), float(high))
            words.append(f"{parameter.name} {middle} {between} {parameter.unit.label}".rstrip())
        # Where a law fails most says at which temperature not to trust it.
        most = level_text(master.factors.column, law.worst)
        # A departure is a difference of logarithms.
        off = percent(float(np.expm1(law.departure)), 2)
        if law.departure < ALIKE:
            # Of factors of one, rounding is left.
            off, most = percent(0.0), "-"
        if law.verdict == "cannot-tell":
            # As many constants as factors: what is left is rounding, and no quality of the law.
            off, most = EXACT, "-"
        factor = _factor(master, "a")
        if law.law.vertical:
            factor = _factor(master, "b")
        rows.append(
            [law.law.name, factor, ", ".join(words), off, most, number(law.chance, 2), law.verdict]
        )
    return TextTable(
        headers, rows, frozenset({"off by", "chance"}), ("chance", "most at", "off by")
    )


def figure_mastercurve(master: MasterCurve, path: str | Path | None = None) -> Figure | Path:
    """Curve, factors with the laws, and errors of each level.

    Parameters
    ----------
    master : MasterCurve
        The curve.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    with blank(9.6, 7.6) as figure:
        # Two rows of their own layout: the curve needs more room than factors and errors.
        halves: Any = figure.subfigures(2, 1, height_ratios=[1.25, 1.0])
        _draw_curve(halves[0], master)
        if master.vertical:
            places = halves[1].subplots(1, 3)
            _draw_factors(places[1], master, vertical=True)
        else:
            places = halves[1].subplots(1, 2)
        _draw_factors(places[0], master, vertical=False)
        _draw_errors(places[-1], master)
        return finished(figure, path)


def _colours(master: MasterCurve) -> tuple[Any, Any]:
    from matplotlib import colormaps
    from matplotlib.colors import Normalize

    levels = master.factors.levels
    # Cold is blue and hot is red; the pale middle of a diverging map would vanish on paper.
    return colormaps["turbo"], Normalize(float(levels.min()), float(levels.max()))


def _draw_curve(figure: Any, master: MasterCurve) -> None:
    from matplotlib.cm import ScalarMappable

    clock, *names = master.columns
    reduced_clock, units = "t / a [s]", master.data.units
    if clock == "omega":
        reduced_clock, names = REDUCED[units.clock], list(units.parts)
    planes = figure.subplots(1, len(names), sharex=True, squeeze=False)[0]
    left = planes[0]
    data, levels = master.reduced, master.factors.levels
    measured = master.data.conditions[master.factors.column]
    colour, norm = _colours(master)
    omega: Real = np.geomspace(float(data.omega.min()), float(data.omega.max()), CANVAS.smooth)
    x, *lines = master.drawn(omega, master.curve(omega))
    places, *measured_at = master.drawn(data.omega, data.stiffness)
    if clock == "omega":
        x, places = (units.on_clock(rate / (2.0 * np.pi)) for rate in (x, places))
    unit = master.measured_unit
    for axes, points, line, name in zip(planes, measured_at, lines, names, strict=True):
        # On a logarithmic axis nothing else has a place.
        shown, drawn = points > 0, np.where(line > 0, line, np.nan)
        axes.plot(x, drawn, "-", color=INK, linewidth=1.0, zorder=2, label="any material")
        axes.scatter(
            places[shown],
            points[shown],
            s=13,
            c=colour(norm(measured[shown])),
            zorder=3,
            linewidths=0,
        )
        for direction in ("x", "y"):
            logarithmic(axes, direction)
        reduced = f"{name} / b"
        if name == "compliance":
            reduced = f"b {name}"
        axes.set_ylabel(f"{reduced} [{unit}]")
        axes.set_xlabel(reduced_clock)
    named = level_text(master.factors.column, master.reference)
    off = percent(master.simplicity.error, 2)
    verdict = master.simplicity.verdict.replace("-", " ")
    # Over both planes, as a file's name may be longer than one is wide.
    title = f"{master.data.name} at {named}: {off} off, {verdict}"
    left.set_title(title.replace("$", r"\$"))
    bar = figure.colorbar(ScalarMappable(norm, colour), ax=list(planes), pad=0.01, aspect=30)
    bar.set_label(f"{master.factors.column}{_in_unit(master.unit)}")
    # Each level by its number, as long as the numbers do not touch.
    if len(levels) <= LISTED:
        bar.set_ticks(levels.tolist(), labels=[f"{value:.4g}" for value in levels])
    bar.outline.set_visible(False)
    left.legend(loc="best")


def _draw_factors(axes: Axes, master: MasterCurve, vertical: bool) -> None:
    levels = master.levels
    x = master.factors.levels
    name = "a"
    if vertical:
        name = "b"
    value = np.array([getattr(level, name) for level in levels])
    low = np.array([getattr(level, f"{name}_low") for level in levels])
    high = np.array([getattr(level, f"{name}_high") for level in levels])
    known = master.determined
    _draw_laws(axes, master, vertical)
    # matplotlib refuses a bar of negative length, such as rounding may make.
    bars = np.maximum(np.array([value - low, high - value]), 0.0)
    axes.errorbar(
        x[known],
        value[known],
        bars[:, known],
        fmt="o",
        color=INK,
        markersize=4.0,
        linewidth=1.0,
        capsize=2.0,
    )
    if not np.all(known):
        # Their intervals run to the end of the search and off the picture, which the factors
        # themselves set.
        axes.errorbar(
            x[~known],
            value[~known],
            bars[:, ~known],
            fmt="x",
            color=QUIET,
            linewidth=0.8,
            label="not determined",
        )
        if not vertical:
            axes.set_ylim(value.min() / CANVAS.tenfold, value.max() * CANVAS.tenfold)
    if value.max() > CANVAS.tenfold * value.min():
        logarithmic(axes, "y")
    axes.set_xlabel(f"{master.factors.column}{_in_unit(master.unit)}")
    title = "factors a of frequency"
    if vertical:
        title = f"factors b of {noun(master.data.units)}"
    axes.set_title(title)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best")


def _draw_laws(axes: Axes, master: MasterCurve, vertical: bool) -> None:
    """The laws of these factors as lines."""
    # WLF and VFT are one curve in other parameters: drawn once.
    labels = {"WLF": "WLF = VFT"}
    laws = [law for law in master.laws if law.law.vertical == vertical and law.law.name != "VFT"]
    # Only between the levels: beyond them a law would be a claim without data.
    fine = np.linspace(master.factors.levels.min(), master.factors.levels.max(), CANVAS.smooth)
    for law, colour in zip(laws, COLOURS, strict=False):
        label, drawn = labels.get(law.law.name, law.law.name), np.exp(_along(law, fine, master))
        axes.plot(fine, drawn, "-", color=colour, linewidth=1.2, label=label, zorder=2)


def _along(law: LawFit, celsius: Real, master: MasterCurve) -> Real:
    """A law's logarithm of the factor between the levels."""
    reference = master.reference + KELVIN
    at = Points(
        np.zeros(len(celsius)), temperature=celsius + KELVIN, reference_temperature=reference
    )
    value = law.law.element.respond(law.values, at).value.real
    # A law of a shift gives ln a itself, one of a stiffness b.
    if law.law.vertical:
        value = np.log(value)
    return np.asarray(value, dtype=np.float64)


def _draw_errors(axes: Axes, master: MasterCurve) -> None:
    x = master.factors.levels
    levels = master.levels
    axes.plot(
        x, [100 * level.error for level in levels], "o-", color=COLOURS[0], label="on the curve"
    )
    axes.plot(
        x,
        [100 * level.alone for level in levels],
        "s--",
        color=QUIET,
        label="each by itself",
        linewidth=1.0,
    )
    # A level with too few points has no error of its own, and is left out.
    if max(level.error for level in levels) > CANVAS.tenfold * np.nanmin(
        [level.alone for level in levels]
    ):
        logarithmic(axes, "y")
    else:
        axes.set_ylim(bottom=0.0)
    axes.set_xlabel(f"{master.factors.column}{_in_unit(master.unit)}")
    axes.set_title("error [%]")
    axes.legend(loc="best")
