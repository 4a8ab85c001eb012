"""Rows of a measurement, chosen or left out by what was set.

``temperature=20``, ``frequency=1..10``, ``row=3``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from springpot.errors import DataError

from .measurement import Measurement
from .mixed_tests import NOTE, runs_together
from .rows import rows_with
from .timetest import TimeTest

Test: TypeAlias = Measurement | TimeTest
"""What was measured on one specimen: a sweep, or a test in time."""
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
    left = tests_without([measurement], unwanted)
    assert isinstance(left[0], Measurement)
    return left[0]


def tests_without(tests: Sequence[Test], unwanted: Mapping[str, str]) -> list[Test]:
    """Tests of one specimen without the rows, or samples, that have all of these conditions.

    Parameters
    ----------
    tests : sequence of Measurement or TimeTest
        The tests.
    unwanted : mapping of str to str
        As in `select`; of a test in time also ``time`` in s and ``sample``, and of several tests
        ``test``, a name or its beginning, alone for the whole of it. What names no test is left out
        of all that know the column.

    Raises
    ------
    DataError
        If no test has such a column or value, or nothing would be left.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement.selection import tests_without
    >>> test = springpot.TimeTest.of_relaxation([0.1, 1.0, 10.0], [3.0, 2.0, 1.0])
    >>> tests_without([test], {"time": "..0.5"})
    [<TimeTest relaxation: relaxation, 2 samples, 1 to 10 s>]
    """
    meant, rest = _meant(tests, unwanted)
    left: list[Test] = []
    faults: list[DataError] = []
    for test in tests:
        if test not in meant:
            left.append(test)
            continue
        try:
            kept = ~rows_with(test, rest)
        except DataError as error:
            # Another test may have what this one lacks.
            faults.append(error)
            left.append(test)
            continue
        if kept.any():
            left.append(test.subset(kept))
    if len(faults) == len(meant):
        raise faults[0]
    if not left:
        raise DataError(f"{tests[0].name}: nothing would be left")
    return left


def _meant(tests: Sequence[Test], unwanted: Mapping[str, str]) -> tuple[list[Test], dict[str, str]]:
    """The tests that are named, or all of them, and the conditions on their rows."""
    rest = dict(unwanted)
    # A column of words may have that name, and then it is meant.
    if "test" not in rest or any("test" in test.labels for test in tests):
        return list(tests), rest
    name = rest.pop("test")
    for fits in (str.__eq__, str.startswith):
        if named := [test for test in tests if fits(test.name, name)]:
            return named, rest
    known = ", ".join(test.name for test in tests)
    raise DataError(f"there is no test '{name}' (there are: {known})")
