"""The built-in models, one small file for each family.

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
    from . import asphalt, classical, fluids, fractional, paper, passive, relaxation, spectra

    return (
        *paper.MODELS,
        *fluids.MODELS,
        *classical.MODELS,
        *fractional.MODELS,
        *asphalt.MODELS,
        *relaxation.MODELS,
        *passive.MODELS,
        *spectra.FAMILIES,
    )
