"""Any linear passive material: the model of all networks of springs, dashpots and springpots."""

from __future__ import annotations

from springpot.rheology import Continuum, Model

MODELS = (
    Model(
        "material",
        Continuum(),
        "any linear passive material: a spectrum of relaxation times without a model, the least error that any reaches",
        "Ferry, Viscoelastic Properties of Polymers, 1980, ch. 3; Lawson and Hanson 1995, doi:10.1137/1.9781611971217",
        aliases=("any-material", "free-spectrum"),
    ),
)
