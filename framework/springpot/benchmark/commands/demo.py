"""``springpot demo``: the whole story on data that come with the package."""

from __future__ import annotations

import io
import shlex
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING

import click

from springpot.cli.common import FOLDER, emit, json_option

if TYPE_CHECKING:
    from springpot.hooks import Chapter, Race

SHOWN = ("data set", "optimiser", "success", "evaluations to target", "parameter error")
"""Columns of the race's summary that are printed; all are in its tables."""


@click.command("demo", epilog="Example: springpot demo --out results/demo")
@click.option(
    "--out",
    type=FOLDER,
    default=Path("results/demo"),
    show_default=True,
    metavar="DIR",
    help="Results go here.",
)
@json_option
def command(out: Path, as_json: bool) -> int:
    """Identify, diagnose, race and discover on embedded data, in under a minute.

    Every chapter is a command that you could type; what it prints is kept beside its figures.
    """
    from springpot.errors import OutputError, PluginError
    from springpot.files import write_text
    from springpot.registry import plugins

    chapters = list(plugins().items("chapter"))
    if not chapters:
        raise PluginError("there is no demonstration: no plugin that is installed offers one")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = error.strerror
        if out.is_file():
            reason = "it is a file, name a folder"
        raise OutputError(f"cannot write into {out}: {reason}") from error
    story, worst = [], 0
    for i, chapter in enumerate(chapters, 1):
        heading = f"{i}. {chapter.title}"
        if not as_json:
            if i > 1:
                print()
            print(f"{heading}\n{'=' * len(heading)}", flush=True)
        text, code = _told(chapter, out)
        if not as_json:
            print(text, end="", flush=True)
        story.append(f"{heading}\n{'=' * len(heading)}\n{text}")
        # A chapter without a full answer does not end the story, but its exit code is not lost.
        worst = max(worst, code)
    write_text(out / "story.txt", "\n".join(story))
    files = sorted(str(path) for path in out.rglob("*") if path.is_file())
    emit(
        {"schema": "springpot.files/1", "files": files}, as_json, lambda: print(f"\nwritten: {out}")
    )
    return worst


def _told(chapter: Chapter, out: Path) -> tuple[str, int]:
    """What a chapter prints, and its exit code."""
    if chapter.race is not None:
        return _run(chapter.race, out), 0
    from springpot.cli.group import run

    # The folder is put into each word by itself, so that a blank in its name parts no words.
    arguments = [part.replace("{out}", str(out)) for part in chapter.command]
    typed = f"$ springpot {shlex.join(arguments)}\n"
    if chapter.left_to_user:
        return typed, 0
    printed = io.StringIO()
    # What a chapter prints goes into the story as well.
    with redirect_stdout(printed):
        code = run(arguments)
    return f"{typed}\n{printed.getvalue()}", code


def _run(race: Race, out: Path) -> str:
    """Run a race and give its summary as text."""
    from springpot.benchmark.runner import run_study
    from springpot.benchmark.standings import study_tables
    from springpot.benchmark.store import Store
    from springpot.benchmark.study import Study
    from springpot.report.page import text
    from springpot.report.text import TextTable

    study = Study(
        race.name,
        datasets=list(race.datasets),
        models=["own"],
        objectives=[race.objective],
        optimisers=list(race.optimisers),
        repetitions=race.repetitions,
        budget=race.budget,
    )
    outcome = run_study(study, out=out, quiet=True)
    with Store(outcome.store) as store:
        summary = dict(study_tables(store, ["summary"]))["summary"]
    chosen = [summary.columns.index(column) for column in SHOWN]
    rows = [[text(row[k]) for k in chosen] for row in summary.rows]
    shown = TextTable(SHOWN, rows, frozenset(SHOWN[2:])).plain()
    return f"{shown}\n\nall tables: {outcome.store.parent}\n"
