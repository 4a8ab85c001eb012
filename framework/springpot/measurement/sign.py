"""A channel of a test in time that counts the other way.

A specimen that gives work away, or pulls when pushed.
"""

from __future__ import annotations

from collections.abc import Mapping
from shlex import split

import numpy as np

from springpot.distributions import samples_of_one
from springpot.rheology.points import Real
from springpot.thresholds import SIGNALS

from .timetest import TimeTest

NOTE = "note sign"
"""Where the doubt is kept among what is told of a test."""


def said_of_sign(provenance: Mapping[str, str]) -> list[str]:
    """What was noted of the sign when data were opened, as a list of one or none."""
    return [said for key, said in provenance.items() if key == NOTE]


def turned(provenance: Mapping[str, str]) -> str:
    """The data with one channel turned, where it seems to count the other way; empty for others."""
    return "".join(split(provenance.get(NOTE, "").partition(", open ")[2]))


def sign_note(test: TimeTest, hint: str) -> dict[str, str]:
    """What to tell of a test in which force and displacement count in opposite directions.

    Nothing of another.

    Parameters
    ----------
    test : TimeTest
        Of any kind.
    hint : str
        What to say behind the file's name to turn one channel, such as ``force=-N``.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.sign import sign_note
    >>> t = np.linspace(0.0, 1.0, 200)
    >>> test = TimeTest.of_history(t, np.sin(20 * t), -3.0 * np.sin(20 * t + 0.4), "mm", "N")
    >>> sign_note(test, "force=-N")["note sign"][:45]
    'the specimen gives work away, as if the force'
    """
    moved = np.interp(test.time, test.loading.time, test.loading.value)
    pulled = test.response
    if test.control == "force":
        moved, pulled = pulled, moved
    if test.kind == "history":
        turned, why = _gives_work(test.time, moved, pulled), "the specimen gives work away"
    else:
        # No cycle, over which work is counted: a push is answered by a push.
        turned, why = (
            bool(2 * np.sum(moved * pulled < 0.0) > len(pulled)),
            "force and displacement are opposed",
        )
    if not turned:
        return {}
    turn = f"if one channel counts the other way, open 'FILE?{hint}'"
    return {NOTE: f"{why}, as if the force had the wrong sign: {turn}"}


def _gives_work(time: Real, moved: Real, pulled: Real) -> bool:
    """Whether the force surely goes against the velocity, and not surely with the displacement.

    Above a resonance the storage is negative, and with a late channel the loss; with the wrong sign
    no part is left.
    """
    if np.any(np.diff(time) <= 0.0):
        return False
    columns = np.stack([np.ones_like(moved), moved, np.gradient(moved, time)], axis=1)
    size = np.abs(columns).max(axis=0)
    if not np.all(size > 0.0):
        return False
    amounts, _, rank, _ = np.linalg.lstsq(columns / size, pulled, rcond=None)
    if rank < columns.shape[1]:
        return False
    rest = pulled - (columns / size) @ amounts
    # What is left of a record is alike from sample to sample: it holds fewer than it seems.
    power = float(np.mean(rest**2)) * samples_of_one(rest)
    inverse = np.linalg.inv((columns / size).T @ (columns / size))
    sd = np.sqrt(np.diag(inverse) * power)
    stiffness, damping = amounts[1:] / np.maximum(sd[1:], np.finfo(float).tiny)
    return bool(damping < -SIGNALS.negative and stiffness < SIGNALS.negative)
