"""How far a model is off: the noise floor, the material floor, where it fails, and what noise alone would do.

Nothing here names an effect: `springpot.diagnosis` does, and `springpot.comparison` lays models side by side.
"""

from .battery import Finding
from .error import Error
from .material import any_material
from .values import Value
from .where import Where

__all__ = [
    "Error",
    "Finding",
    "Value",
    "Where",
    "any_material",
]
