"""What the effects that were tried on tests in time say together: verdict, classes, chances.

What a diagnosis of tests in time says: its error, its sentence, and which effect to add.

What a scan finds of one effect: what it would add to the residuals, and what that promises.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from springpot.diagnosis.actions import turning
from springpot.diagnosis.evidence import chances_of, log_prior_of_one, size_of_library, unknown_odds
from springpot.diagnosis.in_practice import Misfit
from springpot.diagnosis.result import Candidate, Diagnosis, EffectVerdict, Verdict
from springpot.diagnosis.verdict import Facts, rule_for
from springpot.identification.part_result import PartResult
from springpot.identification.result import Identification
from springpot.identification.value import Value
from springpot.measurement.sign import said_of_sign, turned
from springpot.misfit.error import Error
from springpot.misfit.where import Where
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from .floor import TimeFloor
from .residuals_of_tests import SweepPart, TestPart
from .scatter import ResidualScatter, times_noise
from .where import rms, worst_first

NAN = float("nan")


def worst_of(tests: Sequence[PartResult]) -> int:
    """Number of the test that a model misses most: it is as good as it is for that one."""
    return max(range(len(tests)), key=lambda i: tests[i].over_floor)


def error_of(
    tests: Sequence[PartResult], noise: Sequence[ResidualScatter], floor: TimeFloor | None = None
) -> Error:
    """The error of a model beside the noise, of the test that it misses most.

    Beside the least of any material in that test, where one was looked for.
    """
    at = worst_of(tests)
    worst, scatter = tests[at], noise[at]
    # Of few samples the presumed noise is believed as it is: its size is one, to the last bit.
    source = "residual"
    if scatter.size == 1.0:
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
    error: Error, verdict: Verdict, candidates: Sequence[Candidate], where: Sequence[Where]
) -> str:
    """The verdict in one sentence."""
    size = f"the error is {error.over_floor:.2g} x the noise"
    # Where it fails is the best advice there is, as long as nobody knows what is missing.
    place = ""
    if where:
        place = f"; {where[0].says}"
    names = " or ".join(leading_of(candidates))
    if verdict == "adequate":
        return f"{size}: nothing is missing that these tests could show"
    if verdict == "inconclusive":
        hint = "what is left is hardly noise alone"
        if candidates and candidates[0].delta_bic > VERDICT.clear_evidence:
            hint = f"{candidates[0].effect} would help a little"
        return f"{size}: {hint}, which may be chance; measure longer or repeat it{place}"
    if not names or (verdict == "unexplained" and not candidates[0].lowers(error)):
        return (
            f"{size}, and no known effect explains it:"
            f" something is missing that is not in the library{place}"
        )
    after = f"{candidates[0].over_floor:.2g} x with it"
    if verdict == "unexplained":
        helps = f"{names} helps ({after}) but is not all"
        return f"{size}, and no single known effect explains it: {helps}{place}"
    return f"{size}; missing is {names}: {after}{place}"


@dataclass(frozen=True, eq=False)
class Left:
    """What a fit leaves of each test.

    Attributes
    ----------
    count : int
        Parameters of the model.
    residuals : tuple of ndarray
        Of each test over the noise of its signal.
    scatters : tuple of ResidualScatter
        The noise in them.
    """

    count: int
    residuals: tuple[Real, ...]
    scatters: tuple[ResidualScatter, ...]

    @classmethod
    def by(cls, model: Model, theta: Real, reference: float, parts: Sequence[TestPart]) -> Left:
        """What a model with these parameters leaves of these tests."""
        # By its noise alone, whatever the test weighed in a fit.
        plain = [part.with_scale(1.0) for part in parts]
        residuals = [part.residual(model, theta, reference).value for part in plain]
        scatters = [part.scatter(value) for part, value in zip(parts, residuals, strict=True)]
        return cls(len(theta), tuple(residuals), tuple(scatters))

    @property
    def noise(self) -> list[ResidualScatter]:
        """The noise of each test, as this fit alone tells it."""
        # Of a test that is missed the upper part of the spectrum may be misfit too, as corners are:
        # there it is no larger than the signal itself says.
        return [
            replace(scatter, size=min(scatter.size, 1.0)) if scatter.misfit else scatter
            for scatter in self.scatters
        ]

    @property
    def chance(self) -> float:
        """That noise alone leaves so much of the test that is missed most."""
        return min(scatter.chance for scatter in self.scatters)

    @property
    def misfit(self) -> bool:
        """Whether some test is missed by more than noise."""
        return any(scatter.misfit for scatter in self.scatters)

    @property
    def doubtful(self) -> bool:
        """Whether some test may well be missed by more than noise."""
        return any(scatter.doubtful for scatter in self.scatters)

    def rows(
        self,
        parts: Sequence[TestPart],
        noise: Sequence[ResidualScatter],
        told: Sequence[PartResult],
    ) -> tuple[PartResult, ...]:
        """Each test beside that noise, of which a fit has told with the noise of its signal."""
        rows = []
        for part, residual, scatter, row in zip(parts, self.residuals, noise, told, strict=True):
            error = rms(residual * part.relative_sd)
            ratio, floor = times_noise(residual, scatter.size), 0.0
            # A fit that leaves nothing at all says nothing of the noise.
            if ratio:
                floor = error / ratio
            # Whatever the noise, together and alone have one.
            alone = ratio * row.over_floor_alone / max(row.over_floor, 1e-300)
            rows.append(
                replace(
                    row,
                    relative_rms=error,
                    noise_floor=floor,
                    over_floor=ratio,
                    over_floor_alone=alone,
                )
            )
        return tuple(rows)

    def squares(self, noise: Sequence[ResidualScatter]) -> float:
        """Sum of squares over that noise, a sample counted for what it adds to its neighbours."""
        pairs = zip(self.residuals, noise, strict=True)
        return sum(scatter.surprise(value) for value, scatter in pairs)

    def over(self, noise: Sequence[ResidualScatter]) -> float:
        """Error over that noise, of the worst test."""
        pairs = zip(self.residuals, noise, strict=True)
        return max(times_noise(value, scatter.size) for value, scatter in pairs)


def independent(residuals: Sequence[Real], noise: Sequence[ResidualScatter]) -> float:
    """Number of samples, counting once those whose noise is alike.

    Bayley & Hammersley (1946, doi:10.2307/2983560).
    """
    pairs = zip(residuals, noise, strict=True)
    counts = [
        len(value) * (1.0 - scatter.memory) / (1.0 + scatter.memory) for value, scatter in pairs
    ]
    # Two at least: the logarithm of their number is what a parameter costs.
    return max(float(sum(counts)), 2.0)


def delta_bic(base: Left, other: Left, noise: Sequence[ResidualScatter], more: int) -> float:
    """By how much the Bayesian information criterion falls with `more` parameters."""
    gain = base.squares(noise) - other.squares(noise)
    return float(gain - more * np.log(independent(base.residuals, noise)))


@dataclass(frozen=True, eq=False)
class Promise:
    """One effect at one place of its parameters.

    Attributes
    ----------
    effect : Effect
        The effect.
    values : tuple of float
        Its parameters, as large as the record asks for.
    theta : ndarray, shape (p,)
        Parameters of the model beside it.
    drop : float
        By how much the sum of squares would fall.
    amount : float
        Of what was tried: far from one, it is no longer the effect that was tried.
    direction : ndarray, shape (m,)
        What it adds to the residuals that the model cannot take over, of length one.
    as_its_size : bool
        Whether it grows as a parameter of it does, so that a linear step leads to it.
    """

    effect: Effect
    values: tuple[float, ...]
    theta: Real
    drop: float
    amount: float
    direction: Real
    as_its_size: bool

    def start(self, base: Identification, model: Model, *, moved: bool = False) -> Real:
        """A start (p,) for the model with the effect.

        What it promises beside the parameters of the fit.

        Parameters
        ----------
        base : Identification
            The fit that was scanned.
        model : Model
            Its model with the effect.
        moved : bool
            Let the parameters of the fit make way for the effect, as far as a linear step says.
        """
        theta = base.theta
        if moved:
            theta = self.theta
        known = dict(zip(base.model.names, theta.tolist(), strict=True))
        new = [parameter for parameter in model.parameters if parameter.name not in known]
        for parameter, value in zip(new, self.values, strict=True):
            known[parameter.name] = float(np.clip(value, parameter.lower, parameter.upper))
        # Lines of a free spectrum, which the fit has and the model not yet, are found anew.
        return model.vector({name: known[name] for name in model.names})


@dataclass(frozen=True, eq=False)
class Atom:
    """A column: what an effect adds to the residuals of all tests, for an amount of one.

    Attributes
    ----------
    effect : Effect
        The effect.
    values : ndarray, shape (q,)
        Its parameters at that amount.
    powers : ndarray, shape (q,)
        With which power of the amount each of them goes.
    column : ndarray, shape (m,)
        The change of the residuals.
    signed : bool
        Whether a negative amount makes sense.
    """

    effect: Effect
    values: Real
    powers: Real
    column: Real
    signed: bool

    def at(self, amount: float) -> tuple[float, ...]:
        """Its parameters for an amount."""
        # A force grows with the amount; a time or an order, whose power is zero, stays what it is.
        size = abs(amount) ** self.powers
        sign = np.where((self.powers != 0.0) & (amount < 0.0), -1.0, 1.0)
        return tuple((self.values * size * sign).tolist())


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
    fit : Identification or None
        The exact fit, where there is one.
    """

    effect: Effect
    model: Model
    theta: Real
    left: Left
    delta: float
    fit: Identification | None = None

    @property
    def helps(self) -> bool:
        """Whether it explains what the model alone does not, beyond doubt."""
        return self.delta > SEARCH.decisive

    @property
    def evidence(self) -> float:
        """The same with how common the effect is: twice the logarithm of its odds."""
        return self.delta + 2.0 * float(np.log(weight_of(self.effect)))


def weight_of(effect: Effect) -> float:
    """How common an effect is in tests in time, before any data are seen."""
    if effect.of_apparatus:
        return effect.prior * EVIDENCE.apparatus
    return effect.prior


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
    misfits : tuple of Misfit
        How far the base lies beside each test.
    """

    diagnosis: Diagnosis
    base: Identification
    best_fit: Identification
    misfits: tuple[Misfit, ...]


def answer_of(
    parts: Sequence[TestPart],
    base: Identification,
    before: Left,
    tried: Sequence[Tried],
    noise: Sequence[ResidualScatter],
    promises: dict[str, list[Promise]],
    left_out: dict[str, str],
) -> TimeCase:
    """The answer of a diagnosis from the effects that were tried, best first."""
    verdict = rule_for(facts_of(before, tried)).verdict
    alike: list[str] = []
    if _is_plain(tried):
        alike = _class(tried, promises, noise)
    candidates = []
    nothing, chances = _chances(before, tried, promises, verdict)
    for each, chance in zip(tried, chances, strict=True):
        of_it = _open(each, alike)
        # One of several that cannot be told apart is not known to be the missing one.
        if verdict == "effect-missing" and len(alike) == 1 and each is tried[0]:
            of_it = "missing"
        after = error_of(each.left.rows(parts, noise, base.tests), noise)
        candidates.append(_candidate(each, chance, alike, after, of_it))
    tests = before.rows(parts, noise, base.tests)
    error = error_of(tests, noise)
    where: tuple[Where, ...] = ()
    # What noise leaves of an adequate model stands out somewhere too.
    if verdict != "adequate":
        where = where_missed(parts, before, noise)
    # The next round of a discovery goes on from the best fit that there is.
    fits = [each.fit for each in tried if each.effect.name in alike[:1]]
    best_fit = next(filter(None, fits), base)
    diagnosis = Diagnosis(
        data=base.name,
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
        tests=tests,
        left_out=left_out,
        evidence=nothing,
        steps=tuple(turning(spec) for part in parts if (spec := turned(part.test.provenance))),
    )
    return TimeCase(diagnosis, base, best_fit, tuple(_misfit(part, base) for part in parts))


def _misfit(part: TestPart, base: Identification) -> Misfit:
    """How far a fitted model lies beside what one test has measured."""
    value = part.with_scale(1.0).residual(base.model, base.theta, base.reference).value
    if not isinstance(part, SweepPart):
        return Misfit(np.abs(value * part.relative_sd), np.zeros(0))
    storage, loss = np.split(value * part.sd, 2)
    return Misfit.of_stiffness(part.test.stiffness + storage + 1j * loss, part.test.stiffness)


def _is_plain(tried: Sequence[Tried]) -> bool:
    """Whether the evidence for the best effect is beyond doubt."""
    return bool(tried) and tried[0].helps


def facts_of(before: Left, tried: Sequence[Tried]) -> Facts:
    """What the tests say of the model, `tried` best first."""
    gain, plain = 0.0, _is_plain(tried)
    if tried:
        gain = tried[0].delta
    return Facts(
        by_battery=before.misfit,
        exceeds=before.doubtful,
        ruled_out=plain,
        gain=gain,
        something=gain > VERDICT.clear_evidence,
        # Of a few that were fitted the first is no name yet: its evidence must be beyond doubt.
        named=plain,
        # An effect that helps and leaves more than noise is not all that is missing.
        left=plain and tried[0].left.misfit,
    )


def where_missed(
    parts: Sequence[TestPart], before: Left, noise: Sequence[ResidualScatter]
) -> tuple[Where, ...]:
    """Where the model fails in all tests in time, the worst first."""
    located: list[Where] = []
    for part, residual, scatter in zip(parts, before.residuals, noise, strict=True):
        located += part.places(residual / scatter.size)
    return worst_first(located)


def _class(
    tried: Sequence[Tried], promises: dict[str, list[Promise]], noise: Sequence[ResidualScatter]
) -> list[str]:
    """The best effect and those that these tests cannot tell from it."""
    # By what the tests say alone: how common an effect is makes it no worse an explanation of them.
    best = max(tried, key=lambda each: each.delta)
    # Two roads to a class: effects that fit as well, and such that add the same shape but were
    # never fitted.
    alike = [
        each for each in tried if each is tried[0] or (each.helps and _as_well(each, best, noise))
    ]
    names = [each.effect.name for each in alike]
    fitted = {each.effect.name for each in tried}
    return names + [name for name in _twins(best.effect.name, promises) if name not in fitted]


def _as_well(each: Tried, best: Tried, noise: Sequence[ResidualScatter]) -> bool:
    """Whether an effect explains the tests as well as the best one.

    More parameters do not exclude it.
    """
    worse = each.left.squares(noise) - best.left.squares(noise)
    return min(worse, best.delta - each.delta) <= EVIDENCE.rivals


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


def _chances(
    before: Left,
    tried: Sequence[Tried],
    promises: Mapping[str, Sequence[Promise]],
    verdict: Verdict,
) -> tuple[dict[str, float], list[float]]:
    """Chances of nothing and of something unknown, and of each effect; see `Evidence`."""
    prior = log_prior_of_one(size_of_library(of_one[0].effect for of_one in promises.values()))
    # Nothing missing is a candidate too.
    logs = [np.log(EVIDENCE.prior_nothing), *(0.5 * each.evidence + prior for each in tried)]
    weights, _ = chances_of(np.array(logs))
    unknown = 0.0
    # It must agree with the verdict, which rests on more than the evidence.
    if verdict == "unexplained":
        best = next((each.left for each in tried), before)
        odds = unknown_odds(best.chance)
        unknown = odds / (1.0 + odds)
    nothing, *chances = ((1.0 - unknown) * weights).tolist()
    return {"nothing": nothing, "unknown": unknown}, chances


def _open(each: Tried, alike: Sequence[str]) -> EffectVerdict:
    """Of an effect that is not plainly missing: absent only where nothing speaks for it.

    One that helps, and less than a rival, may be there beside the rival, or only resemble it: that
    is told when the rival has been accepted.
    """
    if each.effect.name in alike or each.delta > VERDICT.clear_evidence:
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
