"""The built-in effects, one small file for each way in which they act."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.measurement import TimeEffect
from springpot.rheology import Effect

from .. import timeeffects
from . import amplitude, compliance, signal, specimen, stiffness, temperature


@hookimpl
def springpot_effects() -> Iterable[Effect]:
    """All of them."""
    files = (stiffness, compliance, amplitude, signal, temperature, specimen)
    return [effect for file in files for effect in file.EFFECTS]


@hookimpl
def springpot_time_effects() -> Iterable[TimeEffect]:
    """Those of tests in time."""
    return timeeffects.EFFECTS
