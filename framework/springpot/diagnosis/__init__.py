"""Which effect is missing, how sure that is, and what to measure next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .examination import diagnose as diagnose, examine as examine
    from .ladder import Ladder as Ladder, Step as Step
    from .result import Diagnosis as Diagnosis

__getattr__, __dir__ = offered(__name__)
