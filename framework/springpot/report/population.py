"""Specimens as a population: their tables, and each of them beside the mean as a picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from springpot.identification.population import Population, specimens_of
from springpot.identification.result import Identification
from springpot.identification.value import Value
from springpot.writing import number

from .canvas import COLOURS, QUIET, TENFOLD, logarithmic
from .text import Passage, Prose, TextTable, cut, percent, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAMED = 40
"""Specimens whose names find room beside their marks."""
NAME_WIDTH = 18
"""Characters of such a name before it is cut."""


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
    if ends.min() > 0.0 and ends.max() > TENFOLD * ends.min():
        logarithmic(axes, "x")
    axes.set_ylim(len(drawn) - 0.4, -0.6)
    axes.set_yticks([])
    if len(drawn) <= NAMED:
        axes.set_yticks(places, [cut(str(each), NAME_WIDTH) for each in drawn])
    axes.grid(False, axis="y")
    axes.set_xlabel(f"{name} [{mean.unit}]")
