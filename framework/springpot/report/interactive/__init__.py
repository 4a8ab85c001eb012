"""What a page in a browser shows of an answer, as data and as ES modules: for the report and for the workbench.

A report has no server: all that is pointed at must be in its file. The workbench draws with the same modules.
"""

from .answers import drawn, proposed_points, rungs
from .assets import modules
from .bench import bench_of
from .previews import grown_by_each
from .scene import PageScene, relative_error, rounded

__all__ = [
    "PageScene",
    "bench_of",
    "drawn",
    "grown_by_each",
    "modules",
    "proposed_points",
    "relative_error",
    "rounded",
    "rungs",
]
