"""What results show in a notebook: verdicts, errors beside the floors, and a table."""

from __future__ import annotations

from collections.abc import Mapping
from functools import singledispatch
from typing import Any

from springpot.comparison.comparing import Comparison
from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Diagnosis
from springpot.format_numbers import number
from springpot.identification.part_result import in_time
from springpot.markup import Html, html, table, tag
from springpot.misfit.words import over_floor, percent

from .answers import probability, worth_showing

SHOWN = 6
"""Candidates in a notebook's table."""
NOTES = 5
"""Notes below it, the most telling first; `print` tells all."""


@singledispatch
def shown(result: object) -> Html:
    """A result as HTML; of anything else its short form."""
    # `html` escapes it: a repr begins with <, and would be taken for an element.
    return html(repr(result))


@shown.register
def _of_diagnosis(diagnosis: Diagnosis) -> Html:
    """Verdict, error and both floors, failures, parameters, leading effects, next step, notes."""
    if in_time(diagnosis.tests):
        return tag("pre", str(diagnosis))
    # From the same dictionary as the JSON, so that the two cannot say different things.
    answer = diagnosis.to_dict()
    error = answer["error"]
    values = []
    for name, value in diagnosis.parameters.items():
        numbers = [f"{each:.4g}" for each in (value.value, value.low, value.high)]
        values.append((name, *numbers, value.unit))
    rows = []
    for row in worth_showing(diagnosis, SHOWN):
        errors = [percent(value) for value in (row.predicted_error, row.error_after)]
        alike = ", ".join(name for name in row.alike if name != row.effect)
        rows.append((row.effect, probability(row.probability), *errors, row.verdict, alike))
    headers = (
        "effect",
        "probability",
        "predicted error",
        "error after",
        "verdict",
        "cannot be told from",
    )
    parts = [
        tag("p", tag("b", f"{answer['model']} of {answer['data']}: {answer['verdict']}")),
        tag("p", answer["says"]),
        tag("p", f"error {percent(error['relative_rms'])}, {_floors(error)}"),
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


@shown.register
def _of_ladder(ladder: Ladder) -> Html:
    """The steps with their errors, and the last verdict."""
    if in_time(ladder.diagnosis.tests):
        return tag("pre", str(ladder))
    answer = ladder.to_dict()
    rows = []
    for step in answer["steps"]:
        # The first step is the model that was given: nobody predicted it.
        predicted = "-"
        if step["predicted_error"] is not None:
            predicted = percent(step["predicted_error"])
        errors = [percent(step[name]) for name in ("relative_rms", "noise_floor", "material_floor")]
        ratio = over_floor(step["relative_rms"], step["noise_floor"])
        rows.append((step["accepted"] or step["model"], predicted, *errors, ratio))
    headers = ("accepted", "predicted error", "error", "noise floor", "material floor", "x floor")
    return tag(
        "div",
        tag("p", tag("b", f"{answer['data']}: {answer['verdict']}")),
        table(headers, rows),
        tag("p", answer["diagnosis"]["says"]),
    )


@shown.register
def _of_comparison(comparison: Comparison) -> Html:
    """Errors against the floor that the models share, and where each of them fails."""
    if in_time(comparison.tests):
        return tag("pre", str(comparison))
    # Of a ranking only the models that are worth a look; the JSON has all.
    shown_models = [judgement.to_dict() for judgement in comparison.shown]
    answer = comparison.to_dict() | {"models": shown_models}
    rows = []
    for one in answer["models"]:
        # Of a single model "best" would be praise.
        best = one["model"] == answer["best"] and len(answer["models"]) > 1
        error, name = one["error"], one["model"]
        if best:
            name = f"{name} (best)"
        word = "holds"
        if one["fails"]:
            word = "fails"
        rows.append(
            (
                name,
                *(
                    percent(error[line])
                    for line in ("relative_rms", "noise_floor", "material_floor")
                ),
                over_floor(error["relative_rms"], error["noise_floor"]),
                number(one["delta_bic"], 3),
                word,
            )
        )
    sentences = [f"{one['model']}: {one['says']}" for one in answer["models"]]
    sentences += [finding["says"] for finding in answer["harmonics"] if finding["found"]]
    headers = ("model", "error", "noise floor", "material floor", "x floor", "delta BIC", "verdict")
    parts = [tag("p", tag("b", f"models of {answer['data']}"))]
    if comparison.says:
        parts.append(tag("p", comparison.says))
    parts.append(table(headers, rows))
    parts.append(tag("ul", *(tag("li", sentence) for sentence in (*sentences, *answer["notes"]))))
    return tag("div", *parts)


def _floors(error: Mapping[str, Any]) -> str:
    return (
        f"noise floor {percent(error['noise_floor'])}, material floor"
        f" {percent(error['material_floor'])}"
    )
