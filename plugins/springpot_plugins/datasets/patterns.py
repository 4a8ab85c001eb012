r"""Patterns that a manifest gives for a part of a cell, such as ``Lane (\d+)``.

Only those that end soon.
"""

from __future__ import annotations

import re

from springpot.errors import DataError

LONGEST_CELL = 80
"""Signs of a cell that are searched."""
_LONGEST = 100
_MOST_CHOICES = 4
"""Repetitions and alternatives in a pattern.

With as many, the worst search of a cell takes about a second.
"""
_ONE_SIGN = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]")
"""An escape or a class, which match one sign."""


def checked(pattern: str) -> str:
    """`pattern`, if it has one group and its search cannot take for ever.

    Each repetition may end anywhere, so a search takes a power of the cell's length: with few of
    them that is little. Repeated groups, references and assertions, whose search may grow without
    such a bound, are not taken.

    Raises
    ------
    DataError
        If it has not.
    """
    if len(pattern) > _LONGEST:
        raise DataError(f"has more than {_LONGEST} signs")
    if re.search(r"\\[1-9]|\(\?", pattern):
        raise DataError("has a reference or (?...), which are not taken")
    # Without escapes and classes, whose signs repeat nothing, and with lazy repetitions as plain
    # ones.
    bare = re.sub(r"([*+?}])[?+]", r"\1", _ONE_SIGN.sub("x", pattern))
    if re.search(r"\)[*+?{]", bare):
        raise DataError("repeats a group, which is not taken")
    if len(re.findall(r"[*+?{|]", bare)) > _MOST_CHOICES:
        raise DataError(f"has more than {_MOST_CHOICES} of * + ? {{ |")
    try:
        groups = re.compile(pattern).groups
    except (re.error, OverflowError) as error:
        raise DataError(f"is wrong: {error}") from None
    if groups != 1:
        raise DataError("needs one group in parentheses")
    return pattern


def picked(pattern: str, cell: str) -> str:
    """What the group of a checked pattern finds in a cell; nothing where it is not there."""
    match = re.search(pattern, cell[:LONGEST_CELL])
    if match is None:
        return ""
    # A group that took no part in the match is None.
    return match[1] or ""
