"""The built-in effects, one small file for each way in which they act."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.rheology import Effect

from . import amplitude, compliance, signal, specimen, stiffness, temperature


@hookimpl
def springpot_effects() -> Iterable[Effect]:
    """All of them."""
    files = (stiffness, compliance, amplitude, signal, temperature, specimen)
    return [effect for file in files for effect in file.EFFECTS]
