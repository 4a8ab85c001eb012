"""The built-in effects, one small file for each way in which they act.

Files are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.rheology import Effect


@hookimpl
def springpot_effects() -> Iterable[Effect]:
    """All of them."""
    from . import amplitude, instrument, loading, record, specimen, stiffness, stops

    return [
        *stiffness.EFFECTS,
        *instrument.IN_SERIES,
        *amplitude.EFFECTS,
        *instrument.SIGNALS,
        *specimen.EFFECTS,
        *loading.EFFECTS,
        *record.CLOCKS,
        *record.EFFECTS,
        *stops.EFFECTS,
    ]
