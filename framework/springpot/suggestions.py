"""Commands that springpot shows to be copied: each is one that it takes."""

from __future__ import annotations

from collections.abc import Iterable
from shlex import quote


def suggested(verb: str, *words: object) -> str:
    """A command of springpot as a shell takes it.

    Parameters
    ----------
    verb : str
        What stands behind ``springpot``, such as ``list models``.
    *words : object
        Data, options and their values. Those in capitals, such as ``STUDY.py``, the reader
        replaces.

    Examples
    --------
    >>> from springpot.suggestions import suggested
    >>> print(suggested("diagnose", "my gel.csv", "--model", "kelvin + inertia"))
    springpot diagnose 'my gel.csv' --model 'kelvin + inertia'
    """
    return " ".join(["springpot", verb, *map(in_shell, words)])


def in_shell(word: object) -> str:
    """A word as a shell takes it."""
    return quote(str(word))


def with_model(model: str | None) -> list[str]:
    """The words that name a model, if there is one."""
    if model is None:
        return []
    return ["--model", model]


def accepting(effects: Iterable[str]) -> list[str]:
    """The words that accept effects one after the other."""
    return [word for effect in effects for word in ("--accept", effect)]
