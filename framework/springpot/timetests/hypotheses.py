"""Hypotheses of what is missing: effects, what a fit with them leaves, and how likely that is.

The size of the noise may be unknown, and neighbours may be alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np

from springpot.diagnosis.grown import key_of
from springpot.distributions import effective_share, f_sf
from springpot.identification.material import is_material, own_parameters
from springpot.identification.result import Identification
from springpot.identification.value import PartResult
from springpot.measurement.course import followed
from springpot.misfit.residual_scatter import ResidualScatter, times_noise
from springpot.misfit.residuals_of_tests import InTimePart, Test, TestPart
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from ..numerics import NEGLIGIBLE, SMALLEST, TWO_DEVIATIONS
from .specimen import residual_of

APART = 16
"""Samples between two of the kicks that are tried, in turn up and down."""


@dataclass(frozen=True, eq=False)
class FitResiduals:
    """What a fit leaves of each test.

    Attributes
    ----------
    count : int
        Parameters of the model that it answers for: all but the lines of a free spectrum.
    residuals : tuple of ndarray
        Of each test over the noise of its signal.
    scatters : tuple of ResidualScatter
        The noise in them.
    rounded : tuple of ndarray
        Of each test the errors that its digits may make of what the fit says, in the units of its
        residual (k, m); no rows where they are fine.
    noise_answer : tuple of ndarray
        Of each test what the fit answers to noise of the imposed channel, likewise (m,).
    lines : int
        Weights of a free spectrum that are above zero. How many there are is chance, and that all
        models with one share it no reason to prefer one of them: each costs what it follows of the
        noise, and no more (Meyer and Woodroofe 2000, doi:10.1214/aos/1015956708).
    """

    count: int
    residuals: tuple[Real, ...]
    scatters: tuple[ResidualScatter, ...]
    rounded: tuple[Real, ...]
    noise_answer: tuple[Real, ...]
    lines: int = 0

    @classmethod
    def by(
        cls, model: Model, theta: Real, reference: float, parts: Sequence[TestPart]
    ) -> FitResiduals:
        """What a model with these parameters leaves of these tests."""
        residuals = [part.over_noise(model, theta, reference).value for part in parts]
        rounded = [part.rounded(value) for part, value in zip(parts, residuals, strict=True)]
        answers = [noise_answer(part, model, theta, reference) for part in parts]
        lines = 0
        if is_material(model):
            lines = int(np.count_nonzero(theta[: len(model.material.parameters)]))
            theta = theta[own_parameters(model)]
        # Each test is followed by its share of the parameters.
        share = (len(theta) + lines) / max(sum(len(value) for value in residuals), 1)
        scatters = [
            part.scatter(value, share * len(value))
            for part, value in zip(parts, residuals, strict=True)
        ]
        told = tuple(residuals), tuple(scatters), tuple(rounded), tuple(answers)
        return cls(len(theta), *told, lines)

    @classmethod
    def of(cls, fit: Identification, parts: Sequence[TestPart]) -> FitResiduals:
        """What a fit leaves of these tests."""
        return cls.by(fit.model, fit.theta, fit.reference, parts)

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
    def all_noise(self) -> list[ResidualScatter]:
        """The noise of each test where all that is left is noise, whatever another fit leaves.

        What the signal tells is not read from what is left.
        """
        told = zip(self.residuals, self.scatters, strict=True)
        return [
            own if own.presumed else replace(own, size=times_noise(value, 1.0))
            for value, own in told
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

    def beside(self, noise: Sequence[ResidualScatter]) -> FitResiduals:
        """The same, judged over that noise too: the one that its error is told in."""
        told = [
            replace(own, local=min(own.local, other.chance_of(value, own)))
            for value, own, other in zip(self.residuals, self.scatters, noise, strict=True)
        ]
        return replace(self, scatters=tuple(told))

    def rows(
        self,
        parts: Sequence[TestPart],
        noise: Sequence[ResidualScatter],
        told: Sequence[PartResult],
    ) -> tuple[PartResult, ...]:
        """Each test beside that noise, of which a fit has told with the noise of its signal."""
        rows = []
        for part, residual, scatter, row in zip(parts, self.residuals, noise, told, strict=True):
            error = part.relative_error(residual)
            ratio, floor = times_noise(residual, scatter.size), 0.0
            # A fit that leaves nothing at all says nothing of the noise.
            if ratio:
                floor = error / ratio
            # Whatever the noise, together and alone have one.
            alone = ratio * row.over_floor_alone / max(row.over_floor, SMALLEST)
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

    def squares(self, noise: Sequence[ResidualScatter], *others: FitResiduals) -> float:
        """Sum of squares over that noise, a sample counted for what it adds to its neighbours.

        It may be the noise that this fit leaves, or one of the others.
        """
        stories = zip(*(each.scatters for each in (self, *others)), strict=True)
        told = zip(self.residuals, noise, stories, strict=True)
        return sum(scatter.squares(value, *owns) for value, scatter, owns in told)

    def whitened(self, noise: Sequence[ResidualScatter]) -> list[Real]:
        """The residuals over that noise, free of its memory."""
        return [each.whitened(value) for each, value in zip(noise, self.residuals, strict=True)]

    def squares_of_imposed(self, noise: Sequence[ResidualScatter]) -> float:
        """The same that noise of the imposed channels is to be expected to leave."""
        pairs = zip(self.noise_answer, noise, strict=True)
        return sum(float(np.sum(scatter.whitened(value) ** 2)) for value, scatter in pairs)

    def noise_with_imposed(
        self, noise: Sequence[ResidualScatter], best: FitResiduals
    ) -> list[ResidualScatter]:
        """The noise that the best fit tells, by what this one answers to noise of imposed channels.

        The specimen never felt it, and a fit that answers more to it, or less, leaves as much more.
        """
        told = []
        for each, own, other in zip(noise, self.noise_answer, best.noise_answer, strict=True):
            square = each.size**2 + float(np.mean(own**2) - np.mean(other**2))
            # No less than what the signal itself says.
            least = min(each.size, 1.0)
            told.append(replace(each, size=float(np.sqrt(max(square, least**2)))))
        return told

    def over(self, noise: Sequence[ResidualScatter]) -> float:
        """Error over that noise, of the worst test."""
        pairs = zip(self.residuals, noise, strict=True)
        return max(times_noise(value, scatter.size) for value, scatter in pairs)


def independent_samples(residuals: Sequence[Real], noise: Sequence[ResidualScatter]) -> float:
    """Number of samples, counting once those whose noise is alike.

    Bayley & Hammersley (1946, doi:10.2307/2983560).
    """
    pairs = zip(residuals, noise, strict=True)
    counts = [len(value) * effective_share(scatter.memory) for value, scatter in pairs]
    # Two at least: the logarithm of their number is what a parameter costs.
    return max(float(sum(counts)), 2.0)


def _alike(base: FitResiduals, other: FitResiduals, noise: Sequence[ResidualScatter]) -> float:
    """By how much rounding varies more than noise along what another fit changes; at least 1.

    Rounding to a coarse digit errs alike wherever the signal comes by again, so that as many
    samples tell less, as those of a cluster do (Kish 1965, Survey Sampling, section 5.4).
    """
    pairs = zip(base.residuals, other.residuals, noise, strict=True)
    changes = [scatter.whitened(one - two) for one, two, scatter in pairs]
    size, varied = sum(float(change @ change) for change in changes), 0.0
    for change, errors, scatter in zip(changes, base.rounded, noise, strict=True):
        share = 0.0
        if len(errors):
            share = min(float(np.mean(errors**2)) / scatter.size**2, 1.0)
        varied += (1.0 - share) * float(change @ change)
        if share > 0.0:
            drawn = np.array([scatter.whitened(row) for row in errors])
            varied += share * float(np.mean((drawn @ change) ** 2) / np.mean(drawn**2))
    return max(varied / max(size, SMALLEST), 1.0)


def vuong_distinguishes(residuals: Iterable[tuple[Real, Real]]) -> bool:
    """Whether one explanation is better than another beyond the scatter of its lead.

    A sum of log-likelihoods grows with every sample, so that of two laws, neither of them exact,
    one always wins beyond doubt in the end. What speaks against that is the scatter of its own
    terms: if the lead comes and goes along the record, another record may give it to the other.

    The test of Vuong (1989, doi:10.2307/1912557) at 5 %: the sum of the differences of the samples'
    log-likelihoods against its own standard deviation. That is of terms with a memory, and about
    zero, as the two are as good as each other where it is asked: about their mean few samples
    would tell apart too often.

    Parameters
    ----------
    residuals : iterable of tuple of ndarray
        Of each test what the one and the other leave (n,), over the noise and free of its memory.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.timetests.hypotheses import vuong_distinguishes
    >>> noise, wave = np.random.default_rng(1).normal(size=200), np.sin(0.1 * np.arange(200))
    >>> [vuong_distinguishes([(noise, noise + share * wave)]) for share in (1.0, 0.2)]
    [True, False]
    """
    lead = varied = 0.0
    for one, other in residuals:
        terms = other**2 - one**2
        lead += float(terms.sum())
        varied += variance_of_sum(terms)
    return lead**2 > TWO_DEVIATIONS * varied


def variance_of_sum(terms: Real) -> float:
    """Variance of the sum of terms (n,) of mean zero, of which neighbours may be alike.

    By Newey and West (1987, doi:10.2307/1913610), up to the lag of their rule of 1994
    (doi:10.2307/2297912).
    """
    n = len(terms)
    variance, most = float(terms @ terms), int(4.0 * (n / 100.0) ** (2.0 / 9.0))
    for lag in range(1, min(most, n - 1) + 1):
        variance += 2.0 * (1.0 - lag / (most + 1.0)) * float(terms[lag:] @ terms[:-lag])
    return variance


def bic_of(left: FitResiduals) -> float:
    """Of a fit by itself: the size of its noise is read from what it leaves."""
    points = sum(len(value) for value in left.residuals)
    power = sum_of_squares(left)
    # What the fit answers to noise of the imposed channel is no misfit: a story that answers less
    # to it is no better, as long as more than the signal's own noise is left.
    power = max(
        power - sum(float(np.sum(value**2)) for value in left.noise_answer),
        min(power, points),
    )
    variance = max(power, SMALLEST) / max(points - left.lines, 1)
    return float(points * np.log(variance) + left.count * np.log(points))


def sum_of_squares(left: FitResiduals) -> float:
    """Sum of squares of all that is left."""
    return sum(float(np.sum(value**2)) for value in left.residuals)


def chi_square_gain(
    base: FitResiduals, other: FitResiduals, noise: Sequence[ResidualScatter]
) -> float:
    """By how much less another fit leaves, but for what is to be expected of imposed noise.

    To answer less to what the specimen never felt is no evidence, nor is it to answer more: so much
    is expected. As the noise of the response goes by chance with the difference of both answers,
    what is expected varies, with four times the square of that difference: what is beyond counts
    as the square of its own deviations, where that is less.
    """
    # A noise that excuses what one of them leaves may excuse what the other does.
    gain = base.squares(noise, other) - other.squares(noise, base)
    spared = base.squares_of_imposed(noise) - other.squares_of_imposed(noise)
    answers = zip(base.noise_answer, other.noise_answer, noise, strict=True)
    varied = 4.0 * sum(float(np.sum(each.whitened(one - two) ** 2)) for one, two, each in answers)
    beyond = abs(gain)
    if gain * spared > 0.0:
        beyond = max(beyond - abs(spared), 0.0)
    if beyond < varied:
        beyond *= beyond / varied
    return float(np.copysign(beyond, gain))


def delta_bic(base: FitResiduals, other: FitResiduals, noise: Sequence[ResidualScatter]) -> float:
    """By how much the Bayesian information criterion falls with another fit, over a noise."""
    gain = chi_square_gain(base, other, noise) / _alike(base, other, noise)
    gain += base.lines - other.lines
    more = other.count - base.count
    return float(gain - more * np.log(independent_samples(base.residuals, noise)))


def noise_answer(part: TestPart, model: Model, theta: Real, reference: float) -> Real:
    """What a model answers to noise of the imposed channel, over the standard deviations.

    The specimen never felt that noise, and what an effect makes of the answer, as a mass that
    swallows what is fast, is no evidence for it (errors in variables: Fuller 1987, Measurement
    Error Models, chapter 1).

    Parameters
    ----------
    part : TestPart
        A test.
    model : Model
        Any model.
    theta : ndarray, shape (p,)
        Its parameters.
    reference : float
        Temperature in kelvin at which shifts are one.

    Returns
    -------
    ndarray, shape (m,)
        Zero where the channel is quiet beside the response, or was not recorded.
    """
    quiet = np.zeros(len(part.measured))
    if not isinstance(part, InTimePart) or part.imposed.noise == 0.0:
        return quiet
    # Of independent noise the answers add as squares do: those to some kicks stand for all.
    loading, kicks = part.test.loading, np.zeros(len(part.at))
    # Those that a smooth course has followed reach as far as it is smooth.
    reach = ceil(len(kicks) / loading.unfelt.numbers) if loading.unfelt.noise else 1
    # Of a short record at least one is tried, and not at its end.
    apart = min(APART * reach, len(kicks) // 2)
    kicks[apart::apart] = part.imposed.noise
    kicks[2 * apart :: 2 * apart] *= -1.0
    kicked = loading.value.copy()
    kicked[loading.before :] += followed(loading, kicks)
    moved = replace(part.test, loading=replace(loading, value=kicked))
    rows = np.arange(len(part.at))
    before = part.answer(model, theta, reference, rows).value
    after = replace(part, test=moved, noise=part.sd).answer(model, theta, reference, rows).value
    share = np.count_nonzero(kicks) / len(kicks)
    answer = np.where(part.counted, (after - before) / part.sd, 0.0)
    return np.asarray(answer / np.sqrt(share), dtype=float)


@dataclass(frozen=True, eq=False)
class ScanEntry:
    """What a linearised scan says of one effect at one place of its parameters.

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
    leaves : float
        Sum of squares that would be left.
    """

    effect: Effect
    values: tuple[float, ...]
    theta: Real
    drop: float
    amount: float
    direction: Real
    as_its_size: bool
    leaves: float = 0.0

    def start(self, base: Identification, model: Model, *, moved: bool = False) -> Real:
        """A start (p,) for the model with the effect.

        What the scan says beside the parameters of the fit.

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
        known = base.model.named(theta)
        if is_material(model):
            # Lines of a free spectrum are found anew, however many the fit and the model have.
            known = {
                **dict.fromkeys((line.name for line in model.material.parameters), 0.0),
                **known,
            }
        new = [parameter for parameter in model.parameters if parameter.name not in known]
        for parameter, value in zip(new, self.values, strict=True):
            known[parameter.name] = float(np.clip(value, parameter.lower, parameter.upper))
        return model.picked(known)


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


class AskedTests(NamedTuple):
    """Tests as they are fitted, and what may be missing from a model of them.

    Attributes
    ----------
    tests : sequence of TimeTest or Measurement
        As they were given.
    parts, quick : sequence of TestPart
        Exact, and by fixed exponentials.
    known : sequence of ndarray or None, or None
        The noise of each test, where a model has told another than its signal.
    effects : sequence of Effect
        Those of the library that the model does not have.
    left_out : dict of str to str
        Those of them that cannot be fitted, and why.
    """

    tests: Sequence[Test]
    parts: Sequence[TestPart]
    quick: Sequence[TestPart]
    known: Sequence[Real | None] | None
    effects: Sequence[Effect]
    left_out: dict[str, str]


COLLINEAR = 0.995
"""Cosine between what two effects leave in a record from which they are one to it, whatever the
fits say: told apart they would need a hundred times the evidence that finds them."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Effects, what is left with them, and how much likelier they make the tests.

    Attributes
    ----------
    effects : tuple of Effect
        Those that were added.
    model : Model
        The model with them.
    theta : ndarray, shape (p,)
        Its parameters.
    left : FitResiduals
        What is left of the tests.
    fit : Identification or None
        The exact fit, where there is one.
    delta : float
        By how much the Bayesian information criterion falls.
    """

    effects: tuple[Effect, ...]
    model: Model
    theta: Real
    left: FitResiduals
    fit: Identification | None = None
    delta: float = 0.0

    @classmethod
    def exactly(
        cls, effects: tuple[Effect, ...], fit: Identification, parts: Sequence[TestPart]
    ) -> Hypothesis:
        """Effects that were fitted exactly."""
        return cls(effects, fit.model, fit.theta, FitResiduals.of(fit, parts), fit)

    @property
    def effect(self) -> Effect:
        """The last of them: the only one, where each was tried alone."""
        return self.effects[-1]

    @property
    def key(self) -> tuple[str, ...]:
        """Their names in alphabetical order."""
        return key_of(self.effects)

    @property
    def helps(self) -> bool:
        """Whether they explain what the model alone does not, beyond doubt."""
        return self.delta > SEARCH.decisive

    @property
    def evidence(self) -> float:
        """The same with how common they are: twice the logarithm of their odds."""
        return self.delta + self._common

    @property
    def cost(self) -> float:
        """Information criterion, whatever the noise, with how common they are."""
        return bic_of(self.left) - self._common

    @property
    def _common(self) -> float:
        return 2.0 * sum(float(np.log(prior_weight(effect))) for effect in self.effects)


def chow_rejects(each: Hypothesis) -> bool:
    """Whether several tests, each by itself, are followed better than one specimen's chance lets.

    One fit to all against one for each (Chow 1960, doi:10.2307/1910133): what bends the common
    parameters stands in no record as more than noise, where few samples tell how large that is.
    """
    fit = each.fit
    if fit is None or len(fit.tests) < 2:
        return False
    told = zip(each.left.scatters, each.left.residuals, fit.tests, strict=True)
    counts, common, own = np.transpose(
        [
            (scatter.independent_squares(len(left)), test.over_floor**2, test.over_floor_alone**2)
            for scatter, left, test in told
        ]
    )
    more = len(fit.theta) * (len(fit.tests) - 1)
    free, unexplained = float(np.sum(counts)) - more - len(fit.theta), float(counts @ own)
    if free < 1.0 or unexplained == 0.0:
        return False
    ratio = float(counts @ (common - own)) / more / (unexplained / free)
    return bool(f_sf(ratio, more, free) < VERDICT.structure_alarm)


def prior_weight(effect: Effect) -> float:
    """How common an effect is in tests in time, before any data are seen."""
    if effect.of_apparatus:
        return effect.prior * EVIDENCE.apparatus
    return effect.prior


def without_nested(
    names: Sequence[str], tried: Sequence[Hypothesis], parts: Sequence[TestPart], reference: float
) -> list[str]:
    """Names but those of effects that have become a simpler one, the first by another name.

    One of their parameters is at its end or without influence, as the stiffness of a slider that is
    friction alone. Never the first, nor one with no more parameters than it.
    """
    limits = set()
    for each in tried[1:]:
        if each.effect.name not in names or each.left.count <= tried[0].left.count:
            continue
        theta, parameters = each.theta, each.model.parameters
        at_end = np.array([theta[i] in (o.lower, o.upper) for i, o in enumerate(parameters)])
        _, slopes = residual_of(parts, each.model, theta, reference)
        # By natural units of each: of a logarithm, its own size, or a range with two ends.
        unit = [
            1.0 if one.scale != "log" and np.isfinite(one.upper - one.lower) else theta[i]
            for i, one in enumerate(parameters)
        ]
        influence = np.linalg.norm(slopes * unit, axis=0)
        lost = at_end | (influence < EVIDENCE.least_influence)
        if any(each.effect.own_of(dict(zip(each.model.names, lost, strict=True))).values()):
            limits.add(each.effect.name)
    return [name for name in names if name not in limits]


def explains_as_well(each: Hypothesis, best: Hypothesis, noise: Sequence[ResidualScatter]) -> bool:
    """Whether an effect explains the tests as well as the best one.

    More parameters do not exclude one that helps beyond doubt, nor does a lead that is no more than
    its own scatter where both leave noise alone.
    """
    if best.delta - each.delta <= EVIDENCE.rivals:
        return True
    if not each.helps:
        return False
    worse = each.left.squares(noise) - best.left.squares(noise)
    if worse <= EVIDENCE.rivals:
        return True
    # However uncertain a noise is that was read from few samples: it is the same for both.
    if each.left.over(noise) >= VERDICT.misfit:
        return False
    if any(one.left.beside(noise).misfit for one in (best, each)):
        return False
    return not vuong_distinguishes(
        zip(best.left.whitened(noise), each.left.whitened(noise), strict=True)
    )


def no_worse(each: Hypothesis, before: FitResiduals) -> Hypothesis:
    """An effect that changes nothing, or whose fit went astray, leaves what was left without it.

    It has no size.
    """
    if sum_of_squares(each.left) < (1.0 - NEGLIGIBLE) * sum_of_squares(before):
        return each
    return replace(each, left=replace(before, count=each.left.count), fit=None)


def one_of_each(tried: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Of an effect that all rigs or one alone may have, where it explains more."""
    best: dict[str, Hypothesis] = {}
    for each in tried:
        name = each.effect.name
        if name not in best or bic_of(each.left) < bic_of(best[name].left):
            best[name] = each
    return list(best.values())


def of_what_helps(parts: Sequence[TestPart], before: FitResiduals, each: Hypothesis) -> Hypothesis:
    """An effect that leaves more than noise has no evidence where it explains next to none.

    It must be the better story too where what it leaves is taken for noise.
    """
    if not each.left.misfit:
        return each
    helps = evidence_over_misfit(parts, before, each, each.left)
    if helps > 0.0:
        return each
    return replace(each, delta=helps)


def evidence_over_misfit(
    parts: Sequence[TestPart], before: FitResiduals, each: Hypothesis, unit: FitResiduals
) -> float:
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


def collinear_with(name: str, entries: Mapping[str, Sequence[ScanEntry]]) -> list[str]:
    """Effects that add the same to a record as one does."""
    # What the model's own parameters could take over is out of these directions: only what is seen
    # is compared.
    if name not in entries:
        return []
    own = entries[name][0].direction
    twins = []
    for other, others in entries.items():
        if other != name and abs(float(own @ others[0].direction)) > COLLINEAR:
            twins.append(other)
    return twins
