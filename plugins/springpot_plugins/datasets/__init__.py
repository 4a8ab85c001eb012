"""The built-in data sets."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.measurement import DataSet


@hookimpl
def springpot_datasets() -> Iterable[DataSet]:
    """All of them; nothing is loaded before it is used."""
    from . import folders, shipped

    return (
        *shipped.computed_sets(),
        *shipped.measured_sets(),
        *folders.datasets(),
    )
