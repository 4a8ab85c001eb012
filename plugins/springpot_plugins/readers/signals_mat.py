"""Time signals in MATLAB files (version 7 and before).

Vectors named as in CSV, or the columns of one matrix.

Their names carry the units (``t_s``, ``disp_mm``, ``force_N``), or the user says them:
``FILE?t=s,x=mm,F=N``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import (
    Choice,
    Signals,
    budget_of,
    bytes_of,
)

from .channels import places_of, reader_of_signals, signals_from
from .matfile import HEADER, BrokenFile, arrays_in

MOST_CHANNELS = 64
"""Columns of a matrix at most: a larger one is no table of signals."""


def recognises(head: bytes) -> float:
    """High for the first line of a MATLAB file."""
    return float(head.startswith(b"MATLAB ") and len(head) >= HEADER)


def signals(path: Path, choice: Choice) -> Signals:
    """The signals in a file.

    Raises
    ------
    DataError
        If the file is of version 7.3, broken, unpacks to too much, or lacks a channel or its unit.
    """
    columns = _columns(_arrays(path))
    if not columns:
        raise DataError("no vectors of numbers; save t_s, disp_mm and force_N from MATLAB with -v7")
    titles = list(columns)
    places = places_of(titles, [], choice)
    chosen = [columns[titles[i]] for i in places.columns]
    if len({len(values) for values in chosen}) > 1:
        lengths = ", ".join(f"{titles[i]}: {len(columns[titles[i]])}" for i in places.columns)
        raise DataError(f"time, displacement and force differ in length ({lengths})")
    return signals_from(chosen, places, path, "MATLAB")


def _arrays(path: Path) -> dict[str, NDArray[np.float64]]:
    content = bytes_of(path)
    if content.startswith(b"MATLAB 7.3"):
        raise DataError("MATLAB 7.3 files are HDF5; save it with -v7, or as CSV")
    try:
        return arrays_in(content, budget_of(path).memory)
    except BrokenFile as error:
        raise DataError(f"no readable MATLAB file: {error}") from None


def _columns(arrays: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Vectors by name, those in a structure by the names of its fields.

    Columns of a matrix by name and number.
    """
    vectors: dict[str, NDArray[np.float64]] = {}
    for name, array in arrays.items():
        key = name.rpartition(".")[2]
        flat = array.reshape([size for size in array.shape if size != 1] or [1], order="F")
        if flat.size < 2:
            continue
        if flat.ndim == 1:
            vectors.setdefault(key, flat)
        elif flat.ndim == 2 and min(flat.shape) <= MOST_CHANNELS:
            tall = flat
            if flat.shape[0] < flat.shape[1]:
                # Samples are more than channels, whichever way they were saved.
                tall = flat.T
            vectors |= {f"{key}:{i}": tall[:, i - 1] for i in range(1, tall.shape[1] + 1)}
    return vectors


READER = reader_of_signals(
    "signals-mat",
    "MATLAB .mat (to version 7) with vectors of time, displacement and force",
    recognises,
    signals,
)
