"""The runs of a measurement: rows of one step, temperature and repeat, whatever was swept in them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Real

from .measurement import Measurement

KELVINS = 0.5
"""Neighbouring temperatures that differ by more than this belong to different runs; a slow ramp stays one."""


@dataclass(frozen=True, eq=False)
class Run:
    """Rows that were measured under one set of conditions.

    Parameters
    ----------
    conditions : dict of str to str or float
        Step, temperature (the mean) and repeat, as far as there are any.
    rows : ndarray of int
        Their numbers.
    """

    conditions: dict[str, str | float]
    rows: NDArray[np.int64]

    @property
    def name(self) -> str:
        """Such as ``temperature 20, repeat 1``; ``all`` where nothing tells the rows apart."""
        parts = [f"{k} {v}" if isinstance(v, str) else f"{k} {v:.4g}" for k, v in self.conditions.items()]
        return ", ".join(parts) or "all"


def runs_of(measurement: Measurement) -> Iterator[Run]:
    """The runs, by step in the order of the file, then by temperature and repeat."""
    keys: list[NDArray[np.int64]] = []
    step = measurement.labels.get("step")
    if step is not None:
        _, first, which = np.unique(step, return_index=True, return_inverse=True)
        keys.append(np.argsort(np.argsort(first))[which.ravel()])
    temperature = measurement.conditions.get("temperature")
    if temperature is not None:
        keys.append(_levels(temperature))
    if measurement.repeat is not None:
        keys.append(measurement.repeat)
    if not keys:
        yield Run({}, np.arange(len(measurement)))
        return
    found, which = np.unique(np.column_stack(keys), axis=0, return_inverse=True)
    for i in range(len(found)):
        rows = np.flatnonzero(which.ravel() == i)
        conditions: dict[str, str | float] = {}
        if step is not None:
            conditions["step"] = str(step[rows[0]])
        if temperature is not None:
            conditions["temperature"] = float(np.mean(temperature[rows]))
        if measurement.repeat is not None:
            conditions["repeat"] = float(measurement.repeat[rows[0]])
        yield Run(conditions, rows)


def _levels(temperature: Real) -> NDArray[np.int64]:
    """Number of the level of each temperature, in ascending order."""
    values, which = np.unique(temperature, return_inverse=True)
    return np.concatenate([[0], np.cumsum(np.diff(values) > KELVINS)])[which.ravel()].astype(np.int64)
