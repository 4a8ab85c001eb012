"""The built-in data sets."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.measurement import DataSet


@hookimpl
def springpot_datasets() -> Iterable[DataSet]:
    """All of them; nothing is loaded before it is used."""
    from . import artificial, folders, hidden, nist, reconstructions, rheodata

    return (
        *artificial.datasets(),
        *hidden.datasets(),
        *reconstructions.datasets(),
        *nist.datasets(),
        *rheodata.datasets(),
        *folders.datasets(),
    )
