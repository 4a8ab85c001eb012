"""Which grown models explain the data.

Single effects first, pairs where one effect leaves structure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np

from springpot.identification.convex import within_material
from springpot.identification.leastsquares import Effort
from springpot.identification.material import is_material
from springpot.identification.starts import EDGE
from springpot.measurement.independence import at_one_frequency, moved_along, telling
from springpot.measurement.measurement import CONDITIONS
from springpot.misfit.floor import beyond_floor
from springpot.misfit.refit import Refit, refit
from springpot.misfit.residual_tests import battery, repeats_structure
from springpot.numerics import NEGLIGIBLE, SMALLEST
from springpot.rheology.effect import Effect
from springpot.rheology.points import Complex
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from .grown import (
    AskedSet,
    Grown,
    Search,
    beside,
    in_each_place,
    once,
    one_more,
    two_more,
    without_one,
)
from .result import Fitted, TriedEffect, unseen
from .scan import Score, applicable, enough_for, scan_effects, shifted_twice


def search_from(
    base: Refit,
    library: Sequence[Effect],
    rng: np.random.Generator,
    fitted: Fitted = unseen,
) -> Search:
    """Look for what is missing from a fitted model.

    Parameters
    ----------
    base : Refit
        The fit of the user's model.
    library : sequence of Effect
        Effects that may be missing.
    rng : numpy.random.Generator
        For simulated noise.
    fitted : callable
        Given each effect that was fitted by itself.
    """
    effects = [
        effect
        for effect in applicable(library, base.fit.measurement)
        if not effect.narrow
        and enough_for(base, base.model + effect)
        and not shifted_twice(base.model, effect)
        and not within_material(base.model, effect)
        and not _is_the_materials_own(base, effect)
    ]
    frame = base.frame()
    scanned = scan_effects(base, frame, effects, rng)
    search = Search(base, frame, scanned, battery(frame, rng))
    search.left = search.structure
    search.repeats = repeats_structure(base.data, rng)
    for score in scanned.scores[: SEARCH.singles]:
        search.grown.append(grown_with(search, score))
        fitted(_single(search.grown[-1]))
    sort_by_evidence(search)
    search.grown[1:] = [_from_the_best(search, grown) for grown in search.grown[1:]]
    sort_by_evidence(search)
    if search.grown and search.alarm < SEARCH.look_further:
        search.left = battery(search.best.frame(), rng)
        if search.left.p_value < SEARCH.left_over or _strained(search):
            _seek_pairs(search, [*effects, *_try_narrow(search, library)], rng)
            _forget_narrow(search)
    search.confounded = _confounded(search, library)
    if _only_confounded(search):
        search.promoted = frozenset(grown.names[0] for grown in search.confounded)
        search.grown += search.confounded
        search.confounded = []
        sort_by_evidence(search)
        search.left = battery(search.best.frame(), rng)
    return search


def _single(grown: Grown) -> TriedEffect:
    return TriedEffect(grown.effects[0], grown.refit.model, grown.refit.theta)


def _is_the_materials_own(base: Refit, effect: Effect) -> bool:
    """Whether at one frequency an effect is no more than another size and phase of any material.

    What is the same factor at all points, such as a phase error, could only make the material one
    that gives work away.
    """
    constant = effect.plane == "log-complex" and not effect.needs
    return constant and is_material(base.model) and at_one_frequency(base.fit.measurement)


def with_factors(search: Search, library: Sequence[Effect]) -> Grown | None:
    """The model with a factor at each level of a condition; None where the error stays.

    Such factors are no law, and are sought only where no effect with a law is found.

    Parameters
    ----------
    search : Search
        A finished search.
    library : sequence of Effect
        Effects, those with a factor for each level among them.
    """
    base, measurement = search.base, search.base.fit.measurement
    levels = {
        name: len(np.unique(measurement.levels(name)))
        for name in telling(measurement) & set(CONDITIONS)
    }
    present = {effect.name for effect in base.model.effects}
    shifted = any(effect.plane == "shift" for effect in base.model.effects)
    # At the noise, and with structure all the same: more freedom is no answer to that.
    if base.relative_rms < VERDICT.noisy * base.floor:
        return None
    best: Grown | None = None
    for effect in library:
        several = effect.by_levels and all(
            levels.get(name, 0) >= EVIDENCE.fewest_levels for name in effect.needs
        )
        # A law and free factors of the same times are one too many.
        again = effect.name in present or (shifted and effect.plane == "shift")
        if (
            not several
            or again
            or not enough_for(base, (base.model + effect).bound_to(measurement.points))
        ):
            continue
        grown = Grown(
            (effect,), refit(base.model + effect, base.data, base.noise, [], starts=2), 0.0
        )
        if best is None or grown.refit.log_evidence > best.refit.log_evidence:
            best = grown
    if best is None or best.refit.log_evidence < base.log_evidence + 0.5 * SEARCH.decisive:
        return None
    takes_most = best.refit.relative_rms <= VERDICT.takes_most * base.relative_rms
    if takes_most or not beyond_floor(best.refit):
        return best
    return None


def _try_narrow(search: Search, library: Sequence[Effect]) -> list[Effect]:
    """Let effects that can imitate any narrow feature compete.

    They are asked only when no simple common effect explains the data.
    """
    base = search.base
    present = {effect.name for effect in base.model.effects}
    effects = []
    for effect in applicable(library, base.fit.measurement):
        if effect.narrow and effect.name not in present and enough_for(base, base.model + effect):
            for score in scan_effects(
                base, search.frame, [effect], threshold=search.scan.threshold
            ).scores:
                search.scan.scores.append(score)
                search.grown += clear(search, [grown_with(search, score)])
                effects.append(effect)
    sort_by_evidence(search)
    return effects


def _forget_narrow(search: Search) -> None:
    """Leave out of the scan the narrow effects that no fitted model has.

    They would share the prior for nothing.
    """
    named = {name for grown in search.grown for name in grown.names}
    kept = []
    for score in search.scan.scores:
        effect = score.influence.effect
        if not effect.narrow or effect.name in named:
            kept.append(score)
    search.scan.scores[:] = kept


def clear(search: Search, tried: Sequence[Grown]) -> list[Grown]:
    """The grown models whose narrow effects, if they have any, are seen as such."""
    return [grown for grown in tried if _resolved(search, grown)]


def _resolved(search: Search, grown: Grown) -> bool:
    """Whether a narrow effect is seen as such.

    At several points, as one alone is an outlier, and not too broad.
    """
    if not any(effect.narrow for effect in grown.effects):
        return True
    others = {effect.name for effect in grown.effects if not effect.narrow}
    without = [
        one.refit
        for one in search.grown
        if others and {effect.name for effect in one.effects} == others
    ]
    before = [*without, search.base][0]
    # Against the fit without it, and against the same fit with it taken out: the first spreads by
    # what the others then follow, and a resonance as narrow as one point would seem to be seen at
    # four.
    seen = min(
        _spread(search, grown.refit.stiffness - other)
        for other in (before.stiffness, _taken_out(grown))
    )
    at_end = any(
        parameter.scale == "linear"
        and parameter.name not in search.base.model.names
        and min(value - parameter.lower, parameter.upper - value)
        <= EDGE * (parameter.upper - parameter.lower)
        for parameter, value in zip(grown.refit.model.parameters, grown.refit.theta, strict=True)
        if np.isfinite(parameter.upper - parameter.lower)
    )
    return seen >= SEARCH.resolved and not at_end


def _spread(search: Search, change: Complex) -> float:
    """Over how many points a change of K is spread.

    All of them where it is the same everywhere, one for a spike.
    """
    size = np.hypot(*search.frame.whiten(change).reshape(2, -1))
    # Relative to the largest: what is taken out may have been held by what is left, and the square
    # of the rest be no number.
    size /= max(float(size.max()), SMALLEST)
    return float(np.sum(size)) ** 2 / max(float(np.sum(size**2)), SMALLEST)


def _taken_out(grown: Grown) -> Complex:
    """K of a grown model without its narrow effects, all else as it was fitted with them."""
    model, theta = grown.refit.model, grown.refit.theta
    for effect in grown.effects:
        if effect.narrow:
            model, theta = without_one(model, theta, effect)
    return model.stiffness(theta, grown.refit.fit.measurement.points)


def _strained(search: Search) -> bool:
    """Whether the best single effect is rare, or has so many parameters that it may be two."""
    best = search.grown[0]
    spent = len(best.refit.own) - len(search.base.own)
    return spent > 1 or any(effect.prior < SEARCH.common for effect in best.effects)


def grown_with(search: Search, score: Score, effort: Effort | None = None) -> Grown:
    """The base model refitted with one more effect, from where the scan saw it.

    Parameters
    ----------
    search : Search
        What was found so far: a fit that is no rival of the best one ends early.
    score : Score
        What the scan says of the effect.
    effort : Effort, optional
        How far the fit goes, where not to the best one.
    """
    base = search.base
    grown = refit(
        score.influence.model,
        base.data,
        base.noise,
        list(score.starts),
        starts=2,
        effort=effort or effort_of(search),
    )
    return Grown((score.influence.effect,), grown, score.predicted)


def _from_the_best(search: Search, grown: Grown) -> Grown:
    """A rival of the best model fitted again from what that makes of the base, if it is better.

    Of two effects with one curve each may have ended in another minimum of the base, and that would
    decide.
    """
    # One without evidence leaves the base where it is, from where all have begun.
    if search.base.has_one_minimum or search.gain <= 0.0:
        return grown
    own, base = grown.refit, search.base.model.names
    start = np.where(
        np.isin(own.model.names, base), own.seed_from(search.grown[0].refit), own.theta
    )
    again = refit(own.model, search.base.data, search.base.noise, [start], starts=0)
    if again.log_evidence > own.log_evidence + NEGLIGIBLE:
        return replace(grown, refit=again)
    return grown


def effort_of(search: Search) -> Effort:
    """No longer than it takes to tell that a grown model is no rival of the best one."""
    least = min((grown.refit.rss for grown in search.grown), default=inf)
    if least == inf:
        return Effort(NEGLIGIBLE)
    half = search.base.rss - SEARCH.hopeless * (search.base.rss - least)
    return Effort(NEGLIGIBLE, max(half, least + 2.0 * SEARCH.decisive))


def sort_by_evidence(search: Search) -> None:
    """The grown models with the best evidence first."""
    search.grown.sort(key=lambda grown: -grown.refit.log_evidence)


def _seek_pairs(search: Search, effects: Sequence[Effect], rng: np.random.Generator) -> None:
    """Seek a second effect beside several first ones, and pairs that only work together."""
    # Joined first: each way to a set has starts of its own, and one that pays is tried from all.
    asked = once([*_together(search), *_one_by_one(search, effects)])
    best = search.grown[0]
    fit_new(search, [each for each in asked if pays(best, each.effects, each.predicted)])
    sort_by_evidence(search)
    _exchange(search, effects)
    _add_singles(search)
    search.left = battery(search.best.frame(), rng)


def pays(best: Grown, effects: Sequence[Effect], left: float) -> bool:
    """Whether effects will have more evidence than the best so far, if they leave what is foretold.

    Parameters
    ----------
    best : Grown
        The best so far.
    effects : sequence of Effect
        What may take its place.
    left : float
        Whitened residual sum of squares that a scan foretells.
    """
    points = 2 * len(best.refit.fit.measurement)
    more = _parameters(effects) - _parameters(best.effects)
    # The lines of a free spectrum follow as much beside them.
    gain = best.refit.noise.log_likelihood(best.refit.fair(left), points)
    gain -= best.refit.log_likelihood
    return gain > 0.5 * more * float(np.log(points))


def _parameters(effects: Sequence[Effect]) -> int:
    return sum(len(effect.element.parameters) for effect in effects)


def fit_new(search: Search, asked: Sequence[AskedSet]) -> None:
    """Fit those of some sets that the data can judge and that were not fitted yet."""
    known = {grown.key for grown in search.grown}
    new = [each for each in once(asked) if each.key not in known]
    effort = effort_of(search)
    base = search.base
    judged = [each.fitted(base, effort) for each in new if enough_for(base, each.model)]
    search.grown += clear(search, [*judged, *_less_one(search, judged)])


def _less_one(search: Search, tried: Sequence[Grown]) -> list[Grown]:
    """The best of some sets without an effect that can be spared, from where the set ended.

    What fitted badly by itself, as what is large is no tangent, may be all that is missing.
    """
    best = max(tried, key=lambda grown: grown.refit.log_evidence, default=None)
    if best is None or len(set(best.names)) < 2:
        return []
    if search.grown and best.refit.log_evidence <= search.best.log_evidence:
        return []
    foretold = {score.influence.effect: score.predicted for score in search.scan.scores}
    less = []
    for spared in best.effects:
        effects = tuple(effect for effect in best.effects if effect is not spared)
        model, start = without_one(best.refit.model, best.refit.theta, spared)
        fit = refit(model, search.base.data, search.base.noise, [start], starts=0)
        if fit.log_evidence > best.refit.log_evidence:
            less.append(Grown(effects, fit, foretold.get(effects[0], fit.rss)))
    return less


def go_on_from(search: Search, before: Search, rng: np.random.Generator) -> Search:
    """A search in another noise, with the best that one before it has found.

    Parameters
    ----------
    search : Search
        The later one.
    before : Search
        The former one, of the same model.
    rng : numpy.random.Generator
        For simulated noise.
    """
    if not before.grown:
        return search
    known = before.grown[0]
    base = search.base
    again = refit(known.refit.model, base.data, base.noise, [known.refit.theta], starts=0)
    if again.log_evidence > search.best.log_evidence + SEARCH.better:
        found = [replace(known, refit=again)]
        search.grown += clear(search, [*found, *_less_one(search, found)])
        # What is narrow is scanned only where it is asked for.
        there = [score.influence.effect.name for score in search.scan.scores]
        asked = set(known.names).difference(there)
        effects = [effect for effect in known.effects if effect.name in asked]
        search.scan.scores.extend(scan_effects(base, search.frame, effects).scores)
        sort_by_evidence(search)
        search.left = battery(search.best.frame(), rng)
    return search


def _exchange(search: Search, effects: Sequence[Effect]) -> None:
    """Fit whatever may stand in a place of the best pair, until none is better."""
    exchanged: set[tuple[str, ...]] = set()
    while (best := search.grown[0]).key not in exchanged and len(best.effects) > 1:
        exchanged.add(best.key)
        fit_new(search, list(in_each_place(search, best, effects)))
        sort_by_evidence(search)


def _together(search: Search) -> list[AskedSet]:
    """Pairs that explain the residual together."""
    return two_more((), search.base, search.frame, search.scan.scores)


def _one_by_one(search: Search, effects: Sequence[Effect]) -> list[AskedSet]:
    """The best second effects beside each of the best first ones."""
    asked = []
    for first in search.grown[: SEARCH.beam]:
        scores = scan_effects(
            first.refit, first.refit.frame(), beside(first.effects, first.refit.model, effects)
        ).scores
        asked += one_more(first.effects, scores)
    return asked


def _add_singles(search: Search) -> None:
    """Refit by themselves the effects that so far were only tried in good pairs.

    Their rows tell what each does.
    """
    alone = {grown.names[0] for grown in search.grown if len(grown.effects) == 1}
    wanted = {name for grown in search.grown[: SEARCH.singles] for name in grown.names} - alone
    scores = [score for score in search.scan.scores if score.influence.effect.name in wanted]
    search.grown += clear(search, [grown_with(search, score) for score in scores])
    sort_by_evidence(search)


def _confounded(search: Search, library: Sequence[Effect]) -> list[Grown]:
    """Models grown by effects that took no part and explain the data as well as the best that did.

    The condition that such an effect needs moved with the frequency, or an amplitude with the
    temperature, so that no fit can say which of the two is the cause: they form a class with
    whatever else explains the data. Their scores join the scan.
    """
    base = search.base
    measurement = base.fit.measurement
    moved = moved_along(measurement)
    effects = [
        effect
        for effect in library
        if effect.needs & moved
        and effect.needs <= set(measurement.conditions)
        and not (effect.narrow or effect.by_levels)
        and enough_for(base, base.model + effect)
    ]
    least = max(search.best.log_evidence, base.log_evidence + EVIDENCE.as_good) - EVIDENCE.as_good
    alike = []
    for score in scan_effects(base, search.frame, effects, threshold=search.scan.threshold).scores:
        grown = grown_with(search, score)
        if grown.refit.log_evidence > least:
            search.scan.scores.append(score)
            alike.append(grown)
    return sorted(alike, key=lambda grown: -grown.refit.log_evidence)


def _only_confounded(search: Search) -> bool:
    """Whether only effects of conditions not varied by themselves follow data to their noise."""
    if not search.confounded:
        return False
    best, judged = search.confounded[0].refit, search.best
    # Not by fitting better alone: whatever else was tried must miss the data.
    clear = best.log_evidence > judged.log_evidence + 0.5 * SEARCH.decisive
    return clear and beyond_floor(judged) and not beyond_floor(best)
