"""Bytes to text: UTF-8, UTF-16, or the older code in which the file speaks of dynamic tests."""

from __future__ import annotations

import codecs
from pathlib import Path

from springpot.errors import DataError
from springpot.measurement import bytes_of

from .languages import CHANNELS, LANGUAGES

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_OLDER = ("cp932", "gb18030", "big5", "cp949", "cp1251", "cp1250", "cp1254")
"""Codes of Japanese, Chinese, Korean, Russian, Polish and Turkish Windows.

Bytes alone cannot tell them apart.
"""
_WORDS = frozenset(
    word
    for names in (*LANGUAGES.values(), *CHANNELS.values())
    for word in names
    if not word.isascii() and len(word) > 1
)
"""What a table of dynamic tests says in languages that need one of those codes."""
HEAD = 1 << 15
"""Signs of a file by which its format is told: there stand the names of columns, if it has any."""
_CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f")) + b"\x7f"


def encoding_of(head: bytes) -> str | None:
    """The encoding of a text that begins with `head`, or None if it is no text."""
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return encoding
    if b"\0" in head:
        return _wide(head)
    if head.translate(None, _CONTROL) != head:
        return None
    # The head may end within a character: an incremental decoder waits for the rest of it.
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return _older(head)
    return "utf-8"


def _older(head: bytes) -> str:
    """The code in which the text has most words of the field.

    Latin-1 where it has none in any other.
    """
    count = dict.fromkeys(("latin-1", *_OLDER), 0)
    head = head[:HEAD]
    for encoding in count:
        # The head may end within a character; what cannot be read at all has no words either.
        text = head.decode(encoding, errors="ignore").casefold()
        count[encoding] = sum(word in text for word in _WORDS)
    return max(count, key=lambda encoding: count[encoding])


def _wide(head: bytes) -> str | None:
    """UTF-16 without a mark: western text has a zero in every second byte."""
    # Not every second byte: a prime or an omega has no zero in it.
    even, odd = head[0::2], head[1::2]
    if len(odd) and odd.count(0) > 0.9 * len(odd) and not even.count(0):
        return "utf-16-le"
    if len(even) and even.count(0) > 0.9 * len(even) and not odd.count(0):
        return "utf-16-be"
    return None


def head_text(head: bytes) -> str:
    """As much of a file's beginning as is text; empty for what is none."""
    encoding = encoding_of(head)
    if encoding is None:
        return ""
    # The head may end within a character.
    return head.decode(encoding, errors="ignore")


def text_of(path: Path) -> str:
    """The whole text of a file.

    Raises
    ------
    DataError
        If it is empty, too large, no text, or cannot be read.
    """
    data = bytes_of(path)
    if not data.strip():
        raise DataError("the file is empty")
    encoding = encoding_of(data[: 1 << 16])
    # A beginning without accents is UTF-8 by any code: then the whole file tells.
    if encoding == "utf-8" and encoding_of(data) != "utf-8":
        encoding = encoding_of(data)
    if encoding is None:
        raise DataError("this is no text file; save the table as CSV in UTF-8")
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise DataError(
            f"byte {error.start} is no {encoding} text; save the table as CSV in UTF-8"
        ) from None
