"""Finds effects by name.

The registry of plugins puts its own finder here, so that rheology imports no host.
"""

from __future__ import annotations

from collections.abc import Callable

from springpot.errors import ModelError

from .effect import Effect


def _unset(name: str) -> Effect:
    raise ModelError(f"effect '{name}' cannot be looked up by name before 'import springpot'")


_finder: Callable[[str], Effect] = _unset


def use_finder(finder: Callable[[str], Effect]) -> None:
    """Let `finder` resolve effect names from now on."""
    global _finder
    _finder = finder


def find_effect(name: str) -> Effect:
    """The effect called `name`.

    Raises
    ------
    ModelError
        If no plugin offers it.
    """
    return _finder(name)
