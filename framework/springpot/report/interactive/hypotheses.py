"""What an answer could become, as hypotheses: each is seen before it is taken.

The model grown by each candidate, from fits that the diagnosis has already done; and what can be
done with the data themselves.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.diagnosis.ladder import Case
from springpot.errors import SpringpotError
from springpot.measurement.measurement import Measurement
from springpot.misfit.refit import refit
from springpot.registry import of_each
from springpot.rheology.model import Model
from springpot.rheology.points import Real


@dataclass(frozen=True, eq=False)
class Preview:
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


def grown_by_each(case: Case, only: Container[str] | None = None) -> Iterator[Preview]:
    """For each candidate of a diagnosis, the model that has accepted it alone, as far as known.

    Of all, or of the effects `only`.
    """
    for candidate in case.diagnosis.candidates:
        if only is not None and candidate.effect not in only:
            continue
        try:
            grown = case.grown_with(candidate.physics)
        # An effect that does not fit this model or these data has nothing to be drawn.
        except SpringpotError:
            continue
        yield Preview(candidate.effect, *grown)


@dataclass(frozen=True, eq=False)
class Act:
    """Something that can be done with the data.

    Parameters
    ----------
    name, label, says : str
        By which it is known, called, and told.
    preview : Preview
        The model as it would then be.
    used : Measurement
        The rows that would then be used.
    accept : tuple of str
        Effects that are accepted by it.
    exclude : tuple of int
        Rows that are left out by it, counted from 0 among those that were used.
    """

    name: str
    label: str
    says: str
    preview: Preview
    used: Measurement
    accept: tuple[str, ...] = ()
    exclude: tuple[int, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """What it is called, and what accepting it does."""
        names = ("name", "label", "says", "accept", "exclude")
        return {name: getattr(self, name) for name in names}


def acted(case: Case, used: Measurement) -> Iterator[Act]:
    """What can be done with the data of an answer, which was found from the rows `used`."""
    base = case.search.base
    for step in case.diagnosis.steps:
        if step.split:
            effect = of_each(step.split)
            grown = refit(base.model + effect, base.data, base.noise)
            one = Preview(effect.name, grown.model, grown.theta, True)
            label = f"split by {step.split}"
            yield Act(effect.name, label, step.says, one, used, accept=(effect.name,))
    # All at once, as the answer was found without all of them.
    rows = [row - 1 for step in case.diagnosis.steps for row in step.exclude]
    if rows:
        what, stand = f"row {rows[0] + 1}", "stands"
        if len(rows) > 1:
            what, stand = f"rows {', '.join(str(row + 1) for row in rows)}", "stand"
        stays = np.ones(len(used), dtype=bool)
        stays[rows] = False
        yield Act(
            f"without {what}",
            f"leave out {what}",
            f"{what} {stand} out: without it every fit is that of the others",
            Preview("", base.model, base.theta, True),
            used.subset(stays),
            exclude=tuple(rows),
        )
