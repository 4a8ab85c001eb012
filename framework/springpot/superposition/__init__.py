"""Superposition: sweeps at many levels of a condition as one master curve, without a model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from springpot.identification.free_factors import Factors
    from springpot.rheology.levels import level_text

    from .curve import Level, MasterCurve, mastercurve
    from .laws import LawFit
    from .simplicity import Failure, Simplicity
    from .words import level_of

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

_WHERE = {
    "Factors": "springpot.identification.free_factors",
    "Failure": "springpot.superposition.simplicity",
    "LawFit": "springpot.superposition.laws",
    "Level": "springpot.superposition.curve",
    "MasterCurve": "springpot.superposition.curve",
    "Simplicity": "springpot.superposition.simplicity",
    "level_of": "springpot.superposition.words",
    "level_text": "springpot.rheology.levels",
    "mastercurve": "springpot.superposition.curve",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
