"""``springpot export``: a study's results for other tools."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from springpot.cli.common import DATA, FOLDER, emit, json_option, results_option

FORMATS = ("ioh", "coco", "csv", "parquet")


@click.command("export", epilog="Example: springpot export race --format ioh -o for-iohanalyzer")
@click.argument("study", type=DATA, metavar="STUDY")
@click.option("--format", "kind", type=click.Choice(FORMATS), required=True, help="For which tool.")
@click.option(
    "-o",
    "--output",
    "folder",
    type=FOLDER,
    metavar="DIR",
    help="Folder; by default beside the results.",
)
@results_option("Where results are.")
@json_option
def command(study: str, kind: str, folder: Path | None, out: Path, as_json: bool) -> None:
    """Write the results of STUDY (name, script, folder, store or archive) for another tool.

    ioh: IOHanalyzer and iohinspector; coco: cocopp; csv and parquet: every trial, and every point
    of its trace.
    """
    from springpot.benchmark.exporting import export

    result = {
        "schema": "springpot.export/1",
        "format": kind,
        **asdict(export(study, kind, folder, out)),
    }
    emit(result, as_json, lambda: _show(result))


def _show(result: dict[str, Any]) -> None:
    lost = ""
    if result["left_out"]:
        lost = f"; {result['left_out']} that came to nothing are left out"
    print(f"{result['trials']} trials in {len(result['files'])} files in {result['folder']}{lost}")
    print(f"to open: {result['hint']}")
