"""Amplitudes counted from trough to crest, as test machines often do, not from the middle."""

from __future__ import annotations

from collections.abc import Sequence

from .grid import is_number
from .peaks import says_whole_swing, without_peak
from .titles import Heading
from .written import value_of

SWINGING = ("amplitude", "force_amplitude")
"""What may be counted either way."""


def counts_whole_swing(heading: Heading) -> bool:
    """Whether the title or the unit of an amplitude says that it counts from trough to crest."""
    return says_whole_swing(heading.title) or says_whole_swing(heading.unit or "")


def unit_of_amplitude(unit: str | None) -> str | None:
    """The unit without what says from where it counts: ``mm`` of ``mm pk-pk``."""
    if unit is None:
        return None
    # A unit that is nothing else, such as "pp", is told as it stands.
    return without_peak(unit) or unit


def halved(cells: Sequence[str]) -> list[str]:
    """Half of each number."""
    return list(map(_half, cells))


def _half(cell: str) -> str:
    if not is_number(cell):
        # A gap or a slip is told later, as it stands in the file.
        return cell
    return repr(value_of(cell) / 2)
