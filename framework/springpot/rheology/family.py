"""Families of models that differ in one whole number, such as ``prony-N``."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from .model import Model


@dataclass(frozen=True)
class Family:
    """Models ``prefix-N`` for N = 1, 2, ...

    Parameters
    ----------
    name : str
        As listed, such as ``prony-N``.
    build : callable
        From N to the model called ``prefix-N``.
    summary : str
        One sentence on what the members describe.
    aliases : tuple of str
        Other names, each ending in ``-N``.
    largest : int
        Largest N accepted.
    """

    name: str
    build: Callable[[int], Model]
    summary: str = ""
    aliases: tuple[str, ...] = ()
    largest: int = 50

    def number(self, name: str) -> int | None:
        """N of the member called `name`, or None if it is none of this family's."""
        for pattern in (self.name, *self.aliases):
            match = re.fullmatch(re.escape(pattern[:-1]) + r"([1-9]\d{0,3})", name)
            if match and int(match[1]) <= self.largest:
                return int(match[1])
        return None

    def member(self, name: str) -> Model | None:
        """The member called `name`, or None if it is none of this family's."""
        number = self.number(name)
        if number is None:
            return None
        return self.build(number)
