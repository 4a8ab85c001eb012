"""Benchmark: studies, their engines and store, statistics and tables."""

from .columns import frame
from .export import export
from .exported import Export
from .findings import Findings, summarise, write_tables
from .runner import Outcome, run_study
from .script import load_study
from .statistics import Interval
from .store import Store
from .study import Study
from .summary import store_path
from .tables import FORMATS, Table, save_table
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
