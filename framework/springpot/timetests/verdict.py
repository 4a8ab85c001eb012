"""What the effects that were tried on tests in time say together: verdict, classes, chances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from springpot.diagnosis.result import Candidate, Diagnosis, EffectVerdict, Verdict
from springpot.identification.value import Value
from springpot.measurement.sign import said_of_sign
from springpot.misfit.error import Error
from springpot.misfit.where import Where
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .answer import NAN, error_of, leading_of, sentence
from .information_criterion import ALIKE, HINT, PLAINLY, Left
from .residuals_of_tests import InTimePart, Part
from .result import TimeIdentification
from .scan_scores import Promise
from .scatter import Scatter
from .where import places, worst_first

TWINS = 0.995
"""Cosine between what two effects leave in a record from which they are one to it, whatever the
fits say: told apart they would need a hundred times the evidence that finds them."""


@dataclass(frozen=True, eq=False)
class Tried:
    """An effect, what is left with it, and how much likelier it makes the tests.

    Attributes
    ----------
    effect : Effect
        The effect.
    model : Model
        The model with it.
    theta : ndarray, shape (p,)
        Its parameters.
    left : Left
        What is left of the tests.
    delta : float
        By how much the Bayesian information criterion falls.
    fit : TimeIdentification or None
        The exact fit, where there is one.
    """

    effect: Effect
    model: Model
    theta: Real
    left: Left
    delta: float
    fit: TimeIdentification | None = None

    @property
    def evidence(self) -> float:
        """The same with how common the effect is: twice the logarithm of its odds."""
        return self.delta + 2.0 * float(np.log(self.effect.prior))


class TimeCase(NamedTuple):
    """A diagnosis of tests in time with the fits behind it.

    Attributes
    ----------
    diagnosis : Diagnosis
        What is said.
    base : TimeIdentification
        The model that was judged.
    best_fit : TimeIdentification
        The model with the best effect, where one is missing; else the base.
    """

    diagnosis: Diagnosis
    base: TimeIdentification
    best_fit: TimeIdentification


def answer_of(
    parts: Sequence[Part],
    base: TimeIdentification,
    before: Left,
    tried: Sequence[Tried],
    noise: Sequence[Scatter],
    promises: dict[str, list[Promise]],
    left_out: dict[str, str],
) -> TimeCase:
    """The answer of a diagnosis from the effects that were tried, best first."""
    verdict = _verdict(before, tried)
    alike: list[str] = []
    if _is_plain(tried):
        alike = _class(tried, promises, noise)
    candidates = []
    for each, chance in zip(tried, _chances(tried), strict=True):
        of_it = _open(each, alike)
        # One of several that cannot be told apart is not known to be the missing one.
        if verdict == "effect-missing" and len(alike) == 1 and each is tried[0]:
            of_it = "missing"
        after = error_of(parts, each.left, noise)
        candidates.append(_candidate(each, chance, alike, after, of_it))
    error = error_of(parts, before, noise)
    where: tuple[Where, ...] = ()
    # What noise leaves of an adequate model stands out somewhere too.
    if verdict != "adequate":
        where = where_missed(parts, before, noise)
    # The next round of a discovery goes on from the best fit that there is.
    best_fit = base
    for each in tried:
        if each.fit is not None and each.effect.name in alike[:1]:
            best_fit = each.fit
            break
    diagnosis = Diagnosis(
        data=" + ".join(test.name for test in base.tests),
        model=base.model,
        error=error,
        verdict=verdict,
        says=sentence(error, verdict, candidates, where),
        split="",
        where=where,
        candidates=tuple(candidates),
        classes=_classes(promises, tried, alike),
        notes=tuple(note for part in parts for note in said_of_sign(part.test.provenance)),
        parameters=base.parameters,
        leading=leading_of(candidates),
        tests=base.tests,
        left_out=left_out,
    )
    return TimeCase(diagnosis, base, best_fit)


def _is_plain(tried: Sequence[Tried]) -> bool:
    """Whether the evidence for the best effect is beyond doubt."""
    return bool(tried) and tried[0].delta > PLAINLY


def _verdict(before: Left, tried: Sequence[Tried]) -> Verdict:
    """What the tests say of the model, `tried` best first."""
    if _is_plain(tried):
        # An effect that helps and leaves more than noise is not all that is missing.
        if tried[0].left.misfit:
            return "unexplained"
        return "effect-missing"
    if before.misfit:
        return "unexplained"
    if before.doubtful or (tried and tried[0].delta > HINT):
        return "inconclusive"
    return "adequate"


def where_missed(
    parts: Sequence[Part], before: Left, noise: Sequence[Scatter]
) -> tuple[Where, ...]:
    """Where the model fails in all tests in time, the worst first."""
    located: list[Where] = []
    for part, residual, scatter in zip(parts, before.residuals, noise, strict=True):
        if isinstance(part, InTimePart):
            located += places(part.test, residual / scatter.size)
    return worst_first(located)


def _class(
    tried: Sequence[Tried], promises: dict[str, list[Promise]], noise: Sequence[Scatter]
) -> list[str]:
    """The best effect and those that these tests cannot tell from it."""
    # By what the tests say alone: how common an effect is makes it no worse an explanation of them.
    best = max(tried, key=lambda each: each.delta)
    # Two roads to a class: effects that fit as well, and such that add the same shape but were
    # never fitted.
    alike = [
        each
        for each in tried
        if each is tried[0] or (each.delta > PLAINLY and _as_well(each, best, noise))
    ]
    names = [each.effect.name for each in alike]
    fitted = {each.effect.name for each in tried}
    return names + [name for name in _twins(best.effect.name, promises) if name not in fitted]


def _as_well(each: Tried, best: Tried, noise: Sequence[Scatter]) -> bool:
    """Whether an effect explains the tests as well as the best one.

    More parameters do not exclude it.
    """
    worse = each.left.squares(noise) - best.left.squares(noise)
    return min(worse, best.delta - each.delta) <= ALIKE


def _twins(name: str, promises: dict[str, list[Promise]]) -> list[str]:
    """Effects that add the same to a record as one does."""
    # What the model's own parameters could take over is out of these directions: only what is seen
    # is compared.
    own = promises[name][0].direction
    twins = []
    for other, others in promises.items():
        if other != name and abs(float(own @ others[0].direction)) > TWINS:
            twins.append(other)
    return twins


def _classes(
    promises: dict[str, list[Promise]], tried: Sequence[Tried], alike: Sequence[str]
) -> tuple[tuple[str, ...], ...]:
    """Effects that are one to these tests.

    The class of the best, and the twins of the others that were fitted.
    """
    classes = []
    if len(alike) > 1:
        classes.append(tuple(alike))
    taken = set(alike)
    for each in tried:
        name = each.effect.name
        if name in taken:
            continue
        # Each effect in one class alone: the first that claims it is the better one.
        twins = [other for other in _twins(name, promises) if other not in taken]
        if twins:
            classes.append((name, *twins))
            taken |= {name, *twins}
    return tuple(classes)


def _chances(tried: Sequence[Tried]) -> list[float]:
    """Probability of each effect, against nothing missing too."""
    if not tried:
        return []
    # Nought is the model as it is: nothing missing is a candidate too.
    logs = np.array([0.0, *(0.5 * each.evidence for each in tried)])
    # Less the largest, or evidence of some thousand would overflow.
    weights = np.exp(logs - logs.max())
    return [float(weight) for weight in weights[1:] / weights.sum()]


def _open(each: Tried, alike: Sequence[str]) -> EffectVerdict:
    """Of an effect that is not plainly missing: absent only where nothing speaks for it.

    One that helps, and less than a rival, may be there beside the rival, or only resemble it: that
    is told when the rival has been accepted.
    """
    if each.effect.name in alike or each.delta > HINT:
        return "cannot-tell"
    return "absent"


def _candidate(
    each: Tried, chance: float, alike: Sequence[str], after: Error, verdict: EffectVerdict
) -> Candidate:
    name = each.effect.name
    parameters: dict[str, Value] = {}
    if each.fit is not None:
        # A parameter is called effect.own, and effect#2.own where the model has the effect already.
        for whole, value in each.fit.parameters.items():
            prefix, _, own = whole.rpartition(".")
            if prefix.split("#")[0] == name:
                parameters[own] = value
    others: tuple[str, ...] = ()
    if name in alike:
        others = tuple(other for other in alike if other != name)
    return Candidate(
        physics=each.effect,
        alike=(name, *others),
        probability=chance,
        delta_bic=each.delta,
        score=NAN,
        verdict=verdict,
        predicted_error=NAN,
        error_after=after.relative_rms,
        over_floor=after.over_floor,
        bound=NAN,
        parameters=parameters,
        says=each.effect.summary,
    )
