"""Test reports: what each cycle of a record is, how sure that is, and whether a code is met."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .certificate import Certificate
    from .certifying import certify
    from .record import LoopRecord, read_record
    from .report import CycleReport, cycles
    from .summary import EvaluatedTest, Told
    from .velocity import VelocityLaw

__all__ = [
    "Certificate",
    "CycleReport",
    "EvaluatedTest",
    "LoopRecord",
    "Told",
    "VelocityLaw",
    "certify",
    "cycles",
    "read_record",
]

_WHERE = {
    "Certificate": "springpot.testreport.certificate",
    "certify": "springpot.testreport.certifying",
    "CycleReport": "springpot.testreport.report",
    "EvaluatedTest": "springpot.testreport.summary",
    "LoopRecord": "springpot.testreport.record",
    "Told": "springpot.testreport.summary",
    "VelocityLaw": "springpot.testreport.velocity",
    "cycles": "springpot.testreport.report",
    "read_record": "springpot.testreport.record",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
