"""Documents of ladders, and of installed models ranked against the material floor."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from springpot.comparison.result import Judgement, Ranking
from springpot.diagnosis.ladder import Ladder, Step
from springpot.identification.value import LOST
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import sweep_of
from springpot.misfit.error import over_floor, plain
from springpot.report.text import LETTERS
from springpot.writing import LISTED, listed, number

from ..numerics import NEGLIGIBLE, Real
from .answers import (
    beside_floor,
    diagnosis_document,
    experiment_text,
    floors,
    handy_model,
    left_out,
    reference_note,
    times,
    times_floor,
    value_text,
)
from .canvas import COLOURS, INK, QUIET, blank, finished, logarithmic
from .figures import draw_floors
from .fit_text import parameters_table
from .text import Listing, Passage, Prose, TextTable, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class LadderLayout(NamedTuple):
    """Of the picture of a ladder."""

    moved: float
    """Ratio of noise floors that are shown as two different numbers.

    Their own uncertainty is about as large.
    """
    level: int
    """Steps whose names are set level; of more, they are slanted."""
    after: float
    """Room for the words at the last step, in steps."""
    room: float
    """The error axis reaches this factor below the floor and above the largest error."""


LADDER = LadderLayout(moved=1.1, level=5, after=0.4, room=2.5)


def ladder_document(ladder: Ladder, verbose: bool = False) -> list[Passage]:
    """Each step with its error, forecast and what it changed, then the last diagnosis."""
    last = ladder.steps[-1]
    return [
        Prose(f"{ladder.steps[0].model.name} of {ladder.data}: {_fall(ladder)}"),
        steps_table(ladder),
        Prose(floor_moved(ladder)),
        parameters_table("parameter", last.parameters),
        Prose(reference_note(data_of(last), [last.model.network])),
        remarks(ladder),
        Prose(_open_question(ladder)),
        left_out(ladder.left_out),
        *diagnosis_document(
            ladder.diagnosis, data_of(last), verbose, "at the last step: ", fitted=False
        ),
    ]


def _fall(ladder: Ladder) -> str:
    """``error 8.3 % -> 1.1 %, 1.1 x floor``; of several tests in time of the first missed most.

    Then of the one that is missed most in the end, where it is another.
    """
    first, last = ladder.steps[0], ladder.steps[-1]
    nothing = ", nothing accepted" if len(ladder.steps) == 1 else ""
    reached = f"{percent(last.relative_rms)}{nothing}"
    against = f"{reached}, {times(last.relative_rms, ladder.diagnosis.error)}"
    if not first.test:
        return f"error {percent(first.relative_rms)} -> {against}"
    before = f"error of {first.test} {percent(first.relative_rms)}"
    if last.test == first.test:
        return f"{before} -> {against}"
    same = next(test for test in last.tests if test.name == first.test)
    ratio = over_floor(same.relative_rms, same.noise_floor, 2)
    return f"{before} -> {percent(same.relative_rms)}, {ratio} x floor; of {last.test} {against}"


def steps_table(ladder: Ladder) -> TextTable:
    """A row for each step; a narrow window names what was accepted in place of the whole model."""
    # Each model is the one above it and what was accepted.
    return replace(_steps(ladder), brief=replace(_steps(ladder, brief=True), spare=SPARE))


def _steps(ladder: Ladder, brief: bool = False) -> TextTable:
    """All columns; `brief` names what was accepted in place of the whole model."""
    numbers = ("predicted", "error", "x floor", "noise floor", "material floor")
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
            step.test,
        )
        rows.append(row)
    # Of one test alone the last column is empty, and left out.
    return TextTable(("step", "model", *numbers, "missed most"), rows, frozenset(numbers))


def remarks(ladder: Ladder) -> Listing:
    """What accepting each effect changed, and what it may be as well."""
    lines = [words(step) for step in ladder.steps for words in (changes_text, doubt_text)]
    return Listing([line for line in lines if line])


def _open_question(ladder: Ladder) -> str:
    """What tells an accepted effect from its rivals, where the last diagnosis asks for nothing."""
    asking = ladder.undecided
    if asking is ladder.steps[-1] or asking.next_experiment is None:
        return ""
    return experiment_text(asking.next_experiment)


def floor_moved(ladder: Ladder) -> str:
    """Why the noise floor is not the same at each step, where it is not."""
    floors = [step.noise_floor for step in ladder.steps]
    # A floor that repeats or the user told does not depend on the model.
    if (
        max(floors) <= LADDER.moved * min(floors)
        or ladder.diagnosis.error.noise_source != "estimated"
    ):
        return ""
    return (
        f"the noise floor moved from {percent(floors[0], 2)} to {percent(floors[-1], 2)}: it is"
        " estimated from the scatter about each step's model, and part of a misfit passes for"
        " noise; repeats would tell it once for all"
    )


def data_of(step: Step) -> Measurement | None:
    """The sweeps of a step; an answer from a file and one of tests in time know none."""
    return None if step.examined is None else sweep_of(step.examined.tests)


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
    return 1.0 / LOST <= ratio <= LOST


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
    if ratio < NEGLIGIBLE:
        return "fell to nothing"
    if ratio < 1.0 / LOST:
        return f"fell more than {LOST:.0f}-fold"
    if ratio > 1.0 / NEGLIGIBLE:
        return "rose from nothing"
    if ratio > LOST:
        return f"rose more than {LOST:.0f}-fold"
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


SPARE = ("material floor", "predicted")
"""Columns of steps that a narrow window goes without, the first first."""
HEADERS = ("model", "verdict", "error", "x floor", "delta BIC", "parameters")


def ranking_document(ranking: Ranking) -> list[Passage]:
    """The answer, models worth a look, those that are alike, and the parameters of the first."""
    best = ranking.best
    values = [f"{name} = {value_text(value)}" for name, value in best.parameters.items()]
    return [
        Prose(f"{ranking.data}: {ranking.says}"),
        _floors(ranking),
        *_table(ranking),
        handy_model(ranking),
        Listing([_alike(group) for group in ranking.groups if len(group) > 1]),
        Listing(values, f"{best.model.name}:", "  "),
        Prose(reference_note(data_of(ranking.ladder.steps[-1]), [best.model.network])),
        Listing(list(filter(None, map(doubt_text, ranking.ladder.steps)))),
        Listing(ranking.notes, mark="note: "),
    ]


def _floors(ranking: Ranking) -> Prose:
    """The lines against which the models stand, and what is beside every material."""
    first, last = ranking.ladder.steps[0], ranking.ladder.steps[-1]
    lines = [floors(ranking.best.error)]
    if added := " and ".join(effect.name for effect in last.model.effects):
        lines[0] += f" with {added}, {percent(first.material_floor)} without"
    # Where no material follows the data, no model of one can: that is the news, not their order.
    if ranking.ladder.verdict != "adequate":
        lines.append(f"any material: {ranking.ladder.diagnosis.says}")
    return Prose(*lines)


def _table(ranking: Ranking) -> list[Passage]:
    """One row for each group of adequate and of near models, then the nearest of the others."""
    rows = []
    # One row for all that cannot be told apart: side by side they would look like a ranking.
    for group in ranking.groups:
        verdict = "adequate"
        if group[0] in ranking.near:
            verdict = "as any material"
        rows.append(_row(group[0], verdict))
    rows += [_row(one, "not enough") for one in ranking.next]
    left = len(ranking.judgements) - len(ranking.adequate) - len(ranking.near) - len(ranking.next)
    more = ""
    if left:
        more = f"{left} more are not enough; --json has all"
    return [
        TextTable(HEADERS, rows, frozenset(HEADERS[2:]), ("parameters", "delta BIC")),
        Prose(more),
    ]


def _row(judged: Judgement, verdict: str) -> tuple[str, ...]:
    error = judged.error
    ratio = "-"
    if error.noise_floor > 0:
        ratio = times_floor(error.relative_rms, error.noise_floor)
    values = (
        percent(error.relative_rms),
        ratio,
        number(round(judged.delta_bic, 2), 3),
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
    text = f"{first} cannot be told from {listed(names, LISTED)}"
    if first.effects and same:
        text += " with the same effects"
    return text


def figure_ladder(ladder: Ladder, path: str | Path | None = None) -> Figure | Path:
    """The ladder as a figure, which is written to `path` if there is one.

    Parameters
    ----------
    ladder : Ladder
        The discovery.
    path : str or Path, optional
        Where to write; what is returned and raised is told by `springpot.report.canvas.finished`.
    """
    with blank(max(6.4, 1.15 * len(ladder.steps) + 1.2), 4.4) as figure:
        axes = figure.subplots()
        draw_ladder(axes, ladder)
        entitled(axes, f"{ladder.steps[0].model.name} of {ladder.data}")
        return finished(figure, path)


def draw_ladder(axes: Axes, ladder: Ladder) -> None:
    """Error, forecast, noise floor and material floor of each step on a logarithmic axis."""
    steps = ladder.steps
    place = np.arange(len(steps))
    error = 100.0 * np.array([step.relative_rms for step in steps])
    floor = 100.0 * np.array([step.noise_floor for step in steps])
    material = 100.0 * np.array([step.material_floor for step in steps])
    draw_floors(axes, floor, material, LADDER.after)
    _forecast(axes, steps, error)
    axes.plot(place, error, "o-", color=COLOURS[0], label="error", zorder=4, markersize=6.0)
    for x, step in enumerate(steps):
        words = f"{percent(step.relative_rms, 2)}\n{_ratio(step)}"
        beside_mark(axes, (x, error[x]), words)
    _names(axes, steps)
    foretold = [100.0 * (step.predicted_error or 0.0) for step in steps]
    error_axis(axes, np.concatenate([floor, material, error, foretold]))


def error_axis(axes: Axes, levels: Real) -> None:
    """A logarithmic axis of errors in per cent on which levels have room."""
    logarithmic(axes, "y")
    # A floor of exact data is zero, which has no place there, and what could not be fitted has no
    # error.
    drawn = levels[(levels > 0.0) & np.isfinite(levels)]
    axes.set_ylim(float(drawn.min()) / LADDER.room, float(drawn.max()) * LADDER.room)
    # Again: which numbers stand at the axis depends on its ends.
    logarithmic(axes, "y")
    axes.set_ylabel("error [%]")
    axes.legend(loc="upper right")


def entitled(axes: Axes, title: str) -> None:
    """Set the title of a picture of one panel, as it stands.

    A dollar sign in a file's name begins no formula.
    """
    axes.set_title(title.replace("$", r"\$"), fontsize=11.0)


def beside_mark(axes: Axes, place: tuple[float, float], words: str) -> None:
    """Write words to the upper right of a mark."""
    axes.annotate(
        words, place, (7, 5), textcoords="offset points", fontsize=9.0, color=INK, zorder=5
    )


def _ratio(step: Step) -> str:
    if not step.noise_floor > 0:
        return "no noise"
    return f"{plain(step.relative_rms / step.noise_floor, 2)} × floor"


def _forecast(
    axes: Axes, steps: tuple[Step, ...], error: np.ndarray[tuple[int], np.dtype[np.float64]]
) -> None:
    forecasts = [
        (x, 100.0 * step.predicted_error) for x, step in enumerate(steps) if step.predicted_error
    ]
    for i, (x, predicted) in enumerate(forecasts):
        # From the step before, where it was made.
        axes.plot(
            [x - 1, x], [error[x - 1], predicted], ":", color=COLOURS[1], linewidth=1.2, zorder=2
        )
        # A legend names each kind of mark once.
        label: str | None = None
        if i == 0:
            label = "predicted"
        hidden = 0.97 < predicted / error[x] < 1.03
        size = 6.0
        # Around the error's own mark, where both fall together.
        if hidden:
            size = 10.0
        axes.plot(
            x,
            predicted,
            "D",
            color=COLOURS[1],
            markerfacecolor="white",
            label=label,
            zorder=3,
            markersize=size,
        )


def _names(axes: Axes, steps: tuple[Step, ...]) -> None:
    names = [broken(_name(step)) for step in steps]
    axes.set_xticks(range(len(steps)), names, color=INK)
    if len(steps) > LADDER.level:
        axes.tick_params(axis="x", labelrotation=30)
    axes.tick_params(axis="x", length=0)
    axes.grid(False, axis="x")
    axes.spines["bottom"].set_color(QUIET)


def _name(step: Step) -> str:
    if step.accepted is None:
        return step.model.base
    # A leading hyphen marks an effect that was dropped again.
    if step.accepted.startswith("-"):
        return f"− {step.accepted[1:]}"
    return f"+ {step.accepted}"


def broken(name: str) -> str:
    """A long name on several lines, broken behind hyphens."""
    lines = [""]
    # The hyphen stays at the end of its line.
    for part in name.replace("-", "-\0").split("\0"):
        if lines[-1] and len(lines[-1]) + len(part) > LETTERS.step:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)
