"""A first look at data, some tenths of a second after they were dropped.

How far the model lies from them, what noise and any material would leave, and where it fails. What
may be missing is sought meanwhile.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.comparison.comparing import compare
from springpot.measurement.measurement import Measurement
from springpot.registry import parse_model
from springpot.report.interactive.answers import drawn_at_once

from .sessions import State, kept

FEW = 100
"""Rows that are looked at, evenly many of all: more would take longer than a first look may."""
SAYS = "what may be missing is being sought"


def first_look(state: State, measurement: Measurement) -> dict[str, Any]:
    """An answer as `springpot.web.tasks.answer`, without a single cause."""
    used = kept(measurement, state.excluded)
    if len(used) > FEW:
        rows = np.zeros(len(used), dtype=bool)
        rows[np.linspace(0, len(used) - 1, FEW).round().astype(int)] = True
        used = used.subset(rows)
    model = parse_model(state.expression)
    [judged] = compare(used, [model], np.random.default_rng(state.seed)).judgements
    error = judged.error.to_dict()
    rung = {"model": model.name, "accepted": None, "class": [], **error}
    diagnosis = {
        "model": model.name,
        "verdict": "sought",
        "says": SAYS,
        "error": error,
        "where": [place.to_dict() for place in judged.where],
        "candidates": [],
        "leading": [],
        "next_experiment": None,
    }
    return {
        "state": state.to_dict(),
        "discovery": {"steps": [rung], "verdict": "sought", "diagnosis": diagnosis},
        **drawn_at_once(judged.refit, measurement),
    }
