"""The built-in models, one file for each family.

Files are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.rheology import Model
from springpot.rheology.model import Family


@hookimpl
def springpot_models() -> Iterable[Model | Family]:
    """All of them."""
    from . import classical, fractional, paper, relaxation

    return (
        *paper.MODELS,
        *paper.FLUIDS,
        *classical.MODELS,
        *fractional.MODELS,
        *fractional.ASPHALT,
        *relaxation.MODELS,
        *fractional.PASSIVE,
        *classical.FAMILIES,
    )
