"""Errors that a user can mend: one line each, safe on a terminal, and whose fault it is.

Names of files, labels, and whatever a file or manifest says of itself may hold ESC and other
control signs, by which a terminal moves its cursor, changes its title or takes commands; or signs
that turn the direction of writing: they are shown, never sent. What a plugin raised is told with
its name; the host of plugins puts its answers here, so that no room below imports it.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import walk_tb
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


LONGEST_REASON = 300
"""Signs of a reason that are kept: the message of an error may hold whole arrays."""


class SpringpotError(Exception):
    """Something the user gave cannot be used: one line that says what, where and how to mend it."""

    def __str__(self) -> str:
        # Names of files and words in them come from strangers, and an error ends on a terminal.
        return plain(super().__str__())


class DataError(SpringpotError):
    """A file, data set or column cannot be used."""


class ModelError(SpringpotError):
    """A model, effect or expression is unknown or does not fit the data."""


class PluginError(SpringpotError):
    """A plugin is missing, faulty or clashes with another."""


class OutputError(SpringpotError):
    """A result cannot be written where it was wanted, or a library needed for it is missing."""


class OptionError(SpringpotError):
    """An option of an optimiser or of a run is out of its range."""


class StudyError(SpringpotError):
    """A study, its script or its store cannot be used."""


def _nobody(*_: str) -> str:
    return ""


_by_name: Callable[[str, str], str] = _nobody
_by_module: Callable[[str], str] = _nobody


def use_owners(by_name: Callable[[str, str], str], by_module: Callable[[str], str]) -> None:
    """Let these tell the plugin of a kind and name, and of a module, from now on.

    Empty for springpot's own.
    """
    global _by_name, _by_module
    _by_name, _by_module = by_name, by_module


def owner_of(word: str, name: str) -> str:
    """The plugin that offers a thing of that kind and name.

    Empty for springpot's own and where nobody knows.
    """
    return _by_name(word, name)


def owned(word: str, name: str) -> str:
    """A thing with its plugin, such as ``effect 'sag' of plugin 'bridges' of bridge-lab``.

    Parameters
    ----------
    word : str
        Its kind, such as ``effect``.
    name : str
        Its name.
    """
    thing, owner = f"{word} '{name}'", _by_name(word, name)
    if owner:
        thing += f" of {owner}"
    return thing


def blamed(error: BaseException) -> str:
    """What to say of an error that was raised in a plugin or in what it called.

    Nothing if it was not.
    """
    told = ""
    # The last frame of a plugin: those after it are of what it called, those before it called the
    # plugin.
    for frame, line in walk_tb(error.__traceback__):
        owner = _by_module(frame.f_globals.get("__name__", ""))
        if owner:
            place = f"{Path(frame.f_code.co_filename).name}, line {line}"
            told = f"{owner} failed: {described(error)} ({place})"
    return told


def described(error: BaseException) -> str:
    """Kind of an error, and its message if there is one."""
    text = type(error).__name__
    if str(error):
        text += f": {error}"
    return text
