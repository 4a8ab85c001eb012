"""What opening a file costs, and what came of it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import process_time

from springpot.errors import DataError
from springpot.limits import own_process
from springpot.measurement import budget_of, open_measurement, parts_of, within_budget
from springpot_plugins.readers import springpot_readers

READERS = tuple(springpot_readers())
ALLOWED_TIMES = 4
"""How many times its budget a reader may take before it has ended.

One step within a library cannot be interrupted,
and takes longer on a slow machine. Without a budget these files take 20 to 1000 times as long, or
never end.
"""


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
        Processor time, and bytes at the peak beyond what there was before (nan where the system
        does not tell).
    time_share, memory_share : float
        The same as shares of what is allowed.
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
    """Open a file, or do something else with it, within its budget as the command line does."""
    budget = budget_of(path)
    _forget_peak()
    before, reserved, start = (
        _status("VmHWM"),
        _status("VmData") - _status("RssAnon"),
        process_time(),
    )
    said = fault = ""
    try:
        with own_process():
            _ = (
                open_measurement(path, (), READERS)
                if action is None
                else within_budget(path, action)
            )
    except DataError as error:
        said = str(error)
        fault = (
            "more than one line"
            if "\n" in said
            else ""
            if path.name in said
            else "the file is not named"
        )
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        fault = f"{type(error).__name__}: {error}"
    seconds, memory = process_time() - start, _status("VmHWM") - before
    if seconds > ALLOWED_TIMES * budget.seconds:
        fault = fault or f"{seconds:.1f} s of {budget.seconds:.1f}"
    # The kernel counts what a process asks for: what this one had asked for before, and not used,
    # is not counted.
    allowed = budget.memory + reserved
    if memory > allowed:
        fault = fault or f"{memory / 2**20:.0f} MiB of {budget.memory >> 20}"
    return Cost(said, fault, seconds, memory, seconds / budget.seconds, memory / allowed)


def parts_cost(path: Path) -> Cost:
    """List the parts of a file."""
    return cost_of(path, lambda: parts_of(path, READERS))


def _forget_peak() -> None:
    """Let the peak of memory be that from now on."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _status(key: str) -> float:
    """What the system tells of this process, in bytes."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
        return 1024.0 * next(int(line.split()[1]) for line in lines if line.startswith(f"{key}:"))
    except (OSError, StopIteration):
        return float("nan")
