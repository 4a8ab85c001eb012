"""Words by which an amplitude says from where it is counted.

From trough to crest, or from the middle.
"""

from __future__ import annotations

import re

_WHOLE_SWING = re.compile(
    # A title's underscore parts words as a blank does, and in a tidied unit "p-p" has become "p p".
    r"(?<![^\W_])(?:pk|peak)[\s_-]*(?:to)?[\s_-]*(?:pk|peak)(?![^\W_])|(?<![^\W_])p[\s_]*[-/\s_][\s_]*p(?![^\W_])"
    # In capitals PP may be polypropylene, the name of a curve.
    r"|(?<![^\W_])pp$|(?<![^\W_])(?-i:pp)(?![^\W_])|(?<=mm)pp|両振幅|全振幅|双振幅"
    r"|\bdouble[\s_]amplitude|\bdoppelamplitude|cr[êe]te[\s-]+(?:à|a)[\s-]+cr[êe]te|spitze[\s-]*(?:zu)?[\s-]*spitze",
    re.IGNORECASE,
)
_FROM_ZERO = re.compile(
    r"(?<![^\W_])(?:0|zero)[\s_-]*(?:to)?[\s_-]*(?:pk|peak|p)(?![^\W_])|±|\+/-", re.IGNORECASE
)
_PEAK = re.compile(r"\b(?:pk|peak)\b(?![\s-]*(?:to|pk|peak))", re.IGNORECASE)
_LEFT = re.compile(r"[\[(]\s*[\])]")
"""Brackets that held nothing else."""


def says_whole_swing(text: str) -> bool:
    """Whether a text says that an amplitude counts from trough to crest."""
    return bool(_WHOLE_SWING.search(text))


def without_swing(title: str) -> str:
    """A title without the words that say plainly from where an amplitude counts.

    A mere "peak" stays: the peak of a strain may have a static part.
    """
    return _tidied(_FROM_ZERO.sub(" ", _WHOLE_SWING.sub(" ", title)))


def without_peak(unit: str) -> str:
    """A unit without all of these words: ``mm`` of ``mm pk-pk`` and of ``mm peak``."""
    return _PEAK.sub("", _FROM_ZERO.sub("", _WHOLE_SWING.sub("", unit))).strip(" -()")


def _tidied(title: str) -> str:
    return " ".join(_LEFT.sub(" ", title).split()).strip(" -_")
