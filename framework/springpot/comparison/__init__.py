"""Comparison: models side by side against one noise floor, and the installed ones in order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .comparing import rank as rank
    from .result import Comparison as Comparison, Judgement as Judgement, Ranking as Ranking

__getattr__, __dir__ = offered(__name__)
