"""What a file leaves open and its user knows.

Questions with their answers, so that a page can ask them as a form.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from springpot.errors import DataError

Kind = Literal["unit", "meaning", "column", "base", "constant", "part"]


@dataclass(frozen=True)
class Question:
    """One thing that a file leaves open.

    Parameters
    ----------
    about : str
        A column, or what is looked for among the columns.
    kind : str
        ``unit``: the unit of a column; ``meaning``: what a column is; ``column``: which column is
        the one looked for; ``base``: of logarithms; ``constant``: a value that all rows share;
        ``part``: which part of the file.
    answers : mapping of str to str
        What may be answered, the usual first, each with what is typed behind the file's name for
        it: ``storage=kPa`` (behind ``?``) or ``#2``.

    Examples
    --------
    >>> Question.of_unit("loss", "Pa", ["Pa", "kPa"]).answers
    {'Pa': 'loss=Pa', 'kPa': 'loss=kPa'}
    """

    about: str
    kind: Kind
    answers: Mapping[str, str]

    @classmethod
    def of_unit(cls, column: str, usual: str, units: Iterable[str]) -> Question:
        """The question for the unit of a column."""
        return cls(column, "unit", {unit: f"{column}={unit}" for unit in [usual, *units]})

    def to_dict(self) -> dict[str, object]:
        """As JSON has it; answers keep their order."""
        answers = [{"answer": answer, "said": said} for answer, said in self.answers.items()]
        return {"about": self.about, "kind": self.kind, "answers": answers}


class OpenQuestion(DataError):
    """A file cannot be read until its user says more; the message says so in one line, too.

    Parameters
    ----------
    message : str
        What a terminal shows.
    questions : iterable of Question
        All that is open, each to be answered.
    """

    def __init__(self, message: str, questions: Iterable[Question]) -> None:
        super().__init__(message)
        self.questions = tuple(questions)

    def worded(self, message: str) -> OpenQuestion:
        """The same questions with another message."""
        return OpenQuestion(message, self.questions)
