"""Diagnosis: the noise floor, where a model fails, which effect is missing, what to measure next."""

from .battery import Finding
from .compare import Comparison, Judgement, compare
from .diagnose import Case, diagnose, examine
from .ladder import Ladder, Step, discover
from .material import any_material
from .progress import Progress
from .ranking import Ranking, rank
from .result import Candidate, Diagnosis, Error, NextExperiment, Value, Where

__all__ = [
    "Candidate",
    "Case",
    "Comparison",
    "Diagnosis",
    "Error",
    "Finding",
    "Judgement",
    "Ladder",
    "NextExperiment",
    "Progress",
    "Ranking",
    "Step",
    "Value",
    "Where",
    "any_material",
    "compare",
    "diagnose",
    "discover",
    "examine",
    "rank",
]
