"""A guest: identified models handed to solvers, as a Prony series in the format of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .exporting import Exported, exported
    from .handoff import Handoff, Writer
    from .prony import Prony, prony_of

__all__ = ["Exported", "Handoff", "Prony", "Writer", "exported", "prony_of"]

_WHERE = {
    "Exported": "springpot.solvers.exporting",
    "Handoff": "springpot.solvers.handoff",
    "Prony": "springpot.solvers.prony",
    "Writer": "springpot.solvers.handoff",
    "exported": "springpot.solvers.exporting",
    "prony_of": "springpot.solvers.prony",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
