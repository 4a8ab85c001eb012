"""How results show themselves in a notebook, and the slot for what draws them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.errors import OutputError
from springpot.markup import Html, joined, table, tag

if TYPE_CHECKING:
    from .compare import Comparison
    from .ladder import Ladder
    from .result import Diagnosis, Error

Drawing = Callable[[Any, "str | Path | None"], Any]
SHOWN = 6
"""Candidates in a notebook's table."""

_drawings: dict[str, Drawing] = {}


def use_drawing(kind: str, drawing: Drawing) -> None:
    """Let `drawing` draw results of one kind: figures are made above this room, which therefore hands itself up."""
    _drawings[kind] = drawing


def draw(kind: str, result: object, path: str | Path | None) -> Any:
    """Draw a result, on a figure that is returned or into a file.

    Raises
    ------
    OutputError
        If nothing that draws it has been loaded.
    """
    if kind not in _drawings:
        raise OutputError(f"nothing is loaded that draws a {kind}: import springpot.api first")
    return _drawings[kind](result, path)


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.3g} %"


def _floors(error: Error) -> str:
    return f"noise floor {_percent(error.noise_floor)}, material floor {_percent(error.material_floor)}"


def html_of_diagnosis(diagnosis: Diagnosis) -> Html:
    """Verdict, error against both floors, where the model fails and the leading effects."""
    error = diagnosis.error
    rows = [
        (c.effect, f"{c.probability:.3f}", _percent(c.predicted_error), _percent(c.error_after), c.verdict)
        for c in diagnosis.candidates[:SHOWN]
    ]
    headers = ("effect", "probability", "predicted error", "error after", "verdict")
    return tag(
        "div",
        tag("p", tag("b", f"{diagnosis.model.name} of {diagnosis.data}: {diagnosis.verdict}")),
        tag("p", diagnosis.says),
        tag("p", f"error {_percent(error.relative_rms)}, {_floors(error)}"),
        tag("p", diagnosis.split) if diagnosis.split else joined(()),
        tag("ul", *(tag("li", where.says) for where in diagnosis.where)),
        table(headers, rows) if rows else joined(()),
    )


def html_of_ladder(ladder: Ladder) -> Html:
    """The steps with their errors, and the last verdict."""
    rows = [
        (
            step.accepted or step.model.name,
            "-" if step.predicted_error is None else _percent(step.predicted_error),
            _percent(step.relative_rms),
            _percent(step.noise_floor),
            _percent(step.material_floor),
            f"{step.relative_rms / step.noise_floor:.3g}",
        )
        for step in ladder.steps
    ]
    headers = ("accepted", "predicted error", "error", "noise floor", "material floor", "x floor")
    return tag(
        "div",
        tag("p", tag("b", f"{ladder.data}: {ladder.verdict}")),
        table(headers, rows),
        tag("p", ladder.diagnosis.says),
    )


def html_of_comparison(comparison: Comparison) -> Html:
    """Errors against the floor that the models share, and where each of them fails."""
    best = comparison.best
    rows = [
        (
            judged.model.name + (" (best)" if judged is best and len(comparison.shown) > 1 else ""),
            _percent(judged.error.relative_rms),
            _percent(judged.error.noise_floor),
            _percent(judged.error.material_floor),
            f"{judged.error.relative_rms / judged.error.noise_floor:.3g}",
            f"{judged.delta_bic:.3g}",
            "fails" if judged.fails else "holds",
        )
        for judged in comparison.shown
    ]
    told = [f"{judged.model.name}: {judged.says}" for judged in comparison.shown]
    told += [finding.says for finding in comparison.harmonics if finding.found]
    headers = ("model", "error", "noise floor", "material floor", "x floor", "delta BIC", "verdict")
    return tag(
        "div",
        tag("p", tag("b", f"models of {comparison.data}")),
        tag("p", comparison.says) if comparison.says else joined(()),
        table(headers, rows),
        tag("ul", *(tag("li", sentence) for sentence in (*told, *comparison.notes))),
    )
