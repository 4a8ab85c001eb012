"""How a user names a file and what to take from it: ``FILE#PART?COLUMN=MEANING,...``."""

from __future__ import annotations

import re
from itertools import islice, pairwise
from pathlib import Path
from shlex import quote

from springpot.errors import DataError

from .reader import Choice

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
        return text not in ("", ".", "..") and Path(text).exists()
    except (OSError, ValueError):
        return False


def in_quotes(text: str) -> str:
    """An argument in a sentence, in quotes as a shell takes it.

    A name may hold an apostrophe itself.

    Examples
    --------
    >>> from springpot.measurement.naming import in_quotes
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
    >>> from springpot.measurement.naming import with_part
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
