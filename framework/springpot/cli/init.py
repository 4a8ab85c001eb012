"""``springpot init``: files to start from."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import click

from springpot.suggestions import suggested

from .common import FOLDER, emit, json_option, quoted

KINDS: dict[str, dict[str, str]] = {
    "study": {"study": "race.py"},
    "plugin": {
        "plugin": "springpot_mine.py",
        "pyproject": "pyproject.toml",
        "plugin_test": "test_springpot_mine.py",
    },
    "ci": {"ci": ".github/workflows/accuracy.yml", "study": "race.py"},
}
"""For each kind the templates and where they go."""


@click.command("init", epilog="Example: springpot init study")
@click.argument("kind", type=click.Choice(list(KINDS)), metavar="KIND")
@click.option(
    "--folder", type=FOLDER, default=Path(), metavar="DIR", help="Where to write; here by default."
)
@json_option
def command(kind: str, folder: Path, as_json: bool) -> None:
    """Write files to start from.

    KIND is study (a race of optimisers), plugin or ci (an accuracy gate).

    A file that is there already is never replaced.
    """
    from springpot.errors import OutputError
    from springpot.files import write_text

    paths = {name: folder / place for name, place in KINDS[kind].items()}
    # All of them first: a folder is begun whole, or left as it is.
    there = [str(path) for path in paths.values() if path.exists()]
    if there:
        raise OutputError(
            f"{', '.join(there)}: exists already and is not replaced: choose another --folder"
        )
    for name, path in paths.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        template = files(__package__) / "templates" / f"{name}.txt"
        write_text(path, template.read_text(encoding="utf-8"))
    written = [str(path) for path in paths.values()]
    emit(
        {"schema": "springpot.files/1", "files": written},
        as_json,
        lambda: _show(kind, folder, written),
    )


def _show(kind: str, folder: Path, written: list[str]) -> None:
    for path in written:
        print(f"written: {path}")
    print(f"\nnext: {_next(kind, folder)}")


def _next(kind: str, folder: Path) -> str:
    """What to do with what was written, in the folder in which it is."""
    steps = []
    if folder != Path():
        steps.append(f"cd {quoted(str(folder))}")
    if kind == "study":
        steps.append(suggested("run", KINDS[kind]["study"]))
    elif kind == "ci":
        steps.append(suggested("regression update", KINDS[kind]["study"]))
    else:
        steps += ["pip install -e .", "pytest", suggested("list models", "my-model")]
    return " && ".join(steps)
