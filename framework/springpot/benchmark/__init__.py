"""Benchmark: studies, their engines and store, statistics and tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from springpot.report.tables import FORMATS, Table, save_table

    from .columns import frame
    from .exporting import Export, export
    from .runner import Outcome, run_study
    from .standings import Findings, summarise, write_tables
    from .statistics import Interval
    from .store import Store
    from .study import Study
    from .summary import load_study, store_path
    from .trial import Status

__all__ = [
    "FORMATS",
    "Findings",
    "Export",
    "Interval",
    "Outcome",
    "Status",
    "Store",
    "Study",
    "Table",
    "export",
    "frame",
    "load_study",
    "run_study",
    "save_table",
    "store_path",
    "summarise",
    "write_tables",
]

_WHERE = {
    "Export": "springpot.benchmark.exporting",
    "FORMATS": "springpot.report.tables",
    "Findings": "springpot.benchmark.standings",
    "Interval": "springpot.benchmark.statistics",
    "Outcome": "springpot.benchmark.runner",
    "Status": "springpot.benchmark.trial",
    "Store": "springpot.benchmark.store",
    "Study": "springpot.benchmark.study",
    "Table": "springpot.report.tables",
    "export": "springpot.benchmark.exporting",
    "frame": "springpot.benchmark.columns",
    "load_study": "springpot.benchmark.summary",
    "run_study": "springpot.benchmark.runner",
    "save_table": "springpot.report.tables",
    "store_path": "springpot.benchmark.summary",
    "summarise": "springpot.benchmark.standings",
    "write_tables": "springpot.benchmark.standings",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
