"""``springpot archive``: a study's trials as one file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from springpot.cli.common import DATA, FILE, INPUT, emit, json_option, results_option


@click.command("archive", epilog="Example: springpot archive race -o race.zip")
@click.argument("study", type=DATA, metavar="STUDY")
@click.option(
    "-o",
    "--output",
    "path",
    type=FILE,
    metavar="FILE",
    help="By default NAME.zip beside the results.",
)
@click.option("--thin", is_flag=True, help="Leave out improvements that no curve shows.")
@click.option(
    "--beside",
    type=INPUT,
    metavar="FILE",
    help="Put the trials of this archive into the new one too.",
)
@results_option("Where results are.")
@json_option
def command(
    study: str, path: Path | None, thin: bool, beside: Path | None, out: Path, as_json: bool
) -> None:
    """Write trials, versions, machine and seeds of STUDY into one file.

    Others compare with it without running it: springpot tables MINE --beside FILE, or springpot run
    FILE --optimiser NAME. An archive grows by what was raced beside it: springpot archive
    NAME-beside --beside NAME.zip -o NAME-2.zip
    """
    from springpot.benchmark.archive import opened, write_archive
    from springpot.benchmark.summary import store_path

    store = store_path(study, out)
    if path is None:
        path = store.with_suffix(".zip")
    with opened(store, beside) as found:
        trials = write_archive(found, path, thin)
    result: dict[str, Any] = {"schema": "springpot.archived/1", "file": path, "trials": trials}
    emit(result, as_json, lambda: print(f"{trials} trials in {path}"))
