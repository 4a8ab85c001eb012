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

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .contract import (
        PluginContract as PluginContract,
        check_dataset as check_dataset,
        check_objective as check_objective,
        check_plugin as check_plugin,
        check_writer as check_writer,
    )
    from .effects import check_effect as check_effect, check_model as check_model
    from .others import check_optimiser as check_optimiser, check_reader as check_reader

__getattr__, __dir__ = offered(__name__)

__all__ = __dir__()
