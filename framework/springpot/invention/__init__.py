"""A law that is in no library: found as a formula, with those that the data cannot tell from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .inventing import invent
    from .result import FoundLaw, Invention

__all__ = ["FoundLaw", "Invention", "invent"]

_WHERE = {
    "FoundLaw": "springpot.invention.result",
    "Invention": "springpot.invention.result",
    "invent": "springpot.invention.inventing",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
