"""What opening a file costs, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import process_time

from springpot.errors import DataError
from springpot.measurement import budget_of, open_measurement, parts_of, within_budget
from springpot_plugins.readers import springpot_readers

READERS = tuple(springpot_readers())
STATUS = Path("/proc/self/status")
ALLOWED_LATE = 0.5
"""Seconds of processor time by which a reader may be late in ending: one step within a library."""
ALLOWED_MORE = 32 << 20
"""Bytes of address space that the process had been given before and had not yet used."""


@dataclass(frozen=True)
class Cost:
    """One opening.

    Parameters
    ----------
    said : str
        The refusal; empty where there is a measurement.
    fault : str
        What it should not have done; empty for a measurement or a refusal in one line.
    seconds, memory : float
        Processor time, and bytes at the peak beyond what there was before (nan where the system does not tell).
    time_share, memory_share : float
        The same as shares of the budget.
    """

    said: str
    fault: str
    seconds: float
    memory: float
    time_share: float
    memory_share: float

    @property
    def held(self) -> bool:
        """Whether the promise was kept."""
        return not self.fault


def cost_of(path: Path, action=None) -> Cost:
    """Open a file, or do something else with it within its budget."""
    budget = budget_of(path)
    before, start = _peak(fresh=True), process_time()
    said = fault = ""
    try:
        _ = open_measurement(path, (), READERS) if action is None else within_budget(path, action)
    except DataError as error:
        said = str(error)
        fault = "more than one line" if "\n" in said else "" if path.name in said else "the file is not named"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        fault = f"{type(error).__name__}: {error}"
    seconds, memory = process_time() - start, _peak() - before
    if seconds > budget.seconds + ALLOWED_LATE:
        fault = fault or f"{seconds:.1f} s of {budget.seconds:.1f}"
    if memory > budget.memory + ALLOWED_MORE:
        fault = fault or f"{memory / 2**20:.0f} MiB of {budget.memory >> 20}"
    return Cost(said, fault, seconds, memory, seconds / budget.seconds, memory / budget.memory)


def parts_cost(path: Path) -> Cost:
    """List the parts of a file."""
    return cost_of(path, lambda: parts_of(path, READERS))


def _peak(fresh: bool = False) -> float:
    """Bytes of memory at the peak, from now on if `fresh`."""
    try:
        if fresh:
            Path("/proc/self/clear_refs").write_text("5")
        lines = STATUS.read_text().splitlines()
        return 1024.0 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return float("nan")
