"""The workbench: the missing effect found by pointing, in a browser on the same machine.

The server of this room computes nothing itself: worker processes read files and fit models, and can
be ended. What they answer is a pure function of a `State` and of the text of the data, kept by the
state's key.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .launch import (
        Workbench as Workbench,
        serve as serve,
        workbench as workbench,
    )

__getattr__, __dir__ = offered(__name__)
