"""Names of a package that are imported when they are first asked for.

So that the package itself costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def offered(
    package: str, names: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The module functions ``__getattr__`` and ``__dir__`` of a package.

    Parameters
    ----------
    package : str
        Its name.
    names : mapping of str to str
        What it offers of each of its modules, with spaces between. A module with a dot is named in
        full.
    """
    where = {
        name: module if "." in module else f"{package}.{module}"
        for module, offers in names.items()
        for name in offers.split()
    }

    def get(name: str) -> Any:
        if name not in where:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        module = import_module(where[name])
        # A module that is offered by its own name.
        if where[name] == f"{package}.{name}":
            return module
        return getattr(module, name)

    def listed() -> list[str]:
        return sorted(where)

    return get, listed
