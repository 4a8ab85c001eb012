"""Whoever waits for an answer is told what is being done."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str], None]
"""Called with a stage in a few words when it begins; whatever it raises ends the work."""


def silent(stage: str) -> None:
    """For those who do not ask."""


def within(whole: str, progress: Progress) -> Progress:
    """Stages of a part, told as such: ``step 1: fitting fractional-maxwell``."""

    def part(stage: str) -> None:
        progress(f"{whole}: {stage}")

    return part
