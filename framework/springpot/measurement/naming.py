"""How a user names a file and what to take from it: ``FILE#PART?COLUMN=MEANING,...``."""

from __future__ import annotations

from pathlib import Path

from springpot.errors import DataError

from .reader import Choice

ADVICE = "write 'FILE?frequency=Hz' or 'FILE?1=omega[rad/s],2=storage[Pa],3=loss[Pa]'"


def is_file(text: str) -> bool:
    """Whether something is there; a folder is reported by the reading."""
    try:
        return text not in ("", ".", "..") and Path(text).exists()
    except (OSError, ValueError):
        return False


def short(text: str) -> str:
    """At most 80 signs of a name, for errors."""
    return text if len(text) <= 80 else f"{text[:40]}...{text[-30:]}"


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
    name, mark, said = text.rpartition("?")
    if not mark:
        name, said = text, ""
    columns = columns_of(said, text) if mark else {}
    if is_file(name):
        return name, Choice("", columns)
    stem, mark, part = name.rpartition("#")
    if not mark:
        return name, Choice("", columns)
    if not part.strip():
        raise DataError(f"'{short(text)}': give the number or name of a part after '#', such as FILE#2")
    return stem, Choice(part.strip(), columns)


def columns_of(said: str, text: str) -> dict[str, str]:
    """What is said of the columns, ``frequency=Hz,3=loss[Pa]``, as a mapping."""
    found: dict[str, str] = {}
    for piece in said.split(","):
        name, equals, meaning = (word.strip() for word in piece.partition("="))
        if not (name and equals and meaning):
            raise DataError(f"'{short(text)}': '{short(piece)}' says nothing of a column; {ADVICE}")
        if name in found:
            raise DataError(f"'{short(text)}': column '{short(name)}' is given twice")
        found[name] = meaning
    return found
