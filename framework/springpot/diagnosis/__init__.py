"""Diagnosis: the noise floor, where a model fails, which effect is missing, what to measure next."""

from .battery import Finding
from .diagnose import Case, Progress, diagnose, examine, silent, within
from .ladder import Ladder, Step, discover
from .material import any_material
from .result import Candidate, Diagnosis, Error, NextExperiment, Value, Where

__all__ = [
    "Candidate",
    "Case",
    "Diagnosis",
    "Error",
    "Finding",
    "Ladder",
    "NextExperiment",
    "Progress",
    "Step",
    "Value",
    "Where",
    "any_material",
    "diagnose",
    "discover",
    "examine",
    "silent",
    "within",
]
