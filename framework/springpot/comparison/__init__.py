"""Comparison: models side by side against one noise floor, and the installed ones in order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .comparing import Comparison, Judgement, compare
    from .ranking import Ranking, rank

__all__ = [
    "Comparison",
    "Judgement",
    "Ranking",
    "compare",
    "rank",
]

_WHERE = {
    "Comparison": "springpot.comparison.comparing",
    "Judgement": "springpot.comparison.comparing",
    "Ranking": "springpot.comparison.ranking",
    "compare": "springpot.comparison.comparing",
    "rank": "springpot.comparison.ranking",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
