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
from springpot.diagnosis.result import Diagnosis, Fitted, unseen
from springpot.identification.held_material import within_material
from springpot.identification.material import is_material
from springpot.identification.result import Identification
from springpot.measurement.timenoise import noise_of
from springpot.measurement.timetest import TimeTest
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from ..numerics import NEGLIGIBLE, SMALLEST
from .experiment import next_test
from .exponentials import quick_parts
from .fitting import identify
from .floor import material_floor
from .left import Left, slip_beside
from .residuals_of_tests import (
    InTimePart,
    Test,
    TestPart,
    parts_of_specimen,
)
from .scatter import (
    scatter_of,
)
from .score import TimeScan
from .sieve import (
    delta_of,
    exactly_fitted,
    from_the_best,
    leading_of_scan,
    nearly_all,
    noise_of_both,
    of_material,
    plain_bic,
    power_of,
)
from .specimen import at_rigs, at_tests
from .tried import Tried
from .verdict import AskedTests, TimeCase, answer_of, worst_of

UNEVEN = 1.5
"""Ratio of the largest to the smallest noise of a record from which its shape matters."""


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
    >>> names = ("force-drift", "force-offset", "parallel-spring")
    >>> few = [springpot.plugins().effect(name) for name in names]
    >>> diagnose(test, model, few).best.effect
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
    fitted: Fitted = unseen,
) -> TimeCase:
    """The same with the fits behind it; `base` is that of the model, where it is known already.

    `accuracy` is what the instrument promises; `fitted` is given each effect that was fitted.
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
    case = _judged(given, model, library, base, None, fitted)
    noise = _noise_beside(parts_of_specimen(given), case)
    if noise is not None:
        # `base` was fitted with the weights of the first noise: it is fitted anew with those of the
        # second.
        case = _judged(given, model, library, None, noise, fitted)
    told = in_practice(case.diagnosis, case.misfits, accuracy)
    lowest = material_floor(case.base).errors[worst_of(told.tests)]
    error = replace(told.error, material_floor=lowest)
    asked = next_test(case, parts_of_specimen(given, noise))
    return case._replace(diagnosis=replace(told, error=error, next_experiment=asked))


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
    fitted: Fitted,
) -> TimeCase:
    """The diagnosis with a certain noise."""
    if base is None:
        base = identify(given, model, noise=known)
    parts = parts_of_specimen(given, known)
    quick, left_out = quick_parts(parts), dict[str, str]()
    # Three sieves, each finer and dearer than the one before: a linear scan, fits by fixed
    # exponentials, exact fits.
    before = Left.by(base.model, base.theta, base.reference, parts)
    beside = [effect for effect in effects if not _within(base.model, effect)]
    promises = TimeScan(base, quick).promises(beside)
    if is_material(base.model):
        leading = leading_of_scan(promises, before)
        tried = of_material(given, parts, base, leading, known, left_out, fitted)
    else:
        nearly = nearly_all(base, parts, quick, promises, before, left_out, fitted)
        nearly += from_the_best(base, parts, quick, beside, nearly, before, left_out)
        tried = exactly_fitted(given, parts, base, nearly, before, known, left_out, fitted)
    # A model with one more effect can always do as well as the one without: worse is a search that
    # failed.
    tried = _one_of_each([_no_worse(each, before) for each in tried])
    # By a criterion that needs no noise, which is only read from what the best one leaves.
    slip = slip_beside(parts, base, before)
    named = [each.left for each in tried] or [before]
    best = min([*named, slip.left], key=plain_bic)
    noise = noise_of_both(before, best)
    judged = [replace(each, delta=delta_of(before, each, noise, base)) for each in tried]
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
    ranked = sorted(judged, key=lambda each: (-round(each.evidence, 1), power_of(each.left)))
    # What cannot be told from another material and helps no more than one is no candidate.
    ranked = [each for each in ranked if each.effect.name not in left_out or each.helps]
    for each in ranked:
        left_out.pop(each.effect.name, None)
    case = answer_of(parts, base, before, ranked, noise, promises, left_out, slip)
    return case._replace(asked=AskedTests(given, parts, quick, known, beside))


def _no_worse(each: Tried, before: Left) -> Tried:
    """An effect that changes nothing, or whose fit went astray, leaves what was left without it.

    It has no size.
    """
    if power_of(each.left) < (1.0 - NEGLIGIBLE) * power_of(before):
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
        if name not in best or plain_bic(each.left) < plain_bic(best[name].left):
            best[name] = each
    return list(best.values())


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
        of_one = max(part.sampled(missed), SMALLEST)
        gain += float(old @ old - new @ new) / of_one
        count += float(missed @ missed) / of_one
    return gain - (each.left.count - before.count) * float(np.log(max(count, 2.0)))
