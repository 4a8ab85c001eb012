"""The overall verdict, and the sentence that says it."""

from __future__ import annotations

from collections.abc import Sequence

from .candidates import CLEAR_EVIDENCE
from .occam import likeliest_unknown
from .outliers import Outlier
from .posterior import Posterior
from .result import Verdict
from .search import Search
from .words import times

LIBRARY_ALARM = 0.006
"""Chance of a false alarm granted to the scan of the library."""
STRUCTURE_ALARM = 0.005
"""Chance of a false alarm granted to the test for structure of any kind."""
BEYOND_DOUBT = 0.002
"""Chance of a false alarm below which something is missing even if the evidence names it weakly."""
REMAINDER = 0.005
"""Share of the misfit that named effects may leave and still be the verdict."""
NOISY = 1.2
"""Error over noise floor below which only the pattern of a misfit tells it from noise."""
NOTHING_LEFT = 10.0
"""Chi-square beyond the degrees of freedom that is no misfit worth a verdict."""
FEWEST_SPARE = 4
"""Degrees of freedom below which data cannot be judged."""
REPEATS_ALARM = 0.002
"""Chance of a false alarm granted to the test of the repeats' scatter."""


def verdict_of(found: Search, probabilities: Posterior, outliers: Sequence[Outlier]) -> Verdict:
    """Judge what fits and scans found; points that stand out are explained by no effect.

    Parameters
    ----------
    found : Search
        Fits and scans, of the data without outliers.
    probabilities : Posterior
        Of every effect.
    outliers : sequence of Outlier
        Points set aside.
    """
    judged = _without_outliers(found, probabilities)
    return "unexplained" if outliers and judged in ("adequate", "inconclusive") else judged


def _without_outliers(found: Search, probabilities: Posterior) -> Verdict:
    by_library = found.scan.p_value < LIBRARY_ALARM
    by_structure = found.structure.p_value < STRUCTURE_ALARM
    gain = _gain(found)
    if not (by_library or by_structure):
        likely = gain >= CLEAR_EVIDENCE and probabilities.nothing < 0.5
        return "inconclusive" if likely or found.base.fit.dof < FEWEST_SPARE else "adequate"
    if probabilities.unknown > 0.5 and likeliest_unknown(found).says:
        return "unexplained"
    left = found.left.p_value < STRUCTURE_ALARM or probabilities.unknown > 0.5
    if (left or (gain < CLEAR_EVIDENCE and by_structure)) and not _all_but_explained(found):
        return "unexplained"
    certain = min(found.scan.p_value, found.structure.p_value) < BEYOND_DOUBT
    named = gain >= CLEAR_EVIDENCE or (certain and gain > 0.0)
    return "effect-missing" if named and probabilities.nothing < 0.5 else "inconclusive"


def _gain(found: Search) -> float:
    """Drop of the information criterion that the best grown model brings."""
    return 2.0 * (found.best.log_evidence - found.base.log_evidence)


def _all_but_explained(found: Search) -> bool:
    """Whether named effects explain nearly all of a misfit, and what they leave is small beside the noise.

    Real measurements always keep some structure at the level of their noise; it is noted, not made the verdict.
    """
    spare = found.base.fit.dof
    excess = [refit.rss - spare for refit in (found.base, found.best)]
    small = found.best.relative_rms < 2.0 * found.best.floor
    return excess[0] > spare and excess[1] < max(REMAINDER * excess[0], NOTHING_LEFT) and small


def sentence(
    found: Search,
    verdict: Verdict,
    named: Sequence[str],
    beside: Sequence[str],
    imitators: frozenset[str],
    outliers: Sequence[Outlier],
) -> str:
    """The verdict in words.

    Parameters
    ----------
    found : Search
        Fits and scans.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    named, beside : sequence of str
        Effects one of which is missing, and those one of which is missing as well.
    imitators : frozenset of str
        Effects in whose place something else as narrow may stand.
    outliers : sequence of Outlier
        Points set aside.
    """
    ratio = found.base.relative_rms / found.base.floor
    error = f"the error is {times(ratio)} the noise floor"
    if verdict == "adequate":
        return f"nothing is missing down to the noise floor: {error}"
    if verdict == "effect-missing":
        second = f", and beside it {' or '.join(beside)}" if beside else ""
        other = " or another narrow feature" if imitators & {*named, *beside} else ""
        return f"{error}; missing is {' or '.join(named)}{second}{other}"
    if verdict == "unexplained":
        if outliers and min(found.scan.p_value, found.structure.p_value) > STRUCTURE_ALARM:
            points = "a single point stands out" if len(outliers) == 1 else f"{len(outliers)} single points stand out"
            return (
                f"{error} without outliers: {points} that no effect of the library explains, nothing else is missing"
            )
        pattern = ", but no pattern of noise" if ratio < NOISY else ""
        return f"{error}{pattern}; something is missing that no effect of the library explains"
    return f"{error}; these data cannot tell whether something is missing"
