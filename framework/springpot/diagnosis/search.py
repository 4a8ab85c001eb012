"""Which grown models explain the data: single effects first, pairs where one effect leaves structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from springpot.identification import EDGE
from springpot.measurement import Measurement, telling
from springpot.rheology import Effect, Model

from .directions import influence
from .frame import Frame
from .pairs import best_pairs
from .refit import Refit, refit
from .scan import Scan, Score, scan
from .structure import Structure, repeats_structure, structure

SINGLES = 12
"""Effects refitted after the first scan."""
BEAM = 4
"""Single effects from which a second one is sought."""
SECONDS = 4
"""Second effects refitted for each of them."""
TOGETHER = 8
"""Pairs refitted that explain the residual only together."""
LEFT_OVER = 1e-2
"""Chance of a false alarm at which something is held to be left over."""
RESOLVED = 3.0
"""Points over which a narrow effect must spread at least."""
COMMON = 1.0
"""Prior weight below which an effect alone is not taken for an answer before pairs of common ones are tried."""


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
    def names(self) -> tuple[str, ...]:
        """Names of the effects added."""
        return tuple(effect.name for effect in self.effects)


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
    structure : Structure
        The test for structure of any kind in its residual.
    grown : list of Grown
        Grown models, the best evidence first.
    left : Structure
        The test on the residual of the best model.
    repeats : Structure
        The test on the scatter of repeats.
    """

    base: Refit
    frame: Frame
    scan: Scan
    structure: Structure
    grown: list[Grown] = field(default_factory=list)
    left: Structure = field(default_factory=lambda: Structure(1.0, {}))
    repeats: Structure = field(default_factory=lambda: Structure(1.0, {}))

    @property
    def best(self) -> Refit:
        """The model with the best evidence, the base included."""
        refits = [self.base, *(grown.refit for grown in self.grown)]
        return max(refits, key=lambda found: found.log_evidence)


def search(base: Refit, library: Sequence[Effect], rng: np.random.Generator) -> Search:
    """Look for what is missing from a fitted model.

    Parameters
    ----------
    base : Refit
        The fit of the user's model.
    library : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.
    """
    effects = [
        effect
        for effect in held(library, base.fit.measurement)
        if not effect.narrow and _fits(base, base.model + effect) and not _twice(base.model, effect)
    ]
    frame = base.frame()
    scanned = scan_effects(base, frame, effects, rng)
    found = Search(base, frame, scanned, structure(frame, rng))
    found.left = found.structure
    found.repeats = repeats_structure(base.data, rng)
    found.grown = [_grow(base, (), score) for score in scanned.scores[:SINGLES]]
    _sort(found)
    if found.grown and min(scanned.p_value, found.structure.p_value) < 5 * LEFT_OVER:
        found.left = structure(found.best.frame(), rng)
        if found.left.p_value < LEFT_OVER * 20 or _strained(found):
            _seek_pairs(found, [*effects, *_try_narrow(found, library)], rng)
            _forget_narrow(found)
    return found


def _try_narrow(found: Search, library: Sequence[Effect]) -> list[Effect]:
    """Let effects that can imitate any narrow feature compete, now that no simple common effect explains the data."""
    base = found.base
    present = {effect.name for effect in base.model.effects}
    effects = []
    for effect in held(library, base.fit.measurement):
        if effect.narrow and effect.name not in present and _fits(base, base.model + effect):
            for score in scan_effects(base, found.frame, [effect], threshold=found.scan.threshold).scores:
                found.scan.scores.append(score)
                found.grown += _clear(found, [_grow(base, (), score)])
                effects.append(effect)
    _sort(found)
    return effects


def _forget_narrow(found: Search) -> None:
    """Leave out of the scan the narrow effects that no fitted model has."""
    named = {name for grown in found.grown for name in grown.names}
    kept = [
        score
        for score in found.scan.scores
        if not score.influence.effect.narrow or score.influence.effect.name in named
    ]
    found.scan.scores[:] = kept


def _clear(found: Search, tried: Sequence[Grown]) -> list[Grown]:
    """The grown models whose narrow effects, if they have any, are seen as such."""
    return [grown for grown in tried if _resolved(found, grown)]


def _resolved(found: Search, grown: Grown) -> bool:
    """Whether a narrow effect is seen as such: at several points, as one alone is an outlier, and not too broad."""
    if not any(effect.narrow for effect in grown.effects):
        return True
    others = {effect.name for effect in grown.effects if not effect.narrow}
    without = [one.refit for one in found.grown if {effect.name for effect in one.effects} == others]
    before = without[0] if without and others else found.base
    size = np.hypot(*found.frame.whiten(grown.refit.stiffness - before.stiffness).reshape(2, -1))
    at_end = any(
        parameter.scale == "linear"
        and parameter.name not in found.base.model.names
        and min(value - parameter.lower, parameter.upper - value) <= EDGE * (parameter.upper - parameter.lower)
        for parameter, value in zip(grown.refit.model.parameters, grown.refit.theta, strict=True)
        if np.isfinite(parameter.upper - parameter.lower)
    )
    return float(np.sum(size)) ** 2 >= RESOLVED * float(np.sum(size**2)) and not at_end


def _strained(found: Search) -> bool:
    """Whether the best single effect is a rare one, or one with so many parameters that it may stand for two."""
    best = found.grown[0]
    spent = len(best.refit.own) - len(found.base.own)
    return spent > 1 or any(effect.prior < COMMON for effect in best.effects)


def _twice(model: Model, effect: Effect) -> bool:
    """Whether a model already has this shift: two of one law are a law with a kink, which is no physics."""
    return effect.plane == "shift" and effect.name in {own.name for own in model.effects}


def _fits(base: Refit, model: Model) -> bool:
    """Whether the data are numbers enough for a grown model."""
    return len(model.names) <= 2 * len(base.fit.measurement)


def held(library: Sequence[Effect], measurement: Measurement) -> list[Effect]:
    """Effects whose conditions these data tell of: what only moved with the frequency is no evidence for them.

    Factors without a law are left out: they can imitate every law.
    """
    columns = telling(measurement)
    return [effect for effect in library if effect.needs <= columns and not effect.by_levels]


def scan_effects(
    base: Refit,
    frame: Frame,
    effects: Sequence[Effect],
    rng: np.random.Generator | None = None,
    threshold: float = inf,
) -> Scan:
    """Score effects at a fit; see `scan`."""
    measurement = base.fit.measurement
    influences = [influence(base.model, base.theta, base.stiffness, effect, measurement) for effect in effects]
    return scan(frame, [each for each in influences if len(each.theta)], rng, threshold)


def _grow(base: Refit, before: tuple[Effect, ...], score: Score) -> Grown:
    """Refit with one more effect."""
    grown = score.influence.model
    found = refit(grown, base.data, base.noise, list(score.starts), starts=2)
    return Grown((*before, score.influence.effect), found, score.predicted)


def _sort(found: Search) -> None:
    found.grown.sort(key=lambda grown: -grown.refit.log_evidence)


def _seek_pairs(found: Search, effects: Sequence[Effect], rng: np.random.Generator) -> None:
    """Seek a second effect beside several first ones, and pairs that only work together."""
    base = found.base
    pairs = [
        Grown(
            (pair.first.influence.effect, pair.second.influence.effect),
            refit(pair.model, base.data, base.noise, [pair.start], starts=1),
            base.rss - pair.gain,
        )
        for pair in best_pairs(found.frame, found.scan.scores, base.model, base.theta, TOGETHER)
        if _fits(base, pair.model)
    ]
    for first in found.grown[:BEAM]:
        frame = first.refit.frame()
        others = [
            effect
            for effect in effects
            if not (effect.narrow and any(one.narrow for one in first.effects))
            and not _twice(first.refit.model, effect)
        ]
        seconds = scan_effects(first.refit, frame, others).scores[:SECONDS]
        pairs += [_grow(first.refit, first.effects, score) for score in seconds if _fits(base, score.influence.model)]
    found.grown += _clear(found, pairs)
    _sort(found)
    _add_singles(found)
    found.left = structure(found.best.frame(), rng)


def _add_singles(found: Search) -> None:
    """Refit by themselves the effects that so far were only tried in good pairs: their rows tell what each does."""
    alone = {grown.names[0] for grown in found.grown if len(grown.effects) == 1}
    wanted = {name for grown in found.grown[:SINGLES] for name in grown.names} - alone
    scores = [score for score in found.scan.scores if score.influence.effect.name in wanted]
    found.grown += _clear(found, [_grow(found.base, (), score) for score in scores])
    _sort(found)
