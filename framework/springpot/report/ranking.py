"""Installed models ranked against the material floor, as text for people."""

from __future__ import annotations

from springpot.comparison.comparing import Judgement
from springpot.comparison.ranking import Ranking
from springpot.format_numbers import number

from .answers import USUAL, floors, times_floor, value_text
from .ladder_text import data_of, doubt_text
from .numbers import percent
from .reference import reference_note
from .text import Table, paragraphs

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
        Table(HEADERS, rows, frozenset(HEADERS[2:]))
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
