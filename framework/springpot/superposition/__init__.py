"""Superposition: sweeps at many levels of a condition as one master curve, without a model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .curve import MasterCurve as MasterCurve, mastercurve as mastercurve
    from .laws import level_of as level_of

__getattr__, __dir__ = offered(__name__)
