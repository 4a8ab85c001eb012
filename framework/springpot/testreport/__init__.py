"""Test reports: what each cycle of a record is, how sure that is, and whether a code is met."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .certificate import certify as certify
    from .record import LoopRecord as LoopRecord
    from .report import cycles as cycles

__getattr__, __dir__ = offered(__name__)
