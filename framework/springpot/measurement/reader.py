"""Readers of measurement files: chosen by what a file holds, never by its name alone.

For sweeps and for tests in time: which of the installed readers a file is for, what becomes of
their errors, how a user names a file and what to take from it (``FILE#PART?COLUMN=MEANING,...``),
and questions about what it leaves open with their answers, so that a page can ask them as a form.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice, pairwise
from pathlib import Path
from shlex import quote
from types import MappingProxyType
from typing import Literal, Protocol, TypeVar

from springpot.errors import DataError, SpringpotError, described, owned, owner_of

from .measurement import Measurement
from .signals import Signals


@dataclass(frozen=True)
class Choice:
    """What a user says about a file beside its name: ``FILE#PART?COLUMN=MEANING,...``.

    Parameters
    ----------
    part : str
        Which of several steps, sweeps or sheets: a number (``2``), numbers (``2-4``) or a part of
        their names; all that can be used by default.
    columns : mapping of str to str
        What the file leaves open: by a column's name, title or number its unit (``frequency=Hz``),
        its meaning (``3=loss [Pa]``), or a constant (``frequency=1 [Hz]``).

    Examples
    --------
    >>> from springpot.measurement import Choice
    >>> bool(Choice()), Choice("2", {"frequency": "Hz"}).columns["frequency"]
    (False, 'Hz')
    """

    part: str = ""
    columns: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def __bool__(self) -> bool:
        return bool(self.part or self.columns)


@dataclass(frozen=True)
class Part:
    """One step, sweep or sheet of a file.

    Parameters
    ----------
    name : str
        As the file calls it.
    points : int
        Number of its rows.
    usable : bool
        Whether it is a dynamic test, so that it can be opened.
    says : str
        What it holds, or what it lacks.
    asks : bool
        Whether it opens once the user says what the file leaves open.
    """

    name: str
    points: int
    usable: bool = True
    says: str = ""
    asks: bool = False


def parts_as_opened(parts: Sequence[Part], measurement: Measurement) -> list[Part]:
    """The parts of a file.

    Those that ask for something are usable where they opened with what the user says.

    Parameters
    ----------
    parts : sequence of Part
        As the file alone tells of them.
    measurement : Measurement
        What was opened of the file.
    """
    if "note parts" not in measurement.provenance:
        return list(parts)
    made = []
    for part in parts:
        if part.asks and f"note {part.name}" not in measurement.provenance:
            part = replace(part, usable=True, says="")
        made.append(part)
    return made


@dataclass(frozen=True)
class Reader:
    """One file format.

    Parameters
    ----------
    name : str
        Shown by ``springpot list readers``.
    summary : str
        One sentence on the format.
    recognises : callable
        From the first bytes of a file to a confidence between 0 (not mine) and 1 (surely mine).
    read : callable
        From a path and a `Choice` to the measurement. Its `DataError` need not name the file: the
        name is put before the message (``line 3: ...``), and in the place of ``'FILE`` in a hint
        (``open 'FILE?storage=Pa'``).
    signals : callable, optional
        From a path and a `Choice` to the displacement and force against time, for formats that hold
        such signals.
    text : callable, optional
        From a measurement to the text of a file in this format that reads back as the same bits.
    parts : callable, optional
        From a path to the `Part` s of a file, in order, for formats that hold several.
    """

    name: str
    summary: str
    recognises: Callable[[bytes], float]
    read: Callable[[Path, Choice], Measurement]
    signals: Callable[[Path, Choice], Signals] | None = None
    text: Callable[[Measurement], str] | None = None
    parts: Callable[[Path], Sequence[Part]] | None = None


ADVICE = "write 'FILE?frequency=Hz' or 'FILE?1=omega[rad/s],2=storage[Pa],3=loss[Pa]'"

_TEMPERATURE = re.compile(
    r"(?<![A-Za-z0-9.])(?:T\s?=?\s?)?([-+−]?\d{1,3}(?:[.,]\d{1,2})?)[ _]?(°C|deg ?C|C|K|°F|deg"
    r" ?F)(?![A-Za-z0-9])"
)
_NAMED = re.compile(
    r"(?<![A-Za-z0-9.])(?:T|Temp|temp)[=_ ]?(-?\d{1,3}(?:[.,]\d{1,2})?)(?![A-Za-z0-9])"
)
# A minus after a letter or a digit joins two words, as in ps-130; after another mark it is a sign.
_NUMBER = re.compile(r"(?<!\d)(?:(?<![A-Za-z0-9])[-−])?\d{2,3}(?!\d)")
COLDEST_KELVIN = 100.0
"""Below it a K in a name is more likely a thousand, as in PS5K."""
SIBLINGS = 2
"""Other files of the same name but for one number, from which that number is taken for a condition.
"""
APART = 5
"""Kelvin between such numbers, at least."""
LONGEST_NAME, SHOWN_BEGINNING, SHOWN_END = 80, 40, 30
"""Signs of a name in an error, and those that stand for a longer one.

Both ends, which tell a path best.
"""
LISTED = 2000
"""Entries of a folder that are looked at: of a very large one the rest would only take time."""


def is_file(text: str) -> bool:
    """Whether something is there; a folder is reported by the reading."""
    try:
        # A long expression or a line of text is no path: the system refuses to look for it.
        return text != "" and Path(text).exists()
    except (OSError, ValueError):
        return False


def in_quotes(text: str) -> str:
    """An argument in a sentence, in quotes as a shell takes it.

    A name may hold an apostrophe itself.

    Examples
    --------
    >>> from springpot.measurement.reader import in_quotes
    >>> print(in_quotes("gel.csv?storage=Pa"), in_quotes("Bob's.csv"))
    'gel.csv?storage=Pa' 'Bob'"'"'s.csv'
    """
    if "'" in text:
        return quote(text)
    return f"'{text}'"


def short(text: str) -> str:
    """A name that is not too long for an error."""
    if len(text) <= LONGEST_NAME:
        return text
    return f"{text[:SHOWN_BEGINNING]}...{text[-SHOWN_END:]}"


def file_and_choice(text: str) -> tuple[str, Choice]:
    """The name of a file, and what a user says of its parts and columns.

    A file whose own name holds ``#`` or ``?`` goes first.

    Raises
    ------
    DataError
        If what follows ``?`` cannot be understood.
    """
    if is_file(text):
        return text, Choice()
    # From the right: a folder may have a question mark in its name, what is said of columns has
    # none.
    name, mark, answers = text.rpartition("?")
    columns: dict[str, str] = {}
    if mark:
        columns = columns_of(answers, text)
    else:
        name = text
    if is_file(name):
        return name, Choice("", columns)
    stem, mark, part = name.rpartition("#")
    if not mark:
        return name, Choice("", columns)
    if not part.strip():
        raise DataError(
            f"'{short(text)}': give the number or name of a part after '#', such as FILE#2"
        )
    return stem, Choice(part.strip(), columns)


def without_rows(text: str) -> str:
    """What a user names, without the choice of rows behind it.

    Any word of a file may stand in that choice.

    A file whose own name holds ``@`` goes first.
    """
    if is_file(text):
        return text
    stems = (text[:i] for i, sign in enumerate(text) if sign == "@")
    return next((stem for stem in stems if names_file(stem)), text)


def names_file(text: str) -> bool:
    """Whether a file is named, with what is said of its parts and columns."""
    try:
        return is_file(file_and_choice(text)[0])
    # What follows a mark is no choice of columns, and so a part of some other name.
    except DataError:
        return False


def with_part(text: str, number: int) -> str:
    """The same file with one of its parts chosen.

    The part stands before what is said of columns and rows.

    Examples
    --------
    >>> from springpot.measurement.reader import with_part
    >>> with_part("sweeps.csv?storage=Pa", 2)
    'sweeps.csv#2?storage=Pa'
    """
    # Rows are chosen last, columns before them; a name that holds such a mark itself goes first.
    name, said = text, ""
    for mark in ("@", "?"):
        stem, is_marked, rest = name.rpartition(mark)
        if is_marked and not is_file(name):
            name, said = stem, f"{mark}{rest}{said}"
    return f"{name}#{number}{said}"


def columns_of(answers: str, text: str) -> dict[str, str]:
    """What is said of the columns, ``frequency=Hz,3=loss[Pa]``, as a mapping."""
    meanings: dict[str, str] = {}
    for piece in answers.split(","):
        name, equals, meaning = (word.strip() for word in piece.partition("="))
        if not (name and equals and meaning):
            raise DataError(f"'{short(text)}': '{short(piece)}' says nothing of a column; {ADVICE}")
        if name in meanings:
            raise DataError(f"'{short(text)}': column '{short(name)}' is given twice")
        meanings[name] = meaning
    return meanings


def temperature_offer(path: Path) -> dict[str, str]:
    """A note that offers the temperature that a file's name seems to state.

    Empty where it states none.

    It is offered and not taken: whether ``gel_20C`` is a temperature or a sample only the user
    knows.
    """
    stated = _stated_temperature(path.stem) or _number_among_siblings(path)
    if stated is None:
        return {}
    text, number, unit = stated
    offer = in_quotes(f"{path}?temperature={number}[{unit}]")
    return {
        "note temperature": (
            f"no temperature in the file; if '{text}' in its name is one, open {offer}"
        )
    }


def _stated_temperature(stem: str) -> tuple[str, str, str] | None:
    """Text, number and unit of ``gel_20C``, ``T=-5 degC`` or ``293K``."""
    if match := _TEMPERATURE.search(stem):
        number = match[1].replace(",", ".").replace("−", "-")
        unit = {"C": "degC", "F": "degF"}.get(match[2][-1], "K")
        if unit != "K" or float(number) >= COLDEST_KELVIN:
            return match[0], number, unit
    match = _NAMED.search(stem)
    if match is None:
        return None
    return match[0], match[1].replace(",", "."), "degC"


def _number_among_siblings(path: Path) -> tuple[str, str, str] | None:
    """The number in which a file's name differs from several others.

    ``ps130`` beside ``ps145`` and ``ps160``.
    """
    numbers = list(_NUMBER.finditer(path.stem))
    if not numbers:
        return None
    try:
        # Some of them are enough to see a series; a folder may hold a million files.
        names = {entry.name for entry in islice(path.parent.iterdir(), LISTED)} - {path.name}
    except OSError:
        return None
    for match in numbers:
        before, after = path.name[: match.start()], path.name[match.end() :]
        pattern = re.escape(before) + r"([-−]?\d{1,3})" + re.escape(after)
        others = [
            _integer(match_of_other[1])
            for name in names
            if (match_of_other := re.fullmatch(pattern, name))
        ]
        values = sorted([_integer(match[0]), *others])
        # Numbers that only count the tests lie closer together than temperatures that somebody
        # chose.
        if len(others) >= SIBLINGS and min(b - a for a, b in pairwise(values)) >= APART:
            return match[0], str(_integer(match[0])), "degC"
    return None


def _integer(text: str) -> int:
    """A number of a file's name, with either sign for minus."""
    return int(text.replace("−", "-"))


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


T = TypeVar("T")

_HINT = re.compile(r"'FILE([#?@]?)([^']*)'")
"""What an error offers to type."""


class Recognising(Protocol):
    """Any reader: it has a name, and tells how sure it is of the first bytes of a file."""

    @property
    def name(self) -> str:
        """Shown to users."""

    @property
    def recognises(self) -> Callable[[bytes], float]:
        """From the first bytes to a confidence between 0 and 1."""


R = TypeVar("R", bound=Recognising)


def surest(readers: Iterable[R], head: bytes) -> tuple[R | None, float]:
    """The reader that is surest of the first bytes of a file, and how sure; of equals the first."""
    best: R | None = None
    most = -1.0
    for reader in readers:
        sure = _confidence(reader, head)
        # Not >=: of equals the first stays, so that a further plugin takes no files from those
        # before it.
        if sure > most:
            best, most = reader, sure
    return best, most


def _confidence(reader: Recognising, head: bytes) -> float:
    try:
        return float(reader.recognises(head))
    except Exception:
        # A reader that stumbles over a foreign format simply does not recognise it.
        return 0.0


def guarded(
    reader: Recognising, path: Path, action: Callable[[], T], choice: Choice | None = None
) -> T:
    """What a reader gives; its errors name the file, which readers need not do.

    Where they hint at what to type, it holds all that the user said before in `choice`, so that no
    hint leads back to a question that was answered.

    Raises
    ------
    DataError
        In one line, whatever the reader raised.
    """
    try:
        return action()
    except OpenQuestion as error:
        raise error.worded(_about(path, str(error), choice or Choice())) from None
    except DataError as error:
        message = _about(path, str(error), choice or Choice())
        # What a plugin reads may be wrong by its own fault.
        if owner := owner_of("reader", reader.name) or owner_of("time reader", reader.name):
            message += f" (by the reader '{reader.name}' of {owner})"
        raise DataError(message) from None
    except (SpringpotError, MemoryError):
        raise
    except Exception as error:
        # Of a plugin's own fault the first line says what; a traceback helps its author only.
        first = (described(error).splitlines() or [""])[0]
        raise DataError(f"{path}: the {owned('reader', reader.name)} failed: {first}") from error


def _about(path: Path, message: str, choice: Choice) -> str:
    """An error as a user sees it: which file, and what to type instead of ``FILE``."""
    if str(path) in message:
        return to_type(path, message, choice)
    for own in (path.name, path.stem):
        # Signals and measurements name themselves; once is enough.
        message = message.removeprefix(f"{own}: ")
    sign = ": "
    if message.startswith(("line ", "column ")):
        sign = ", "
    return f"{path}{sign}{to_type(path, message, choice)}"


def to_type(path: Path, text: str, choice: Choice) -> str:
    """What a reader says, with what to type as a user has to.

    The file's name, and what was said of it before.

    Readers and whoever judges a file do not know under which name it was opened, and write
    ``FILE``.
    """

    def typed(hint: re.Match[str]) -> str:
        if hint[1] == "?":
            return in_quotes(f"{path}{said_with(choice, hint[2])}")
        return in_quotes(f"{path}{hint[1]}{hint[2]}")

    return _HINT.sub(typed, text)


def said_with(choice: Choice, answers: str) -> str:
    """What to type behind a file's name.

    What was said before, then `answers` such as ``loss=Pa,3=ignore``.
    """
    part = ""
    if choice.part:
        part = f"#{choice.part}"
    now = {piece.partition("=")[0].strip() for piece in answers.split(",")}
    before = [f"{name}={meaning}" for name, meaning in choice.columns.items() if name not in now]
    return f"{part}?{','.join([*before, answers])}"
