"""The built-in formats for solvers.

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
    from . import by_frequency, fmu, series

    return (
        *series.TABLES,
        series.PYTHON,
        by_frequency.ABAQUS,
        series.ANSYS,
        series.LS_DYNA,
        by_frequency.NASTRAN,
        series.COMSOL,
        fmu.WRITER,
        *series.OPENSEES,
    )
