"""A law that was found, for people: as text, and as a picture of data, model and law."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from springpot.invention.result import FoundLaw, Invention
from springpot.measurement.measurement import Measurement
from springpot.misfit.error import over_floor
from springpot.report.text import LETTERS
from springpot.rheology.effect import Effect
from springpot.rheology.points import Complex, Real

from .answers import probability
from .canvas import COLOURS, blank, finished, logarithmic
from .figures import marks_of
from .text import Listing, Passage, Prose, TextTable, percent
from .views import DrawnFit, Scene, storage_and_loss

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PHYSICS = {
    (True, True): "causal, passive",
    (True, False): "causal, not passive",
    (True, None): "causal",
}


def invention_document(found: Invention, verbose: bool = False) -> list[Passage]:
    """The verdict, the class of laws, what they are like, and what to measure next."""
    error = found.error
    floors = f"noise floor {percent(error.noise_floor)} ({error.noise_source}),"
    floors += f" material floor {percent(error.material_floor)}"
    parts: list[Passage] = [
        Prose(
            f"law beside {found.model.name} of {found.data}, {found.tried} laws tried",
            f"verdict     {found.verdict}: {found.says}",
            f"error       {percent(error.relative_rms)},"
            f" {over_floor(error.relative_rms, error.noise_floor)} x the noise floor; {floors}",
        )
    ]
    if found.laws:
        heading = "law" if found.verdict != "none" else "nearest law"
        rows = [_row(law) for law in found.laws]
        headers = [heading, "probability", "error after", "is", "like"]
        parts.append(TextTable(headers, rows, frozenset(headers[1:3]), ("is", "like")))
        first = found.laws[0]
        values = [f"{name} = {value}" for name, value in first.parameters.items()]
        parts += [Listing(values, f"parameters of {first.text}", "  "), Prose(first.says)]
    if found.next_experiment is not None:
        parts.append(Prose(f"next experiment: {found.next_experiment.says}"))
    return [*parts, Listing(found.notes, mark="note: ")]


def _row(law: FoundLaw) -> list[str]:
    kind = PHYSICS.get((law.causal, law.passive), "not causal")
    return [
        law.text,
        probability(law.probability),
        percent(law.error_after),
        kind,
        ", ".join(law.like),
    ]


def figure_invention(found: Invention, path: str | Path | None = None) -> Figure | Path:
    """Data beside the model and the likeliest law, and what that law is in its plane.

    Parameters
    ----------
    found : Invention
        What to draw; one of a file has no data.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    with blank(10.4, 4.4) as figure:
        left, right = figure.subplots(1, 2)
        draw_fits(found, left)
        _draw_law(found, right)
        return finished(figure, path)


def draw_fits(found: Invention, axes: Axes) -> None:
    """Storage and loss of the data, of the model, and of the model with the law."""
    base = found.search.base
    fits = [DrawnFit(base.model, base.theta, found.model.name)]
    for law in found.ranked[:1]:
        best = law.grown.refit
        fits.append(DrawnFit(best.model, best.theta, "with the law"))
    scene = Scene(base.data.raw, fits)
    storage_and_loss(axes, scene)
    axes.legend(handles=marks_of(scene), fontsize=8)
    axes.set_title(f"{percent(found.error.relative_rms)} without a law")


def _draw_law(found: Invention, axes: Axes) -> None:
    """What is left of the data when the material is undone, and the law through it."""
    if not found.ranked:
        axes.set_axis_off()
        return
    law, ranked = found.laws[0], found.ranked[0]
    best = ranked.grown.refit
    alone = best.model - ranked.effect.name
    theta = alone.picked(best.model.named(best.theta))
    bare = alone.stiffness(theta, best.fit.measurement.points)
    data, whole = best.fit.measurement.stiffness, best.stiffness

    def undo(k: Complex) -> Complex:
        if law.plane == "parallel":
            return k - bare
        if law.plane == "series":
            return 1.0 / k - 1.0 / bare
        return k / bare

    column, label = _along(best.fit.measurement, ranked.effect)
    order = np.argsort(column, kind="stable")
    for part, colour, name in ((np.real, COLOURS[0], "real"), (np.imag, COLOURS[1], "imaginary")):
        axes.plot(column, part(undo(data)), "o", color=colour, label=f"data, {name} part")
        axes.plot(column[order], part(undo(whole))[order], ".", color="black", markersize=2)
    if np.all(column > 0.0) and column.max() > 3.0 * column.min():
        logarithmic(axes, "x")
    axes.set_xlabel(label)
    axes.set_ylabel(_of_plane(law.plane, best.fit.measurement.units.stiffness))
    axes.set_title("\n".join(wrap(f"{law.text} (dots)", LETTERS.formula)), fontsize=9)
    axes.legend()


def _of_plane(plane: str, stiffness: str) -> str:
    """What is left of the data in the plane of a law."""
    if plane == "parallel":
        return f"added stiffness [{stiffness}]"
    if plane == "series":
        inverse = f"1/({stiffness})" if "/" in stiffness else f"1/{stiffness}"
        return f"added compliance [{inverse}]"
    return "factor of the stiffness"


def _along(data: Measurement, law: Effect) -> tuple[Real, str]:
    """The column that a law goes with: a condition before the frequency."""
    for name in sorted(law.needs & set(data.conditions)):
        unit = f" [{data.units.amplitude}]" if name == "amplitude" else ""
        return data.conditions[name], f"{name}{unit}"
    return data.frequency, "frequency [Hz]"
