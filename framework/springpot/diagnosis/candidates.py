"""From fits to candidates: numbers, units, verdicts and a sentence for each effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from springpot.identification import Uncertainty
from springpot.rheology import Effect

from .posterior import BESIDE, Posterior, best_with, grown_beside, leading, seconds
from .refit import Refit
from .result import Candidate, EffectVerdict, Value, Verdict
from .scan import Score
from .search import Grown, Search

LIKELY = 0.5
"""Probability from which an effect of the first class is called missing."""
CLEAR_EVIDENCE = 6.0
"""Drop of the information criterion from which something counts as missing."""
MISFIT = 1.3
"""Error over noise floor from which a fit does not hold."""
SEEN = 0.05
"""Relative change of K: an effect that would have been seen at this size is called absent."""


class Standing(NamedTuple):
    """What the evidence makes of an effect: its probability, its class and its verdict."""

    probability: float
    alike: tuple[str, ...]
    word: EffectVerdict


def candidates_of(
    found: Search, probabilities: Posterior, groups: Sequence[Sequence[str]], verdict: Verdict
) -> list[Candidate]:
    """All scanned effects as candidates, the likeliest first."""
    group_of = {name: tuple(group) for group in groups for name in group}
    alone = {grown.names[0]: grown for grown in reversed(found.grown) if len(grown.effects) == 1}
    best, chances = best_with(found), probabilities.effects
    leader = leading(found, probabilities) if chances else ""
    beside = grown_beside(found, leader, seconds(found, probabilities) if chances else [])
    rows = []
    for score in found.scan.scores:
        name = score.influence.effect.name
        # An effect that only shows beside the leading one is told as it is there.
        grown = beside.get(name) or alone.get(name)
        before = alone.get(leader) if name in beside else None
        least = LIKELY if groups and name in groups[0] else BESIDE
        missing = verdict == "effect-missing" and chances.get(name, 0.0) > least * probabilities.trust(name)
        word = _effect_verdict(found, score, best.get(name), missing)
        standing = Standing(chances.get(name, 0.0), group_of.get(name, (name,)), word)
        rows.append(_candidate(before.refit if before else found.base, score, grown, standing))
    rows = [replace(row, says=f"beside {leader}: {row.says}") if row.effect in beside else row for row in rows]
    rows.sort(key=lambda row: (row.effect != leader, -row.probability, -row.delta_bic))
    return rows


def _candidate(before: Refit, score: Score, grown: Grown | None, standing: Standing) -> Candidate:
    """One effect as it is when it joins a fitted model: the user's alone, or that with the leading effect."""
    effect = score.influence.effect
    left = score.predicted if grown is None else grown.predicted
    refit = None if grown is None else grown.refit
    return Candidate(
        effect=effect.name,
        alike=standing.alike,
        probability=standing.probability,
        delta_bic=-np.inf if refit is None else 2.0 * (refit.log_evidence - before.log_evidence),
        score=score.score,
        verdict=standing.word,
        predicted_error=before.relative_rms * float(np.sqrt(max(left, 0.0) / max(before.rss, 1e-300))),
        error_after=before.relative_rms if refit is None else refit.relative_rms,
        bound=score.bound,
        parameters={} if refit is None else _parameters(refit, effect),
        says=effect.summary,
    )


def _effect_verdict(found: Search, score: Score, best: Refit | None, missing: bool) -> EffectVerdict:
    gain = -np.inf if best is None else 2.0 * (best.log_evidence - found.base.log_evidence)
    if missing and gain >= CLEAR_EVIDENCE:
        return "missing"
    return "absent" if gain < 0.0 and score.bound < SEEN else "cannot-tell"


def _parameters(refit: Refit, effect: Effect) -> dict[str, Value]:
    """The effect's own parameters in printed units, without the prefix of its name."""
    own = {}
    for name, value in printed(refit).items():
        prefix, _, short = name.rpartition(".")
        if prefix.partition("#")[0] == effect.name:
            own[short] = value
    return own


def printed(refit: Refit) -> dict[str, Value]:
    """All parameters with their 95 % intervals, in the units in which they are printed.

    Where a model does not fit, its misfit and not the noise sets how uncertain they are.
    """
    units = refit.fit.measurement.units
    fits = refit.fit.dof <= 0 or refit.relative_rms < MISFIT * refit.floor
    low, high = Uncertainty(refit.fit, absolute=fits).interval()
    rows = {}
    for i, parameter in enumerate(refit.model.parameters):
        if parameter.detail:
            continue
        factor, label = units.of(parameter.unit)
        rows[parameter.name] = Value(
            float(refit.theta[i]) * factor, float(low[i]) * factor, float(high[i]) * factor, label
        )
    return rows
