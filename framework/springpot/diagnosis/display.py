"""How results show themselves in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from springpot.markup import Html, table, tag

Plain: TypeAlias = Mapping[str, Any]


SHOWN = 6
"""Candidates in a notebook's table."""
NOTES = 5
"""Notes below it, the most telling first; `print` tells all."""


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.3g} %"


def _floors(error: Plain) -> str:
    return f"noise floor {_percent(error['noise_floor'])}, material floor {_percent(error['material_floor'])}"


def html_of_diagnosis(answer: Plain) -> Html:
    """Verdict, error against both floors, where it fails, parameters, leading effects, what to do next, and notes.

    Parameters
    ----------
    answer : mapping
        Schema ``springpot.diagnosis/1``.
    """
    error = answer["error"]
    values = []
    for name, value in answer["parameters"].items():
        numbers = [f"{value[key]:.4g}" for key in ("value", "low", "high")]
        values.append((name, *numbers, value["unit"]))
    rows = []
    for c in answer["candidates"][:SHOWN]:
        errors = [_percent(c[name]) for name in ("predicted_error", "error_after")]
        alike = ", ".join(name for name in c["class"] if name != c["effect"])
        rows.append((c["effect"], f"{c['probability']:.3f}", *errors, c["verdict"], alike))
    headers = ("effect", "probability", "predicted error", "error after", "verdict", "cannot be told from")
    parts = [
        tag("p", tag("b", f"{answer['model']} of {answer['data']}: {answer['verdict']}")),
        tag("p", answer["says"]),
        tag("p", f"error {_percent(error['relative_rms'])}, {_floors(error)}"),
    ]
    if answer["split"]:
        parts.append(tag("p", answer["split"]))
    parts.append(tag("ul", *(tag("li", place["says"]) for place in answer["where"])))
    if values:
        parts.append(table(("parameter", "value", "from", "to", "unit"), values))
    if rows:
        parts.append(table(headers, rows))
    if answer["next_experiment"]:
        parts.append(tag("p", f"next experiment: {answer['next_experiment']['says']}"))
    if answer["notes"]:
        parts.append(tag("ul", *(tag("li", note) for note in answer["notes"][:NOTES])))
    return tag("div", *parts)


def html_of_ladder(answer: Plain) -> Html:
    """The steps with their errors, and the last verdict.

    Parameters
    ----------
    answer : mapping
        Schema ``springpot.discovery/1``.
    """
    rows = []
    for step in answer["steps"]:
        predicted = "-"
        if step["predicted_error"] is not None:
            predicted = _percent(step["predicted_error"])
        errors = [_percent(step[name]) for name in ("relative_rms", "noise_floor", "material_floor")]
        ratio = step["relative_rms"] / step["noise_floor"]
        rows.append((step["accepted"] or step["model"], predicted, *errors, f"{ratio:.3g}"))
    headers = ("accepted", "predicted error", "error", "noise floor", "material floor", "x floor")
    return tag(
        "div",
        tag("p", tag("b", f"{answer['data']}: {answer['verdict']}")),
        table(headers, rows),
        tag("p", answer["diagnosis"]["says"]),
    )
