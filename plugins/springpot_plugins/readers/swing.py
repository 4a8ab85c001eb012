"""Amplitudes that are counted from trough to crest, as test machines often do, rather than from the middle."""

from __future__ import annotations

import re
from collections.abc import Sequence

from .grid import is_number
from .titles import Heading
from .written import value_of

SWINGING = ("amplitude", "force_amplitude")
"""What may be counted either way."""
_WHOLE_SWING = re.compile(
    r"\b(?:pk|peak)[\s-]*(?:to)?[\s-]*(?:pk|peak)\b|\bp(?:\s*-\s*)?p\b|\bpp$|(?<=mm)pp|両振幅|全振幅|双振幅"
    r"|\bdouble amplitude|\bdoppelamplitude|cr[êe]te[\s-]+(?:à|a)[\s-]+cr[êe]te|spitze[\s-]*spitze",
    re.IGNORECASE,
)
_FROM_MIDDLE = re.compile(
    r"\b(?:0|zero)[\s-]*(?:to)?[\s-]*(?:pk|peak|p)\b|\b(?:pk|peak)\b(?![\s-]*(?:to|pk|peak))", re.IGNORECASE
)


def counts_whole_swing(heading: Heading) -> bool:
    """Whether the title or the unit of an amplitude says that it counts from trough to crest."""
    return bool(_WHOLE_SWING.search(heading.title) or _WHOLE_SWING.search(heading.unit or ""))


def unit_of_amplitude(unit: str | None) -> str | None:
    """The unit without what says from where it counts: ``mm`` of ``mm pk-pk``."""
    if unit is None:
        return None
    # A unit that is nothing else, such as "pp", is told as it stands.
    return _FROM_MIDDLE.sub("", _WHOLE_SWING.sub("", unit)).strip(" -()") or unit


def halved(cells: Sequence[str]) -> list[str]:
    """Half of each number."""
    return list(map(_half, cells))


def _half(cell: str) -> str:
    if not is_number(cell):
        # A gap or a slip is told later, as it stands in the file.
        return cell
    return repr(value_of(cell) / 2)
