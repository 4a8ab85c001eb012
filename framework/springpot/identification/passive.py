"""What is a part of any material, so that beside a free spectrum it can explain nothing."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from springpot.errors import ModelError
from springpot.rheology import Effect, Layer, Model

from .material import is_material


def within_material(model: Model, effect: Effect) -> bool:
    """Whether an effect is a part of any material, so that beside a free spectrum it can explain nothing.

    Around a material whose times are shifted, what gives way in the mounting is not shifted with it, and shows.

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
    return is_material(model) and not (shifted and effect.layer > Layer.MATERIAL) and _is_passive(effect)


@lru_cache(maxsize=256)
def _is_passive(effect: Effect) -> bool:
    """Whether it adds a spring, dashpot, springpot or mode: what has a relaxation spectrum, and no mass."""
    if effect.plane not in ("stiffness", "compliance") or effect.needs:
        return False
    element = Model(effect.name, effect.element)
    bounds = np.array([(parameter.lower, parameter.upper) for parameter in element.parameters])
    # Inside its range the sign of a spectrum does not depend on the parameters: any value will do.
    theta = np.where(np.isfinite(bounds[:, 1]), bounds.mean(axis=1), 1.0)
    try:
        return element.spectrum(theta).mass == 0.0
    except ModelError:
        return False
