"""Rows of a measurement, chosen or left out by what was set.

``temperature=20``, ``frequency=1..10``, ``row=3``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from springpot.errors import DataError

from .measurement import Measurement
from .mixed_tests import NOTE, runs_together
from .rows import rows_with, rows_without

EXAMPLE = "temperature=20,amplitude=1 or frequency=1..10"


def conditions(text: str, where: str) -> dict[str, str]:
    """Conditions and their values, of text such as ``temperature=20,frequency=1..10``.

    Parameters
    ----------
    text : str
        The conditions, with commas between them; a value of words may hold commas too.
    where : str
        What they stand in, for the message.

    Raises
    ------
    DataError
        If a part of it is none.

    Examples
    --------
    >>> from springpot.measurement import conditions
    >>> conditions("temperature=20,frequency=1..10", "FILE@temperature=20,frequency=1..10")
    {'temperature': '20', 'frequency': '1..10'}
    """
    wanted = {}
    # A comma that no further condition follows belongs to a value, which may be anybody's words.
    for part in re.split(r",(?=[^,=]*=)", text):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        # A value may be empty, as a remark is that was not written.
        if not (key and equals):
            raise DataError(f"'{where}': write conditions as {EXAMPLE}")
        wanted[key] = value
    return wanted


def select(measurement: Measurement, wanted: Mapping[str, str]) -> Measurement:
    """The rows that have all the wanted conditions.

    Parameters
    ----------
    measurement : Measurement
        The data.
    wanted : mapping of str to str
        Condition, label, ``repeat``, ``frequency`` in Hz, ``omega`` in rad/s or ``row`` (the first
        is 1), and its value or range: ``1..10``, ``..10`` or ``1..``, ends included. Numbers match
        within 0.5 K for ``temperature``, 5 % for ``amplitude`` and 1 % otherwise; words match
        whole, or by their beginning.

    Raises
    ------
    DataError
        If there is no such column or value, with those that there are.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import select
    >>> select(springpot.read("artificial-hidden"), {"frequency": "1..10"})
    <Measurement artificial-hidden@frequency=1..10: 17 points, 1.13 to 9.93 Hz>
    """
    rows = rows_with(measurement, wanted)
    if not rows.any():
        # Each condition alone has rows, or one of them would have been refused by name.
        chosen = ", ".join(f"{key}={value}" for key, value in wanted.items())
        raise DataError(f"{measurement.name}: no row has {chosen} together")
    chosen = ",".join(f"{key}={value}" for key, value in wanted.items())
    part = measurement.subset(rows, f"{measurement.name}@{chosen}")
    if NOTE not in part.provenance:
        return part
    # Of the tests that stood together fewer may be left, or one.
    known = {key: value for key, value in part.provenance.items() if key != NOTE}
    named_already = frozenset[str]()
    if "note parts" in known:
        named_already = frozenset({"step"})
    return replace(
        part, provenance={**known, **runs_together(part.conditions, part.labels, named_already)}
    )


def without(measurement: Measurement, unwanted: Mapping[str, str]) -> Measurement:
    """The rows that lack one of the conditions, as part of the same data; see `select`.

    Raises
    ------
    DataError
        If there is no such column or value, or nothing would be left.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import without
    >>> len(without(springpot.read("artificial-hidden"), {"frequency": "1..10"}))
    23
    """
    return measurement.subset(rows_without(measurement, unwanted))
