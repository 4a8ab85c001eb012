"""What else the user should know of a diagnosis, one sentence each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .discrepancy import discrepancy, log_shift_of
from .findings import Finding, judged
from .harmonics import UNPREDICTED, harmonic_evidence
from .occam import likeliest_unknown
from .outliers import Outlier
from .overtones import overtones
from .posterior import Posterior, explanations, leading
from .result import Verdict
from .search import Search
from .validation import validation
from .verdict import REPEATS_ALARM, STRUCTURE_ALARM
from .words import percent, times

WORTH_A_WORD = 0.03
"""Probability from which narrow features of unknown origin are told of."""
EXPLAINED = 1.5
"""Chi-square per degree of freedom up to which nothing worth a word is left."""
MOST_OF_IT = 0.2
"""Share of a misfit beyond the noise that may be left by what is said to explain most of it."""
LOUD = 0.01
"""Share of the first harmonic from which a higher one is told of: less is the rig's."""


def notes(
    found: Search, probabilities: Posterior, verdict: Verdict, outliers: Sequence[Outlier], measured: int
) -> Iterator[str]:
    """Sentences on the data, on what is left, and on how well the grown model predicts the unseen.

    Parameters
    ----------
    found : Search
        Fits and scans.
    probabilities : Posterior
        Of every effect.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    outliers : sequence of Outlier
        Points set aside.
    measured : int
        Rows of the data before thinning.
    """
    yield from _of_data(found, outliers, measured)
    for finding in unexplained_harmonics(found, verdict):
        yield f"{finding.says}; the model does not make it, and K of the first harmonic does not tell of it"
    kind = _unknown(found) if verdict == "unexplained" else ""
    if kind:
        yield f"what is missing looks like {kind}: the measuring chain rather than the material"
    elif found.left.p_value < STRUCTURE_ALARM:
        yield from _of_rest(found)
    if probabilities.narrow > WORTH_A_WORD:
        share = f"{100 * probabilities.narrow:.0f} %"
        names = " and ".join(sorted(probabilities.imitators))
        yield (
            f"other narrow features, such as an interference, look like {names}: "
            f"{share} of the probability is left to them"
        )
    if verdict != "adequate" and probabilities.together:
        yield from validation(found.base, explanations(found, probabilities)[leading(found, probabilities)])


def _of_data(found: Search, outliers: Sequence[Outlier], measured: int) -> Iterator[str]:
    if outliers:
        places = ", ".join(map(str, outliers))
        kind = "a single point stands out and was" if len(outliers) == 1 else "single points stand out and were"
        yield f"{kind} set aside, an outlier or narrow interference: {places}"
    if found.base.noise.doubt:
        yield found.base.noise.doubt
    used = len(found.base.data.raw) + len(outliers)
    if measured > used:
        yield f"diagnosed on {used} of the {measured} points"
    own_gain = found.base.data.own_gain
    if own_gain > 0.0:
        yield f"replicates differ as a whole by {percent(own_gain)} (rms): each run was given a gain of its own"
    if found.repeats.p_value < REPEATS_ALARM:
        yield f"repeats differ by more than chance ({found.repeats.kind}): drift or a disturbance common to a sweep"


def unexplained_harmonics(found: Search, verdict: Verdict) -> list[Finding]:
    """Loud force harmonics that the model, with what is missing from it, does not make.

    Parameters
    ----------
    found : Search
        Fits and scans.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    """
    refit = found.best if verdict == "effect-missing" else found.base
    odd = harmonic_evidence(refit) >= UNPREDICTED
    told = judged(overtones(found.base.data.mean, found.base.noise.sd))
    return [each for each in told if each.found and each.statistic > LOUD and not (odd and each.test == "harmonic 3")]


def _of_rest(found: Search) -> Iterator[str]:
    """What the best model leaves, without a name for it."""
    best = found.best
    if best is not found.base:
        ratio = best.relative_rms / best.floor
        yield f"the best model found, {best.model}, still leaves structure ({times(ratio)} the noise floor)"
    yield from discrepancy(best.frame(), log_shift_of(best))


def _unknown(found: Search) -> str:
    """The kind of structure that explains the data, if one does that no effect of the library is."""
    if found.structure.p_value >= STRUCTURE_ALARM:
        return ""
    kind, frame = likeliest_unknown(found), found.frame
    spare = frame.size - frame.absorbed.shape[1]
    misfit = float(frame.rest @ frame.rest)
    left = misfit - kind.drop
    all_of_it = left < EXPLAINED * spare
    most_of_it = left - spare < MOST_OF_IT * (misfit - spare)
    return kind.says if all_of_it or most_of_it else ""
