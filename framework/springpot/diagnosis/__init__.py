"""Which effect is missing, how sure that is, and what to measure next."""

from .diagnose import Case, Progress, diagnose, examine, silent, within
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
