"""Contract tests for authors of plugins; loaded when used, so that this costs nothing to import.

A whole test file::

    import my_plugin
    from springpot.testing import PluginContract


    class TestMyPlugin(PluginContract):
        plugin = my_plugin

The functions ``check_*`` do the same for one thing and return plain sentences that say what is wrong.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_WHERE = {
    "PluginContract": "contract",
    "check_dataset": "datasets",
    "check_effect": "effects",
    "check_model": "models",
    "check_objective": "objectives",
    "check_optimiser": "optimisers",
    "check_plugin": "contract",
    "check_reader": "readers",
    "check_time_effect": "timeeffects",
}

__all__ = list(_WHERE)


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
