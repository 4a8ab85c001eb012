"""Which effect is missing from a model of tests in time.

All are looked at at once, and the leading few are fitted.

Harmonics hide what happens within a cycle; the record does not. The error of the model stands
beside the noise of the record, every effect is judged by how far the error falls for its
parameters, and those that fall alike are one class.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from springpot.diagnosis.in_practice import Accuracy, in_practice
from springpot.diagnosis.result import Diagnosis
from springpot.errors import SpringpotError
from springpot.identification.held_material import within_material
from springpot.identification.material import is_material
from springpot.identification.result import Identification
from springpot.measurement.timenoise import noise_of
from springpot.measurement.timetest import TimeTest
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from ..numerics import NEGLIGIBLE
from .exponentials import UnfollowedError, quick_parts
from .fitting import identify
from .floor import material_floor
from .left import Left, delta_bic, independent
from .material import UntoldError
from .native import TimeSearch
from .promises import Promise
from .residuals_of_tests import (
    InTimePart,
    Test,
    TestPart,
    parts_of_specimen,
)
from .scatter import (
    ResidualScatter,
    scatter_of,
)
from .score import TimeScan
from .slip import slip_beside
from .specimen import at_rigs, at_tests
from .temperatures import is_law
from .verdict import TimeCase, Tried, answer_of, worst_of

LEADING = 14
"""Effects that are fitted, nearly: the others fell behind by a linear step already."""
FEWEST = 3
"""Effects that are fitted even where nothing promises much.

So that the answer says how little they would help.
"""
HOPE = 4.0
"""Drop of the sum of squares, over the noise, below which an effect is not worth a fit.

Two standard deviations.
"""
STARTS = 4
"""Places in the parameters of an effect from which its fit begins."""
EXACT = 5
"""Effects that are fitted exactly, of those that are near the best.

The rest can be no more than absent.
"""
MARGIN = 12.0
"""Difference of the Bayesian information criterion within which an effect is near the best.

Twice that of a class.
"""
UNEVEN = 1.5
"""Ratio of the largest to the smallest noise of a record from which its shape matters."""
COSTLY = 0.05
"""Share of the best promise that makes an effect by which the specimen swings worth its fit."""
ASTRAY = 3.0
"""Error over the noise of the best effect from which its fit is not believed to be at its minimum.
"""


def diagnose(
    tests: Sequence[Test] | Test,
    model: Model | str,
    effects: Iterable[Effect] | None = None,
    *,
    accuracy: Accuracy | None = None,
) -> Diagnosis:
    """Find which effect is missing from a model of tests in time.

    Parameters
    ----------
    tests : TimeTest, Measurement, or a sequence of them
        Of one specimen, at least one in time.
    model : Model or str
        The model to be judged, or its expression, such as ``"fractional-zener + force-drift"``.
    effects : iterable of Effect, optional
        What may be missing; by default all that is installed. Those without a law in time, or whose
        conditions the tests lack, are passed over.
    accuracy : Accuracy, optional
        What the instrument promises: a misfit within it is no verdict on the model.

    Returns
    -------
    Diagnosis
        Verdict, candidates best first, and where the model fails.

    Raises
    ------
    SpringpotError
        If the model itself does not fit the tests.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.timetests import diagnose
    >>> model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.01, 100.0, 80)
    >>> exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), t) + 0.2 * t
    >>> noise = np.random.default_rng(1).normal(size=80)
    >>> test = springpot.TimeTest.of_relaxation(t, exact + noise, "kPa")
    >>> diagnose(test, model, springpot.plugins().items("effect")).best.effect
    'force-drift'
    """
    return examine(tests, model, effects, accuracy=accuracy).diagnosis


def examine(
    tests: Sequence[Test] | Test,
    model: Model | str,
    effects: Iterable[Effect] | None = None,
    *,
    base: Identification | None = None,
    accuracy: Accuracy | None = None,
) -> TimeCase:
    """The same with the fits behind it; `base` is that of the model, where it is known already.

    `accuracy` is what the instrument promises.
    """
    given = _listed(tests)
    if isinstance(model, str):
        model = parse_model(model)
    if effects is None:
        effects = list(plugins().items("effect"))
    library = [there for effect in effects for there in at_tests(effect, given)]
    model = at_rigs(model, given)
    # The noise is needed to judge and a good model to know the noise: so a second round, where it
    # matters.
    case = _judged(given, model, library, base, None)
    noise = _noise_beside(parts_of_specimen(given), case)
    if noise is not None:
        # `base` was fitted with the weights of the first noise: it is fitted anew with those of the
        # second.
        case = _judged(given, model, library, None, noise)
    told = in_practice(case.diagnosis, case.misfits, accuracy)
    lowest = material_floor(case.base).errors[worst_of(told.tests)]
    error = replace(told.error, material_floor=lowest)
    return case._replace(diagnosis=replace(told, error=error))


def _listed(tests: Sequence[Test] | Test) -> list[Test]:
    if isinstance(tests, TimeTest) or not isinstance(tests, Sequence):
        return [tests]
    return list(tests)


def _noise_beside(parts: Sequence[TestPart], first: TimeCase) -> list[Real | None] | None:
    """The noise of each test as the best model shows it, where the signal told another.

    None where it did not.

    Corners that friction, stops or a release make in a signal look like noise that grows with it.
    """
    noise = [_better_noise(part, first.best_fit) for part in parts]
    if all(each is None for each in noise):
        return None
    return noise


def _better_noise(part: TestPart, fit: Identification) -> Real | None:
    """The noise of one test as a fit shows it; None where what the signal told will do."""
    # The answer to a step is smooth between its jumps: its signal has told its noise already.
    if not isinstance(part, InTimePart) or part.test.after_step:
        return None
    # Only the shape of the noise weighs samples against one another: its size is read from what is
    # left anyway.
    if part.sd.max() < UNEVEN * part.sd.min():
        return None
    over_noise = part.residual(fit.model, fit.theta, fit.reference).value
    all_noise = not scatter_of(over_noise).doubtful
    better = noise_of(part.test, over_noise * part.sd, all_noise=all_noise).sd
    share = better / part.sd
    if share.max() > UNEVEN * share.min():
        return better
    return None


def _judged(
    given: Sequence[Test],
    model: Model,
    effects: Sequence[Effect],
    base: Identification | None,
    known: Sequence[Real | None] | None,
) -> TimeCase:
    """The diagnosis with a certain noise."""
    if base is None:
        base = identify(given, model, noise=known)
    parts = parts_of_specimen(given, known)
    quick = quick_parts(parts)
    # Three sieves, each finer and dearer than the one before: a linear scan, fits by fixed
    # exponentials, exact fits.
    before = Left.by(base.model, base.theta, base.reference, parts)
    beside = [effect for effect in effects if not _within(base.model, effect)]
    promises = TimeScan(base, quick).promises(beside)
    leading = _leading(promises, before)
    left_out: dict[str, str] = {}
    if is_material(base.model):
        tried = _of_material(given, parts, base, leading, known, left_out)
    else:
        nearly = _nearly(base, parts, quick, leading, before, left_out)
        nearly += _from_the_best(base, parts, quick, beside, nearly, before, left_out)
        tried = _exactly(given, parts, base, nearly, before, known, left_out)
    # A model with one more effect can always do as well as the one without: worse is a search that
    # failed.
    tried = _one_of_each([_no_worse(each, before) for each in tried])
    # By a criterion that needs no noise, which is only read from what the best one leaves.
    slip = slip_beside(parts, base, before)
    named = [each.left for each in tried] or [before]
    best = min([*named, slip.left], key=_plain_bic)
    noise = _noise(before, best)
    judged = [replace(each, delta=_delta(before, each, noise, base)) for each in tried]
    # Where the misfit is not certain by itself, it is the noise over which an effect shows it.
    if before.misfit and best.misfit:
        # No unit but that of what the best explanation misses: over the noise alone whatever takes
        # a little more of a large misfit would be proved.
        judged = [replace(each, delta=_over_misses(parts, before, each, best)) for each in tried]
    else:
        judged = [_of_what_helps(parts, before, each) for each in judged]
    # By their chances, so that what is rare stands behind what is common and explains the tests as
    # well.
    # Where all leave less than the noise, the one that leaves least stands first all the same.
    ranked = sorted(judged, key=lambda each: (-round(each.evidence, 1), _power(each.left)))
    # What cannot be told from another material and helps no more than one is no candidate.
    ranked = [each for each in ranked if each.effect.name not in left_out or each.helps]
    for each in ranked:
        left_out.pop(each.effect.name, None)
    return answer_of(parts, base, before, ranked, noise, promises, left_out, slip)


def _no_worse(each: Tried, before: Left) -> Tried:
    """An effect that changes nothing, or whose fit went astray, leaves what was left without it.

    It has no size.
    """
    if _power(each.left) < (1.0 - NEGLIGIBLE) * _power(before):
        return each
    return replace(each, left=replace(before, count=each.left.count), fit=None)


def _within(material: Model, effect: Effect) -> bool:
    """Whether a free spectrum has an effect already.

    That of one rig alone the other tests are free of.
    """
    return effect.in_time and within_material(material, effect)


def _one_of_each(tried: Sequence[Tried]) -> list[Tried]:
    """Of an effect that all rigs or one alone may have, where it explains more."""
    best: dict[str, Tried] = {}
    for each in tried:
        name = each.effect.name
        if name not in best or _plain_bic(each.left) < _plain_bic(best[name].left):
            best[name] = each
    return list(best.values())


def _leading(promises: dict[str, list[Promise]], before: Left) -> list[list[Promise]]:
    """The promises of the effects that are worth a fit."""
    scatter = before.scatters[0]
    # Of noise whose neighbours are alike so many samples are one independent number.
    unit = scatter.size**2 * (1.0 + scatter.memory) / (1.0 - scatter.memory)
    count = np.log(independent(before.residuals, before.scatters))

    def hope(of_effect: list[Promise]) -> float:
        return float(of_effect[0].drop / unit - len(of_effect[0].values) * count)

    # Hope is the drop less what its parameters cost: else the effect with most parameters would
    # lead.
    ranked = sorted(_by_rig(promises), key=hope, reverse=True)
    worth = [of_effect for of_effect in ranked[:LEADING] if of_effect[0].drop / unit > HOPE]
    # Of what does not go as its size, such as a limit or a fading, a linear step tells too little.
    # Beside other tests each such fit would take as long as all others.
    if len(before.residuals) == 1:
        worth += [each for each in ranked if not each[0].as_its_size and each not in worth]
    # A law of temperature moves times by decades, which no small step foretells either.
    worth += [each for each in ranked if is_law(each[0].effect) and each not in worth]
    if len(worth) < FEWEST:
        return ranked[:FEWEST]
    return worth


def _by_rig(promises: dict[str, list[Promise]]) -> list[list[Promise]]:
    """The promises of each effect at one place: of all rigs, or of one alone."""
    apart: dict[tuple[str, bool], list[Promise]] = {}
    for name, of_effect in promises.items():
        for promise in of_effect:
            apart.setdefault((name, promise.effect.in_time), []).append(promise)
    return list(apart.values())


def _of_material(
    tests: Sequence[Test],
    parts: Sequence[TestPart],
    base: Identification,
    leading: Sequence[list[Promise]],
    known: Sequence[Real | None] | None,
    left_out: dict[str, str],
) -> list[Tried]:
    """The leading effects beside any material, whose spectrum is found anew with each."""
    tried = []
    for promises in leading:
        effect = promises[0].effect
        model = base.model + effect
        try:
            seeds = [promise.start(base, model) for promise in promises[:STARTS]]
            fit = identify(tests, model, seeds=seeds, thorough=False, noise=known)
        except UntoldError as error:
            # Of no known size, it may explain the tests all the same.
            left_out[effect.name] = str(error)
            left = Left.by(error.model, error.theta, base.reference, parts)
            tried.append(Tried(effect, error.model, error.theta, left, 0.0))
            continue
        except SpringpotError as error:
            left_out[effect.name] = str(error)
            continue
        left = Left.by(fit.model, fit.theta, fit.reference, parts)
        tried.append(Tried(effect, fit.model, fit.theta, left, 0.0, fit))
    return tried


def _nearly(
    base: Identification,
    parts: Sequence[TestPart],
    quick: Sequence[TestPart],
    leading: Sequence[list[Promise]],
    before: Left,
    left_out: dict[str, str],
) -> list[Tried]:
    """The leading effects fitted by fixed exponentials, and what is left of the exact response.

    Those that swing by the exact response, if they lead.
    """
    tried = []
    best = max((promises[0].drop for promises in leading), default=0.0)
    for promises in leading:
        effect = promises[0].effect
        model = base.model + effect
        seeds = [promise.start(base, model, moved=True) for promise in promises[:STARTS]]
        seeds.append(promises[0].start(base, model))
        # The model's own fit with a trace of the effect is the last seed: an effect that does
        # nothing ends there.
        search = TimeSearch(model, quick, base.reference, seeds, thorough=False)
        # Without the effect a parameter may have gone where nothing tells the way back.
        starts = [*(search.centred(u) for u in search.starts()[:-1]), search.starts()[-1]]
        try:
            u, _ = search.near(quick, starts)
            # Not of the exponentials: by the part in a thousand that they are off, the right effect
            # could fall behind.
            left = Left.by(model, search.theta(u), base.reference, parts)
        except UnfollowedError:
            # The exact response takes long: it is spent only where more than noise is left to
            # explain.
            if promises[0].drop < COSTLY * best or not before.misfit:
                continue
            try:
                u, _ = search.near(parts, starts[:STARTS])
                left = Left.by(model, search.theta(u), base.reference, parts)
            except SpringpotError as error:
                left_out[effect.name] = str(error)
                continue
        except SpringpotError as error:
            # It has no law in time for such a test.
            left_out[effect.name] = str(error)
            continue
        tried.append(Tried(effect, model, search.theta(u), left, 0.0))
    return tried


def _from_the_best(
    base: Identification,
    parts: Sequence[TestPart],
    quick: Sequence[TestPart],
    effects: Sequence[Effect],
    nearly: Sequence[Tried],
    before: Left,
    left_out: dict[str, str],
) -> list[Tried]:
    """Effects that do what the best one does, where it is.

    From a fit that misses the tests by far a linear step leads astray: so a dashpot may be left out
    that a springpot of order one was found to be.
    """
    if not nearly or before.over(before.scatters) < ASTRAY:
        return []
    best = min(nearly, key=lambda each: _plain_bic(each.left))
    grown = replace(base, model=best.model, theta=best.theta)
    promises = TimeScan(grown, quick).in_place_of(best.effect, effects)
    tried = {each.effect.name for each in nearly}
    leading = [each for name, each in promises.items() if name not in tried]
    return _nearly(base, parts, quick, leading, before, left_out)


def _exactly(
    tests: Sequence[Test],
    parts: Sequence[TestPart],
    base: Identification,
    nearly: Sequence[Tried],
    before: Left,
    known: Sequence[Real | None] | None,
    left_out: dict[str, str],
) -> list[Tried]:
    """The best of them fitted exactly, and the others as they are."""
    # The noise is read where the least is left, and the effects are then rated by that one noise.
    least = min((each.left for each in nearly), key=_plain_bic, default=before)
    noise = _noise(before, least)
    rated = sorted(nearly, key=lambda each: -_delta(before, each, noise, base))
    if not rated:
        return []
    best = rated[0]
    # An exact fit is dear: it is spent where it can change the order, and not on what is far
    # behind.
    near = [i for i, each in enumerate(rated) if _near(each, best, before, noise, base)][:EXACT]
    # Fits that all go on from one that misses the tests by far may all be caught where it was.
    astray = best.left.over(noise) > ASTRAY
    if astray:
        near = list(range(len(rated)))[:EXACT]
    tried = []
    for i, each in enumerate(rated):
        if i not in near:
            tried.append(each)
            continue
        try:
            fit = identify(
                tests, each.model, seeds=[each.theta], thorough=astray, noise=known, near=not astray
            )
        except SpringpotError as error:
            left_out[each.effect.name] = str(error)
            continue
        left = Left.by(fit.model, fit.theta, fit.reference, parts)
        tried.append(replace(each, model=fit.model, theta=fit.theta, left=left, fit=fit))
    return tried


def _near(
    each: Tried,
    best: Tried,
    before: Left,
    noise: Sequence[ResidualScatter],
    base: Identification,
) -> bool:
    """Whether a nearly fitted effect may be in the class of the best."""
    worse = each.left.squares(noise) - best.left.squares(noise)
    apart = _delta(before, best, noise, base) - _delta(before, each, noise, base)
    return min(worse, apart) <= MARGIN


def _delta(
    before: Left, each: Tried, noise: Sequence[ResidualScatter], base: Identification
) -> float:
    return delta_bic(before, each.left, noise, each.left.count - before.count)


def _of_what_helps(parts: Sequence[TestPart], before: Left, each: Tried) -> Tried:
    """An effect that leaves more than noise has no evidence where it explains next to none.

    It must be the better story too where what it leaves is taken for noise.
    """
    if not each.left.misfit:
        return each
    helps = _over_misses(parts, before, each, each.left)
    if helps > 0.0:
        return each
    return replace(each, delta=helps)


def _over_misses(parts: Sequence[TestPart], before: Left, each: Tried, unit: Left) -> float:
    """The evidence for an effect in units of what a fit misses.

    Samples that are missed alike count once.
    """
    gain, count = float(before.lines - each.left.lines), 0.0
    for part, old, new, missed in zip(
        parts, before.residuals, each.left.residuals, unit.residuals, strict=True
    ):
        of_one = max(part.sampled(missed), 1e-300)
        gain += float(old @ old - new @ new) / of_one
        count += float(missed @ missed) / of_one
    return gain - (each.left.count - before.count) * float(np.log(max(count, 2.0)))


def _plain_bic(left: Left) -> float:
    """Of a fit by itself: the size of its noise is read from what it leaves."""
    points = sum(len(value) for value in left.residuals)
    variance = max(_power(left), 1e-300) / max(points - left.lines, 1)
    return float(points * np.log(variance) + left.count * np.log(points))


def _power(left: Left) -> float:
    """Sum of squares of all that is left."""
    return sum(float(np.sum(value**2)) for value in left.residuals)


def _noise(before: Left, best: Left) -> list[ResidualScatter]:
    """The noise of each test: read where the least else is left."""
    noise = list(before.scatters)
    for i, (old, new) in enumerate(zip(before.residuals, best.residuals, strict=True)):
        # The best of all tests together may be worse for one of them.
        if np.sum(new**2) <= np.sum(old**2):
            noise[i] = best.scatters[i]
    return noise
