"""Comparison: models side by side against one noise floor, and the installed ones in order."""

from .compare import Comparison, Judgement, compare
from .ranking import Ranking, rank

__all__ = ["Comparison", "Judgement", "Ranking", "compare", "rank"]
