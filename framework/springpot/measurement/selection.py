"""Rows of a measurement, chosen or left out by what was set: ``temperature=20``, ``frequency=1..10``, ``row=3``."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.rheology import Real

from .measurement import Measurement

KELVINS = 0.5
"""Temperatures that agree to this belong to one choice."""
CLOSE = {"amplitude": 0.05}
"""Relative agreement of a condition, where it is coarser than one per cent."""
SHOWN = 12
"""Values listed where none fits; of more the first ones and the last."""
EXAMPLE = "temperature=20,amplitude=1 or frequency=1..10"


def conditions(text: str, where: str) -> dict[str, str]:
    """Conditions and their values, of text such as ``temperature=20,frequency=1..10``.

    Parameters
    ----------
    text : str
        The conditions, with commas between them.
    where : str
        What they stand in, for the message.

    Raises
    ------
    DataError
        If a part of it is none.
    """
    wanted = {}
    for part in text.split(","):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not (key and equals and value):
            raise DataError(f"'{where}': write conditions as {EXAMPLE}")
        wanted[key] = value
    return wanted


def select(measurement: Measurement, wanted: Mapping[str, str]) -> Measurement:
    """The rows that have all the wanted conditions.

    Parameters
    ----------
    measurement : Measurement
        The data.
    wanted : mapping of str to str
        Condition, label, ``repeat``, ``frequency`` in Hz, ``omega`` in rad/s or ``row`` (the first is 1), and its
        value or range: ``1..10``, ``..10`` or ``1..``, ends included. Numbers match within 0.5 K for ``temperature``,
        5 % for ``amplitude`` and 1 % otherwise; words match whole, or by their beginning.

    Raises
    ------
    DataError
        If there is no such column or value, with those that there are.
    """
    rows = _together(measurement, wanted)
    if not rows.any():
        chosen = ", ".join(f"{key}={value}" for key, value in wanted.items())
        raise DataError(f"{measurement.name}: no row has {chosen} together")
    chosen = ",".join(f"{key}={value}" for key, value in wanted.items())
    return measurement.subset(rows, f"{measurement.name}@{chosen}")


def without(measurement: Measurement, unwanted: Mapping[str, str]) -> Measurement:
    """The rows that lack one of the conditions, as part of the same data; see `select`.

    Raises
    ------
    DataError
        If there is no such column or value, or nothing would be left.
    """
    rows = ~_together(measurement, unwanted)
    if not rows.any():
        raise DataError(f"{measurement.name}: nothing would be left")
    return measurement.subset(rows)


def _together(measurement: Measurement, wanted: Mapping[str, str]) -> NDArray[np.bool_]:
    """Rows that have all the wanted conditions."""
    rows = np.ones(len(measurement), dtype=bool)
    for key, value in wanted.items():
        rows &= _matching(measurement, key, value)
    return rows


def _matching(measurement: Measurement, key: str, value: str) -> NDArray[np.bool_]:
    if key in measurement.labels:
        return _matching_words(measurement, key, value)
    column = _column(measurement, key)
    if ".." in value:
        return _between(measurement, key, value, column)
    number = _number(measurement, key, value)
    reach = CLOSE.get(key, 0.01) * abs(number)
    if key == "temperature":
        reach = KELVINS
    elif key == "row":
        reach = 0.0
    rows: NDArray[np.bool_] = np.abs(column - number) <= reach * (1 + 1e-9)
    if not rows.any():
        known = np.unique([float(f"{v:.3g}") for v in np.unique(column[np.isfinite(column)])])
        raise DataError(
            f"{measurement.name}: no {key} near {value} (there are: {_listed([f'{v:g}' for v in known])})"
        )
    return rows


def _column(measurement: Measurement, key: str) -> Real:
    """The numbers that a condition stands for."""
    own = {
        "frequency": measurement.frequency,
        "omega": measurement.omega,
        "row": np.arange(1.0, len(measurement) + 1.0),
        **measurement.conditions,
    }
    if measurement.repeat is not None:
        own["repeat"] = measurement.repeat.astype(float)
    if key not in own:
        there = [
            *measurement.conditions,
            *measurement.labels,
            *(["repeat"] if measurement.repeat is not None else []),
        ]
        raise DataError(f"{measurement.name} has no condition '{key}' (there are: {', '.join(there) or 'none'})")
    return own[key]


def _between(measurement: Measurement, key: str, value: str, column: Real) -> NDArray[np.bool_]:
    """Rows between two ends, either of which may be left open."""
    first, _, last = value.partition("..")
    low = _number(measurement, key, first) if first.strip() else -np.inf
    high = _number(measurement, key, last) if last.strip() else np.inf
    slack = 1e-9 * float(np.max(np.abs(column)))  # a frequency in Hz was once rad/s, and ends are included
    rows: NDArray[np.bool_] = (column >= low - slack) & (column <= high + slack)
    if not rows.any():
        least, most = float(np.min(column)), float(np.max(column))
        raise DataError(f"{measurement.name}: no {key} in {value} (there are {least:.4g} to {most:.4g})")
    return rows


def _number(measurement: Measurement, key: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise DataError(f"{measurement.name}: {key}={value} is no number or range such as 1..10") from None


def _matching_words(measurement: Measurement, key: str, value: str) -> NDArray[np.bool_]:
    column = measurement.labels[key]
    known = [str(word) for word in np.unique(column)]
    low = value.lower()
    exact = [word for word in known if word.lower() == low]
    begins = [word for word in known if re.match(re.escape(low) + r"(?!\w)", word.lower())]
    within = [word for word in known if low in word.lower()]
    found = exact or begins or within
    if len(found) != 1:
        many = f"several values of {key} match '{value}'" if found else f"no {key} '{value}'"
        raise DataError(f"{measurement.name}: {many} (there are: {_listed(found or known)})")
    return np.asarray(column == found[0])


def _listed(values: list[str]) -> str:
    shown = values if len(values) <= SHOWN else [*values[: SHOWN - 2], "...", values[-1]]
    return ", ".join(shown)
