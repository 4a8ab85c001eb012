"""What the effects that were tried on tests in time say together: verdict, classes, chances.

A diagnosis says its error, its sentence, and which effect to add.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from springpot.diagnosis.evidence import chances_of, doubted, log_prior_of_one, size_of_library
from springpot.diagnosis.in_practice import Misfit
from springpot.diagnosis.ladder import GrownBy
from springpot.diagnosis.result import (
    AsTold,
    Candidate,
    Diagnosis,
    EffectVerdict,
    ToDo,
    Verdict,
    leaving_out_the_beginning,
)
from springpot.diagnosis.verdict import Facts, rule_for
from springpot.errors import ModelError
from springpot.identification.result import Identification
from springpot.identification.uncertainty import correlation_of
from springpot.identification.value import PartResult, Value
from springpot.measurement.mixed_up import said_of_sign
from springpot.measurement.timenoise import said_of_strays
from springpot.measurement.timetest import TimeTest
from springpot.misfit.error import Error, times
from springpot.misfit.residual_scatter import ResidualScatter, times_noise
from springpot.misfit.residuals_of_tests import InTimePart, SweepPart, Test, TestPart
from springpot.misfit.where import Where
from springpot.numerics import SMALLEST
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from .disturbances import Slip, lines_in
from .hypotheses import (
    AskedTests,
    FitResiduals,
    Hypothesis,
    ScanEntry,
    chow_rejects,
    collinear_with,
    explains_as_well,
    without_nested,
)
from .material import TimeFloor

NAN = float("nan")


def worst_of(tests: Sequence[PartResult]) -> int:
    """Number of the test that a model misses most: it is as good as it is for that one."""
    return max(range(len(tests)), key=lambda i: tests[i].over_floor)


def error_of(
    tests: Sequence[PartResult],
    noise: Sequence[ResidualScatter],
    floor: TimeFloor | None = None,
    at: int | None = None,
) -> Error:
    """The error of a model beside the noise, of one test: by default the one that it misses most.

    Beside the least of any material in that test, where one was looked for.
    """
    if at is None:
        at = worst_of(tests)
    worst, scatter = tests[at], noise[at]
    source = "residual"
    if scatter.presumed:
        source = "signal"
    lowest = NAN
    if floor is not None:
        lowest = floor.errors[at]
    return Error(
        worst.relative_rms,
        worst.noise_floor,
        source,
        "",
        lowest,
        NAN,
        noise_memory=scatter.memory,
        test=worst.name if len(tests) > 1 else "",
    )


def leading_of(candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """The effects that should be added, which the tests cannot tell apart; empty if none should.

    The class of the first, where the evidence for it is beyond doubt.
    """
    # By evidence alone: the first of several candidates always fits best, which is no proof.
    if not candidates or candidates[0].delta_bic <= SEARCH.decisive:
        return ()
    return candidates[0].alike


def sentence(
    error: Error,
    verdict: Verdict,
    candidates: Sequence[Candidate],
    where: Sequence[Where],
    jump: str = "",
    apart: str = "",
    rival: str = "",
    beside: str = "",
) -> str:
    """The verdict in one sentence; `jump` and `rival` tell of what explains the tests as well.

    `apart` tells of tests that are followed one by one and not together, `beside` of another test
    that the best effect leaves missed.
    """
    size = f"the error is {times(error.over_floor)} the noise"
    # Where it fails is the best advice there is, as long as nobody knows what is missing.
    place = ""
    if where:
        place = f"; {where[0].says}"
    leading = leading_of(candidates)
    names = " or ".join(leading)
    if jump and names:
        return f"{size}; missing is {names}, or it is {jump}{place}"
    if jump:
        return f"{size}; {jump}, explains more than any known effect{place}"
    if verdict == "adequate":
        # Few samples know their noise to a factor of two.
        few = ", which so few samples leave to chance" if error.over_floor > VERDICT.misfit else ""
        return f"{size}{few}: nothing is missing that these tests could show"
    if verdict == "inconclusive":
        hint = "what is left is hardly noise alone"
        if candidates and candidates[0].delta_bic > VERDICT.clear_evidence:
            hint = f"{candidates[0].effect} would help a little"
        return f"{size}: {hint}, which may be chance; measure longer or repeat it{place}"
    if not names or (verdict == "unexplained" and not candidates[0].lowers(error)):
        if apart:
            return f"{size}; {apart}{place}"
        return (
            f"{size}, and no known effect explains it:"
            f" something is missing that is not in the library{place}"
        )
    before, left = error.over_floor, candidates[0].over_floor
    size = f"the error is {times(before, left)} the noise"
    after = f"{times(left, before)} with it{beside}"
    if verdict == "unexplained":
        # Where many do so equally well their names say nothing of the cause.
        if len(leading) > VERDICT.most_alike:
            names = f"{leading[0]}, as any of {len(leading) - 1} others,"
        rest = ", but a pattern is left" if left <= VERDICT.misfit else " but is not all"
        helps = f"{names} helps ({after}){rest}"
        if apart:
            return f"{size}; {apart}; {helps}{place}"
        return f"{size}, and no single known effect explains it: {helps}{place}"
    return f"{size}; missing is {names}: {after}{rival}{place}"


class TimeCase(NamedTuple):
    """A diagnosis of tests in time with the fits behind it.

    Attributes
    ----------
    diagnosis : Diagnosis
        What is said.
    base : Identification
        The model that was judged.
    best_fit : Identification
        The model with the best effect, where one is missing; else the base.
    tried : tuple of Hypothesis
        The model grown by each effect that was fitted.
    asked : AskedTests
        The tests and effects behind it.
    aside : tuple of (int, int, float), optional
        A sample that is all that is missed, see `Slip`.
    """

    diagnosis: Diagnosis
    base: Identification
    best_fit: Identification
    tried: tuple[Hypothesis, ...]
    asked: AskedTests
    aside: tuple[int, int, float] | None = None

    @property
    def tests(self) -> Sequence[Test]:
        """What the model was fitted to, in the units of the fit."""
        return self.base.data

    @property
    def correlated(self) -> tuple[Model, Real]:
        """The model, and the correlations (p, p) of its parameters."""
        return self.base.model, correlation_of(self.base.covariance)

    @property
    def untold(self) -> None:
        """What is nonlinear shows in a record: no amplitude is untold."""

    def grown_with(self, effect: Effect) -> GrownBy:
        """The model as accepting one effect would make it, without a new fit.

        Raises
        ------
        ModelError
            If the effect was not fitted.
        """
        for each in self.tried:
            if each.effect.name == effect.name:
                return GrownBy(each.model, each.theta, each.fit is not None)
        raise ModelError(f"{effect.name} was not fitted beside {self.base.model.name}")


def answer_of(
    asked: AskedTests,
    base: Identification,
    before: FitResiduals,
    tried: Sequence[Hypothesis],
    noise: Sequence[ResidualScatter],
    entries: dict[str, list[ScanEntry]],
    slip: Slip,
) -> TimeCase:
    """The answer of a diagnosis from the effects that were tried, best first."""
    parts, of_slip = asked.parts, slip.delta(before, noise)
    noise, tried = _over_one_noise(before, tried, noise, of_slip)
    weights = _weights(tried, entries, of_slip)
    # A class holds nearly all of the probability: what is in no library may be one of it.
    slipped = of_slip > SEARCH.decisive and weights[-1] > 1.0 - EVIDENCE.credible
    verdict = rule_for(facts_of(before.beside(noise), tried, slipped)).verdict
    noise = before.all_noise if verdict == "adequate" else noise
    best = next((each.left for each in tried), before)
    nothing, *chances, unknown = _posterior(_beside_narrow(weights, tried), verdict, best.chance)
    alike = without_nested(_class(tried, entries, noise), tried, parts, base.reference)
    tests = before.rows(parts, noise, base.tests)
    after, beside = _after(tried, parts, noise, tests)
    error, jump = error_of(tests, noise), slip.says if slipped else ""
    candidates = _candidates(tried, chances, alike, after, verdict, error)
    named = [] if slipped and weights[-1] > VERDICT.likely else candidates
    # What noise leaves of an adequate model stands out somewhere too.
    where = () if verdict == "adequate" else where_missed(parts, before, noise)
    apart = said_apart(parts, tests, best.rows(parts, noise, tests))
    rival = beside_one_way(parts, named, leading_of(named))
    diagnosis = Diagnosis(
        data=base.name,
        model=base.model,
        error=error,
        verdict=verdict,
        says=sentence(error, verdict, named, where, jump, apart, rival, beside),
        split="",
        where=where,
        candidates=tuple(candidates),
        classes=_classes(entries, tried, alike),
        notes=tuple(_notes_on(parts, best)),
        parameters=base.parameters,
        leading=leading_of(named),
        tests=tests,
        left_out=asked.left_out,
        evidence={"nothing": nothing, "unknown": unknown},
        steps=tuple(_steps(parts, verdict, where)),
        quantities=base.quantities if verdict == "adequate" else None,
    )
    fit = _going_on_from(base, tried, alike[:1])
    aside = slip.aside if slipped and weights[-1] > EVIDENCE.credible else None
    return TimeCase(diagnosis, base, fit, tuple(tried), asked, aside)


def _over_one_noise(
    before: FitResiduals,
    tried: Sequence[Hypothesis],
    noise: Sequence[ResidualScatter],
    of_slip: float,
) -> tuple[Sequence[ResidualScatter], list[Hypothesis]]:
    """The noise that errors are told in, and what was tried as it is judged over that noise."""
    # What no story is likelier than is noise itself, however little a story would leave.
    if not before.doubtful and max([of_slip, *(each.delta for each in tried)]) <= 0.0:
        noise = before.noise
    # By itself what an effect misses at random, as at corners that noise has moved, is called noise
    # again.
    return noise, [replace(each, left=each.left.beside(noise)) for each in tried]


def _going_on_from(
    base: Identification, tried: Sequence[Hypothesis], best: Sequence[str]
) -> Identification:
    """The best fit that there is: from it the next round of a discovery goes on."""
    fits = (each.fit for each in tried if each.effect.name in best and each.fit is not None)
    return next(fits, base)


def _after(
    tried: Sequence[Hypothesis],
    parts: Sequence[TestPart],
    noise: Sequence[ResidualScatter],
    tests: Sequence[PartResult],
) -> tuple[list[Error], str]:
    """The error with each effect, and in words what speaks against the best one.

    It leaves another test missed most, or the tests one by one ask for more.

    Before and after are of one test, the one that the model misses most: errors of two tests, and
    what noise leaves of them, do not compare.
    """
    rows, at = [each.left.rows(parts, noise, tests) for each in tried], worst_of(tests)
    after = [error_of(each, noise, at=at) for each in rows]
    if tried and not tried[0].left.misfit and chow_rejects(tried[0]):
        return after, ", though each test by itself is followed better than chance lets"
    if not tried or not tried[0].left.misfit or worst_of(rows[0]) == at:
        return after, ""
    worst = rows[0][worst_of(rows[0])]
    return after, f", {worst.name} still {times(worst.over_floor)}"


def said_apart(
    parts: Sequence[TestPart], tests: Sequence[PartResult], with_best: Sequence[PartResult]
) -> str:
    """What tests say that one material follows worse than each its own; nothing of others.

    Nor where one material with the best effect follows them no worse: that is the shorter story.
    """
    if all(test.agrees for test in tests):
        return ""
    if max(test.over_floor for test in with_best) <= max(test.over_floor_alone for test in tests):
        return ""
    alone, taken = max(test.over_floor_alone for test in tests), _taken_by_own(tests)
    if alone < VERDICT.agrees:
        says = f"each test by itself is followed to {times(alone)} its noise, all together are not"
    elif taken > 0.5:
        says = f"{taken:.0%} of the misfit goes where each test has a material of its own"
    else:
        return ""
    if any("temperature" in part.conditions for part in parts):
        return f"{says}: they are not of one specimen in one state, or it is not linear"
    return (
        f"{says}: they are of another temperature, age or specimen, which no column tells; say it"
        " of each, such as 'FILE#2?temperature=25[degC]'; or the specimen is not linear and answers"
        " otherwise to another size or speed of the load"
    )


def _taken_by_own(tests: Sequence[PartResult]) -> float:
    """The share of the squared residuals that parameters of each test's own take."""
    common = sum(test.points * test.over_floor**2 for test in tests)
    own = sum(test.points * test.over_floor_alone**2 for test in tests)
    return 1.0 - own / common


def _steps(parts: Sequence[TestPart], verdict: Verdict, where: Sequence[Where]) -> Iterator[ToDo]:
    """What can be done with the tests themselves."""
    if verdict == "effect-missing" or not where or len(parts) != 1:
        return
    test = parts[0].test
    if not isinstance(test, TimeTest) or not test.after_step or where[0].low > test.time[0]:
        return
    # Of a step that took its time the usual advice is to look at what comes long after it.
    later = np.flatnonzero(test.time > where[0].high)
    if len(later):
        until = 0.5 * (where[0].high + float(test.time[later[0]]))
        yield leaving_out_the_beginning(until, int(later[0]))


def _notes_on(parts: Sequence[TestPart], best: FitResiduals) -> Iterator[str]:
    """What one should know of the tests beside the verdict."""
    for part in parts:
        yield from said_of_sign(part.test.provenance)
        if isinstance(part, InTimePart):
            test = part.test
            yield from filter(None, [said_of_strays(test), test.said_of_start])
    for part, residual in zip(parts, best.residuals, strict=True):
        yield from lines_in(part, residual)


def misfit_of(part: TestPart, base: Identification) -> Misfit:
    """How far a fitted model lies beside what one test has measured."""
    value = part.over_noise(base.model, base.theta, base.reference).value
    if not isinstance(part, SweepPart):
        return Misfit(np.abs(value * part.relative_sd), np.zeros(0))
    return Misfit.of_stiffness(part.modelled(value), part.test.stiffness)


def facts_of(before: FitResiduals, tried: Sequence[Hypothesis], unknown: bool) -> Facts:
    """What the tests say of the model, `tried` best first.

    Whether something `unknown` may be it as well, beyond doubt that something is.
    """
    gain, odds, plain = 0.0, 0.0, False
    if tried:
        gain, odds, plain = tried[0].delta, tried[0].evidence, tried[0].helps
    return Facts(
        by_battery=before.misfit,
        exceeds=before.doubtful,
        ruled_out=plain or unknown,
        gain=gain,
        # A fault of the apparatus asks for more before it casts a doubt, as before it is named.
        something=odds > VERDICT.clear_evidence,
        unknown=unknown,
        # Of a few that were fitted the first is no name yet: its evidence must be beyond doubt.
        named=plain,
        # An effect that helps and leaves more than noise is not all that is missing.
        left=plain and (tried[0].left.misfit or chow_rejects(tried[0])),
    )


def where_missed(
    parts: Sequence[TestPart], before: FitResiduals, noise: Sequence[ResidualScatter]
) -> tuple[Where, ...]:
    """Where the model fails: first in the test that it misses most, the worst place first."""
    located = [
        (times_noise(residual, scatter.size), place)
        for part, residual, scatter in zip(parts, before.residuals, noise, strict=True)
        for place in part.places(residual / scatter.size)
    ]
    return tuple(place for _, place in sorted(located, key=lambda one: -one[0]))


def _class(
    tried: Sequence[Hypothesis],
    entries: dict[str, list[ScanEntry]],
    noise: Sequence[ResidualScatter],
) -> list[str]:
    """The best effect, if one helps, and those that these tests cannot tell from it."""
    if not tried or not tried[0].helps:
        return []
    # By what the tests say alone: how common an effect is makes it no worse an explanation of them.
    best = max(tried, key=lambda each: each.delta)
    # Two roads to a class: effects that fit as well, and such that add the same shape but were
    # never fitted.
    alike = [each for each in tried if each is tried[0] or explains_as_well(each, best, noise)]
    names = [each.effect.name for each in alike]
    fitted = {each.effect.name for each in tried}
    others = collinear_with(best.effect.name, entries)
    return names + [name for name in others if name not in fitted]


def _classes(
    entries: dict[str, list[ScanEntry]], tried: Sequence[Hypothesis], alike: Sequence[str]
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
        twins = [other for other in collinear_with(name, entries) if other not in taken]
        if twins:
            classes.append((name, *twins))
            taken |= {name, *twins}
    return tuple(classes)


def _posterior(weights: Sequence[float], verdict: Verdict, chance: float) -> list[float]:
    """The same in agreement with the verdict, which rests on more than the evidence."""
    unknown = weights[-1]
    if verdict == "unexplained":
        unknown = doubted(unknown, chance)
    others = (1.0 - unknown) / max(1.0 - weights[-1], SMALLEST)
    return [*(others * weight for weight in weights[:-1]), unknown]


def _weights(
    tried: Sequence[Hypothesis], entries: Mapping[str, Sequence[ScanEntry]], slip: float
) -> list[float]:
    """Chances of nothing, of each effect, and of a jump that is in no library; see `Evidence`."""
    prior = log_prior_of_one(size_of_library(of_one[0].effect for of_one in entries.values()))
    # What slips or lets go is one more fault of the apparatus, as common as any other of them.
    unnamed = prior + np.log(EVIDENCE.apparatus) + 0.5 * slip
    # Nothing missing is a candidate too.
    logs = [
        np.log(EVIDENCE.prior_nothing),
        *(0.5 * each.evidence + prior for each in tried),
        unnamed,
    ]
    weights, _ = chances_of(np.array(logs))
    return list(weights.tolist())


def _beside_narrow(weights: Sequence[float], tried: Sequence[Hypothesis]) -> list[float]:
    """The same, where other narrow features look like an effect as narrow, as for sweeps."""
    shares = [EVIDENCE.other_shape * each.effect.narrow for each in tried]
    taken = [weight * share for weight, share in zip(weights[1:-1], shares, strict=True)]
    left = [weight - less for weight, less in zip(weights[1:-1], taken, strict=True)]
    return [weights[0], *left, weights[-1] + sum(taken)]


def _open(each: Hypothesis, alike: Sequence[str]) -> EffectVerdict:
    """Of an effect that is not plainly missing: absent only where nothing speaks for it.

    One that helps, and less than a rival, may be there beside the rival, or only resemble it: that
    is told when the rival has been accepted.
    """
    if each.effect.name in alike or each.delta > VERDICT.clear_evidence:
        return "cannot-tell"
    return "absent"


def _candidates(
    tried: Sequence[Hypothesis],
    chances: Sequence[float],
    alike: Sequence[str],
    after: Sequence[Error],
    verdict: Verdict,
    error: Error,
) -> list[Candidate]:
    """The row of each effect that was tried, and whether the first is missing for certain."""
    told = zip(tried, chances, after, strict=True)
    rows = [_candidate(each, chance, alike, left) for each, chance, left in told]
    # Of several that are missing each by itself may explain next to nothing.
    if verdict == "unexplained":
        rows = [
            replace(each, verdict="cannot-tell") if each.lowers(error) else each for each in rows
        ]
    # One of several that cannot be told apart is not known to be the missing one.
    if verdict == "effect-missing" and len(alike) == 1:
        rows[0] = replace(rows[0], verdict="missing")
    return rows


def _candidate(each: Hypothesis, chance: float, alike: Sequence[str], after: Error) -> Candidate:
    name = each.effect.name
    parameters: dict[str, Value] = {}
    # Nearly fitted it is foretold: what acceptance gives is known of an exact fit alone.
    predicted, reached = after.relative_rms, NAN
    if each.fit is not None:
        predicted, reached = NAN, after.relative_rms
        parameters = each.effect.own_of(each.fit.parameters)
    others = [other for other in alike if other != name and name in alike]
    return Candidate(
        physics=each.effect,
        alike=(name, *others),
        probability=chance,
        delta_bic=each.delta,
        score=NAN,
        verdict=_open(each, alike),
        predicted_error=predicted,
        bound=NAN,
        says=each.effect.summary,
        alone=AsTold(reached, after.over_floor, parameters),
    )


def beside_one_way(
    parts: Sequence[TestPart], candidates: Sequence[Candidate], leading: Sequence[str]
) -> str:
    """The specimen that is not linear, beside leading effects of one motion that are none of it.

    A displacement that never comes back passes each place once: a force that a part of the rig adds
    from there on and one of the specimen are the same to it, but for the shape that each was given.

    Empty where there are more tests, another kind of test, or no such specimen that helps.
    """
    if len(parts) != 1 or not isinstance(parts[0], InTimePart) or parts[0].test.after_step:
        return ""
    if not parts[0].test.loading.recorded.goes_one_way:
        return ""
    own = [each for each in candidates if each.physics.layer is Layer.MATERIAL]
    best = next((each for each in own if each.delta_bic > SEARCH.decisive), None)
    if best is None or {each.effect for each in own} & {*leading}:
        return ""
    return (
        f", or a specimen that is not linear ({best.effect}: {times(best.over_floor)}), which a"
        " motion one way does not tell apart: move at another rate, or back"
    )
