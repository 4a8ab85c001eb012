"""Columns whose cells hold two numbers, as two columns.

A complex modulus, or a value with its deviation.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

from springpot.measurement import MODULUS_UNITS, normal_unit

from .grid import COMPLEX, DEVIATING, MISSING, is_number
from .names import MODULI
from .titles import COMPLIANCE_UNITS, Heading

_SAMPLED = 20
"""Cells of a column by which it is told: a column of numbers alone must cost nothing."""
_CONJUGATE = {
    "viscosity": ("dynamic_viscosity", "out_of_phase_viscosity"),
    "complex_compliance": ("storage_compliance", "loss_compliance"),
}
"""Parts of what is written x' - i x'', since it goes against the modulus.

Eta* = G* / (i omega), J* = 1 / G*.
"""


def with_pairs_apart(
    headings: Sequence[Heading], rows: Sequence[list[str]]
) -> tuple[tuple[Heading, ...], Sequence[list[str]]]:
    """Headings and rows, where columns of two numbers in a cell have become two columns.

    Parameters
    ----------
    headings : sequence of Heading
        What the columns are.
    rows : sequence of list of str
        The cells, as many in each row as there are headings.
    """
    parts = {place: _parts(heading, rows, place) for place, heading in enumerate(headings)}
    if not any(parts.values()):
        return tuple(headings), rows
    made: list[Heading] = []
    for place, heading in enumerate(headings):
        made += parts[place] or [heading]
    return tuple(made), [_row_apart(row, parts) for row in rows]


def _parts(heading: Heading, rows: Sequence[Sequence[str]], place: int) -> list[Heading]:
    """The two headings of a column of pairs; none for a column that stays as it is."""
    filled = (row[place] for row in rows if row[place].strip() not in MISSING)
    sample = [cell for cell in islice(filled, _SAMPLED) if not is_number(cell)]
    # By most of them: a slip in one cell is told with its line, not by a column that nobody knows.
    if 2 * sum(1 for cell in sample if COMPLEX.match(cell)) > len(sample):
        return _complex_parts(heading)
    if 2 * sum(1 for cell in sample if DEVIATING.match(cell)) > len(sample):
        return _with_deviation(heading)
    return []


def _complex_parts(heading: Heading) -> list[Heading]:
    roles = _CONJUGATE.get(str(heading.role))
    unit = normal_unit(heading.unit or "")
    if heading.role is None and unit in COMPLIANCE_UNITS:
        roles = _CONJUGATE["complex_compliance"]
    # A name such as "stiffness" leaves open which part is meant: a complex number is both.
    elif heading.role in MODULI - {*_CONJUGATE} or (
        heading.role is None and (not heading.unit or unit in MODULUS_UNITS)
    ):
        roles = ("storage", "loss")
    if roles is None:
        return []
    names = [f"{heading.title} (real part)", f"{heading.title} (imaginary part)"]
    return [
        replace(heading, title=name, name=role, role=role)
        for name, role in zip(names, roles, strict=True)
    ]


def _with_deviation(heading: Heading) -> list[Heading]:
    deviation = replace(heading, title=f"{heading.title} (deviation)", name="", role=None)
    # Of other quantities the deviation is left out: only that of the moduli weighs anything.
    if heading.role in ("storage", "loss"):
        deviation = replace(deviation, name=f"{heading.role}_sd", role=f"{heading.role}_sd")
    return [heading, deviation]


def _row_apart(row: Sequence[str], parts: dict[int, list[Heading]]) -> list[str]:
    cells: list[str] = []
    for place, cell in enumerate(row):
        if parts[place]:
            cells += _two_numbers(cell, parts[place][1])
        else:
            cells.append(cell)
    return cells


def _two_numbers(cell: str, second: Heading) -> tuple[str, str]:
    """Both numbers of a cell; what is no pair is a gap in both, and told as such."""
    if match := DEVIATING.match(cell):
        return match[1], match[2]
    match = COMPLEX.match(cell)
    if match is None:
        return cell, cell
    sign = match[2]
    if second.role in ("out_of_phase_viscosity", "loss_compliance"):
        sign = {"-": "+", "−": "+", "+": "-"}[sign]
    return re.sub(r"\s", "", match[1]), sign.replace("+", "") + (match[3] or match[4])
