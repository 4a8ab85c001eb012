"""Superposition: sweeps at many levels of a condition as one master curve, without a model."""

from .curve import Level, MasterCurve, mastercurve
from .factors import Factors
from .laws import LawFit
from .simplicity import Failure, Simplicity
from .words import level_of, level_text

__all__ = [
    "Factors",
    "Failure",
    "LawFit",
    "Level",
    "MasterCurve",
    "Simplicity",
    "level_of",
    "level_text",
    "mastercurve",
]
