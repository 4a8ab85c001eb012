"""Diagnosis: the noise floor, where a model fails, which effect is missing, what to measure next."""

from .compare import Comparison, Judgement, compare
from .diagnose import Case, diagnose, examine
from .findings import Finding
from .ladder import Ladder, Step, discover
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
    "Step",
    "Value",
    "Where",
    "compare",
    "diagnose",
    "discover",
    "examine",
]
