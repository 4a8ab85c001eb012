"""Screening of the effects that may be missing, each stage finer and dearer than the one before.

What a linearised scan foretells, fits by fixed exponentials, exact fits.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from springpot.diagnosis.result import Fitted, TriedEffect, unseen
from springpot.distributions import effective_share
from springpot.errors import SpringpotError
from springpot.identification.result import Identification
from springpot.misfit.residual_scatter import ResidualScatter
from springpot.misfit.residuals_of_tests import TestPart
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH

from ..numerics import SMALLEST, TWO_DEVIATIONS
from .exponentials import UnfollowedError
from .hypotheses import (
    AskedTests,
    FitResiduals,
    Hypothesis,
    ScanEntry,
    bic_of,
    delta_bic,
    independent_samples,
)
from .material import UntoldError
from .native import STARTS, TimeSearch
from .specimen import reference_of
from .temperatures import is_law

FEWEST = 3
"""Effects that are fitted even where the scan foretells little.

So that the answer says how little they would help.
"""
EXACT = 5
"""Effects that are fitted exactly, of those that are near the best.

The rest can be no more than absent.
"""
COSTLY = 0.05
"""Share of the best drop that makes an effect by which the specimen swings worth its fit."""
ASTRAY = 3.0
"""Error over the noise of the best effect from which its fit is not believed to be at its minimum.
"""


def leading_of_scan(
    entries: dict[str, list[ScanEntry]], before: FitResiduals
) -> list[list[ScanEntry]]:
    """Scan entries of the effects that are worth a fit."""
    scatter = before.scatters[0]
    # Of noise whose neighbours are alike so many samples are one independent number.
    unit = scatter.size**2 / effective_share(scatter.memory)
    count = np.log(independent_samples(before.residuals, before.scatters))

    def hope(of_effect: list[ScanEntry]) -> float:
        return float(of_effect[0].drop / unit - len(of_effect[0].values) * count)

    # Hope is the drop less what its parameters cost: else the effect with most parameters would
    # lead.
    ranked = sorted(_by_rig(entries), key=hope, reverse=True)
    worth = [
        of_effect
        for of_effect in ranked[: SEARCH.singles]
        if of_effect[0].drop / unit > TWO_DEVIATIONS
    ]
    # Of what does not go as its size, such as a limit or a fading, a linear step tells too little.
    # Beside other tests each such fit would take as long as all others.
    if len(before.residuals) == 1:
        worth += [each for each in ranked if not each[0].as_its_size and each not in worth]
    # A law of temperature moves times by decades, which no small step foretells either.
    worth += [each for each in ranked if is_law(each[0].effect) and each not in worth]
    if len(worth) < FEWEST:
        return ranked[:FEWEST]
    return worth


def left_by_screening(
    entries: dict[str, list[ScanEntry]], nearly: Sequence[Hypothesis], before: FitResiduals
) -> list[list[ScanEntry]]:
    """Scan entries of the other effects, where all that were fitted may well miss the tests.

    A linear step foretells little: what an effect does the model may do in its stead, as at one
    frequency any mass is a spring, and at corners no delay is small. That none explains the tests
    is said of those alone that were fitted.
    """
    best = min([before, *(each.left for each in nearly)], key=bic_of)
    fitted = {each.effect.name for each in nearly}
    others = [each for each in _by_rig(entries) if each[0].effect.name not in fitted]
    # By few samples several times the noise is no plain misfit yet, and explained it is not either.
    if best.doubtful:
        return others
    # What explains them by more parameters may be a simpler effect at an end of its range.
    return [each for each in others if before.count + len(each[0].values) < best.count]


def _by_rig(entries: dict[str, list[ScanEntry]]) -> list[list[ScanEntry]]:
    """Scan entries of each effect at one place: of all rigs, or of one alone."""
    apart: dict[tuple[str, bool], list[ScanEntry]] = {}
    for name, of_effect in entries.items():
        for entry in of_effect:
            apart.setdefault((name, entry.effect.in_time), []).append(entry)
    return list(apart.values())


def of_material(
    asked: AskedTests,
    base: Identification,
    leading: Sequence[list[ScanEntry]],
    fitted: Fitted = unseen,
) -> list[Hypothesis]:
    """The leading effects beside any material, whose spectrum is found anew with each."""
    tried = []
    for entries in leading:
        effect = entries[0].effect
        model = base.model + effect
        seeds = [entry.start(base, model) for entry in _first(entries, STARTS)]
        tried.append(_exact_fit(asked, effect, model, seeds, fitted))
    return [each for each in tried if each is not None]


def _exact_fit(
    asked: AskedTests,
    effect: Effect,
    model: Model,
    seeds: Sequence[Real],
    fitted: Fitted,
    *,
    thorough: bool = False,
    near: bool = False,
) -> Hypothesis | None:
    """An effect fitted exactly; None, and why among those left out, where that fails."""
    from .fitting import identify

    try:
        fit = identify(
            asked.tests, model, seeds=seeds, noise=asked.known, thorough=thorough, near=near
        )
    except UntoldError as error:
        # Of no known size, it may explain the tests all the same.
        asked.left_out[effect.name] = str(error)
        left = FitResiduals.by(error.model, error.theta, reference_of(asked.tests), asked.parts)
        return Hypothesis((effect,), error.model, error.theta, left)
    except SpringpotError as error:
        asked.left_out[effect.name] = str(error)
        return None
    fitted(TriedEffect(effect, fit.model, fit.theta))
    return Hypothesis.exactly((effect,), fit, asked.parts)


def _first(entries: Sequence[ScanEntry], count: int) -> list[ScanEntry]:
    """The first scan entries of an effect, and the first of the other sign where they have one.

    Of an effect that is large a linear step may not even tell whether it adds or takes away.
    """
    best = list(entries[:count])
    turned = (each for each in entries if each.values[0] * best[0].values[0] < 0.0 < each.drop)
    other = next(turned, None)
    if other is not None and other not in best:
        best.append(other)
    return best


def approximately_fitted(
    asked: AskedTests,
    base: Identification,
    leading: Sequence[list[ScanEntry]],
    before: FitResiduals,
    starts: int = STARTS,
    fitted: Fitted = unseen,
) -> list[Hypothesis]:
    """The leading effects fitted by fixed exponentials, and what is left of the exact response.

    Those that swing by the exact response, if they lead; each from so many `starts`. `fitted` is
    given each as it comes.
    """
    tried = []
    best = max((entries[0].drop for entries in leading), default=0.0)
    for entries in leading:
        effect = entries[0].effect
        model = base.model + effect
        seeds = [entry.start(base, model, moved=True) for entry in _first(entries, starts)]
        seeds.append(entries[0].start(base, model))
        # The model's own fit with a trace of the effect is the last seed: an effect that does
        # nothing ends there.
        search = TimeSearch(model, asked.quick, base.reference, seeds, thorough=False)
        # Without the effect a parameter may have gone where nothing tells the way back; the
        # effect's own are where it was tried.
        own = np.isin(model.names, base.model.names)
        *begun, last = search.starts()
        begun = [*(np.where(own, search.inside(u), u) for u in begun), last]
        # The exact response takes long: it is spent only where more than noise is left to explain,
        # or where most of what passes for noise would go.
        worth = before.misfit or _predicted_gain(entries[0]) >= SEARCH.decisive
        try:
            try:
                found = _near_fit(asked, effect, search, asked.quick, begun)
            except UnfollowedError:
                if entries[0].drop < COSTLY * best or not worth:
                    continue
                found = _near_fit(asked, effect, search, asked.parts, begun[:starts])
        except SpringpotError as error:
            # It has no law in time for such a test.
            asked.left_out[effect.name] = str(error)
            continue
        tried.append(found)
        fitted(TriedEffect(effect, model, found.theta))
    return tried


def _near_fit(
    asked: AskedTests,
    effect: Effect,
    search: TimeSearch,
    parts: Sequence[TestPart],
    begun: Sequence[Real],
) -> Hypothesis:
    """An effect nearly fitted to tests as a search sees them, from where it has begun."""
    theta = search.theta(search.near(parts, begun)[0])
    # Not of the exponentials: by the part in a thousand that they are off, the right effect could
    # fall behind.
    left = FitResiduals.by(search.model, theta, search.reference, asked.parts)
    # Beside a spring that does not give, the exact response may be no number.
    if not all(np.isfinite(each).all() for each in left.residuals):
        raise UnfollowedError(f"{search.model.name} cannot be followed in these tests")
    return Hypothesis((effect,), search.model, theta, left)


def _predicted_gain(entry: ScanEntry) -> float:
    """By how much the Bayesian information criterion would fall as a linear step foretells it."""
    count, left = len(entry.direction), max(entry.leaves, SMALLEST)
    fall = count * float(np.log1p(entry.drop / left))
    return fall - len(entry.values) * float(np.log(count))


def nearly_all(
    asked: AskedTests,
    base: Identification,
    entries: dict[str, list[ScanEntry]],
    before: FitResiduals,
    fitted: Fitted = unseen,
) -> list[Hypothesis]:
    """The leading effects nearly fitted, and the others where those miss the tests."""
    leading = leading_of_scan(entries, before)
    nearly = approximately_fitted(asked, base, leading, before, fitted=fitted)
    others = left_by_screening(entries, nearly, before)
    return nearly + approximately_fitted(asked, base, others, before, fitted=fitted)


def alone(each: Hypothesis, model: Model) -> Real:
    """A model's own parameters (p,) where an effect has led them."""
    return model.picked(each.model.named(each.theta))


def from_the_data(
    asked: AskedTests, base: Identification, nearly: Sequence[Hypothesis], before: FitResiduals
) -> list[Hypothesis]:
    """The same, those that help less than one that explains the tests sought as a first fit is.

    What it makes of the model's own parameters another effect may ask otherwise: of a mode in the
    relaxation and of one in the retardation each leads away from the other.
    """
    best = min(nearly, key=lambda each: bic_of(each.left), default=None)
    if best is None or best.left.misfit:
        return list(nearly)
    noise = noise_of_best(before, best.left)
    gains = [delta_bic(before, each.left, noise) for each in nearly]
    helps = [i for i in np.argsort(gains)[::-1].tolist() if gains[i] >= SEARCH.decisive]
    behind = [i for i in helps if not _near(nearly[i], best, before, noise)][:EXACT]
    found = list(nearly)
    for i in behind:
        each = nearly[i]
        search = TimeSearch(each.model, asked.quick, base.reference, [each.theta])
        with suppress(SpringpotError):
            anew = _near_fit(asked, each.effect, search, asked.quick, search.starts())
            found[i] = min(each, anew, key=lambda one: bic_of(one.left))
    return found


def exactly_fitted(
    asked: AskedTests,
    nearly: Sequence[Hypothesis],
    before: FitResiduals,
    fitted: Fitted = unseen,
) -> list[Hypothesis]:
    """The best of them fitted exactly, and the others as they are."""
    # The noise is read where the least is left, and the effects are then rated by that one noise.
    least = min((each.left for each in nearly), key=bic_of, default=before)
    noise = noise_of_best(before, least)
    rated = sorted(nearly, key=lambda each: -delta_bic(before, each.left, noise))
    if not rated:
        return []
    best = rated[0]
    # An exact fit is dear: it is spent where it can change the order, and not on what is far
    # behind.
    near = [i for i, each in enumerate(rated) if _near(each, best, before, noise)][:EXACT]
    # Fits that all go on from one that misses the tests by far may all be caught where it was.
    astray = best.left.over(noise) > ASTRAY
    if astray:
        near = list(range(len(rated)))[:EXACT]
    tried: list[Hypothesis | None] = list(rated)
    for i in near:
        one, seeds = rated[i], [rated[i].theta]
        tried[i] = _exact_fit(
            asked, one.effect, one.model, seeds, fitted, thorough=astray, near=not astray
        )
    found = [each for each in tried if each is not None]
    return found if astray else _sought_where_it_misses(asked, found, fitted)


def _sought_where_it_misses(
    asked: AskedTests, found: list[Hypothesis], fitted: Fitted
) -> list[Hypothesis]:
    """The same, the best sought as a first fit is, where it misses the tests.

    What the effect did to the model before it was there may hold it in another minimum: that no
    effect explains the tests is said of the best that each can do.
    """
    from .fitting import identify

    best = min(found, key=lambda each: bic_of(each.left), default=None)
    if best is None or not best.left.misfit:
        return found
    try:
        fit = identify(
            asked.tests, best.model, seeds=[best.theta], noise=asked.known, thorough=True
        )
    except SpringpotError:
        return found  # what was found before stands
    anew = Hypothesis.exactly((best.effect,), fit, asked.parts)
    if bic_of(anew.left) >= bic_of(best.left):
        return found
    fitted(TriedEffect(best.effect, fit.model, fit.theta))
    return [anew if each is best else each for each in found]


def _near(
    each: Hypothesis, best: Hypothesis, before: FitResiduals, noise: Sequence[ResidualScatter]
) -> bool:
    """Whether a nearly fitted effect may be in the class of the best."""
    worse = each.left.squares(noise) - best.left.squares(noise)
    apart = delta_bic(before, best.left, noise) - delta_bic(before, each.left, noise)
    # Twice what makes a class of effects.
    return min(worse, apart) <= 2.0 * EVIDENCE.rivals


def noise_of_best(before: FitResiduals, best: FitResiduals) -> list[ResidualScatter]:
    """The noise of each test: read where the least else is left."""
    noise = list(before.scatters)
    for i, (old, new) in enumerate(zip(before.residuals, best.residuals, strict=True)):
        # The best of all tests together may be worse for one of them.
        if np.sum(new**2) <= np.sum(old**2):
            noise[i] = best.scatters[i]
    return noise
