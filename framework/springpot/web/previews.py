"""What each candidate would make of the curve, from fits that the diagnosis has already done.

This is the only file of the room that looks behind a diagnosis: into the `Case` of a step of a ladder.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from springpot.diagnosis import Case
from springpot.errors import SpringpotError
from springpot.rheology import Model, Real


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
    """For each candidate of a diagnosis, the model as accepting it alone would make it, as far as it is known."""
    alone = {one.names[0]: one.refit for one in reversed(case.search.grown) if len(one.effects) == 1}
    scanned = {score.influence.effect.name: score for score in case.search.scan.scores}
    base = case.search.base.model
    for candidate in case.diagnosis.candidates:
        name = candidate.effect
        if name in alone:
            yield Grown(name, alone[name].model, alone[name].theta, True)
            continue
        score = scanned.get(name)
        if score is None or not len(score.starts):
            continue
        try:
            model = (base + score.influence.effect).bound_to(case.search.base.fit.measurement.points)
        except SpringpotError:
            continue
        if len(score.starts[0]) == len(model.parameters):
            yield Grown(name, model, score.starts[0], False)
