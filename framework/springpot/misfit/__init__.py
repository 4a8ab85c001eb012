"""How far a model is off.

The noise floor, the material floor, where it fails, and what noise alone would do.

Nothing here names an effect: `springpot.diagnosis` does, and `springpot.comparison` lays models
side by side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .material import any_material as any_material

__getattr__, __dir__ = offered(__name__)
