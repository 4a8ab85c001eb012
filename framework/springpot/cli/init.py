"""``springpot init``: files to start from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import distribution
from importlib.resources import files
from pathlib import Path
from typing import Any

import click

from springpot.writing import NAMED, in_shell, suggested

from .common import FOLDER, INPUT, emit, json_option

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
RIVALS = ("pso-paper", "cma-es", "native")
LAW = "my-law"
"""What the law of a plugin is called until its author gives it a name."""


@click.command("init", epilog="Example: springpot init study")
@click.argument("kind", type=click.Choice(list(KINDS)), metavar="KIND")
@click.option(
    "--folder", type=FOLDER, default=Path(), metavar="DIR", help="Where to write; here by default."
)
@click.option(
    "--from",
    "source",
    type=INPUT,
    metavar="FILE",
    help="Of a plugin: the law in a file of 'springpot invent -o'.",
)
@json_option
def command(kind: str, folder: Path, source: Path | None, as_json: bool) -> None:
    """Write files to start from.

    KIND is study (a race of optimisers), plugin or ci (an accuracy gate).

    A file that is there already is never replaced: ci races the study that is there.
    """
    from springpot.errors import OptionError, OutputError
    from springpot.files import write_text

    texts = {name: _template(name) for name in KINDS[kind]}
    if "study" in texts:
        texts["study"] = texts["study"].replace("@OPTIMISERS@", _entrants())
    if kind == "ci":
        texts["ci"] = texts["ci"].replace("@INSTALL@", _installed_from(folder))
    if source is not None:
        if kind != "plugin":
            raise OptionError(f"--from {source}: only a plugin is made of a law, not a {kind}")
        texts["plugin"] = plugin_of(source)
    paths = {name: folder / place for name, place in KINDS[kind].items()}
    kept: list[str] = []
    if kind == "ci" and paths["study"].exists():
        kept.append(str(paths.pop("study")))
    # All of them first: a folder is begun whole, or left as it is.
    there = [str(path) for path in paths.values() if path.exists()]
    if there:
        raise OutputError(
            f"{', '.join(there)}: exists already and is not replaced: choose another --folder"
        )
    for name, path in paths.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, texts[name])
    written = [str(path) for path in paths.values()]
    emit(
        {"schema": "springpot.files/1", "files": written},
        as_json,
        lambda: _show(written, kept, _next(kind, folder, source is not None)),
    )


def _entrants() -> str:
    """Names for a study: the user's own optimisers if there are any, and some to compare with."""
    from springpot import plugins

    registry = plugins()
    names = registry.shelf("optimiser").items
    own = [name for name in names if registry.owner_of("optimiser", name)]
    return ", ".join(f'"{name}"' for name in [*own[:NAMED], *RIVALS])


def _installed_from(folder: Path) -> str:
    """What a build installs: springpot from where it came, and the package in that folder."""
    origin = json.loads(distribution("springpot").read_text("direct_url.json") or "{}")
    package = "." if (folder / "pyproject.toml").exists() else ""
    # Of springpot's own folder the package is springpot.
    if package and origin.get("url") == folder.resolve().as_uri():
        return package
    return _addresses(origin, package)


def _addresses(origin: Mapping[str, Any], package: str) -> str:
    """Where pip finds springpot again, and a package (or none) that needs it.

    By what pip wrote down when it installed springpot (PEP 610).
    """
    address, told = "springpot", ""
    if "vcs_info" in origin:
        version = origin["vcs_info"]
        address = f'"springpot @ {version["vcs"]}+{origin["url"]}@{version["commit_id"]}"'
    elif "archive_info" in origin and not origin["url"].startswith("file:"):
        address = f'"springpot @ {origin["url"]}"'
    elif origin:
        # A folder of this machine is nowhere else: no build could install it.
        told = "  # springpot is from a folder here: write where it is to be found"
    elif package:
        # From the index it comes with what needs it.
        return package
    return f"{address} {package}".rstrip() + told


def _template(name: str) -> str:
    return (files(__package__) / "templates" / f"{name}.txt").read_text(encoding="utf-8")


def plugin_of(source: Path) -> str:
    """The text of a plugin that offers the law of an invention.

    Parameters
    ----------
    source : Path
        A file of ``springpot invent -o``.
    """
    from springpot.loading import law_of

    effect = law_of(source, LAW)
    plane, _, formula = effect.expression[1:-1].partition("=")[2].strip().partition(": ")
    # As a literal of Python: a formula has no quotes, but its data may have any name.
    text = _template("law_plugin").replace("@LAW@", repr(f"{plane}: {formula}"))
    return text.replace("@NAME@", repr(LAW)).replace("@FILE@", source.name.replace(chr(34), ""))


def _show(written: list[str], kept: list[str], following: str) -> None:
    for path in written:
        print(f"written: {path}")
    for path in kept:
        print(f"kept:    {path}, which was there")
    print(f"\nnext: {following}")


def _next(kind: str, folder: Path, of_law: bool) -> str:
    """What to do with what was written, in the folder in which it is."""
    steps = []
    if folder != Path():
        steps.append(f"cd {in_shell(folder)}")
    if kind == "study":
        steps.append(suggested("run", KINDS[kind]["study"]))
    elif kind == "ci":
        steps.append(suggested("regression update", KINDS[kind]["study"]))
    else:
        offered = ("list effects", LAW) if of_law else ("list models", "my-model")
        steps += ["pip install -e .", "pytest", suggested(*offered)]
    return " && ".join(steps)
