"""Text from strangers on a terminal: signs that command it are shown, never sent.

Names of files, labels, and whatever a file or manifest says of itself may hold ESC and other
control signs, by which a terminal moves its cursor, changes its title or takes commands; or signs
that turn the direction of writing.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

_COMMANDS = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""C0 without tab and line end, DEL, C1, the signs of direction (Unicode's Bidi_Control), and halves
of characters.
"""


def plain(text: str) -> str:
    r"""`text` with every sign that a terminal would obey written out, as ``\x1b`` for ESC."""
    return _COMMANDS.sub(lambda sign: sign[0].encode("unicode_escape").decode(), text)


def plain_json(text: str) -> str:
    """JSON with the same signs as JSON's own escapes, so that it still means the same."""
    # All of them lie below U+10000, where one escape of four digits is enough.
    return _COMMANDS.sub(lambda sign: f"\\u{ord(sign[0]):04x}", text)


STDERR = 2


class LostStream(OSError):
    """What is printed goes nowhere, as on a disk that is full: no fault of who prints it."""


class PlainStream:
    """A stream to a terminal or file that shows such signs; all else is left to the stream below.

    Parameters
    ----------
    stream : TextIO
        The stream below.
    """

    def __init__(self, stream: TextIO) -> None:
        self.below = stream

    def write(self, text: str) -> int:
        """Write `text`, with its commands shown."""
        with _lost(self.below):
            self.below.write(plain(text))
        # The length of what was handed in: whoever asks wants to know whether all of it was
        # written.
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write them one after the other."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Hand over what was written."""
        with _lost(self.below):
            self.below.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.below, name)


@contextmanager
def _lost(stream: TextIO) -> Iterator[None]:
    """Tell a stream that cannot be written from whatever else goes wrong with files."""
    try:
        yield
    # Nobody reads on, which is another thing and no loss.
    except BrokenPipeError:
        raise
    except OSError as error:
        if stream.fileno() != STDERR:
            raise LostStream(
                error.errno, f"cannot write what is printed: {error.strerror or error}"
            ) from error
        # Nobody can be told, and the answer goes elsewhere: what waits to be written is let go with
        # it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), STDERR)


def below(stream: TextIO) -> TextIO:
    """The stream itself, for those who command the terminal and clean their texts themselves."""
    if isinstance(stream, PlainStream):
        return stream.below
    return stream


@contextmanager
def plain_streams() -> Iterator[None]:
    """Let nothing that is printed command the terminal."""
    # From below: a command may run others, and each asks for streams like these.
    had = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (cast(TextIO, PlainStream(below(stream))) for stream in had)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = had
