"""Records of displacement and force as tests in time.

From the binary files of laboratories and RepTate's .laos. The readers that give a stiffness for
each record know these formats; here the record itself is what was measured.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import Choice, Reader, Signals, TimeReader, TimeTest
from springpot.measurement.mixed_up import sign_note

from ..readers.grid import is_number
from ..readers.reptate import first_line
from ..readers.reptate_laos import READER as LAOS
from ..readers.signals_mat import READER as MATLAB
from ..readers.signals_tdms import READER as TDMS
from ..readers.text import HEAD, head_text
from ..readers.written import value_of
from .table import manner_of

_FORMATS = (LAOS, MATLAB, TDMS)


def recognises(head: bytes) -> float:
    """High for what one of these formats is sure of."""
    return max(reader.recognises(head) for reader in _FORMATS)


def read(path: Path, choice: Choice) -> list[TimeTest]:
    """The record in a file; none where it holds something else, such as a sweep."""
    with path.open("rb") as stream:
        head = stream.read(HEAD)
    reader = max(_FORMATS, key=lambda each: each.recognises(head))
    manner, columns = manner_of(choice, path)
    try:
        signals = _signals(reader, path, replace(choice, columns=columns))
    except DataError:
        # What lacks is asked for by the reader that finds a stiffness, which knows sweeps in such
        # files as well.
        return []
    known = (
        np.isfinite(signals.time) & np.isfinite(signals.displacement) & np.isfinite(signals.force)
    )
    temperature = manner.temperature
    if (
        temperature is None
        and (warm := first_line(head_text(head)).get("T")) is not None
        and is_number(warm)
    ):
        temperature = value_of(warm)
    test = TimeTest.of_history(
        signals.time[known],
        signals.displacement[known],
        signals.force[known],
        signals.displacement_unit,
        signals.force_unit,
        control=manner.control,
        rise=manner.ramp,
        temperature=temperature,
        name=path.stem,
        provenance={"file": path.name, **signals.provenance},
    )
    return [
        replace(
            test, provenance={**test.provenance, **sign_note(test, f"force=-{signals.force_unit}")}
        )
    ]


def _signals(reader: Reader, path: Path, choice: Choice) -> Signals:
    load = reader.signals
    assert load is not None, "all of these formats hold signals"
    return load(path, choice)


READER = TimeReader(
    "time-records",
    "displacement and force against time in MATLAB .mat, TDMS and RepTate .laos",
    recognises,
    read,
)
