"""A record of displacement and force as a test report takes it.

With its temperature, or without a clock.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePath

import numpy as np

from springpot.errors import DataError
from springpot.measurement.from_signals import stiffness_unit
from springpot.measurement.reader import OpenQuestion, file_and_choice
from springpot.measurement.steady import Signals, in_order
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import STRAIN_UNITS
from springpot.registry import open_in_time, open_signals
from springpot.rheology.points import Real


@dataclass(frozen=True, eq=False)
class LoopRecord:
    """One test.

    Parameters
    ----------
    time : ndarray, shape (n,)
        In s, rising; numbers of the samples where the record has no clock.
    displacement, force : ndarray, shape (n,)
        The two channels, complete.
    displacement_unit, force_unit : str
        Their units; a strain is a share, ``-``.
    name : str
        Shown in tables.
    timed : bool
        Whether `time` is a time.
    temperature : ndarray, shape (n,), optional
        In degC.
    notes : tuple of str
        What a user should know of how it was read.
    """

    time: Real
    displacement: Real
    force: Real
    displacement_unit: str = "mm"
    force_unit: str = "N"
    name: str = "record"
    timed: bool = True
    temperature: Real | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, signals: Signals, timed: bool = True) -> LoopRecord:
        """From signals as a reader gives them: in order, complete, a strain as a share.

        Raises
        ------
        DataError
            If too little is left, or the units make no stiffness.
        """
        mended = in_order(signals.time, signals.displacement, signals.force, signals.name)
        channels = np.column_stack([mended.time, mended.displacement, mended.force])
        # Of two samples at one time none is later: a slope between them would be infinite.
        known = np.isfinite(channels).all(axis=1)
        channels = channels[known]
        channels = channels[np.concatenate([[True], np.diff(channels[:, 0]) > 0.0])]
        clock, moved, pulled = channels.T.copy()
        unit = signals.displacement_unit
        stiffness_unit(unit, signals.force_unit)
        if unit in STRAIN_UNITS:
            moved, unit = moved * STRAIN_UNITS[unit], "-"
        told = tuple(text for key, text in signals.provenance.items() if key.startswith("note "))
        # That samples are counted in seconds is no news of a record without a clock.
        notes = (*(told if timed else ()), *mended.notes)
        name = PurePath(signals.name).stem
        return cls(clock, moved, pulled, unit, signals.force_unit, name, timed, None, notes)

    @property
    def units(self) -> dict[str, str]:
        """Units of what is made of the channels, by dimension."""
        way, force = self.displacement_unit, self.force_unit
        if way == "-":
            stiffness, energy, speed = force, force, "1/s"
        else:
            stiffness, energy, speed = f"{force}/{way}", f"{force} {way}", f"{way}/s"
        damping = f"{force} s" if way == "-" else f"{force} s/{way}"
        return {
            "displacement": way,
            "force": force,
            "stiffness": stiffness,
            "damping": damping,
            "energy": energy,
            "velocity": speed,
            "ratio": "-",
            "temperature": "degC",
            "frequency": "Hz",
        }


def read_record(spec: str | Path) -> LoopRecord:
    """The record that a user names, as ``springpot signals`` reads it.

    Parameters
    ----------
    spec : str or Path
        ``FILE``, or ``FILE?force=kN`` for what the file leaves open. A file of displacement and
        force without a time gives what needs none.

    Raises
    ------
    DataError
        If the file holds no such signals.
    """
    try:
        record = LoopRecord.of(open_signals(spec))
    except OpenQuestion as question:
        if [each.about for each in question.questions] != ["time"]:
            raise
        record = LoopRecord.of(open_signals(_counted(str(spec))), timed=False)
    return _with_temperature(record, spec)


def _counted(spec: str) -> str:
    """The same file with its samples counted for want of a clock."""
    answered = bool(file_and_choice(spec)[1].columns)
    return f"{spec}{',' if answered else '?'}rate=1[Hz]"


def _with_temperature(record: LoopRecord, spec: str | Path) -> LoopRecord:
    """The record with the temperature of each sample, where the file has a column of it."""
    if not record.timed:
        return record
    # Tests in time are read with all their conditions, by readers that are stricter: where these
    # refuse a file there is a record all the same, and no temperature.
    tests: tuple[object, ...] = ()
    with suppress(DataError):
        tests = open_in_time(spec)
    found = tests[0] if len(tests) == 1 else None
    if not isinstance(found, TimeTest) or found.temperature is None:
        return record
    warmth = np.full(len(record.time), found.temperature)
    if found.warmth is not None:
        warmth = np.interp(record.time, found.time, found.warmth)
    return LoopRecord(
        record.time,
        record.displacement,
        record.force,
        record.displacement_unit,
        record.force_unit,
        record.name,
        True,
        warmth,
        record.notes,
    )
