"""How far a model is off.

The noise floor, the material floor, where it fails, and what noise alone would do.

Nothing here names an effect: `springpot.diagnosis` does, and `springpot.comparison` lays models
side by side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .error import Error
    from .material import any_material
    from .residual_battery import Finding
    from .where import Where

__all__ = [
    "Error",
    "Finding",
    "Where",
    "any_material",
]

_WHERE = {
    "Error": "springpot.misfit.error",
    "Finding": "springpot.misfit.residual_battery",
    "Where": "springpot.misfit.where",
    "any_material": "springpot.misfit.material",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
