"""Which of the installed readers a file is for, and what becomes of their errors.

Of sweeps and of tests in time.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol, TypeVar

from springpot.errors import DataError, SpringpotError
from springpot.owners import described, owned, owner_of

from .naming import in_quotes
from .question import OpenQuestion
from .reader import Choice

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
