"""What a search has in hand: a model, the models grown from it, and what each explains."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from springpot.identification.allowed_shifts import refused_laws
from springpot.misfit.frame import Frame
from springpot.misfit.refit import Refit
from springpot.misfit.residual_battery import Battery
from springpot.rheology.effect import Effect
from springpot.thresholds import SEARCH

from .scan import Scan


@dataclass(frozen=True, eq=False)
class Grown:
    """The fitted model with effects added.

    Attributes
    ----------
    effects : tuple of Effect
        Those added.
    refit : Refit
        The fit.
    predicted : float
        Whitened residual sum of squares that the scan foretold.
    """

    effects: tuple[Effect, ...]
    refit: Refit
    predicted: float

    @property
    def beyond_physics(self) -> list[Effect]:
        """Effects larger than any specimen makes them, at the end of their range, or no law."""
        units, beyond = self.refit.fit.measurement.units, []
        for effect in self.effects:
            factor, _ = units.of(effect.element.parameters[0].unit)
            too_large = (
                units.is_modulus
                and factor * size_of(self.refit, effect) > effect.largest_of_modulus
            )
            # Constants of a shift trade with each other, and one at its end says nothing of the
            # law.
            ended = effect.plane != "shift" and at_its_limit(self.refit, effect)
            if too_large or ended or effect.name in self.refused:
                beyond.append(effect)
        return beyond

    @cached_property
    def refused(self) -> dict[str, str]:
        """What laws do that are none of a material, by their name."""
        return {effect.name: does for effect, does in refused_laws(self.refit.fit)}

    @property
    def same_at_all_amplitudes(self) -> bool:
        """Whether effects of the amplitude do nothing, as fitted, that goes with it.

        A slider that never slips.

        Then it is a spring, and a part of the material by its true name.
        """
        points = self.refit.fit.measurement.points
        if points.amplitude is None:
            return False
        at_one_amplitude = points.at_amplitude(
            np.full_like(points.amplitude, np.median(points.amplitude))
        )
        moved = self.refit.stiffness - self.refit.model.stiffness(
            self.refit.theta, at_one_amplitude
        )
        noise = self.refit.noise.sd
        # As fits are compared: what changes chi-square by less than its own scatter of one is not
        # seen.
        return float(np.sum((moved.real / noise.real) ** 2 + (moved.imag / noise.imag) ** 2)) < 1.0

    @property
    def broadens_an_order(self) -> bool:
        """Whether one part with its own time or order joins a model that has an order already.

        A springpot has a broad and symmetric spectrum. What such a model lacks may be that the
        material's is skewed (Havriliak and Negami 1967, doi:10.1016/0032-3861(67)90021-3): one mode
        or springpot more follows that.
        """
        (effect,) = self.effects
        model = self.refit.model
        others = list(model.effects)
        others.remove(effect)
        own = [
            *model.material.parameters,
            *(each for other in others for each in other.element.parameters),
        ]
        return len(effect.element.parameters) > 1 and any(parameter.is_order for parameter in own)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects added."""
        return tuple(effect.name for effect in self.effects)


def size_of(fitted: Refit, effect: Effect) -> float:
    """The size of an effect in a fitted model; of one that was added twice, that of the second."""
    size = effect.element.parameters[0].name
    value = 0.0
    for name, number in zip(fitted.model.names, fitted.theta.tolist(), strict=True):
        owner, _, short = name.rpartition(".")
        if owner.partition("#")[0] == effect.name and short == size:
            value = number
    return value


def at_its_limit(fitted: Refit, effect: Effect) -> bool:
    """Whether the size of an effect rests on a bound at which it does not vanish.

    More of it than physics knows.

    What follows the data only there does so by its shape alone, as a modulus that would go as T^20.
    """
    size, value = effect.element.parameters[0], size_of(fitted, effect)
    ends = [
        end for end in (size.lower, size.upper) if np.isfinite(end) and end != effect.vanishes_at
    ]
    return any(abs(value - end) <= SEARCH.near_an_end * abs(end) for end in ends)


@dataclass(eq=False)
class Search:
    """A model's fit, the scan of the library on it, and the grown models that were fitted.

    Attributes
    ----------
    base : Refit
        The user's model.
    frame : Frame
        Its linear geometry.
    scan : Scan
        Scores of the library.
    structure : Battery
        The test for structure of any kind in its residual.
    grown : list of Grown
        Grown models, the best evidence first.
    left : Battery
        The test on the residual of the best model.
    repeats : Battery
        The test on the scatter of repeats.
    confounded : list of Grown
        Models grown by effects of a condition that was not varied by itself and that explain the
        data as well as any other, the best evidence first.
    promoted : frozenset of str
        Effects of such a condition that are judged all the same, as nothing else explains the data.
    """

    base: Refit
    frame: Frame
    scan: Scan
    structure: Battery
    grown: list[Grown] = field(default_factory=list)
    left: Battery = field(default_factory=lambda: Battery(1.0, {}))
    repeats: Battery = field(default_factory=lambda: Battery(1.0, {}))
    confounded: list[Grown] = field(default_factory=list)
    promoted: frozenset[str] = frozenset()

    @property
    def best(self) -> Refit:
        """The model with the best evidence, the base included."""
        refits = [self.base, *(grown.refit for grown in self.grown)]
        return max(refits, key=lambda refit: refit.log_evidence)

    @property
    def alarm(self) -> float:
        """Chance that noise alone gives such a score or such structure, whichever is rarer."""
        return min(self.scan.p_value, self.structure.p_value)

    @property
    def gain(self) -> float:
        """Drop of the information criterion that the best model brings."""
        return 2.0 * (self.best.log_evidence - self.base.log_evidence)
