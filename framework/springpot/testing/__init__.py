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

__getattr__, __dir__ = offered(
    __name__,
    {
        "contract": "check_dataset check_objective check_plugin check_writer PluginContract",
        "effects": "check_effect",
        "models": "check_model",
        "optimisers": "check_optimiser",
        "readers": "check_reader",
    },
)

__all__ = __dir__()
