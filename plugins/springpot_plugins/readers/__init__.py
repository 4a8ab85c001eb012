"""The built-in readers."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.measurement import Reader, TimeReader

from ..timereaders import records as time_records, reptate as time_reptate, table as time_table
from . import (
    excel,
    generic,
    malvern,
    reptate,
    reptate_laos,
    rheocompass,
    signals_csv,
    signals_mat,
    signals_tdms,
    springpot_csv,
    ta_thermal,
    trios_json,
    trios_lims,
    trios_text,
)


@hookimpl
def springpot_readers() -> Iterable[Reader]:
    """All of them."""
    return (
        springpot_csv.READER,
        signals_csv.READER,
        rheocompass.READER,
        trios_text.READER,
        trios_lims.READER,
        trios_json.READER,
        ta_thermal.READER,
        malvern.READER,
        reptate.READER,
        reptate_laos.READER,
        excel.READER,
        signals_mat.READER,
        signals_tdms.READER,
        generic.READER,
    )


@hookimpl
def springpot_time_readers() -> Iterable[TimeReader]:
    """Those of tests in time."""
    return (time_reptate.READER, time_records.READER, time_table.READER)
