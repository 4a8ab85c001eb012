"""Ladders as text for people.

Each step with its error and what it changed, then the last diagnosis.

Installed models ranked against the material floor, as text for people.

``print(result)``: the text that the command line prints.
"""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch

from springpot.comparison.comparing import Comparison, Judgement
from springpot.comparison.ranking import Ranking
from springpot.diagnosis.ladder import Ladder, Step
from springpot.diagnosis.result import Diagnosis
from springpot.format_numbers import number
from springpot.identification.part_result import in_time
from springpot.identification.result import Identification
from springpot.measurement.measurement import Measurement
from springpot.misfit.words import over_floor

from .answers import (
    USUAL,
    beside_floor,
    comparison_text,
    diagnosis_text,
    floors,
    reference_note,
    times,
    times_floor,
    value_text,
)
from .fit_text import (
    climbed_in_time_text,
    compared_in_time_text,
    diagnosed_in_time_text,
    identification_text,
)
from .numbers import percent
from .text import TextTable, paragraphs
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


def _steps(ladder: Ladder, brief: bool = False) -> TextTable:
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
    return TextTable(headers, rows, frozenset(headers[2:]))


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
    return TextTable(
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


HEADERS = ("model", "verdict", "error", "x floor", "delta BIC", "parameters")
NAMED = 12
"""Models of a group that are named."""


def ranked_text(ranking: Ranking, width: int = USUAL) -> str:
    """The answer, models worth a look, those that are alike, and the parameters of the first."""
    parts = [
        f"{ranking.data}: {ranking.says}",
        _floors(ranking),
        _table(ranking, width),
        "\n".join(_alike(group) for group in ranking.groups if len(group) > 1),
        _first(ranking.best),
        reference_note(data_of(ranking.ladder.steps[-1]), [ranking.best.model.network]),
        "\n".join(filter(None, map(doubt_text, ranking.ladder.steps))),
        "\n".join(f"note: {note}" for note in ranking.notes),
    ]
    return paragraphs(parts, width)


def _floors(ranking: Ranking) -> str:
    """The lines against which the models stand, and what is beside every material."""
    first, last = ranking.ladder.steps[0], ranking.ladder.steps[-1]
    lines = [floors(ranking.best.error)]
    if added := " and ".join(effect.name for effect in last.model.effects):
        lines[0] += f" with {added}, {percent(first.material_floor)} without"
    # Where no material follows the data, no model of one can: that is the news, not their order.
    if ranking.ladder.verdict != "adequate":
        lines.append(f"any material: {ranking.ladder.diagnosis.says}")
    return "\n".join(lines)


def _table(ranking: Ranking, width: int) -> str:
    """One row for each group of adequate and of near models, then the nearest of the others."""
    rows = []
    # One row for all that cannot be told apart: side by side they would look like a ranking.
    for group in ranking.groups:
        verdict = "adequate"
        if group[0] in ranking.near:
            verdict = "as any material"
        rows.append(_row(group[0], verdict))
    rows += [_row(one, "not enough") for one in ranking.next]
    table = (
        TextTable(HEADERS, rows, frozenset(HEADERS[2:]))
        .without(("parameters", "delta BIC"), width)
        .plain()
    )
    left = len(ranking.judgements) - len(ranking.adequate) - len(ranking.near) - len(ranking.next)
    if left:
        table += f"\n{left} more are not enough; --json has all"
    return table


def _row(judged: Judgement, verdict: str) -> tuple[str, ...]:
    error = judged.error
    ratio = "-"
    if error.noise_floor > 0:
        ratio = times_floor(error.relative_rms, error.noise_floor)
    values = (
        percent(error.relative_rms),
        ratio,
        number(judged.delta_bic, 3),
        str(judged.free_parameters),
    )
    return (judged.model.name, verdict, *values)


def _alike(group: tuple[Judgement, ...]) -> str:
    """``springpot + inertia cannot be told from kelvin, maxwell (with the same effects)``."""
    first, *others = (one.model for one in group)
    same = [other for other in others if other.effects == first.effects]
    # The effects that all share are told once, behind the names; other models are named in full,
    # and last.
    names = [one.base for one in same] + [one.name for one in others if one not in same]
    text = f"{first} cannot be told from {', '.join(names[:NAMED])}"
    if len(names) > NAMED:
        text += f" and {len(names) - NAMED} more"
    if first.effects and same:
        text += " with the same effects"
    return text


def _first(one: Judgement) -> str:
    """Parameters of the model that comes first."""
    values = "\n".join(f"  {name} = {value_text(value)}" for name, value in one.parameters.items())
    return f"{one.model.name}:\n{values}"


@singledispatch
def told(result: object) -> str:
    """The text of a result; of anything else its short form."""
    return repr(result)


# The functions of the command line themselves: what Python prints cannot differ from what a shell
# shows.
told.register(Identification, identification_text)
told.register(Ranking, ranked_text)


@told.register
def _diagnosis(result: Diagnosis) -> str:
    if in_time(result.tests):
        return diagnosed_in_time_text(result)
    return diagnosis_text(result)


@told.register
def _ladder(result: Ladder) -> str:
    if in_time(result.diagnosis.tests):
        return climbed_in_time_text(result)
    return ladder_text(result)


@told.register
def _comparison(result: Comparison) -> str:
    if in_time(result.tests):
        return compared_in_time_text(result)
    return comparison_text(result)
