"""The built-in formats for solvers, one small file for each.

Files are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from springpot.hooks import hookimpl

if TYPE_CHECKING:
    from springpot.solvers import Writer


@hookimpl
def springpot_writers() -> Iterable[Writer]:
    """All of them."""
    from . import abaqus, ansys, comsol, fmu, lsdyna, nastran, opensees, python, tables

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
