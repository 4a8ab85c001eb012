"""The built-in formats for solvers, one small file for each."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.rheology import Writer

from . import abaqus, ansys, opensees, python, tables


@hookimpl
def springpot_writers() -> Iterable[Writer]:
    """All of them."""
    return (*tables.WRITERS, python.WRITER, abaqus.WRITER, ansys.WRITER, *opensees.WRITERS)
