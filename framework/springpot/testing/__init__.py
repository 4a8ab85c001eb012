"""Contract tests for authors of plugins; loaded when used, so that this costs nothing to import.

A whole test file::

    import my_plugin
    from springpot.testing import PluginContract


    class TestMyPlugin(PluginContract):
        plugin = my_plugin

The functions ``check_*`` do the same for one thing and return plain sentences that say what is
wrong.
"""

from __future__ import annotations

from springpot.lazy import offered

_WHERE = {
    "PluginContract": "springpot.testing.contract",
    "check_dataset": "springpot.testing.contract",
    "check_effect": "springpot.testing.effects",
    "check_model": "springpot.testing.models",
    "check_objective": "springpot.testing.contract",
    "check_optimiser": "springpot.testing.optimisers",
    "check_plugin": "springpot.testing.contract",
    "check_reader": "springpot.testing.readers",
}

__all__ = list(_WHERE)

__getattr__, __dir__ = offered(__name__, _WHERE)
