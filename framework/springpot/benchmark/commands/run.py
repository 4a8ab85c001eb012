"""``springpot run``: run a study, or resume it, and write its tables and its report."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from springpot.cli.common import (
    INPUT,
    POSITIVE,
    emit,
    json_option,
    own_stdout,
    results_option,
)

if TYPE_CHECKING:
    from springpot.benchmark.study import Study


@click.command("run", epilog="Example: springpot run race.py --workers 2")
@click.argument("study", type=INPUT, metavar="STUDY.py")
@click.option(
    "--workers", type=POSITIVE, metavar="N", help="Processes; one for each core by default."
)
@click.option("--engine", metavar="NAME", help="local (default), serial or dask:ADDRESS.")
@click.option(
    "--budget",
    type=POSITIVE,
    metavar="N",
    help="Evaluations of each trial, instead of the study's.",
)
@click.option(
    "--repeats", type=POSITIVE, metavar="N", help="Trials of each cell, instead of the study's."
)
@results_option("Results go here.")
@click.option(
    "--beside",
    type=INPUT,
    metavar="FILE",
    help="Show this archive in the tables too.",
)
@click.option(
    "--optimiser",
    "optimisers",
    multiple=True,
    metavar="NAME",
    help="Race this one, with options as in pso-paper:particles=40, beside an archive that is"
    " given for STUDY.py; may be repeated.",
)
@click.option(
    "--problem",
    "problems",
    multiple=True,
    metavar="NAME",
    help="Of the archive, on this one alone; may be repeated.",
)
@click.option("--retry-failed", is_flag=True, help="Run trials that failed before once more.")
@click.option("--quiet", "-q", is_flag=True, help="Show no progress.")
@json_option
def command(
    study: Path,
    workers: int | None,
    engine: str | None,
    budget: int | None,
    repeats: int | None,
    out: Path,
    beside: Path | None,
    optimisers: tuple[str, ...],
    problems: tuple[str, ...],
    retry_failed: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Run what is missing of the study that STUDY.py declares, and write its tables and report.

    Finished trials are kept: after an interruption, the same command goes on. An archive in place
    of STUDY.py gives the problems, and its trials are the rivals: springpot run published.zip
    --optimiser mine
    """
    from springpot.benchmark.archive import study_of
    from springpot.benchmark.runner import run_study
    from springpot.benchmark.study_report import write_study_report

    if workers is not None and engine not in (None, "local"):
        raise click.UsageError("give --workers or --engine, not both")
    is_archive = study.suffix == ".zip"
    if is_archive and not optimisers:
        raise click.UsageError("who races beside what an archive holds? Give --optimiser NAME")
    if (optimisers or problems) and not is_archive:
        raise click.UsageError(
            "--optimiser and --problem go with an archive (.zip); a study names its own"
        )
    # Optimisers of other makers print what they like.
    with own_stdout(quiet):
        declared: Study | Path = study
        if is_archive:
            declared, beside = study_of(study, optimisers, problems), study
        outcome = run_study(
            declared, workers, engine, budget, repeats, out, quiet, retry_failed, beside=beside
        )
    result = {
        "schema": "springpot.run/1",
        **asdict(outcome),
        "report": write_study_report(outcome.store, beside=beside),
    }
    emit(result, as_json, lambda: _show(result))


def _show(result: dict[str, Any]) -> None:
    failed = ""
    if result["failed"]:
        failed = f", {result['failed']} of them failed"
    print(f"{result['trials']} trials, {result['ran']} run now{failed}; kept in {result['store']}")
    files = [Path(path) for path in result["tables"]]
    # Each table comes in several formats: told once, in the order in which they were written.
    tables = dict.fromkeys(path.stem for path in files)
    formats = dict.fromkeys(path.suffix for path in files)
    for folder in dict.fromkeys(path.parent for path in files):
        print(f"tables in {folder}: {', '.join(tables)} ({', '.join(formats)})")
    print(f"report: {result['report']}")
