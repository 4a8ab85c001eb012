"""Benchmark: studies, their engines and store, statistics and tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from springpot.report.page import FORMATS as FORMATS, Table as Table, save_table as save_table

    from .exporting import Export as Export, export as export, frame as frame
    from .runner import Outcome as Outcome, run_study as run_study
    from .standings import (
        Findings as Findings,
        summarise as summarise,
        write_tables as write_tables,
    )
    from .statistics import Interval as Interval
    from .store import Store as Store
    from .study import Study as Study
    from .summary import load_study as load_study, store_path as store_path
    from .trial import Status as Status

__getattr__, __dir__ = offered(__name__)

__all__ = __dir__()
