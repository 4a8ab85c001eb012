"""A structure with identified dampers: modes, steady state, motion under a record, energy, and how sure all is."""

from .frame import Damper, Frame
from .modes import Mode, Steady, modes_of, steady_of, steady_state
from .motion import Motion, Record, Simulation, artificial, motion_of, simulate

__all__ = [
    "Damper",
    "Frame",
    "Mode",
    "Motion",
    "Record",
    "Simulation",
    "Steady",
    "artificial",
    "modes_of",
    "motion_of",
    "simulate",
    "steady_of",
    "steady_state",
]
