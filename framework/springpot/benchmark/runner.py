"""Runs a study: plans it, lets an engine work, keeps every result at once, writes the tables."""

from __future__ import annotations

import os
import platform
import shlex
import sys
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import ExitStack, closing, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from springpot.versions import versions

from .engine import check_engine, make_engine
from .findings import write_tables
from .plan import Plan
from .progress import Progress, Silent, make_progress
from .script import load_study
from .store import Store
from .study import Study
from .summary import store_path


@dataclass(frozen=True)
class Outcome:
    """What a run of a study came to.

    Parameters
    ----------
    store : Path
        The SQLite file.
    trials : int
        Trials of the study.
    ran, failed : int
        Trials of this run, and those of them that failed.
    tables : tuple of Path
        Files written.
    """

    store: Path
    trials: int
    ran: int
    failed: int
    tables: tuple[Path, ...]


def run_study(
    study: Study | str | Path,
    workers: int | None = None,
    engine: str | Executor | None = None,
    budget: int | None = None,
    repeats: int | None = None,
    out: Path = Path("results"),
    quiet: bool = False,
    retry_failed: bool = False,
    tables: bool = True,
) -> Outcome:
    """Run what is missing of a study, then write its tables.

    Parameters
    ----------
    study : Study, str or Path
        A study or the path of its script.
    workers : int, optional
        Processes; by default one for each core.
    engine : str or Executor, optional
        ``local`` (default), ``serial``, ``dask:ADDRESS`` or an executor.
    budget, repeats : int, optional
        Instead of the study's own.
    out : Path
        Folder of all results.
    quiet : bool
        Show no progress.
    retry_failed : bool
        Run trials that failed before, or whose records are damaged, once more.
    tables : bool
        Write the tables and what the study adds to them.

    Raises
    ------
    SpringpotError
        If the study, its store or its engine cannot be used.
    KeyboardInterrupt
        After Ctrl-C; finished trials are kept.
    """
    if isinstance(study, Study):
        script, declared = None, study
    else:
        script = Path(study)
        with _aside(quiet):
            declared = load_study(study)
    # Before the plan, which reads all data: a slip in the name of an engine is told at once.
    check_engine(engine)
    plan = declared.with_options(budget, repeats).plan()
    path = store_path(declared, Path(out))
    with Store(path, write=True, mend=retry_failed) as store:
        # Before the first trial, so that a run that is interrupted can be shown and resumed.
        numbers = store.register(plan, provenance(plan))
        if retry_failed:
            store.forget_failed(numbers.values())
        ran, failed = _work(plan, store, numbers, script, workers, engine, quiet)
    written: list[Path] = []
    if tables:
        written = write_tables(path)
        if declared.finish is not None:
            with _aside(quiet):
                declared.finish(path, path.parent)
    return Outcome(path, plan.size, ran, failed, tuple(written))


@contextmanager
def _aside(quiet: bool) -> Iterator[None]:
    """Let what a script prints go to standard error, or nowhere."""
    with ExitStack() as stack:
        stream = sys.stderr
        if quiet:
            stream = stack.enter_context(open(os.devnull, "w"))
        stack.enter_context(redirect_stdout(stream))
        stack.enter_context(redirect_stderr(stream))
        yield


def _work(
    plan: Plan,
    store: Store,
    numbers: dict[int, int],
    script: Path | None,
    workers: int | None,
    engine: str | Executor | None,
    quiet: bool,
) -> tuple[int, int]:
    """Numbers of trials that ran and of those that failed."""
    # A store may hold more repetitions than are asked for now: those beyond are no part of this
    # run.
    kept = 0
    for number in numbers.values():
        kept += sum(repetition < plan.repetitions for repetition in store.finished(number))
    progress: Progress = Silent()
    if not quiet:
        progress = make_progress(plan.name, plan.size)
    progress.update(kept, 0)
    if kept == plan.size:
        progress.close()
        return 0, 0
    ran = failed = 0
    tasks = plan.tasks(lambda cell: store.finished(numbers[cell.index]))
    try:
        with closing(make_engine(plan, script, workers, engine, quiet).run(tasks)) as stream:  # type: ignore[type-var]
            for results in stream:
                # At once: whatever ends this process next, what is done is kept.
                store.add(results, numbers)
                ran += len(results)
                failed += sum(result.status.failed for result in results)
                progress.update(min(kept + ran, plan.size), failed)
    except KeyboardInterrupt:
        _say_goodbye(progress, plan, kept + ran)
        raise
    progress.close()
    return ran, failed


def _say_goodbye(progress: Progress, plan: Plan, done: int) -> None:
    progress.close()
    line = (
        f"{plan.name}: interrupted; {min(done, plan.size)} of {plan.size} trials are kept, run"
        " again to go on"
    )
    print(line, file=sys.stderr)


def provenance(plan: Plan) -> dict[str, str]:
    """Versions, machine and command of this run."""
    facts = {
        "python": platform.python_version(),
        "machine": platform.platform(),
        "processor": platform.machine(),
    }
    facts |= versions(
        entrant.optimiser.card.distribution
        for entrant in plan.entrants
        if entrant.optimiser.card.distribution
    )
    # As a module, ``python -m springpot.cli``, the program is a file of another name.
    facts["command"] = shlex.join(
        [Path(sys.argv[0]).name.replace("__main__.py", "springpot"), *sys.argv[1:]]
    )
    facts["started"] = datetime.now(UTC).isoformat(timespec="seconds")
    return facts
