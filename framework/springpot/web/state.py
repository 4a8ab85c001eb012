"""What a page asks about: data, a model, accepted effects, left-out points, a seed.

An answer depends on no more.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from springpot.errors import DataError

LONGEST_NAME = 200
"""Signs of a model expression or of the name of an effect.

The longest installed model with six effects has 120.
"""
MOST_EFFECTS = 12
"""Twice what `discover --auto` accepts: each one doubles nothing but costs a diagnosis."""
MOST_ROWS = 1_000_000
"""Rows that may be left out: more than any file within the limit of an upload holds."""
LARGEST_SEED = 2**32


@dataclass(frozen=True)
class State:
    """One rung of one ladder.

    Parameters
    ----------
    data : str
        Digest of the text of the data, see `digest_of`.
    model : str
        Expression of the model at the foot of the ladder; empty for any material.
    accepted : tuple of str
        Effects in the order in which they were accepted.
    excluded : tuple of int
        Rows of the data that are left out, ascending.
    seed : int
        Of simulated noise.

    Examples
    --------
    >>> State("0" * 64, "fractional-maxwell").accepting("inertia").expression
    'fractional-maxwell + inertia'
    """

    data: str
    model: str = ""
    accepted: tuple[str, ...] = ()
    excluded: tuple[int, ...] = ()
    seed: int = 0

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> State:
        """The state in a request or a session file, which may hold anything.

        Raises
        ------
        DataError
            If something of it is missing, of the wrong kind or too large.
        """
        try:
            state = cls(
                _text(given["data"]),
                _text(given.get("model", "")),
                tuple(_text(name) for name in _listed(given.get("accepted", ()), MOST_EFFECTS)),
                tuple(
                    sorted({_number(row) for row in _listed(given.get("excluded", ()), MOST_ROWS)})
                ),
                _number(given.get("seed", 0)),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise DataError(f"this is no state of the workbench: {error}") from None
        return state

    @property
    def key(self) -> str:
        """The same for the same state, and for no other."""
        # Sorted, so that equal states have equal texts.
        text = json.dumps(self.to_dict(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def expression(self) -> str:
        """The grown model as it is typed."""
        return " + ".join([self.model or "material", *self.accepted])

    def accepting(self, effect: str) -> State:
        """The next rung."""
        return State(self.data, self.model, (*self.accepted, effect), self.excluded, self.seed)

    def to_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        return asdict(self)


def digest_of(text: str) -> str:
    """SHA-256 of the text of a measurement, by which the page and the server name it."""
    return hashlib.sha256(text.encode()).hexdigest()


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_NAME:
        raise ValueError(f"{str(value)[:40]!r} is no name")
    return value


def _number(value: object) -> int:
    # True is an int to Python.
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < LARGEST_SEED:
        raise ValueError(f"{str(value)[:40]!r} is no whole number from 0 on")
    return value


def _listed(value: object, most: int) -> list[object]:
    if not isinstance(value, list | tuple) or len(value) > most:
        raise ValueError(f"a list of at most {most} is wanted")
    return list(value)
