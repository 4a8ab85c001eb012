"""A structure with identified dampers.

Modes, steady state, motion under a record, energy, and how sure all is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .frame import Damper, Frame, Mode, SteadyState, modes_of, steady_of, steady_state
    from .motion import GroundMotion, Motion, Simulation, artificial, motion_of, simulate

__all__ = [
    "Damper",
    "Frame",
    "Mode",
    "Motion",
    "GroundMotion",
    "Simulation",
    "SteadyState",
    "artificial",
    "modes_of",
    "motion_of",
    "simulate",
    "steady_of",
    "steady_state",
]

_WHERE = {
    "Damper": "springpot.structure.frame",
    "Frame": "springpot.structure.frame",
    "Mode": "springpot.structure.frame",
    "Motion": "springpot.structure.motion",
    "GroundMotion": "springpot.structure.motion",
    "Simulation": "springpot.structure.motion",
    "SteadyState": "springpot.structure.frame",
    "artificial": "springpot.structure.motion",
    "modes_of": "springpot.structure.frame",
    "motion_of": "springpot.structure.motion",
    "simulate": "springpot.structure.motion",
    "steady_of": "springpot.structure.frame",
    "steady_state": "springpot.structure.frame",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
