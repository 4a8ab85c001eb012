"""The search among sets of effects, whichever tests they are asked of.

Of several effects a first one takes the room of the others, so that one after the other leads
astray. A set has neighbours: one effect more, one less, another one or two in the place of one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

from springpot.thresholds import SEARCH


class OneSet(Protocol):
    """Effects that were fitted together."""

    @property
    def key(self) -> tuple[str, ...]:
        """Their names in alphabetical order."""
        ...


S = TypeVar("S", bound=OneSet)


class Sets(Protocol[S]):
    """The sets that were fitted so far, and how others are."""

    def likeliest(self) -> list[S]:
        """One fit of each set, the likeliest first."""
        ...

    def open(self, near: Sequence[S]) -> None:
        """Fit the neighbours of some sets."""
        ...

    def exchange(self, best: S) -> None:
        """Fit whatever may stand in a place of the best set."""
        ...


def go_on_to_neighbours(sets: Sets[S]) -> None:
    """Go on to sets that are neighbours of the best, until none is better.

    Parameters
    ----------
    sets : Sets
        With those to begin with.
    """
    opened: set[tuple[str, ...]] = set()
    exchanged: set[tuple[str, ...]] = set()
    while near := sets.likeliest()[: SEARCH.beam]:
        if near[0].key not in opened:
            new = [one for one in near if one.key not in opened]
            opened.update(one.key for one in new)
            sets.open(new)
        elif near[0].key not in exchanged:
            exchanged.add(near[0].key)
            sets.exchange(near[0])
        else:
            break
