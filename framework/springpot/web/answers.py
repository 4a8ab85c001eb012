"""The answer to a state.

Exactly what ``springpot discover DATA --accept ...`` gives, and what is drawn of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from springpot.api import discover
from springpot.diagnosis.examination import silent
from springpot.diagnosis.ladder import Ladder
from springpot.measurement.measurement import Measurement
from springpot.report.interactive.answers import drawn

from .datatext import kept
from .state import State

SCHEMA = "springpot.workbench/1"
Told = Callable[[str], None]


def ladder_of(state: State, measurement: Measurement, told: Told = silent) -> Ladder:
    """The ladder of a state; the same bits for the same state and data.

    Raises
    ------
    SpringpotError
        If a name is unknown, or if model and data do not fit each other.
    """
    used = kept(measurement, state.excluded)
    # A list, though it may be empty: without one the evidence would accept effects by itself.
    ladder = discover(
        used, state.model or None, accept=list(state.accepted), seed=state.seed, progress=told
    )
    assert isinstance(ladder, Ladder)
    return ladder


def answer(state: State, ladder: Ladder, measurement: Measurement) -> dict[str, Any]:
    """Schema ``springpot.workbench/1``: the discovery, and K of the model and of every candidate.

    Parameters
    ----------
    state : State
        What is asked.
    ladder : Ladder
        Its ladder, see `ladder_of`.
    measurement : Measurement
        The data, all rows.

    Returns
    -------
    dict
        ``schema``, ``state``, its ``key``, and all that `springpot.report.interactive.drawn` gives.
    """
    return {
        "schema": SCHEMA,
        "state": state.to_dict(),
        "key": state.key,
        **drawn(ladder, measurement),
    }
