"""Ladders as text for people.

Each step with its error and what it changed, then the last diagnosis.
"""

from __future__ import annotations

from dataclasses import replace

from springpot.diagnosis.ladder import Ladder, Step
from springpot.format_numbers import number
from springpot.measurement.measurement import Measurement
from springpot.misfit.words import over_floor

from .answers import USUAL, beside_floor, diagnosis_text, times
from .numbers import percent
from .reference import reference_note
from .text import Table, paragraphs
from .values import shown

FAR = 1e3
"""Factor beyond which a parameter's move is told in words."""
MOVED = 1.1
"""Ratio of noise floors that are shown as two different numbers.

Their own uncertainty is about as large.
"""
NOTHING = 1e-6
"""Share of its old value below which a parameter is nothing."""


def ladder_text(ladder: Ladder, width: int = USUAL, verbose: bool = False) -> str:
    """Each step with its error, forecast and what it changed, then the last diagnosis."""
    table = _steps(ladder)
    if table.width > width:  # each model is the one above it and what was accepted
        table = _steps(ladder, brief=True).without(("material floor", "predicted"), width)
    first, last = ladder.steps[0], ladder.steps[-1]
    line = f"error {percent(first.relative_rms)} -> {percent(last.relative_rms)}"
    if len(ladder.steps) == 1:
        line += ", nothing accepted"
    remarks: list[str] = []
    for step in ladder.steps:
        remarks += filter(None, (changes_text(step), doubt_text(step)))
    judged = replace(ladder.diagnosis, parameters={})  # they stand above, in a table
    parts = [
        (
            f"{first.model.name} of {ladder.data}: {line},"
            f" {times(last.relative_rms, ladder.diagnosis.error)}"
        ),
        table.plain(),
        floor_moved(ladder),
        parameters_text(last),
        reference_note(data_of(last), [last.model.network]),
        "\n".join(remarks),
        f"at the last step: {diagnosis_text(judged, data_of(last), width, verbose)}",
    ]
    return paragraphs(parts, width)


def _steps(ladder: Ladder, brief: bool = False) -> Table:
    """A row for each step; `brief` names what was accepted in place of the whole model."""
    headers = ("step", "model", "predicted", "error", "x floor", "noise floor", "material floor")
    rows = []
    for i, step in enumerate(ladder.steps):
        name = step.model.name
        if brief and step.accepted:
            name = accepted_name(step)
        floor = step.noise_floor
        row = (
            str(i),
            name,
            beside_floor(step.predicted_error, floor),
            percent(step.relative_rms, 3),
            over_floor(step.relative_rms, floor, 2),
            percent(floor, 2),
            percent(step.material_floor, 2),
        )
        rows.append(row)
    return Table(headers, rows, frozenset(headers[2:]))


def floor_moved(ladder: Ladder) -> str:
    """Why the noise floor is not the same at each step, where it is not."""
    floors = [step.noise_floor for step in ladder.steps]
    # A floor that repeats or the user told does not depend on the model.
    if max(floors) <= MOVED * min(floors) or ladder.diagnosis.error.noise_source != "estimated":
        return ""
    return (
        f"the noise floor moved from {percent(floors[0], 2)} to {percent(floors[-1], 2)}: it is"
        " estimated from the scatter about each step's model, and part of a misfit passes for"
        " noise; repeats would tell it once for all"
    )


def data_of(step: Step) -> Measurement | None:
    """The data of a step; an answer from a file knows none."""
    if step.examined is None:
        return None
    return step.case.search.base.data.raw


def parameters_text(step: Step) -> str:
    """The parameters of a step with their intervals."""
    rows = [(name, *shown(value), value.unit) for name, value in step.parameters.items()]
    return Table(
        ("parameter", "value", "95 % interval", "unit"), rows, frozenset({"value"})
    ).plain()


def changes_text(step: Step) -> str:
    """What accepting an effect did to the parameters there before."""
    if not step.accepted or not step.changed:
        return ""
    moves = moves_text(step)
    # "changed k by 3 %", but "with + inertia c fell to nothing": the words that follow decide how
    # it begins.
    if any(_in_numbers(ratio) for ratio in step.changed.values()):
        return f"{accepted_name(step)} changed {moves}"
    return f"with {accepted_name(step)} {moves}"


def _in_numbers(ratio: float) -> bool:
    """Whether a parameter moved so little that a number tells it."""
    return 1.0 / FAR <= ratio <= FAR


def moves_text(step: Step) -> str:
    """How far each old parameter moved.

    First by how much, then those that moved beyond what numbers tell.
    """
    near = [f"{name} {change(ratio)}" for name, ratio in step.changed.items() if _in_numbers(ratio)]
    far = [
        f"{name} {change(ratio)}" for name, ratio in step.changed.items() if not _in_numbers(ratio)
    ]
    return "; ".join(", ".join(words) for words in (near, far) if words)


def change(ratio: float) -> str:
    """How much a parameter moved.

    In per cent, as a factor where that reads better, in words beyond a thousand.
    """
    if ratio < 0.0:
        return "changed sign"
    if ratio < NOTHING:
        return "fell to nothing"
    if ratio < 1.0 / FAR:
        return f"fell more than {FAR:.0f}-fold"
    if ratio > 1.0 / NOTHING:
        return "rose beyond all bounds"
    if ratio > FAR:
        return f"rose more than {FAR:.0f}-fold"
    # Beyond half and double per cent mislead: -90 % is a tenth, +90 % is not ten times.
    if not 0.5 < ratio < 2.0:
        return f"by a factor of {number(ratio, 3)}"
    if ratio > 1.0:
        return f"by +{percent(ratio - 1.0, 2)}"
    return f"by -{percent(1.0 - ratio, 2)}"


def doubt_text(step: Step) -> str:
    """What an accepted effect may be as well."""
    rivals = [name for name in step.alike if name != step.accepted]
    # Its shape imitates any narrow feature of a sweep, of whatever cause.
    if any(effect.narrow and effect.name == step.accepted for effect in step.model.effects):
        rivals.append("another narrow feature")
    if not rivals:
        return ""
    return (
        f"{accepted_name(step)} may as well be {' or '.join(rivals)}:"
        " these data cannot tell them apart"
    )


def accepted_name(step: Step) -> str:
    """``+ inertia``, or ``- inertia`` where it was dropped again."""
    name = step.accepted or ""
    if name.startswith("-"):
        return f"- {name[1:]}"
    return f"+ {name}"
