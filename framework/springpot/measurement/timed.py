"""A model of tests in time: a rheological model and what the test itself did."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

from springpot.errors import ModelError
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.parameters import HasParameters, Parameter
from springpot.rheology.points import Real

from .timeeffect import Stage, TimeEffect

STAGES = tuple(Stage)


@dataclass(frozen=True, eq=False)
class Timed(HasParameters):
    """A model with effects of time tests.

    Parameters
    ----------
    material : Model
        The model of the specimen and its rig.
    time_effects : tuple of TimeEffect
        What the test did, in any order: they act by stages.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import Timed
    >>> drift = springpot.plugins().find("time effect", "force-drift")
    >>> Timed(springpot.parse_model("fractional-maxwell"), (drift,)).names
    ('k', 'c', 'alpha', 'force-drift.rate')
    """

    material: Model
    time_effects: tuple[TimeEffect, ...] = field(default=())

    @property
    def name(self) -> str:
        """The expression, such as ``fractional-maxwell + force-drift``."""
        return " + ".join([self.material.name, *(effect.name for effect in self.time_effects)])

    def __str__(self) -> str:
        return self.name

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the material, then those of each effect."""
        parameters = list(self.material.parameters)
        for effect in self.time_effects:
            parameters += effect.own
        return tuple(parameters)

    @property
    def effects(self) -> tuple[Effect | TimeEffect, ...]:
        """All that joined the material."""
        return (*self.material.effects, *self.time_effects)

    @property
    def needs(self) -> frozenset[str]:
        """Conditions without which the material cannot be evaluated."""
        return self.material.needs

    def parts(self, theta: Real) -> tuple[Real, list[tuple[TimeEffect, slice]]]:
        """The material's own parameters, and where each effect's stand in theta, by stages."""
        first = len(self.material.parameters)
        placed = []
        for effect in self.time_effects:
            placed.append((effect, slice(first, first + len(effect.parameters))))
            first += len(effect.parameters)
        # In the order in which they act, whatever the order in which they were named; theta keeps
        # that of the names.
        placed.sort(key=lambda pair: STAGES.index(pair[0].stage))
        return theta[: len(self.material.parameters)], placed

    def __add__(self, effect: Effect | TimeEffect) -> Timed:
        """The model with one more effect.

        Raises
        ------
        ModelError
            If it has that effect of time tests already: two drifts are one.
        """
        if isinstance(effect, Effect):
            return replace(self, material=self.material + effect)
        if effect.name in {own.name for own in self.time_effects}:
            raise ModelError(f"{self.name} has the effect '{effect.name}' already")
        return replace(self, time_effects=(*self.time_effects, effect))


def grown(model: Model | Timed, effect: Effect | TimeEffect) -> Model | Timed:
    """A model with one more effect of either kind.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import grown
    >>> drift = springpot.plugins().find("time effect", "force-drift")
    >>> grown(springpot.parse_model("kelvin"), drift).name
    'kelvin + force-drift'
    """
    if isinstance(effect, Effect):
        return model + effect
    # A model of the material alone becomes one of tests in time with its first such effect.
    if not isinstance(model, Timed):
        model = Timed(model)
    return model + effect


def material_of(model: Model | Timed) -> Model:
    """The model of the specimen and its rig, without what the test did.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import grown, material_of
    >>> drift = springpot.plugins().find("time effect", "force-drift")
    >>> material_of(grown(springpot.parse_model("kelvin"), drift)).name
    'kelvin'
    """
    if isinstance(model, Timed):
        return model.material
    return model
