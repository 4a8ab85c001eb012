"""Which effect is missing from a model of tests in time: each that has a law there is tried on the raw signal.

Harmonics hide what happens within a cycle; the record does not. The error of the model stands beside the noise of the
signal, every candidate is judged by how far the error falls for its parameters, and those that fall alike are one
class.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.errors import SpringpotError
from springpot.measurement import TimeTest
from springpot.rheology import Effect, Model, Real

from .identify import Search, identify
from .parts import InTimePart, Part, Test, parts_of_specimen, reference_of
from .result import TimeIdentification, sampled_scatter

SCHEMA = "springpot.diagnosis-in-time/1"
PLAINLY = 10.0
"""Difference of the Bayesian information criterion that is very strong evidence (Kass & Raftery 1995,
doi:10.1080/01621459.1995.10476572)."""
ALIKE = 6.0
"""Difference within which two effects cannot be told from one another (the same scale: strong evidence)."""
REFITTED = 6
"""Effects that are fitted in full; the others fell behind by a linear step already."""
SHARE = 0.185
"""Share of the samples that tell the noise floor: half of the differences' 0.37, for neighbours share samples."""
SURE = 4.0
"""Standard deviations of the floor by which the error must exceed it before something is missing."""
PIECES = 12
"""Parts of a record among which the place of the largest misfit is sought."""


@dataclass(frozen=True)
class TimeCandidate:
    """One effect, added to the model.

    Attributes
    ----------
    effect : str
        Its name.
    delta_bic : float
        By how much the Bayesian information criterion falls; above 10 is very strong evidence.
    over_floor : float
        Error after it was added, over the noise floor: of the worst test.
    parameters : dict
        Those of the effect, as printed.
    verdict : str
        ``missing``, ``cannot-tell`` or ``absent``.
    says : str
        Its physics.
    """

    effect: str
    delta_bic: float
    over_floor: float
    parameters: dict[str, dict[str, Any]]
    verdict: str
    says: str

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "effect": self.effect,
            "delta_bic": self.delta_bic,
            "over_floor": self.over_floor,
            "parameters": self.parameters,
            "verdict": self.verdict,
            "says": self.says,
        }


@dataclass(frozen=True, eq=False)
class TimeDiagnosis:
    """What is missing from a model of tests in time.

    Attributes
    ----------
    base : TimeIdentification
        The model without further effects.
    verdict : str
        ``adequate``, ``effect-missing`` or ``unexplained``.
    candidates : tuple of TimeCandidate
        Best first.
    where : str
        In which part of which test the model fails most.
    """

    base: TimeIdentification
    verdict: str
    candidates: tuple[TimeCandidate, ...]
    where: str

    @property
    def missing(self) -> tuple[str, ...]:
        """The effects that may be missing, which these tests cannot tell apart; empty where nothing is."""
        return tuple(each.effect for each in self.candidates if each.verdict in ("missing", "cannot-tell"))

    @property
    def says(self) -> str:
        """One sentence."""
        ratio = max(test.ratio for test in self.base.tests)
        size = f"the error is {ratio:.2g} x the noise floor of the signal"
        if self.verdict == "adequate":
            return f"{size}: nothing is missing that these tests could show"
        if self.verdict == "unexplained":
            return f"{size}, and no known effect explains it; {self.where}"
        best = self.candidates[0]
        return f"{size}; missing is {' or '.join(self.missing)}: {best.over_floor:.2g} x with it; {self.where}"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.diagnosis-in-time/1``."""
        return {
            "schema": SCHEMA,
            "model": self.base.model.name,
            "tests": [test.to_dict() for test in self.base.tests],
            "verdict": self.verdict,
            "where": self.where,
            "candidates": [candidate.to_dict() for candidate in self.candidates],
            "says": self.says,
        }


def diagnose(tests: Sequence[Test] | Test, model: Model, effects: Iterable[Effect]) -> TimeDiagnosis:
    """Find which effect is missing from a model of tests in time.

    Parameters
    ----------
    tests : TimeTest, Measurement, or a sequence of them
        Of one specimen, at least one in time.
    model : Model
        The model to be judged.
    effects : iterable of Effect
        What may be missing. Those without a law in time, or whose conditions the tests lack, are passed over; the
        six that promise most are fitted.

    Returns
    -------
    TimeDiagnosis
        Verdict, candidates best first, and where the model fails.

    Raises
    ------
    SpringpotError
        If the model itself does not fit the tests.
    """
    given = [tests] if isinstance(tests, TimeTest) or not isinstance(tests, Sequence) else list(tests)
    base = identify(given, model)
    promising = _promising(given, base, effects)
    fits: list[tuple[Effect, TimeIdentification]] = []
    for effect in promising:
        try:
            fits.append((effect, identify(given, model + effect, seeds=_grown(base, effect), thorough=False)))
        except SpringpotError:
            continue
    count = _independent(given, min((fit for _, fit in fits), key=_power, default=base))
    best = min(_power(base), *(_power(fit) for _, fit in fits)) if fits else _power(base)
    points = sum(test.points for test in base.tests)
    scale = max(1.0, best / points) * points / count
    ranked = sorted(
        (
            ((_power(base) - _power(fit)) / scale - len(effect.element.parameters) * np.log(count), effect, fit)
            for effect, fit in fits
        ),
        key=lambda each: -each[0],
    )
    off = any(test.ratio > 1.0 + SURE / np.sqrt(2.0 * SHARE * max(test.points, 2)) for test in base.tests)
    found = bool(ranked) and ranked[0][0] > PLAINLY and off
    candidates = tuple(_candidate(each, ranked[0][0], found) for each in ranked)
    verdict = "effect-missing" if found else "unexplained" if off else "adequate"
    return TimeDiagnosis(base, verdict, candidates, _where(given, base))


def _promising(tests: Sequence[Test], base: TimeIdentification, effects: Iterable[Effect]) -> list[Effect]:
    """The effects that are worth a fit: those whose linear step from next to nothing lets the error fall most."""
    parts = parts_of_specimen(tests)
    own = {effect.name for effect in base.model.effects}
    hopes: list[tuple[float, Effect]] = []
    for effect in effects:
        if effect.name in own or effect.by_levels:
            continue
        left = [_after_step(base, effect, seed, parts) for seed in _grown(base, effect)]
        if np.isfinite(min(left)):
            hopes.append((min(left), effect))
    return [effect for _, effect in sorted(hopes, key=lambda each: each[0])[:REFITTED]]


def _after_step(base: TimeIdentification, effect: Effect, theta: Real, parts: Sequence[Part]) -> float:
    """Sum of squares that a linear step from theta would leave; endless where the effect has no law in time."""
    search = Search(base.model + effect, parts, base.reference)
    try:
        with np.errstate(all="ignore"):
            value, slopes = search.residual(parts, search.coordinates.u(theta, search.size), coarse=True)
    except SpringpotError:
        # It has no law in time, or none for a step that takes no time.
        return np.inf
    if not (np.all(np.isfinite(value)) and np.all(np.isfinite(slopes))):
        return np.inf
    solution = np.linalg.lstsq(slopes.T, value, rcond=1e-10)[0]
    return float(np.sum((value - slopes.T @ solution) ** 2))


def _power(fit: TimeIdentification) -> float:
    """Sum of squares of the residuals over their noise."""
    return sum(test.points * test.ratio**2 for test in fit.tests)


def _grown(base: TimeIdentification, effect: Effect) -> list[Real]:
    """A start at the fit without the effect, of which there is a little."""
    grown = base.model + effect
    known = dict(zip(base.model.names, base.theta.tolist(), strict=True))
    typical = float(np.exp(np.mean(np.log(np.maximum(np.abs(base.theta), 1e-300)))))
    new = [parameter for parameter in grown.parameters if parameter.name not in known]
    starts = []
    for share in (1e-3, 1e-1):
        values = known | {p.name: _small(p.lower, p.upper, share * typical) for p in new}
        starts.append(grown.vector(values))
    return starts


def _small(lower: float, upper: float, value: float) -> float:
    if np.isfinite(lower) and np.isfinite(upper):
        return float(lower + 0.5 * (upper - lower))
    return float(np.clip(value, lower, upper))


def _independent(tests: Sequence[Test], fit: TimeIdentification) -> float:
    """How many samples there are, those whose misses are alike counted once."""
    parts = parts_of_specimen(tests)
    search = Search(fit.model, parts, fit.reference)
    u = search.coordinates.u(fit.theta, search.size)
    whole = 0.0
    for part in parts:
        value, _ = search.residual([part], u)
        power = max(float(np.mean(value**2)), 1e-300)
        whole += len(value) * power / max(sampled_scatter(value, part), power)
    return max(whole, 2.0)


def _candidate(each: tuple[float, Effect, TimeIdentification], best: float, found: bool) -> TimeCandidate:
    delta, effect, fit = each
    alike = found and delta > PLAINLY and best - delta <= ALIKE
    verdict = "absent" if not alike else "missing" if delta == best else "cannot-tell"
    names = {name for name in fit.model.names if name.partition(".")[0] == effect.name}
    parameters = {name: entry for name, entry in fit.parameters.items() if name in names}
    return TimeCandidate(
        effect.name, float(delta), max(test.ratio for test in fit.tests), parameters, verdict, effect.summary
    )


def _where(tests: Sequence[Test], base: TimeIdentification) -> str:
    """The part of a record in which the model misses most, and what happens there."""
    reference = reference_of(tests)
    worst: tuple[float, str] = (0.0, "it fails nowhere in particular")
    for part in parts_of_specimen(tests):
        if not isinstance(part, InTimePart):
            continue
        value = part.residual(base.model, base.theta, reference).value
        pieces = [piece for piece in np.array_split(np.arange(len(value)), PIECES) if len(piece)]
        sizes = [float(np.sqrt(np.mean(value[piece] ** 2))) for piece in pieces]
        k = int(np.argmax(sizes))
        test, piece = part.test, pieces[k]
        first, last = float(test.time[piece[0]]), float(test.time[piece[-1]])
        size = f"{sizes[k]:.2g} x the noise"
        says = f"{test.name} is missed most from {first:.3g} to {last:.3g} s ({size}){_manner(test, value)}"
        worst = max(worst, (sizes[k], says))
    return worst[1]


def _manner(test: TimeTest, value: Real) -> str:
    """Whether a record is missed where its motion turns, or where it is fast."""
    if test.kind != "history":
        return ""
    rate = np.abs(np.gradient(np.interp(test.time, test.loading.time, test.loading.value), test.time))
    slow = rate < 0.3 * np.percentile(rate, 95)
    if not slow.any() or slow.all():
        return ""
    turning, moving = (float(np.mean(value[rows] ** 2)) for rows in (slow, ~slow))
    if turning > 2.0 * moving:
        return ", where the motion turns"
    return ", where the motion is fast" if moving > 2.0 * turning else ""
