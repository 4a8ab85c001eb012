"""What each candidate would make of the curve, from fits that the diagnosis has already done."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from springpot.diagnosis.examination import Case
from springpot.errors import SpringpotError
from springpot.rheology.model import Model
from springpot.rheology.points import Real


@dataclass(frozen=True, eq=False)
class Grown:
    """The present model with one more effect.

    Parameters
    ----------
    effect : str
        Its name.
    model : Model
        The grown model.
    theta : ndarray, shape (p,)
        Its parameters: refitted, or where the scan puts them.
    refitted : bool
        Which of these.
    """

    effect: str
    model: Model
    theta: Real
    refitted: bool


def grown_by_each(case: Case) -> Iterator[Grown]:
    """For each candidate of a diagnosis, the model that has accepted it alone, as far as known."""
    for candidate in case.diagnosis.candidates:
        try:
            grown = case.grown_with(candidate.physics)
        # An effect that does not fit this model or these data has nothing to be drawn.
        except SpringpotError:
            continue
        yield Grown(candidate.effect, *grown)
