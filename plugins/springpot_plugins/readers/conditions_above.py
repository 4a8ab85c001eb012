"""Conditions stated in a line above a table, such as ``T = 25 °C`` or ``# Frequency [Hz]: 1``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from springpot.measurement import normal_unit

from .blocks import Block
from .curve_names import curve_in_cell
from .names import FREQUENCIES, role_of
from .titles import UNITS

_STATED = re.compile(
    r"(?:^|[,;|#%]\s*)([^\W\d][^\[\]=:,;|]{0,40}?)\s*(?:[\[(]([^\[\]()]{1,12})[\])])?\s*[=:]\s*"
    r"([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*([^\s,;|\d][^\s,;|]{0,12})?\s*(?=$|[,;|])"
)
_ROLES = frozenset({"temperature", "amplitude", *FREQUENCIES})
_NEAR = 12
"""Lines above a table that are looked at."""
_LONGEST = 1000
"""Signs of such a line."""


def with_conditions_above(blocks: Iterable[Block]) -> list[Block]:
    """The blocks, each with the conditions that lines above it state and no column of it has."""
    return [
        replace(block, constants={**conditions_above(block), **block.constants}) for block in blocks
    ]


def conditions_above(block: Block) -> dict[str, str]:
    """Conditions by title: ``temperature [degC]`` and the number; only those with a known unit."""
    taken = set(block.roles)
    if taken & FREQUENCIES:
        # A column of omega says the frequency as well.
        taken |= FREQUENCIES
    stated: dict[str, str] = {}
    # Downwards, so that the line nearest to the table counts.
    for row in block.above[-_NEAR:]:
        conditions = _conditions_in([cell for cell in row if cell])
        for role in {role for role, _, _ in conditions} - taken:
            values = {(unit, number) for each, unit, number in conditions if each == role}
            # Two temperatures in one line are those of two curves.
            if len(values) == 1:
                unit, number = values.pop()
                stated[f"{role} [{unit}]"] = number
    return stated


def _conditions_in(cells: Sequence[str]) -> list[tuple[str, str, str]]:
    """Role, unit and number of each condition in a line."""
    conditions = []
    if len(cells) == 1 and (curve := curve_in_cell(cells[0].strip("#%/ "))).title:
        return [(curve.role, normal_unit(curve.title.partition(" ")[2]), curve.value)]
    text = ""
    if len(cells) == 2 and not re.search("[:=]", cells[0]):
        # A line of two cells is a key and its value, also without a colon.
        cells = [f"{cells[0]}:", cells[1]]
    for cell in cells:
        # "Temperature:" and "25 °C" stand in two cells.
        separator = ", "
        if cell.endswith((":", "=")):
            separator = " "
        text += cell + separator
    for name, bracket, number, behind in _STATED.findall(text[:_LONGEST].removesuffix(", ")):
        role, unit = role_of(name), normal_unit(bracket or behind)
        if role in _ROLES and (bracket or behind) and unit in UNITS[str(role)]:
            conditions.append((str(role), unit, number.replace(",", ".")))
    return conditions
