"""What a user can do with an answer: each step with its command, and the error that it leaves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from springpot.plain_data import jsonable, number
from springpot.suggestions import suggested

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
    """

    says: str
    command: str
    error_after: float = float("nan")

    def to_dict(self) -> dict[str, Any]:
        """As in the schema."""
        return dict(jsonable(vars(self)))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> ToDo:
        """What `to_dict` gave."""
        return cls(row["says"], row["command"], number(row["error_after"]))


def turning(spec: str) -> ToDo:
    """To turn one channel; `spec` opens the data so.

    Of a force that counts the other way every other answer is wrong.
    """
    return ToDo("the force counts the other way: turn it", suggested("diagnose", spec))


def splitting(column: str, error_after: float) -> ToDo:
    """To let each value of a column have a factor of its own, the material being shared."""
    says = f"what is missing goes with {column}: one factor a value, the material shared"
    return ToDo(says, suggested("discover", DATA, "--split", column), error_after)


def leaving_out(row: int, error_after: float) -> ToDo:
    """To leave out a point that stands out, as the answer itself has done."""
    says = f"row {row} stands out: leave it out of every fit too"
    return ToDo(says, suggested("diagnose", DATA, "--exclude", f"row={row}"), error_after)


def accepting(effect: str, explains: bool, error_after: float) -> ToDo:
    """To add an effect, proved or not."""
    says = f"{effect} helps, which is no proof: accept it"
    if explains:
        says = f"{effect} explains it: accept it"
    return ToDo(says, suggested("discover", DATA, "--accept", effect), error_after)
