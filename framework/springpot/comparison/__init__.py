"""Comparison: models side by side against one noise floor, and the installed ones in order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .comparing import Comparison as Comparison
    from .comparing import Judgement as Judgement
    from .ranking import Ranking as Ranking
    from .ranking import rank as rank

__getattr__, __dir__ = offered(
    __name__,
    {
        "comparing": "Comparison Judgement",
        "ranking": "rank Ranking",
    },
)
