"""Quantities that follow from a fit or from data: crossover, plateau, viscosity, linear limit ...

Each with its interval, and whether the data or the model say it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .asking import quantities as quantities

__getattr__, __dir__ = offered(__name__)
