"""Times of day and timestamps with a date, as data loggers write them, in seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from functools import lru_cache

from springpot.errors import DataError
from springpot.measurement import Choice

from .channels import found_in

_TIME = r"(\d{1,2}):(\d{2})(?::(\d{2})(?:[.,](\d+))?)?\s*([AaPp][Mm])?"
_DATE = r"(\d{1,4})[-./](\d{1,2})[-./](\d{1,4})"
_DATED = re.compile(rf"\s*{_DATE}[T\s,]+{_TIME}\s*(?:Z|[+-]\d{{2}}:?\d{{2}})?\s*\Z")
_OF_DAY = re.compile(rf"\s*{_TIME}\s*\Z")


_RATE = re.compile(
    r"(?:sampl\w*[ _-]?(?:rate|freq\w*)|abtast(?:rate|frequenz)|messrate"
    r"|fréquence d.échantillonnage)"
    r"[\s:;,=\t\"]{1,8}(?:[\[(](?P<before>k?Hz)[\])][\s:;,=\t]*)?"
    r"(?P<number>\d+(?:[.,]\d+)?)[\s;,\t\"]*(?P<unit>k?Hz|1/s|S/s)?",
    re.IGNORECASE,
)
"""A line of a header such as ``Sample rate: 400 Hz`` or ``Abtastrate [Hz];400``."""
_SAID = re.compile(r"(\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)\s*\[?\s*(k?Hz|1/s|)\s*\]?\Z")
RATE = "rate"
"""What a user says of signals without a column of time: ``FILE?rate=400[Hz]``."""


def sample_rate(choice: Choice, head: str, titles: Sequence[str]) -> tuple[float | None, Choice]:
    """Samples a second where time is counted by them, and the choice without what it says of them.

    Parameters
    ----------
    choice : Choice
        What the user says.
    head : str
        The beginning of the file.
    titles : sequence of str
        Names of the columns.

    Raises
    ------
    DataError
        If what the user says is no rate.
    """
    said = choice.columns.get(RATE)
    if said is not None:
        match = _SAID.match(said)
        if match is None or not float(match[1]) > 0:
            raise DataError(f"'{said:.20}' is no sample rate; write 'FILE?{RATE}=400[Hz]'")
        others = {name: meaning for name, meaning in choice.columns.items() if name != RATE}
        return _hertz(match[1], match[2]), replace(choice, columns=others)
    named = found_in(titles)
    if choice.columns or "time" in named or not named >= {"displacement", "force"}:
        return None, choice
    stated = _RATE.search(head)
    unit = ""
    if stated is not None:
        unit = stated["before"] or stated["unit"] or ""
    if stated is None or not unit or not float(stated["number"].replace(",", ".")) > 0:
        return None, choice
    return _hertz(stated["number"], unit), choice


def _hertz(number: str, unit: str) -> float:
    rate = float(number.replace(",", "."))
    if unit.casefold().startswith("k"):
        return 1000.0 * rate
    return rate


def seconds_of(cell: str) -> float | None:
    """Seconds of a timestamp since some moment that is the same for all of one style.

    None for what is no timestamp.

    Examples
    --------
    >>> seconds_of("01.09.2014 13:25:39,5") - seconds_of("01.09.2014 13:25:38")
    1.5
    """
    if match := _OF_DAY.match(cell):
        return _of_day(*match.groups())
    match = _DATED.match(cell)
    if match is None:
        return None
    day = _day(match[1], match[2], match[3])
    if day is None:
        return None
    return day * 86400.0 + _of_day(*match.groups()[3:])


@lru_cache(maxsize=64)
def _day(first: str, second: str, third: str) -> int | None:
    """Number of the day.

    Year first, or else last with the month in the middle unless it can be none.
    """
    year, month, day = int(third), int(second), int(first)
    if len(first) == 4:
        year, day = int(first), int(third)
    if month > 12:
        # Written the American way; a date that may be either is read as the rest of the world
        # writes it.
        month, day = day, month
    if year < 100:
        # Two digits are of this century: only differences are used, but there is no year 0.
        year += 2000
    try:
        return datetime(year, month, day).toordinal()
    except ValueError:
        return None


def _of_day(
    hour: str, minute: str, second: str | None, fraction: str | None, half: str | None
) -> float:
    hours = int(hour)
    if half:
        # 12 am is midnight, and 12 pm is noon.
        hours %= 12
        if half.lower() == "pm":
            hours += 12
    return hours * 3600.0 + int(minute) * 60.0 + float(f"{second or 0}.{fraction or 0}")
