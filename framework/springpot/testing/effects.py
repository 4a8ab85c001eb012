"""The contract of an effect, which is tried on a model."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from springpot.errors import DataError
from springpot.rheology.effect import CONTROLS, Effect, Layer
from springpot.rheology.model import Model
from springpot.rheology.points import Points

from ..numerics import NEGLIGIBLE
from .laws import law_aspects
from .networks import (
    POINTS,
    SAMPLE,
    SEED,
    Aspect,
    cited,
    complaints,
    name_and_summary,
    network_aspects,
    sample,
)

COLUMNS = frozenset({"amplitude", "temperature"})
NEARLY = 1e-24
"""Distance from the size at which an effect vanishes, relative to its typical size."""


def check_effect(effect: Effect, *, on: Model = SAMPLE, skip: Collection[str] = ()) -> list[str]:
    """What is wrong with an effect, as plain sentences.

    Aspects: ``words`` (name, summary, citation, prior), ``shapes``, ``derivatives`` (of the grown
    model), ``pure`` (arguments are left alone) and ``vanishes`` (at ``vanishes_at``, and only
    there). Of the network also ``parameters``, ``finite``, ``units``, ``columns`` (it asks for the
    conditions that it uses, no others) and ``harmonic``; of what a test in time did ``suits`` (some
    test can have it).

    Parameters
    ----------
    effect : Effect
        The effect.
    on : Model
        The model that it joins.
    skip : collection of str
        Aspects to leave out.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    # An effect of the levels of a column has parameters only once it knows these levels.
    effect = effect.bound_to(POINTS)
    aspects: dict[str, Aspect] = {"words": lambda: _words(effect)}
    if effect.of_test:
        return complaints(aspects | law_aspects(effect), skip)
    grown = on + effect
    aspects |= {
        **network_aspects(grown),
        "vanishes": lambda: _vanishes(effect, on, grown),
        "columns": lambda: _columns(effect, grown),
        "harmonic": lambda: _harmonic(effect),
    }
    return complaints(aspects, skip)


def _words(effect: Effect) -> Iterator[str]:
    yield from name_and_summary(effect.name, effect.summary, effect.aliases)
    yield from cited(effect.citation)
    if not 0.0 < effect.prior <= 1.0:
        yield f"the prior is {effect.prior}, not above 0 and at most 1"
    if not isinstance(effect.layer, Layer):
        yield (
            f"the layer is {effect.layer!r}, not one of {', '.join(layer.name for layer in Layer)}"
        )
    if not effect.element.parameters:
        yield "the element has no parameter, so there is no size to be found"
    if effect.of_test and len(effect.signature.split()) < 3:
        yield "the signature must say in a sentence how the effect shows in a record"
    controls = effect.applies_to.controls
    if not controls or set(controls) - set(CONTROLS):
        yield f"controls are some of {', '.join(CONTROLS)}, not {controls!r}"


def _vanishes(effect: Effect, on: Model, grown: Model) -> Iterator[str]:
    theta = sample(grown.parameters, np.random.default_rng(SEED), (4,))
    n = len(on.parameters)
    alone = on.stiffness(theta[:, :n], POINTS)
    if not np.max(np.abs(grown.stiffness(theta, POINTS) / alone - 1.0)) > 1e-4:
        yield "at its typical size it changes nothing"
    size, null = effect.element.parameters[0], effect.vanishes_at
    # A factor at every level: the effect is gone only when all of them are.
    if effect.by_levels:
        theta[:, n:] = null
    # A size that is zero as a rule gives no scale to come near by.
    typical = abs(size.typical) or 1.0
    if np.isinf(null):
        # An effect that vanishes at infinity, such as the stiffness of a mounting.
        theta[:, n] = typical / NEARLY
    elif null == 0.0:
        theta[:, n] = NEARLY * typical
    else:
        theta[:, n] = null + NEARLY * null
    left = np.max(np.abs(grown.stiffness(theta, POINTS) / alone - 1.0))
    if not left < NEGLIGIBLE:
        yield (
            f"it does not vanish when {size.name}, its first parameter, goes to {null:g}: K still"
            f" changes by {left:.1e}; put the parameter that measures its size first, or give"
            " absent_at"
        )


def _without(column: str) -> Points:
    if column == "amplitude":
        return replace(POINTS, amplitude=None)
    return replace(POINTS, temperature=None)


def _columns(effect: Effect, grown: Model) -> Iterator[str]:
    theta = sample(grown.parameters, np.random.default_rng(SEED))
    for column in sorted(effect.needs - COLUMNS):
        yield (
            f"it needs '{column}', but measurements have only amplitude and temperature beside the"
            " frequency"
        )
    # Used without being asked for, a column that the data lack would be an error within a fit.
    for column in sorted(COLUMNS - grown.needs):
        try:
            bare = grown.stiffness(theta, _without(column))
        except (DataError, TypeError):
            yield f"it uses the {column} without saying so: name it in the element's conditions"
            continue
        if not np.array_equal(bare, grown.stiffness(theta, POINTS)):
            yield (
                f"it depends on the {column} without saying so: name it in the element's conditions"
            )
    # Asked for without being used, it would refuse data that lack it for nothing.
    for column in sorted(COLUMNS & effect.needs):
        try:
            grown.stiffness(theta, _without(column))
        except DataError as error:
            if column not in str(error):
                yield f"without the column {column} its error does not name it: {error}"
        else:
            yield f"it says that it needs the {column}, but works without"


def _harmonic(effect: Effect) -> Iterator[str]:
    theta = sample(effect.element.parameters, np.random.default_rng(SEED), (2,))
    third = effect.third_harmonic(theta, POINTS)
    expected = (2, len(POINTS.log_omega))
    if third is not None and (np.shape(third) != expected or not np.all(np.isfinite(third))):
        yield f"the third harmonic must be finite and of shape {expected}"
