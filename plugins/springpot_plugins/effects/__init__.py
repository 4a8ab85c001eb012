"""The built-in effects, one small file for each way in which they act."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.rheology import Effect

from . import (
    amplitude,
    clock,
    compliance,
    loading,
    record,
    signal,
    specimen,
    stiffness,
    stops,
    temperature,
)

OF_THE_NETWORK = (stiffness, compliance, amplitude, signal, temperature, specimen)
OF_THE_TEST = (loading, clock, record, stops)


@hookimpl
def springpot_effects() -> Iterable[Effect]:
    """All of them."""
    return [effect for file in (*OF_THE_NETWORK, *OF_THE_TEST) for effect in file.EFFECTS]
