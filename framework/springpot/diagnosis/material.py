"""The third line: the least error that any linear passive material reaches, beside the same effects.

Below it lies what a spring, dashpot, springpot or mode may mend; above it what no material does at one temperature
and amplitude: a mass, the instrument, temperature, amplitude, history.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from springpot.identification import is_material
from springpot.rheology import Continuum, Model

from .battery import Battery, battery
from .policy import VERDICT
from .refit import Refit, refit
from .result import Error
from .words import percent, times

NAME = "material"


@dataclass(frozen=True, eq=False)
class MaterialFloor:
    """Any linear passive material with the effects of a model.

    Attributes
    ----------
    refit : Refit
        Its fit, in units of the same noise.
    rest : Battery
        The test on its residual.
    """

    refit: Refit
    rest: Battery

    @property
    def relative_rms(self) -> float:
        """The least error, relative to |K|."""
        return self.refit.relative_rms

    @property
    def chance(self) -> float:
        """That noise alone leaves a residual like this."""
        return self.rest.p_value


def any_material() -> Model:
    """The model of any linear passive material, which is judged where no model is named."""
    return Model(NAME, Continuum(), "any linear passive material")


def of_any_material(base: Refit) -> Refit:
    """The fit of any material in the place of a model's own, its effects fitted anew."""
    if is_material(base.model):
        return base
    free = replace(any_material(), effects=base.model.effects)
    seed = base.theta[len(base.model.material.parameters) :]
    return refit(free, base.data, base.noise, [seed])


def material_floor(base: Refit, rng: np.random.Generator) -> MaterialFloor:
    """The least error that any material reaches in the place of a model's own, its effects fitted anew.

    Parameters
    ----------
    base : Refit
        A fitted model.
    rng : numpy.random.Generator
        For simulated noise.
    """
    found = of_any_material(base)
    return MaterialFloor(found, battery(found.frame(), rng))


def error_of(base: Refit, floor: MaterialFloor) -> Error:
    """The three lines: a model's error, the noise floor, the material floor."""
    noise = base.noise
    return Error(base.relative_rms, base.floor, noise.source, noise.doubt, floor.relative_rms, floor.chance)


def split_in_words(base: Refit, floor: MaterialFloor, alarm: float) -> str:
    """What the third line says of a model that fails; nothing where it is the material itself.

    Parameters
    ----------
    base : Refit
        The model.
    floor : MaterialFloor
        What any material reaches.
    alarm : float
        Chance of noise below which something is held to be left.
    """
    if is_material(base.model):
        return ""
    spare = base.fit.dof
    misfit, left = max(base.rss - spare, 0.0), max(floor.refit.rss - floor.refit.fit.dof, 0.0)
    could = f"a material could be at {percent(floor.relative_rms)}"
    beside = f" ({times(floor.relative_rms / floor.refit.floor)} the noise floor)"
    # Where the noise was estimated from this very fit, both are zero, and no material comes nearer.
    if left > VERDICT.mostly * misfit or (misfit == 0.0 and floor.chance < alarm):
        would = f"any linear material would be {percent(floor.relative_rms)} off"
        return f"{would}: what is missing is no part of the material"
    if floor.chance >= alarm:
        return f"{could}: a spring, dashpot, springpot or mode is missing, or an effect that looks like one"
    if left > (1.0 - VERDICT.mostly) * misfit:
        return f"{could}{beside}: a part of the material is missing, and something that is no part of it"
    return f"{could}{beside}: most of what is missing is a part of the material, the rest is not"
