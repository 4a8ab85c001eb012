"""Imported by the fork server only: workers are born with the plugins loaded."""

from springpot.registry import plugins

from . import worker

__all__ = ["worker"]

plugins()
