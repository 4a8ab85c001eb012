"""Any linear passive material: the model of all networks of springs, dashpots and springpots."""

from __future__ import annotations

from springpot.rheology import Continuum, Model

MODELS = (
    Model(
        "material",
        Continuum(),
        "any linear passive material: a spectrum of relaxation times, the least error that any"
        " model reaches",
        "Ferry, Viscoelastic Properties of Polymers (1980), ch. 3",
        aliases=("any-material", "free-spectrum"),
    ),
)
