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
    from . import amplitude, clock, compliance, loading, record, signal, specimen, stiffness, stops

    of_the_network = (stiffness, compliance, amplitude, signal, specimen)
    of_the_test = (loading, clock, record, stops)
    return [effect for file in (*of_the_network, *of_the_test) for effect in file.EFFECTS]
