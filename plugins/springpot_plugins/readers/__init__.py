"""The built-in readers."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.measurement import Reader, TimeReader

from . import (
    excel,
    generic,
    reptate,
    rheometers,
    signals_binary,
    signals_csv,
    springpot_csv,
    ta_instruments,
    tests_in_time,
)


@hookimpl
def springpot_readers() -> Iterable[Reader]:
    """All of them."""
    return (
        springpot_csv.READER,
        signals_csv.READER,
        rheometers.RHEOCOMPASS,
        ta_instruments.TRIOS_TEXT,
        ta_instruments.TRIOS_LIMS,
        ta_instruments.TRIOS_JSON,
        ta_instruments.THERMAL,
        rheometers.MALVERN,
        reptate.SWEEP,
        reptate.LAOS,
        excel.READER,
        signals_binary.MATLAB,
        signals_binary.TDMS,
        generic.READER,
    )


@hookimpl
def springpot_time_readers() -> Iterable[TimeReader]:
    """Those of tests in time."""
    return (reptate.TEST, tests_in_time.RECORD, tests_in_time.TABLE)
