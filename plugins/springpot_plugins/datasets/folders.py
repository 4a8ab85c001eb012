"""Data sets in the folders of the directories that the environment variable SPRINGPOT_DATA names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from springpot.errors import DataError
from springpot.measurement import DataSet, Measurement

from .manifest import FILE, read_manifest

VARIABLE = "SPRINGPOT_DATA"
NOWHERE = Path(os.devnull)
"""Stands for the directory of a set that is not on this machine."""


def datasets() -> list[DataSet]:
    """A set for every folder with a manifest, of its own or shipped, and for every shipped one that has no folder.

    The first of a name counts.
    """
    found: dict[str, DataSet] = {}
    for folder in (*_folders(), *_known()):
        dataset = _dataset(folder)
        if dataset is not None:
            found.setdefault(dataset.name, dataset)
    return list(found.values())


def _known() -> Iterator[Path]:
    """Folders that would hold the sets of the shipped manifests, and need not be there."""
    shipped = files(__package__).joinpath("manifests").iterdir()
    yield from sorted(NOWHERE / entry.name.removesuffix(".toml") for entry in shipped if entry.name.endswith(".toml"))


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
    own = folder / FILE
    try:
        if own.is_file():
            return read_manifest(own.read_text(encoding="utf-8"), folder, str(own)).dataset()
        shipped = files(__package__).joinpath("manifests", f"{folder.name}.toml")
        if shipped.is_file():
            return read_manifest(shipped.read_text(encoding="utf-8"), folder, shipped.name).dataset()
    except (DataError, OSError, UnicodeDecodeError) as error:
        return _broken(folder, str(error))
    return None


def _broken(folder: Path, reason: str) -> DataSet:
    def load() -> Measurement:
        raise DataError(f"data set '{folder.name}' is unavailable: {reason}")

    return DataSet(folder.name, "its manifest cannot be used", load, unavailable=reason)
