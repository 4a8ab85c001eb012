"""Which effect is missing, how sure that is, and what to measure next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .examination import Case, Progress, diagnose, examine, silent, within
    from .ladder import Ladder, Step, discover
    from .result import Candidate, Diagnosis, NextExperiment

__all__ = [
    "Candidate",
    "Case",
    "Diagnosis",
    "Ladder",
    "NextExperiment",
    "Progress",
    "Step",
    "diagnose",
    "discover",
    "examine",
    "silent",
    "within",
]

_WHERE = {
    "Candidate": "springpot.diagnosis.result",
    "Case": "springpot.diagnosis.examination",
    "Diagnosis": "springpot.diagnosis.result",
    "Ladder": "springpot.diagnosis.ladder",
    "NextExperiment": "springpot.diagnosis.result",
    "Progress": "springpot.diagnosis.examination",
    "Step": "springpot.diagnosis.ladder",
    "diagnose": "springpot.diagnosis.examination",
    "discover": "springpot.diagnosis.ladder",
    "examine": "springpot.diagnosis.examination",
    "silent": "springpot.diagnosis.examination",
    "within": "springpot.diagnosis.examination",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
