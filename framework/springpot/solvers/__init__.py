"""A guest: identified models handed to solvers, as a Prony series in the format of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .exporting import Exported, exported
    from .handoff import Handoff, Writer
    from .prony import BULKS, Prony, Solid, prony_of, solid_of, young_of

__all__ = [
    "BULKS",
    "Exported",
    "Handoff",
    "Prony",
    "Solid",
    "Writer",
    "exported",
    "prony_of",
    "solid_of",
    "young_of",
]

_WHERE = {
    "BULKS": "springpot.solvers.prony",
    "Solid": "springpot.solvers.prony",
    "solid_of": "springpot.solvers.prony",
    "young_of": "springpot.solvers.prony",
    "Exported": "springpot.solvers.exporting",
    "Handoff": "springpot.solvers.handoff",
    "Prony": "springpot.solvers.prony",
    "Writer": "springpot.solvers.handoff",
    "exported": "springpot.solvers.exporting",
    "prony_of": "springpot.solvers.prony",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
