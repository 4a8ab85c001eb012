"""Whose a thing or a fault is.

The host of plugins puts its answers here, so that no room below imports it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from traceback import walk_tb


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
