"""The built-in formats for solvers, one small file for each."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.solvers import Writer

from . import abaqus, ansys, comsol, fmu, lsdyna, nastran, opensees, python, tables


@hookimpl
def springpot_writers() -> Iterable[Writer]:
    """All of them."""
    return (
        *tables.WRITERS,
        python.WRITER,
        abaqus.WRITER,
        ansys.WRITER,
        lsdyna.WRITER,
        nastran.WRITER,
        comsol.WRITER,
        fmu.WRITER,
        *opensees.WRITERS,
    )
