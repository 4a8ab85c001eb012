"""From fits to candidates: numbers, units, verdicts and a sentence for each effect."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from springpot.identification import Uncertainty
from springpot.rheology import Effect

from .evidence import Evidence, best_with
from .policy import EVIDENCE, VERDICT
from .refit import Refit
from .result import Candidate, EffectVerdict, Value, Verdict
from .scan import Score
from .search import Grown, Search


class Standing(NamedTuple):
    """What the evidence makes of an effect: its probability, its class and its verdict."""

    probability: float
    alike: tuple[str, ...]
    word: EffectVerdict


def candidates_of(evidence: Evidence, verdict: Verdict) -> list[Candidate]:
    """All scanned effects as candidates, the likeliest first; none is missing where the verdict is another."""
    search = evidence.search
    groups: list[list[str]] = []
    if verdict != "adequate":
        groups = evidence.classes
    class_of = {name: tuple(group) for group in groups for name in group}
    alone = {grown.names[0]: grown for grown in reversed(search.grown) if len(grown.effects) == 1}
    best, chances = best_with(search), evidence.effects
    leader, beside = "", dict[str, Grown]()
    if evidence.explanations:
        leader, beside = evidence.leader, evidence.grown_beside(evidence.beside)
    rows = []
    for score in search.scan.scores:
        name = score.influence.effect.name
        chance = chances.get(name, 0.0)
        # Of the first class one member is missing for certain; any other must be likely in its own right.
        least = EVIDENCE.beside
        if groups and name in groups[0]:
            least = VERDICT.likely
        missing = verdict == "effect-missing" and chance > least * evidence.trust(name)
        word = _effect_verdict(search, score, best.get(name), missing)
        standing = Standing(chance, class_of.get(name, (name,)), word)
        if name in beside:
            # An effect that only shows beside the leading one is told as it is there.
            before = search.base
            if leader in alone:
                before = alone[leader].refit
            row = _candidate(before, score, beside[name], standing)
            row = replace(row, says=f"beside {leader}: {row.says}")
        else:
            row = _candidate(search.base, score, alone.get(name), standing)
        rows.append(row)
    rows.sort(key=lambda row: (row.effect != leader, -row.probability, -row.delta_bic))
    return rows


def _candidate(before: Refit, score: Score, grown: Grown | None, standing: Standing) -> Candidate:
    """One effect as it is when it joins a fitted model: the user's alone, or that with the leading effect."""
    effect = score.influence.effect
    row = Candidate(
        physics=effect,
        alike=standing.alike,
        probability=standing.probability,
        delta_bic=-np.inf,
        score=score.score,
        verdict=standing.word,
        predicted_error=_predicted(before, score.predicted),
        error_after=before.relative_rms,
        bound=score.bound,
        parameters={},
        says=effect.summary,
    )
    if grown is None:
        return row
    return replace(
        row,
        delta_bic=2.0 * (grown.refit.log_evidence - before.log_evidence),
        predicted_error=_predicted(before, grown.predicted),
        error_after=grown.refit.relative_rms,
        parameters=_parameters(grown.refit, effect),
    )


def _predicted(before: Refit, left: float) -> float:
    """Relative error that is foretold, from the sum of squares that is."""
    return before.relative_rms * float(np.sqrt(max(left, 0.0) / max(before.rss, 1e-300)))


def _effect_verdict(search: Search, score: Score, best: Refit | None, missing: bool) -> EffectVerdict:
    gain = -np.inf
    if best is not None:
        gain = 2.0 * (best.log_evidence - search.base.log_evidence)
    if missing and gain >= VERDICT.clear_evidence:
        return "missing"
    if gain < 0.0 and score.bound < VERDICT.seen:
        return "absent"
    return "cannot-tell"


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
    fits = refit.fit.dof <= 0 or refit.relative_rms < VERDICT.misfit * refit.floor
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
