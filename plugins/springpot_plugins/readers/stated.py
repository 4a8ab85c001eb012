"""Conditions that a line above a table states, such as ``T = 25 °C`` or ``# Frequency [Hz]: 1``."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from .blocks import Block
from .names import FREQUENCIES, role_of
from .titles import UNITS, tidy

_STATED = re.compile(
    r"(?:^|[,;|#%]\s*)([^\W\d][^\[\]=:,;|]{0,40}?)\s*(?:[\[(]([^\[\]()]{1,12})[\])])?\s*[=:]\s*"
    r"([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*([^\s,;|\d][^\s,;|]{0,12})?\s*(?=$|[,;|])"
)
_ROLES = frozenset({"temperature", "amplitude", *FREQUENCIES})
_NEAR = 12
"""Lines above a table that are looked at."""


def with_stated(blocks: Iterable[Block]) -> list[Block]:
    """The blocks, each with what the lines above it state of conditions that it has no column of."""
    return [replace(block, constants={**stated_above(block), **block.constants}) for block in blocks]


def stated_above(block: Block) -> dict[str, str]:
    """Conditions by title: ``temperature [degC]`` and the number; only those with a known unit."""
    there, found = block.roles, {}
    for row in block.above[-_NEAR:]:
        for name, bracket, number, behind in _STATED.findall(", ".join(cell for cell in row if cell)):
            role = role_of(name)
            taken = there & FREQUENCIES if role in FREQUENCIES else role in there
            unit = tidy(bracket or behind)
            if role in _ROLES and not taken and (bracket or behind) and unit in UNITS[str(role)]:
                found[f"{role} [{unit}]"] = number.replace(",", ".")
    return found
