"""What a store gives back: its problems, cells and trials."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from .trace import unpack, unpack_values
from .trial import TrialResult


@dataclass(frozen=True)
class ProblemRow:
    """What the store knows of one problem."""

    id: int
    dataset: str
    kind: str
    points: int
    stiffness_unit: str
    model: str
    objective: str
    reference: float
    known: float | None
    truth: Mapping[str, float]


@dataclass(frozen=True)
class CellRow:
    """One problem and one entrant."""

    id: int
    problem: ProblemRow
    label: str
    optimiser: str
    options: str
    budget: int


@dataclass(frozen=True, slots=True)
class TrialRow(TrialResult):
    """One finished trial as the store has it.

    Its cell by the store's number, its parameters empty if it failed.
    """

    theta: Mapping[str, float] = field(default_factory=dict)

    @property
    def theta_text(self) -> str | None:
        """Its parameters as JSON, None if it failed."""
        if not self.theta:
            return None
        return json.dumps(self.theta)

    def improvements(self) -> tuple[NDArray[np.int64], Real]:
        """Evaluation numbers (n,) and objectives (n,) of the improvements."""
        return unpack(self.trace)

    def recommendations(self) -> tuple[NDArray[np.int64], Real] | None:
        """Evaluation numbers (n,) and noise-free objectives (n,) of what was best at the time.

        May rise.

        None where the truth is unknown or was not kept.
        """
        if self.recommended is None:
            return None
        evaluations, values = self.improvements()
        if self.recommended:
            values = unpack_values(self.recommended)
        return evaluations, values

    def oracle_trace(self) -> tuple[NDArray[np.int64], Real] | None:
        """Evaluation numbers (n,) and values (n,) of the best noise-free objective evaluated.

        None where the truth is unknown or was not kept.
        """
        if self.seen is None:
            return None
        # Of exact data it is kept empty: there the objective itself has no noise.
        if not self.seen:
            return self.improvements()
        return unpack(self.seen)
