"""Time signals in LabVIEW TDMS files, through npTDMS.

Channels by name, units from their properties.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np

from springpot.errors import DataError
from springpot.measurement import (
    Choice,
    Signals,
    budget_of,
)
from springpot.rheology import Real

from .channels import channel_of, places_of, reader_of_signals, signals_from

_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "units")
_SAMPLE = 8
"""Bytes of a number."""


def recognises(head: bytes) -> float:
    """High for the first four bytes of a TDMS segment."""
    return float(head.startswith(b"TDSm"))


def signals(path: Path, choice: Choice) -> Signals:
    """The signals in a file; time from a channel of that name or from the sampling interval.

    Raises
    ------
    DataError
        If npTDMS is not installed, the file is broken, or a channel or its unit is missing.
    """
    try:
        from nptdms import TdmsFile
        from nptdms.log import log_manager
    except ImportError:
        raise DataError("TDMS files need npTDMS: pip install 'springpot[instruments]'") from None
    # What npTDMS would print of a file that is cut off is said by the error, or does no harm.
    log_manager.set_level(logging.CRITICAL)
    try:
        with TdmsFile.open(path) as file:
            return _signals(file, choice, path)
    except (DataError, MemoryError):
        raise
    except Exception as error:
        # Broken files fail within npTDMS in many ways.
        reason = (str(error).splitlines() or [""])[0]
        raise DataError(f"no readable TDMS file: {type(error).__name__}: {reason:.80}") from None


def _signals(file: Any, choice: Choice, path: Path) -> Signals:
    channels: list[Any] = []
    for group in file.groups():
        channels += filter(len, group.channels())
    most = budget_of(path).memory // _SAMPLE
    # Before any is read: a broken index claims any length.
    if any(not 0 <= len(channel) <= most for channel in channels):
        raise DataError("a channel claims more samples than the file can hold")
    titles = [str(channel.name) for channel in channels]
    units = [
        next((str(c.properties[key]) for key in _UNIT_KEYS if key in c.properties), "")
        for c in channels
    ]
    if not any(channel_of(title)[0] == "time" for title in titles):
        # LabVIEW writes the interval of a waveform as a property, and no channel of times.
        timed = next(
            (c for c in channels if float(c.properties.get("wf_increment", 0) or 0) > 0), None
        )
        if timed is not None:
            channels, titles, units = [*channels, timed], [*titles, "time"], [*units, "s"]
    places = places_of(titles, units, choice)
    made = [_values(channels[i], titles[i], i >= len(set(channels))) for i in places.columns]
    length = min(map(len, made))
    return signals_from([values[:length] for values in made], places, path, "TDMS")


def _values(channel: Any, title: str, is_clock: bool) -> Real:
    if is_clock:
        step, start = (
            float(channel.properties["wf_increment"]),
            float(channel.properties.get("wf_start_offset", 0)),
        )
        return np.asarray(start + step * np.arange(len(channel)), dtype=float)
    values = np.asarray(channel[:])
    if values.dtype.kind == "M":
        return np.asarray((values - values[0]) / np.timedelta64(1, "s"), dtype=float)
    if values.dtype.kind not in "fiu":
        raise DataError(f"channel '{title:.40}' holds no numbers")
    return values.astype(float)


READER = reader_of_signals(
    "signals-tdms",
    "LabVIEW TDMS with channels of time (or a sampling interval), displacement and force",
    recognises,
    signals,
)
