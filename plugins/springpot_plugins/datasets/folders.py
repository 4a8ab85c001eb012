"""Data sets in folders of the directories that the environment variable SPRINGPOT_DATA names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from springpot.errors import LONGEST_REASON, DataError
from springpot.measurement import DataSet, Measurement, within_budget

from .manifest import FILE, LARGEST, read_manifest
from .names import inside

VARIABLE = "SPRINGPOT_DATA"
NOWHERE = Path(os.devnull)
"""Stands for the directory of a set that is not on this machine."""


def datasets() -> list[DataSet]:
    """A set for every folder with a manifest, of its own or shipped.

    Also for every shipped manifest that has no folder. The first of a name counts.
    """
    sets: dict[str, DataSet] = {}
    for folder in (*_folders(), *_known()):
        dataset = _dataset(folder)
        if dataset is not None:
            # Folders before what is shipped, in the order of the directories: a user's own goes
            # first.
            sets.setdefault(dataset.name, dataset)
    return list(sets.values())


def _known() -> Iterator[Path]:
    """Folders that would hold the sets of the shipped manifests, and need not be there."""
    shipped = files(__package__).joinpath("manifests").iterdir()
    yield from sorted(
        NOWHERE / entry.name.removesuffix(".toml")
        for entry in shipped
        if entry.name.endswith(".toml")
    )


def _folders() -> Iterator[Path]:
    """Every directory itself, if it has a manifest, and its folders in the order of their names."""
    for directory in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        root = Path(directory).expanduser()
        try:
            if (root / FILE).is_file():
                yield root
            yield from sorted(entry for entry in root.iterdir() if entry.is_dir())
        except OSError:
            # A directory that is not there holds nothing; the listing must not fail for it.
            continue


def _dataset(folder: Path) -> DataSet | None:
    """The set of a folder; unavailable, with the reason, where its manifest is wrong."""
    try:
        if (folder / FILE).is_file():
            own = inside(folder, FILE)
            return within_budget(own, lambda: read_manifest(_text(own), folder, str(own)).dataset())
        shipped = files(__package__).joinpath("manifests", f"{folder.name}.toml")
        if shipped.is_file():
            return read_manifest(
                shipped.read_text(encoding="utf-8"), folder, shipped.name
            ).dataset()
    except DataError as error:
        return _broken(folder, str(error))
    except Exception as error:
        # Whatever a stranger writes there, it must not take the other sets away.
        return _broken(folder, f"{folder / FILE}: {type(error).__name__}: {error}")
    return None


def _text(path: Path) -> str:
    """A manifest, or as much of it as is enough to see that it is too large."""
    with path.open("rb") as stream:
        return stream.read(LARGEST + 1).decode("utf-8")


def _broken(folder: Path, reason: str) -> DataSet:
    reason = " ".join(reason.split())[:LONGEST_REASON]

    def load() -> Measurement:
        raise DataError(f"data set '{folder.name}' is unavailable: {reason}")

    return DataSet(folder.name, "its manifest cannot be used", load, unavailable=reason)
