"""The built-in models, one small file for each family."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.hooks import hookimpl
from springpot.rheology import Model
from springpot.rheology.model import Family

from . import asphalt, classical, fluids, fractional, paper, passive, relaxation, spectra


@hookimpl
def springpot_models() -> Iterable[Model | Family]:
    """All of them."""
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
