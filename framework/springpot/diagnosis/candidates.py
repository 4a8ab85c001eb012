"""The table of effects: what each would do, how likely it is, and what it cannot be told from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.identification.part_result import in_floors
from springpot.identification.value import Value
from springpot.misfit.refit import Refit
from springpot.misfit.values import printed
from springpot.rheology.effect import Effect
from springpot.thresholds import EVIDENCE, VERDICT

from .evidence import Evidence, best_with
from .grown import Grown, Search
from .result import Candidate, EffectVerdict, Verdict
from .scan import Score


def candidates_of(evidence: Evidence, verdict: Verdict) -> list[Candidate]:
    """All scanned effects as candidates, the likeliest first.

    None is missing where the verdict is another.
    """
    search = evidence.search
    groups: list[list[str]] = []
    if verdict != "adequate":
        groups = evidence.classes
    class_of = {name: tuple(group) for group in groups for name in group}
    # Reversed, so that of several fits of one effect the best stays.
    alone = {grown.names[0]: grown for grown in reversed(search.grown) if len(grown.effects) == 1}
    best, chances = best_with(search), evidence.effects
    leader, beside = "", dict[str, Grown]()
    if evidence.explanations:
        leader, beside = evidence.leader, evidence.grown_beside(evidence.beside)
    rows = []
    for score in search.scan.scores:
        name = score.influence.effect.name
        chance = chances.get(name, 0.0)
        # Of the first class one member is missing for certain; any other must be likely in its own
        # right.
        least = EVIDENCE.beside
        if groups and name in groups[0]:
            least = VERDICT.likely
        missing = verdict == "effect-missing" and chance > least * evidence.trust(name)
        # One of its class needs a condition that moved with the frequency: no fit can say which of
        # them it is.
        if search.confounded and groups and name in groups[0]:
            missing = False
        word = _effect_verdict(search, score, best.get(name), missing)
        # What is told after an effect is what accepting it gives: the model with that effect alone.
        row = _candidate(search.base, score, alone.get(name), chance > VERDICT.profiled)
        if name in beside:
            row = _beside(row, leader, beside[name], alone)
        rows.append(
            replace(row, alike=class_of.get(name, (name,)), probability=chance, verdict=word)
        )
    # The leader first: it stands for its class, of which another member may be as likely.
    rows.sort(key=lambda row: (row.effect != leader, -row.probability, -row.delta_bic))
    return rows


def _candidate(before: Refit, score: Score, grown: Grown | None, believed: bool) -> Candidate:
    """What one effect does when it joins a fitted model.

    The user's alone, or that with the leading effect.
    """
    effect = score.influence.effect
    row = Candidate(
        physics=effect,
        alike=(effect.name,),
        probability=0.0,
        delta_bic=-np.inf,
        score=score.score,
        verdict="cannot-tell",
        predicted_error=_predicted(before, score.predicted),
        error_after=np.nan,
        over_floor=np.nan,
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
        error_after=grown.refit.error,
        over_floor=in_floors(grown.refit.error, before.floor),
        parameters=_parameters(grown.refit, effect, believed),
    )


def _beside(row: Candidate, leader: str, pair: Grown, alone: dict[str, Grown]) -> Candidate:
    """The row of an effect that shows beside the leading one.

    Its evidence there, and what both leave.
    """
    gain = row.delta_bic
    if leader in alone:
        gain = 2.0 * (pair.refit.log_evidence - alone[leader].refit.log_evidence)
    left = f"{100.0 * pair.refit.error:.3g} % is left with both"
    return replace(row, delta_bic=gain, says=f"beside {leader}: {row.says}; {left}")


def _predicted(before: Refit, left: float) -> float:
    """Relative error that is foretold, from the sum of squares that is."""
    return before.error * float(np.sqrt(max(left, 0.0) / max(before.rss, 1e-300)))


def _effect_verdict(
    search: Search, score: Score, best: Refit | None, missing: bool
) -> EffectVerdict:
    gain = -np.inf
    if best is not None:
        gain = 2.0 * (best.log_evidence - search.base.log_evidence)
    # A probability shared among few rivals may be large where the data hardly speak: the gain must
    # be clear too.
    if missing and gain >= VERDICT.clear_evidence:
        return "missing"
    # Not seen is not absent: only where the data would have shown a small one.
    if gain < 0.0 and score.bound < VERDICT.seen:
        return "absent"
    return "cannot-tell"


def _parameters(refit: Refit, effect: Effect, by_profile: bool) -> dict[str, Value]:
    """The effect's own parameters in printed units, without the prefix of its name."""
    own = {}
    for name, value in printed(refit, by_profile).items():
        prefix, _, short = name.rpartition(".")
        if prefix.partition("#")[0] == effect.name:
            own[short] = value
    return own
