"""What a user can do with an answer: each step with its command, and the error that it leaves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from springpot.plain_data import jsonable, number
from springpot.writing import in_shell, suggested

DATA = "DATA"
"""Stands in commands for what a user called the data, and for the model that is judged."""


@dataclass(frozen=True)
class ToDo:
    """One step.

    Attributes
    ----------
    says : str
        What it is.
    command : str
        What does it; `DATA` stands for the data, and for the model that is judged.
    error_after : float
        The relative error that is foretold, NaN where only the step itself will tell.
    split : str
        The column that is split, if that is the step; a file does not hold it.
    exclude : tuple of int
        Rows of the data that are left out, the first being 1; a file does not hold them.
    """

    says: str
    command: str
    error_after: float = float("nan")
    split: str = field(default="", compare=False)
    exclude: tuple[int, ...] = field(default=(), compare=False)

    def to_dict(self) -> dict[str, Any]:
        """As in the schema."""
        row = {"says": self.says, "command": self.command, "error_after": self.error_after}
        return dict(jsonable(row))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> ToDo:
        """What `to_dict` gave."""
        return cls(row["says"], row["command"], number(row["error_after"]))


def of_data(steps: Iterable[ToDo], *words: str) -> tuple[ToDo, ...]:
    """The steps with the data, and the model that is judged, in their commands.

    Parameters
    ----------
    steps : iterable of ToDo
        Whose commands hold `DATA`.
    *words : str
        The data as the user called them, and the options that name the model.
    """
    given = f" {' '.join(map(in_shell, words))} "
    return tuple(replace(step, command=step.command.replace(f" {DATA} ", given)) for step in steps)


def turning(spec: str) -> ToDo:
    """To turn one channel; `spec` opens the data so.

    Of a force that counts the other way every other answer is wrong.
    """
    return ToDo("the force counts the other way: turn it", suggested("diagnose", spec))


def splitting(
    column: str, error_after: float = float("nan"), what: str = "what is missing"
) -> ToDo:
    """To let each value of a column have a factor of its own, the material being shared."""
    says = f"{what} goes with {column}: one factor a value, the material shared"
    return ToDo(says, suggested("discover", DATA, "--split", column), error_after, split=column)


def leaving_out(row: int, error_after: float) -> ToDo:
    """To leave out a point that stands out, as the answer itself has done."""
    says = f"row {row} stands out: leave it out of every fit too"
    command = suggested("diagnose", DATA, "--exclude", f"row={row}")
    return ToDo(says, command, error_after, exclude=(row,))


def leaving_out_the_beginning(until: float) -> ToDo:
    """To leave out what was measured while a step was still being made, up to a time in s."""
    says = (
        "the misfit is largest at the beginning, where a step is still made: leave it out, compare"
    )
    return ToDo(says, suggested("diagnose", DATA, "--exclude", f"time=..{until:.3g}"))


def accepting(effect: str, explains: bool, error_after: float) -> ToDo:
    """To add an effect, proved or not."""
    says = f"{effect} helps, which is no proof: accept it"
    if explains:
        says = f"{effect} explains it: accept it"
    return ToDo(says, suggested("discover", DATA, "--accept", effect), error_after)
