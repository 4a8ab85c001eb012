"""Whole figures: a few views with one legend, written to a file.

With the spectrum of any material, and the two levels against which every error is drawn: what noise
leaves, and what any material leaves. Specimens as a population: their tables, and each of them
beside the mean.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from springpot.errors import OutputError
from springpot.identification.population import Population, specimens_of
from springpot.identification.regularisation import SmoothSpectrum
from springpot.identification.result import Identification
from springpot.identification.value import Value
from springpot.measurement.measurement import Measurement
from springpot.misfit.residuals_of_tests import SweepPart, parts_of_specimen
from springpot.numerics import rms
from springpot.report.text import LETTERS
from springpot.rheology.points import Real
from springpot.writing import NAMED, number

from . import views
from .canvas import CANVAS, COLOURS, INK, QUIET, blank, finished, logarithmic
from .text import Passage, Prose, TextTable, cut, percent, shown
from .views import DrawnFit, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


LABELLED = 40
"""Specimens whose names find room beside their marks."""


def population_passages(identified: Identification) -> list[Passage]:
    """Mean, scatter and limits of what specimens have for themselves; how batches differ."""
    populations = identified.populations
    if not populations:
        return []
    nested = any(population.groups for population in populations.values())
    last = ("within a batch", "between batches") if nested else ("between them", "95 % lie within")
    headers = (f"{len(specimens_of(populations))} specimens", "mean", "95 % interval", "unit")
    rows = []
    for name, population in populations.items():
        apart = [_scatter(population, population.between), _limits(population)]
        if nested:
            apart[1] = _scatter(population, population.groups)
        rows.append([name, *shown(population.mean), population.mean.unit, *apart])
    table = TextTable((*headers, *last), rows, frozenset({"mean"}))
    return [table, *_compared(populations.items())]


def _scatter(population: Population, between: Value | None) -> str:
    """Standard deviation between specimens with its interval, in per cent where it is a share."""
    if between is None:
        return "-"
    ends = [between.value, between.low, between.high]
    if population.relative:
        size, low, high = (percent(end, 2) for end in ends)
    else:
        size, low, high = (number(end, 2) for end in ends)
    return f"{size} [{low}, {high if isfinite(between.high) else 'open'}]"


def _limits(population: Population) -> str:
    if population.limits is None:
        return "-"
    low, high = (number(end, 3) for end in population.limits)
    return f"[{low}, {high}]"


def _compared(populations: Iterable[tuple[str, Population]]) -> Iterator[Passage]:
    """The batches that differ for certain, and how many pairs do not."""
    rows, alike = [], 0
    for name, population in populations:
        for (first, second), value in population.compared.items():
            if not population.told_apart(value):
                alike += 1
                continue
            ends = np.array([value.value, value.low, value.high])
            unit = value.unit
            if population.relative:
                ends, unit = 100.0 * (ends - 1.0), "%"
            size, low, high = (f"{'+' * (end > 0.0)}{number(end, 2)}" for end in ends.tolist())
            rows.append([name, f"{second} against {first}", f"{size} [{low}, {high}]", unit])
    if rows:
        yield TextTable(("parameter", "batches", "differ by", "unit"), rows)
    if alike:
        others = "others" if rows else "batches"
        yield Prose(f"{others}: {alike} comparisons in which none can be told from the other")


def draw_populations(panels: Sequence[Axes], identified: Identification) -> None:
    """A forest plot for each parameter: specimens with their intervals, mean and limits.

    Parameters
    ----------
    panels : sequence of Axes
        One for each parameter of the population.
    identified : Identification
        A fit with a population.
    """
    names = list(identified.populations)
    for i, (axes, name) in enumerate(zip(panels, names, strict=True)):
        _forest(axes, name, identified)
        if i:
            axes.tick_params(axis="y", labelleft=False)


def _forest(axes: Axes, name: str, identified: Identification) -> None:
    population = identified.populations[name]
    mean, drawn = population.mean, population.specimens
    own = identified.values_by_level(name)
    places = np.arange(len(drawn))
    if population.limits is not None:
        label = "95 % of specimens"
        axes.axvspan(*population.limits, color=QUIET, alpha=0.18, linewidth=0.0, label=label)
    axes.axvspan(mean.low, mean.high, color=COLOURS[0], alpha=0.25, linewidth=0.0)
    axes.axvline(mean.value, color=COLOURS[0], label="mean, 95 %")
    # The interval of one that the data leave open runs over the whole panel.
    low, high = (np.array([getattr(value, end) for value in own]) for end in ("low", "high"))
    axes.hlines(places, low, high, color=COLOURS[1], linewidth=1.2)
    values = [value.value for value in own]
    axes.plot(values, places, "o", color=COLOURS[1], markersize=3.5, label="by itself, 95 %")
    shrunken = list(drawn.values())
    axes.plot(shrunken, places, "|", color="black", markersize=6.0, label="drawn to the mean")
    ends = np.array([*values, *shrunken, mean.low, mean.high, *(population.limits or ())])
    if ends.min() > 0.0 and ends.max() > CANVAS.tenfold * ends.min():
        logarithmic(axes, "x")
    axes.set_ylim(len(drawn) - 0.4, -0.6)
    axes.set_yticks([])
    if len(drawn) <= LABELLED:
        axes.set_yticks(places, [cut(str(each), LETTERS.specimen) for each in drawn])
    axes.grid(False, axis="y")
    axes.set_xlabel(f"{name} [{mean.unit}]")


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
    # Where no material was looked for a legend would name a line that is not there.
    if np.any(np.isfinite(material)):
        axes.hlines(material, ends[:-1], ends[1:], label="material floor", zorder=2.5, **DASHES)
    axes.set_xlim(edges[0], edges[-1])


class Legend(NamedTuple):
    """Inches that an entry of a legend takes."""

    mark: float
    """Inches for one entry of a legend, at least."""
    line: float
    letter: float
    """Inches for the line and for each letter of an entry."""


LEGEND = Legend(mark=1.75, line=0.6, letter=0.075)


def figure_identification(
    measurement: Measurement,
    fits: Sequence[DrawnFit],
    path: str | Path | None = None,
    beside: str = "",
) -> Figure | Path:
    """Storage and loss with the models' curves, and the residuals below.

    Parameters
    ----------
    measurement : Measurement
        The data.
    fits : sequence of DrawnFit
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


COLUMN = 84.0 / 25.4
"""Width in inches of a column of a journal, 84 mm."""
VIEWS: dict[str, Callable[[Axes, Scene], None]] = {
    "storage-loss": views.storage_and_loss,
    "loss-factor": views.loss_factor,
    "cole-cole": views.cole_cole,
    "black": views.black,
    "van-gurp-palmen": views.van_gurp_palmen,
    "residual": views.residual,
}


def scene_of(part: SweepPart, fits: Sequence[Identification]) -> Scene:
    """A sweep among tests of a specimen, its noise and what each fit has of it."""
    drawn = []
    for fit in fits:
        own, places = fit.model.had_by(part.test)
        drawn.append(DrawnFit(own, fit.theta[places], fit.model.name))
    return Scene(replace(part.view, reference=fits[0].reference), drawn)


def draw_one_view(axes: Axes, identified: Identification, view: str) -> None:
    """One of `VIEWS` of the fit of a sweep, with what the marks mean.

    Raises
    ------
    OutputError
        If it was fitted to tests of which not one alone is a sweep.
    """
    if identified.sweep is None:
        parts = parts_of_specimen(identified.data)
        sweeps = [part for part in parts if isinstance(part, SweepPart)]
        if len(sweeps) != 1:
            raise OutputError(f"a view is of one sweep, and among these tests are {len(sweeps)}")
        scene = scene_of(sweeps[0], [identified])
    else:
        scene = Scene(identified.measurement, [DrawnFit(identified.model, identified.theta)])
    VIEWS[view](axes, scene)
    # Where one is drawn over the other there is but one kind of mark.
    marks = marks_of(scene) if VIEWS[view] in (views.storage_and_loss, views.residual) else []
    if handles := [*marks, *(sweep_marks(scene) if scene.by_sweep else [])]:
        axes.legend(handles=handles, fontsize="x-small")


def figure_view(
    identified: Identification, view: str, path: str | Path | None = None
) -> Figure | Path:
    """One view of a fit as wide as a journal's column, without a headline, which a caption has.

    Parameters
    ----------
    identified : Identification
        The fit of a sweep.
    view : str
        One of `VIEWS`.
    path : str or Path, optional
        Where to write; see `springpot.report.canvas.finished`.
    """
    with blank(COLUMN, 0.78 * COLUMN) as figure:
        draw_one_view(figure.subplots(), identified, view)
        return finished(figure, path)


def _headline(scene: Scene, beside: str, error: float | None) -> str:
    """What is shown, and how well the model fits."""
    data = scene.measurement
    drawn = ""
    if scene.drawn:
        drawn = f"; {scene.drawn}"
    # Data alone have no error to tell.
    if not scene.fits:
        return f"{cut(data.name, LETTERS.title)}{drawn}"
    # Of several models each has its error in the table, and its name in the legend.
    if len(scene.fits) > 1:
        return f"{cut(data.name, LETTERS.title)}\npoints measured, lines fitted{drawn}"
    fit = scene.fits[0]
    if error is None:
        # Of all points, those among them that are too many to be drawn.
        error = rms(np.abs(fit.at(data.points) - data.stiffness) / data.magnitude)
    fitted = cut(f"{fit.name} fitted to {data.name}", LETTERS.title)
    # On a line of its own: together they are wider than the figure.
    beside = beside.replace(", ", "\n", 1)
    return (
        f"{fitted}\npoints measured, lines fitted; error {percent(error)} of"
        f" {data.units.magnitude}{drawn}{beside}"
    )


def headed(
    figure: Figure,
    scene: Scene,
    below: Scene | None = None,
    floors: bool = False,
    beside: str = "",
    error: float | None = None,
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
    error : float, optional
        That error, where the points of the scene are means; by default it is that of these points.
    """
    marks = marks_of(scene)
    if floors:
        marks.append(_mark("± material floor", **DASHES))
    # A legend's own title is the one headline that the layout keeps clear of the legend.
    above = figure.legend(
        handles=marks,
        title=literal(_headline(scene, beside, error)),
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
        LEGEND.mark, *(LEGEND.line + LEGEND.letter * len(str(mark.get_label())) for mark in marks)
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


DECADES = 4.0
"""Decades of H below its peak that a logarithmic axis shows: what is smaller is as good as nothing.
"""


def figure_material(identified: Identification, path: str | Path | None = None) -> Figure | Path:
    """Data and fit, the residuals, and the regularised spectrum with its band below.

    Parameters
    ----------
    identified : Identification
        Of a model whose spectrum the data choose.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    scene = Scene(identified.measurement, [DrawnFit(identified.model, identified.theta)])
    with blank(7.2, 8.6) as figure:
        above, middle, below = figure.subplots(3, 1, height_ratios=(3, 1.4, 2.6))
        views.storage_and_loss(above, scene)
        views.residual(middle, scene)
        # The rates of the spectrum are no frequencies of the test: only these two share an axis.
        middle.sharex(above)
        above.set_xlabel("")
        if identified.spectrum is not None:
            draw_spectrum(below, identified.spectrum, identified.measurement.units.stiffness)
        headed(figure, scene, beside=beside_floors(identified))
        return finished(figure, path)


def figure_population(identified: Identification, path: str | Path | None = None) -> Figure | Path:
    """Data and fit with the residuals, and each specimen beside the mean of all.

    Parameters as in `figure_material`.
    """
    scene = Scene(identified.measurement, [DrawnFit(identified.model, identified.theta)])
    count = len(identified.populations)
    with blank(min(6.4 + 2.4 * count, 16.0), 6.4) as figure:
        grid = figure.add_gridspec(
            2, 1 + count, width_ratios=(2.4, *[1.0] * count), height_ratios=(3, 1.4)
        )
        above = figure.add_subplot(grid[0, 0])
        below = figure.add_subplot(grid[1, 0], sharex=above)
        views.storage_and_loss(above, scene)
        views.residual(below, scene)
        above.set_xlabel("")
        panels = [figure.add_subplot(grid[:, 1 + i]) for i in range(count)]
        draw_populations(panels, identified)
        headed(figure, scene, beside=beside_floors(identified))
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower right", ncols=4)
        return finished(figure, path)


def draw_spectrum(axes: Axes, spectrum: SmoothSpectrum, unit: str) -> None:
    """H(r) with its band; grey where no frequency was measured."""
    rates, density = spectrum.rates, spectrum.density
    axes.fill_between(
        rates,
        spectrum.low,
        spectrum.high,
        color=COLOURS[0],
        alpha=0.25,
        linewidth=0.0,
        label="95 % of noise",
    )
    axes.plot(rates, density, color=COLOURS[0], label="smoothest H that the data allow")
    for start, stop, label in (
        (rates[0], spectrum.seen[0], "not measured"),
        (spectrum.seen[1], rates[-1], None),
    ):
        axes.axvspan(start, stop, color=QUIET, alpha=0.18, linewidth=0.0, label=label, zorder=0.5)
    axes.set_xlim(rates[0], rates[-1])
    logarithmic(axes, "x")
    # What lies beyond the measured frequencies is the smoothest guess, and must not set the axis.
    inside = density[(rates >= spectrum.seen[0]) & (rates <= spectrum.seen[1])]
    top = float(spectrum.high.max())
    if len(inside) and inside.max() > CANVAS.tenfold * inside.min():
        axes.set_ylim(max(0.3 * float(inside.min()), top * 10.0**-DECADES), 3.0 * top)
        logarithmic(axes, "y")
    else:
        axes.set_ylim(0.0, 1.25 * top)
    axes.set(xlabel="rate r [rad/s]", ylabel=f"H(r) [{unit}]")
    axes.legend(loc="best")


def in_words(spectrum: SmoothSpectrum, unit: str) -> str:
    """Where the relaxing stiffness lies, and the peaks of H that the data bear out."""
    total = float(np.sum(spectrum.density)) * spectrum.step
    if not total > 0.0:
        return "nothing relaxes: a spring beside a dashpot"
    low, high = (number(end, 2) for end in spectrum.within(0.5))
    half = f"half of the relaxing {number(total, 3)} {unit} at rates from {low} to {high} rad/s"
    # Two digits: no peak of such a spectrum is known better.
    shown = [f"{number(spectrum.rates[i], 2)}" for i in spectrum.peaks[:NAMED]]
    if not shown:
        return f"{half}; no peak within what was measured"
    word = "the peak"
    if len(shown) > 1:
        word = f"{len(spectrum.peaks)} peaks, the highest first,"
    height = number(float(spectrum.density[spectrum.peaks[0]]), 2)
    return f"{half}; {word} of H at {', '.join(shown)} rad/s, {height} {unit} high"
