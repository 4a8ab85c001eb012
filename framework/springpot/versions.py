"""What results were made with.

Springpot, the libraries it stands on, and the plugins that are installed.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version

from springpot.registry import plugins

LIBRARIES = ("springpot", "numpy", "scipy", "nlopt", "cma", "pluggy")
"""Distributions on which numbers depend."""


def versions(further: Iterable[str] = ()) -> dict[str, str]:
    """Versions by distribution: the libraries, those of all plugins, and further ones.

    What is absent is left out.

    Parameters
    ----------
    further : iterable of str
        Names of distributions.
    """
    by_name = {}
    for name in dict.fromkeys((*LIBRARIES, *plugins().distributions(), *further)):
        try:
            by_name[name] = version(name)
        # An extra that is not installed had no part in the result.
        except PackageNotFoundError:
            continue
    return by_name
