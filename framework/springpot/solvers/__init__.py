"""A guest: identified models handed to solvers, as a Prony series in the format of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .exporting import exported as exported
    from .handoff import Handoff as Handoff, Writer as Writer
    from .prony import (
        Prony as Prony,
        prony_of as prony_of,
        solid_of as solid_of,
        young_of as young_of,
    )

__getattr__, __dir__ = offered(__name__)
