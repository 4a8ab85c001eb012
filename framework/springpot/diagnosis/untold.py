"""Effects of an amplitude that no column tells.

At one amplitude some of them are the curve of an effect that needs none: dry friction is a constant
loss, as hysteresis in a structure is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from springpot.identification.held_material import is_passive
from springpot.rheology.effect import Effect

from .scan import PARALLEL, Directions, applicable, influence

if TYPE_CHECKING:
    from .grown import Search

COLUMN = "amplitude"


@dataclass(frozen=True)
class Untold:
    """Effects in whose place another one is named, as their amplitude is not known.

    Attributes
    ----------
    effect : str
        The one that is named.
    others : tuple of str
        Those that may be it as well.
    """

    effect: str
    others: tuple[str, ...]

    @property
    def says(self) -> str:
        """As the last of a row of names."""
        names = " or ".join(self.others)
        return f"{names}, the same curve at one {COLUMN}, which no column tells"


def untold_in_place(search: Search, library: Sequence[Effect]) -> Untold | None:
    """The effect of the best grown model whose curve effects of an untold amplitude have too.

    None where the amplitude is told, or nothing is alike. A part of a material is one whatever the
    amplitude: nobody looks for a spring that stiffens where a spring is missing.

    Parameters
    ----------
    search : Search
        A finished search.
    library : sequence of Effect
        All that may be missing.
    """
    base, data = search.base, search.base.fit.measurement
    if COLUMN in data.conditions or not search.grown:
        return None
    held = replace(data, conditions={**data.conditions, COLUMN: np.ones(len(data))})
    # Of one parameter, its size: a law of more makes nearly any curve.
    others = [
        effect
        for effect in applicable(library, held)
        if COLUMN in effect.needs and len(effect.element.parameters) == 1
    ]
    frame = search.frame
    for named in [effect for effect in search.grown[0].effects if not is_passive(effect)]:
        at = influence(base.model, base.theta, base.stiffness, named, data)
        own = Directions.of(frame, at).unit
        alike = []
        # A rarer one is no reason to doubt: a clock is wrong more often than a joint has play.
        for other in [effect for effect in others if effect.prior >= named.prior]:
            there = influence(base.model, base.theta, base.stiffness, other, held)
            unit = Directions.of(frame, there).unit
            if np.max(own.T @ unit, initial=0.0) > PARALLEL:
                alike.append(other.name)
        if alike:
            return Untold(named.name, tuple(alike))
    return None
