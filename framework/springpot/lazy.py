"""Names of a package that are imported when they are first asked for.

So that the package itself costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def offered(
    package: str, where: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The module functions ``__getattr__`` and ``__dir__`` of a package.

    Parameters
    ----------
    package : str
        Its name, for the message.
    where : mapping of str to str
        The module of each name that it offers.
    """

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
