"""Effects of tests in time, one small file for each stage at which they act."""

from __future__ import annotations

from springpot.measurement import TimeEffect

from . import clock, loading, record, stops

EFFECTS: tuple[TimeEffect, ...] = (
    *loading.EFFECTS,
    *clock.EFFECTS,
    *record.EFFECTS,
    *stops.EFFECTS,
)
