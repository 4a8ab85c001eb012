"""What an instrument says against its values.

Flags of a status column, tan delta at a limit, raw phase near 180 deg.

Where the loss tangent is beyond what it can tell, an instrument writes a limit instead, and a
storage modulus that follows from the limit: nothing was measured, and such rows are left out. All
else is told and left to the user.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.rheology import Real

from .table import Column

STATUS = "status"
IGNORE = "ignore"
"""What a user says (``?status=ignore``) to keep rows that the instrument takes back."""
CLIPPED = "taD"
"""RheoCompass: the loss factor is beyond its limit."""
TANGENT_LIMIT = 20000.0
"""The limit that RheoCompass writes as the loss factor; storage is the loss over it."""
ROUNDING = 1e-3
"""Values are printed with five digits, so that the ratio of two is known to a thousandth."""
WAYS = frozenset(
    {"trustrain", "trustress", "dso", "dsc", "dy_auto", "dy_man", "ok", "good", "valid", "-", "0"}
)
"""Words of a status column that tell how was measured, not that something is wrong."""
RAW_PHASE = 150.0
"""Degrees. Without inertia the raw phase lies within 0 and 90.

At 150 the moment of inertia takes 0.87 of the torque
(the cosine) beyond what the sample's elasticity balances, and storage is a small difference of
large numbers.
"""


@dataclass(frozen=True)
class Flags:
    """What was found.

    Parameters
    ----------
    keep : ndarray of bool, shape (n,)
        Rows whose values were measured.
    notes : dict of str to str
        What to tell, by the key of the note.
    """

    keep: NDArray[np.bool_]
    notes: dict[str, str]


def flags_in(
    status: Column | None, storage: Real | None, loss: Real | None, ignored: bool
) -> Flags:
    """What a status column and the values themselves say.

    Parameters
    ----------
    status : Column or None
        The status column.
    storage, loss : ndarray, shape (n,), or None
        The moduli, where the file has both.
    ignored : bool
        Whether the user keeps the rows all the same.

    Raises
    ------
    DataError
        If no row is left.
    """
    words = []
    if status is not None:
        words = [_words(cell) for cell in status.cells]
    count = len(words)
    if storage is not None:
        count = len(storage)
    clipped = np.array([CLIPPED in each for each in words] or [False] * count, dtype=bool)
    zero = np.zeros_like(clipped)
    if storage is not None and loss is not None:
        zero = _zero_in_place_of(storage, loss)
        clipped |= _at_limit(storage, loss) | zero
    notes = _flag_note(words)
    # Flags of other kinds are told and change nothing: what they mean differs from instrument to
    # instrument.
    if not clipped.any():
        return Flags(~clipped, notes)
    why = "tan delta at its limit"
    if zero.any():
        why = "0 beside large ones"
        if (clipped & ~zero).any():
            why += ", or tan delta at its limit"
    what = f"{int(clipped.sum())} of {count} rows have a storage that was not measured ({why})"
    if ignored:
        return Flags(
            np.ones(count, dtype=bool), {**notes, "note clipped": f"{what}; kept as you said"}
        )
    # Nothing would be left: the user decides, rather than an empty table.
    if clipped.all():
        raise DataError(f"{what}; open 'FILE?{STATUS}={IGNORE}' to see them all the same")
    notes["note clipped"] = f"{what} and were left out; '?{STATUS}={IGNORE}' keeps them"
    return Flags(~clipped, notes)


def _words(cell: str) -> set[str]:
    return {word.strip("™® ") for word in re.split(r"[,;|]", cell)} - {""}


def _flag_note(words: Sequence[set[str]]) -> dict[str, str]:
    """How often each flag stands there that may mean a fault."""
    count = Counter[str]()
    for each in words:
        # Sorted, since a set has another order in each process and ties are told in the order of
        # counting.
        count.update(word for word in sorted(each) if word.casefold() not in WAYS)
    if not count:
        return {}
    shown = ", ".join(f"{word} ({number})" for word, number in count.most_common(6))
    return {
        "note status": (
            f"of {len(words)} rows the instrument flags {shown}; its manual says what that means"
        )
    }


def _at_limit(storage: Real, loss: Real) -> NDArray[np.bool_]:
    """Rows whose loss is the limit times their storage; one such row alone may be chance."""
    with np.errstate(all="ignore"):
        rows = np.abs(loss / storage / TANGENT_LIMIT - 1.0) < ROUNDING
    return np.asarray(rows & (rows.sum() > 1))


def _zero_in_place_of(storage: Real, loss: Real) -> NDArray[np.bool_]:
    """Rows of a storage of 0 beside large ones: written for what was negative or not measured.

    Beside the small values of a column it is rounded, and nothing but zeros is a liquid's.
    """
    zero = (storage == 0.0) & (loss != 0.0)
    measured = np.flatnonzero(~zero)
    if not zero.any() or not len(measured):
        return np.zeros_like(zero)
    size = np.abs(storage[measured])
    nearest = np.argmin(np.abs(np.arange(len(storage))[:, None] - measured), axis=1)
    return np.asarray(zero & (size[nearest] > np.median(size)))


def raw_phase_note(raw: Column | None, frequency: Real) -> dict[str, str]:
    """A note where the raw phase comes near 180 deg; `frequency` (n,) in Hz."""
    if raw is None or not raw.is_numeric():
        return {}
    values = raw.numbers(gaps=True)
    # Instruments write degrees unless they say otherwise.
    if raw.unit == "rad":
        values = np.degrees(values)
    rows = values > RAW_PHASE
    if not rows.any():
        return {}
    where = f"{int(rows.sum())} of {len(values)} rows, from {frequency[rows].min():.3g} Hz on"
    return {
        "note raw phase": (
            f"beyond {RAW_PHASE:g} deg in {where}: the instrument's inertia outweighs the sample"
            " there"
        )
    }
