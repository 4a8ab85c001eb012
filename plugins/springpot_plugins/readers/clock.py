"""Times of day and timestamps with a date, as data loggers write them, in seconds."""

from __future__ import annotations

import re
from datetime import datetime
from functools import lru_cache

_TIME = r"(\d{1,2}):(\d{2})(?::(\d{2})(?:[.,](\d+))?)?\s*([AaPp][Mm])?"
_DATE = r"(\d{1,4})[-./](\d{1,2})[-./](\d{1,4})"
_DATED = re.compile(rf"\s*{_DATE}[T\s,]+{_TIME}\s*(?:Z|[+-]\d{{2}}:?\d{{2}})?\s*\Z")
_OF_DAY = re.compile(rf"\s*{_TIME}\s*\Z")


def seconds_of(cell: str) -> float | None:
    """Seconds of a timestamp since some moment that is the same for all of one style; None for what is no timestamp.

    Examples
    --------
    >>> seconds_of("01.09.2014 13:25:39,5") - seconds_of("01.09.2014 13:25:38")
    1.5
    """
    if match := _DATED.match(cell):
        day = _day(match[1], match[2], match[3])
        return None if day is None else day * 86400.0 + _of_day(*match.groups()[3:])
    match = _OF_DAY.match(cell)
    return _of_day(*match.groups()) if match else None


@lru_cache(maxsize=64)
def _day(first: str, second: str, third: str) -> int | None:
    """Number of the day: year first, or else last with the month in the middle unless it can be none."""
    numbers = (first, second, third) if len(first) == 4 else (third, second, first)
    year, month, day = map(int, numbers)
    if month > 12:
        month, day = day, month
    try:
        return datetime(year + (2000 if year < 100 else 0), month, day).toordinal()
    except ValueError:
        return None


def _of_day(hour: str, minute: str, second: str | None, fraction: str | None, half: str | None) -> float:
    hours = int(hour)
    if half:
        hours = hours % 12 + (12 if half.lower() == "pm" else 0)
    return hours * 3600.0 + int(minute) * 60.0 + float(f"{second or 0}.{fraction or 0}")
