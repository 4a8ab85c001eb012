"""The workbench: the missing effect found by pointing, in a browser on the same machine.

The server of this room computes nothing itself: worker processes read files and fit models, and can
be ended. What they answer is a pure function of a `State` and of the text of the data, kept by the
state's key.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .launch import Workbench, serve, workbench

__all__ = ["Workbench", "serve", "workbench"]

_WHERE = {
    "Workbench": "springpot.web.launch",
    "serve": "springpot.web.launch",
    "workbench": "springpot.web.launch",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
