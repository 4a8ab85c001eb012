"""The ES modules and style sheets that every page shares, read once."""

from __future__ import annotations

from functools import cache
from importlib.resources import files


def assets_in(package: str, folder: str) -> dict[str, bytes]:
    """Content of each file in a folder of a package, by name."""
    return {
        item.name: item.read_bytes()
        for item in (files(package) / folder).iterdir()
        if item.is_file()
    }


@cache
def modules() -> dict[str, bytes]:
    """Content of each shared module and style sheet, by name."""
    return assets_in("springpot.report.interactive", "modules")
