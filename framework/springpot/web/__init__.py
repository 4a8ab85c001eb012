"""The workbench: the missing effect found by pointing, in a browser on the same machine.

The server of this room computes nothing itself: worker processes read files and fit models, and can be ended. What
they answer is a pure function of a `State` and of the text of the data, kept by the state's key.
"""

from .launch import Workbench, serve, workbench

__all__ = ["Workbench", "serve", "workbench"]
