"""What is a part of any material, so that beside a free spectrum it can explain nothing."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from springpot.nonnegative import non_negative
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.model import Model

from .material import is_material

OMEGA = np.geomspace(1e-3, 1e3, 61)
"""Frequencies in rad/s, about the time of one second that an element is given."""
RATES = np.geomspace(1e-7, 1e7, 57)
"""Four lines a decade, and four decades beyond: a springpot between is followed to 0.1 %."""
FOLLOWED = 0.01
"""Relative error up to which an element is a sum of relaxations.

A mass or a constant loss is 30 % off and more.
"""


def within_material(model: Model, effect: Effect) -> bool:
    """Whether an effect is a part of any material.

    So that beside a free spectrum it can explain nothing.

    Around a material whose times are shifted, what gives way in the mounting is not shifted with
    it, and shows.

    Parameters
    ----------
    model : Model
        The material with other effects; of any other model nothing is a part of the material.
    effect : Effect
        That may be missing.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import within_material
    >>> model, registry = springpot.parse_model("material"), springpot.plugins()
    >>> [within_material(model, registry.effect(name)) for name in ("parallel-spring", "inertia")]
    [True, False]
    """
    shifted = any(own.plane == "shift" for own in model.effects)
    return (
        is_material(model)
        and not (shifted and effect.layer > Layer.MATERIAL)
        and is_passive(effect)
    )


@lru_cache(maxsize=256)
def is_passive(effect: Effect) -> bool:
    """Whether it adds a spring, dashpot, springpot or mode: what a sum of relaxations follows.

    Parameters
    ----------
    effect : Effect
        That may be missing.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import is_passive
    >>> effects = [springpot.plugins().effect(name) for name in ("series-springpot", "time-delay")]
    >>> [is_passive(effect) for effect in effects]
    [True, False]
    """
    if effect.plane not in ("stiffness", "compliance") or effect.needs:
        return False
    # Inside its range no parameter decides whether an element is passive: any value will do.
    bounds = np.array(
        [(parameter.lower, parameter.upper) for parameter in effect.element.parameters]
    )
    theta = np.where(np.isfinite(bounds[:, 1]), bounds.mean(axis=1), 1.0)
    stiffness = Model(effect.name, effect.element).stiffness(theta, OMEGA)
    s = 1j * OMEGA[:, None]
    columns = (
        np.concatenate([np.ones_like(s), s, s / (s + RATES)], axis=1) / np.abs(stiffness)[:, None]
    )
    target = stiffness / np.abs(stiffness)
    _, left = non_negative(
        np.concatenate([columns.real, columns.imag]), np.concatenate([target.real, target.imag])
    )
    return left < FOLLOWED**2 * len(OMEGA)
