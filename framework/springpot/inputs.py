"""Files that a user names.

One rule of what is opened at all, and one line for each that cannot be read.

A regular file of a bounded size is read whole; what never ends or must be waited for is refused
before it is opened.
"""

from __future__ import annotations

import json
import re
import stat
import tomllib
from math import isfinite
from pathlib import Path
from typing import Any

from springpot.errors import DataError
from springpot.limits import LARGEST_NUMBER

LARGEST = 64 << 20
"""Bytes of a file that is read in one piece.

A table of two million rows, a fit to a million points.
"""
LARGEST_TOML = 1 << 18
"""Bytes of a description that somebody wrote by hand; its reader is a slow one."""
MOST_CONTAINERS = 1_000_000
"""Lists and objects of a file of JSON: each takes thirty times the memory of its brackets."""
_DEEP_KEY = re.compile(r"""(?:\.\s*(?:[\w-]+|"[^"\n]*"|'[^'\n]*')\s*){50}""")
"""A dotted name of more than fifty parts.

The memory of Python's reader grows with the square of their number.
"""


def require_regular(path: Path) -> None:
    """Refuse what has no end or must be waited for.

    What is not there at all is found when it is opened.

    Raises
    ------
    DataError
        If the path is a pipe, a socket or a device.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise DataError(
            f"{path}: a pipe or device, no regular file; save what comes from it, and open that"
        )


def bytes_of(path: Path, most: int = LARGEST) -> bytes:
    """All bytes of a regular file.

    Parameters
    ----------
    path : Path
        As the user named it.
    most : int
        Bytes that it may have.

    Raises
    ------
    DataError
        If it is a pipe or device, larger than that, or cannot be read; the line names it.
    """
    require_regular(path)
    try:
        with path.open("rb") as stream:
            # Not by the size that the system tells, which a file of the system itself has none of.
            content = stream.read(most + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DataError(f"{path} cannot be read: {reason}") from None
    if len(content) > most:
        raise DataError(
            f"{path} is too large: at most {_size(most)} are read in one piece;"
            " save what matters alone"
        )
    return content


def _size(most: int) -> str:
    if most >= 1 << 20:
        return f"{most >> 20} MiB"
    return f"{most >> 10} KiB"


def text_in(path: Path, most: int = LARGEST) -> str:
    """The text of a regular file in UTF-8, without the mark that spreadsheets put before it.

    Raises
    ------
    DataError
        As `bytes_of`, or if it is no text.
    """
    try:
        return bytes_of(path, most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError(
            f"{path} is no text in UTF-8 (byte {error.start}); save it as such"
        ) from None


def json_of(text: str, finite: bool = False) -> Any:
    """What a text of JSON holds.

    Parameters
    ----------
    text : str
        The text.
    finite : bool
        Whether all numbers must be such as a float holds, as in all that springpot writes; a
        program of an instrument may write NaN.

    Raises
    ------
    ValueError
        If it is none, too deeply nested, or of too many parts.
    """
    # Counted before anything is made of them; those within words count as well, which no answer has
    # a million of.
    if text.count("[") + text.count("{") > MOST_CONTAINERS:
        raise ValueError(f"more than {MOST_CONTAINERS} lists and objects")
    try:
        if finite:
            return json.loads(text, parse_float=_usable, parse_int=_whole, parse_constant=_usable)
        return json.loads(text)
    # Nested brackets are read by recursion.
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _finite(word: str) -> float:
    value = float(word)
    if not isfinite(value):
        raise ValueError(f"{word:.20} is no finite number")
    return value


def _usable(word: str) -> float:
    value = float(word)
    # Nor is what is no number below anything.
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(f"{word:.20} is no number that can be used")
    return value


def _whole(word: str) -> int:
    # As a float first: Python refuses to read longer whole numbers at all.
    _usable(word)
    return int(word)


def toml_of(text: str) -> dict[str, Any]:
    """What a text of TOML holds.

    Raises
    ------
    ValueError
        If it is none, too deeply nested, or a number in it is not finite.
    """
    if _DEEP_KEY.search(text):
        raise ValueError("nested too deeply")
    try:
        return tomllib.loads(text, parse_float=_finite)
    # Nested brackets are read by recursion.
    except RecursionError:
        raise ValueError("nested too deeply") from None


def toml_in(path: Path) -> dict[str, Any]:
    """What a description in TOML holds.

    Raises
    ------
    DataError
        As `text_in`, or if it is no TOML.
    """
    try:
        return toml_of(text_in(path, LARGEST_TOML))
    except ValueError as error:
        raise DataError(f"{path} is no TOML: {error}") from None
