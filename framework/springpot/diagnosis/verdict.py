"""The overall verdict: tables of rules on a few facts, and the sentence that tells of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import comb
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_quantile
from springpot.identification.problem import weighted
from springpot.measurement.independence import frequency_numbers, moved_along
from springpot.measurement.mixed_up import sweeps_of
from springpot.misfit.error import percent, times
from springpot.misfit.floor import (
    below_floor,
    beyond_floor,
    is_arithmetic,
    is_hardly_known,
    undragged,
)
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.misfit.residual_causes import Column, EqualRows, column_behind
from springpot.misfit.residual_tests import OF_NEIGHBOURS, sets_apart
from springpot.rheology.points import Real
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT

from .grown import Grown, Search
from .marginal import credible, likeliest_unknown
from .result import Verdict

if TYPE_CHECKING:
    from .evidence import Evidence

DEALT = 1000
"""Times that points which stand out are dealt out anew; a chance of 0.05 is known to an eighth."""


@dataclass(frozen=True)
class Facts:
    """All that the verdict depends on.

    Attributes
    ----------
    repeats : bool
        Repeats drift by more than chance, or the error of one of their points goes on in the next.
    by_scan : bool
        The scan of the library raises its alarm.
    by_battery : bool
        The tests for structure of any kind raise theirs.
    certain : bool
        One of them is beyond doubt.
    gain : float
        Drop of the information criterion that the best grown model brings.
    named : bool
        The evidence prefers some effect to nothing.
    something : bool
        The evidence prefers something, known or not, to nothing.
    unknown : bool
        The evidence prefers something unknown to every effect.
    ruled_out : bool
        The evidence all but rules out that nothing is missing.
    chain : bool
        What it prefers is a fault of the measuring chain that has a description.
    left : bool
        The best grown model leaves structure.
    nearly_all : bool
        It explains nearly all of the misfit, and what it leaves is small beside the noise.
    few : bool
        There are too few data to judge anything.
    outliers : bool
        Single points were set aside.
    interference : bool
        They are no bad readings: what lies beside them is off too.
    material : bool
        A free spectrum follows the data better than the model with any effect does.
    exceeds : bool
        The error is beyond the noise floor by more than chance, though no test sees a pattern.
    together : bool
        The points that are beyond it are neighbours, as those of a notch are and those of
        long-tailed noise are not.
    exact : bool
        The error is that of arithmetic: the data were computed, and their residual is no scatter.
    below : bool
        The error is smaller than the noise that was told by these very data.
    by_column : bool
        Most of what the best model leaves goes with a column that no effect knows.
    remembers : bool
        The noise of a sweep has a memory, and no repeat or other sweep shows that it is noise.
    """

    repeats: bool = False
    by_scan: bool = False
    by_battery: bool = False
    certain: bool = False
    gain: float = 0.0
    named: bool = False
    something: bool = False
    unknown: bool = False
    ruled_out: bool = False
    chain: bool = False
    left: bool = False
    nearly_all: bool = False
    few: bool = False
    outliers: bool = False
    interference: bool = False
    material: bool = False
    exceeds: bool = False
    together: bool = False
    exact: bool = False
    below: bool = False
    by_column: bool = False
    remembers: bool = False

    @property
    def alarm(self) -> bool:
        """Noise alone does not explain the residual."""
        # An error below the noise is no misfit: the noise was misjudged, and with it all that is
        # told in its units.
        return (self.by_scan or self.by_battery or self.ruled_out) and not self.below

    @property
    def clear(self) -> bool:
        """The best grown model is clearly better."""
        return self.gain >= VERDICT.clear_evidence

    @property
    def unnamed(self) -> bool:
        """Structure is left that the best grown model has no part in, or none clearly takes."""
        return self.left or self.unknown or (self.by_battery and not self.clear)


class VerdictRule(NamedTuple):
    """One line of the table."""

    reason: str
    holds: Callable[[Facts], bool]
    verdict: Verdict


ARITHMETIC = VerdictRule(
    "nothing is left but arithmetic", lambda f: f.exact and not f.interference, "adequate"
)
"""Before any alarm: the residual of computed data has a pattern, but no scatter to judge it by."""
QUIET = (
    ARITHMETIC,
    # First: beside a resonance or an interference nothing is adequate.
    VerdictRule(
        "only points that stand out, and what lies beside them",
        lambda f: f.interference,
        "unexplained",
    ),
    # Before all that weighs the size of an error: so few numbers tell neither it nor the floor.
    VerdictRule("too few data", lambda f: f.few, "inconclusive"),
    # Before "an effect would help": an effect fitted to a notch would make it a maybe; whether one
    # would help beside a free spectrum is open, not that the model fails; and rows of two
    # calibrations that take turns look like noise to all that does not know which is which.
    VerdictRule(
        "more than noise, by neighbours or of a kind, beside a material, or by a column",
        lambda f: (f.exceeds and (f.together or f.unknown)) or f.material or f.by_column,
        "unexplained",
    ),
    # Never "effect-missing" without an alarm: of all that was tried, something helps by chance.
    VerdictRule(
        "an effect would help, or it is noise", lambda f: f.clear and f.something, "inconclusive"
    ),
    # Only where no test is alarmed: drift raises the floor, and what shows above it is real.
    VerdictRule("what repeats differ by is no noise", lambda f: f.repeats, "unexplained"),
    # An error beyond the floor in no pattern may be noise with long tails, and something without a
    # name follow noise. Beside a model with one effect more a pattern is seen that the base,
    # further off, may hide. One sweep tells noise with a memory from a misfit that comes and goes
    # only by being measured again.
    VerdictRule(
        "more than noise, or noise of another kind",
        lambda f: f.exceeds or f.unknown or (f.left and not f.below) or f.remembers,
        "inconclusive",
    ),
    # All that could be missing was asked for.
    VerdictRule("noise explains all", lambda f: True, "adequate"),
)
"""Without an alarm the first of these that holds gives the verdict."""
ALARMED = (
    ARITHMETIC,
    # Before any name: an effect may take nearly all of a chain's fault; the best wrong one takes
    # most of any misfit, but leaves structure; and structure is certain where none is clearly
    # better than none.
    VerdictRule(
        "a fault of the measuring chain explains more, or structure is left",
        lambda f: (f.unknown and f.chain) or (f.unnamed and not f.nearly_all),
        "unexplained",
    ),
    # A weak gain is enough where the alarm is beyond doubt: then something is missing.
    VerdictRule(
        "an effect is named",
        lambda f: f.named and (f.clear or (f.certain and f.gain > 0.0)),
        "effect-missing",
    ),
    # After the name: outliers set aside beside a found effect do not take it back. The battery is
    # sure of structure whatever the library holds; the scan, which is not, is last.
    VerdictRule(
        "no name, and points that stand out or structure",
        lambda f: f.outliers or f.by_battery,
        "unexplained",
    ),
    # Always holds, so that there is a verdict for any facts.
    VerdictRule("something, but not what", lambda f: True, "inconclusive"),
)
"""With one, the first of these."""


def rule_for(facts: Facts) -> VerdictRule:
    """The first rule that holds."""
    return next(rule for rule in (ALARMED if facts.alarm else QUIET) if rule.holds(facts))


def facts_of(evidence: Evidence, outliers: Sequence[Outlier], beside_material: bool) -> Facts:
    """What fits, scans and evidence amount to.

    Parameters
    ----------
    evidence : Evidence
        Of every effect, with the search behind it.
    outliers : sequence of Outlier
        Points set aside.
    beside_material : bool
        Whether the search went on beside a free spectrum, as the model could not follow the
        material.
    """
    search = evidence.search
    unknown = evidence.unknown > VERDICT.likely
    exceeds = beyond_floor(search.base)
    certain = min(search.scan.p_value, search.structure.p_value) < VERDICT.beyond_doubt
    return Facts(
        repeats=drifted(search) or _carried_on(search),
        by_scan=search.scan.p_value < VERDICT.library_alarm,
        by_battery=search.structure.p_value < VERDICT.structure_alarm,
        certain=certain,
        gain=search.gain,
        named=prefers_effects(evidence),
        something=evidence.nothing < VERDICT.likely,
        unknown=unknown,
        ruled_out=evidence.nothing < VERDICT.ruled_out
        and search.base.fit.dof >= VERDICT.enough_spare,
        chain=by_chain(evidence),
        left=search.left.p_value < VERDICT.structure_alarm,
        nearly_all=_all_but_explained(search),
        few=is_hardly_known(search.base),
        outliers=bool(outliers),
        interference=not all(outlier.alone for outlier in outliers),
        material=beside_material,
        exceeds=exceeds,
        together=exceeds and _stand_out_together(search.base),
        # A free spectrum follows any smooth computed data: only the user's model may be so exact.
        exact=not beside_material and is_arithmetic(search.base),
        below=below_floor(search.base, certain),
        by_column=column_behind(search.best.frame()) is not None,
        remembers=bool(search.base.noise.memory)
        and search.base.noise.source != "repeats"
        and not search.base.frame().shared.shape[1],
    )


def prefers_effects(evidence: Evidence) -> bool:
    """Whether the evidence prefers some effect to nothing."""
    return sum(one.probability for one in evidence.explanations) > evidence.nothing


def by_chain(evidence: Evidence) -> bool:
    """Whether a fault of the measuring chain with a description explains more than any effect."""
    return evidence.by_itself > VERDICT.likely and bool(likeliest_unknown(evidence.search).says)


def _stand_out_together(base: Refit) -> bool:
    """Whether more of the points that stand out are neighbours than chance would put there."""
    stands_out, sweeps = _standing_out(base), sweeps_of(base.data.mean)
    pairs = 0
    for sweep in sweeps:
        outside = stands_out[sweep.rows]
        pairs += int(np.sum(outside[1:] & outside[:-1]))
    n, m = len(stands_out), int(np.sum(stands_out))
    if pairs > 0 and _chance_of_pairs(n, m, pairs) < VERDICT.neighbours:
        return True
    return len(sweeps) > 1 and _at_few_frequencies(frequency_numbers(base.data.mean), stands_out)


def _at_few_frequencies(which: NDArray[np.int64], stands_out: NDArray[np.bool_]) -> bool:
    """Whether points of several sweeps stand out at fewer frequencies than chance would choose.

    An interference is at one frequency, of whatever sign it is in each sweep.
    """
    found = len(np.unique(which[stands_out]))
    if found == np.sum(stands_out):
        return False
    rng = np.random.default_rng(0)
    dealt = rng.permuted(np.tile(which, (DEALT, 1)), axis=1)[:, : int(np.sum(stands_out))]
    dealt.sort(axis=1)
    frequencies = 1 + np.count_nonzero(np.diff(dealt, axis=1), axis=1)
    return bool(np.mean(frequencies <= found) < VERDICT.neighbours)


def _standing_out(base: Refit) -> NDArray[np.bool_]:
    """Which points (n,) stand out from the curve that is free of those furthest off."""
    free, inside = undragged(base)
    n = len(inside)
    if inside.all():
        return ~inside
    # Without the slow curves of the scatter: they follow all but the furthest point of a notch.
    at_all = free.model.stiffness(free.theta, base.fit.measurement.points)
    off = weighted(base.data.mean.stiffness - at_all, base.noise.weights, base.noise.turn)
    squares: Real = off[:n] ** 2 + off[n:] ** 2
    # Further off than one of so many would be by chance; all of a curve that is a little off itself
    # do not stand out.
    # The median of chi-square with two degrees of freedom is ln 4.
    usual = max(1.0, float(np.median(squares) / np.log(4.0)))
    stands_out = squares > 2.0 * usual * f_quantile(1.0 - 1.0 / n, 2.0, base.noise.dof)
    return np.asarray(stands_out)


def _chance_of_pairs(n: int, m: int, pairs: int) -> float:
    """Chance of so many neighbouring pairs or more among m points dealt out over n places.

    C(n-m+1, r) C(m-1, r-1) of all C(n, m) ways make r runs (Wald and Wolfowitz 1940,
    doi:10.1214/aoms/1177731909).
    """
    # So many neighbouring pairs or more are so many runs or fewer.
    ways = sum(comb(n - m + 1, runs) * comb(m - 1, runs - 1) for runs in range(1, m - pairs + 1))
    # A quotient of whole numbers: of many points each of them is beyond any floating-point number.
    return ways / comb(n, m)


def drifted(search: Search) -> bool:
    """Whether repeats differ by a drift: what they tell of the noise is then the drift's size."""
    beyond_chance = search.repeats.p_value < VERDICT.beyond_doubt
    apart = sets_apart(search.base.data)
    # Replicates of specimens differ by slow curves too, but not by one that goes on from run to
    # run. Of what curves of each run explain, not of all: beside a drift there is always scatter.
    return beyond_chance and apart.one_curve and apart.drift > VERDICT.drift_share * apart.curves


def _carried_on(search: Search) -> bool:
    """Whether errors go on from point to point.

    Then the scatter that repeats tell is not the noise.
    """
    chances = search.repeats.parts
    if not chances:
        return False
    in_repeats = max(search.repeats.p_value, chances[OF_NEIGHBOURS]) < VERDICT.beyond_doubt
    # The mean of the repeats holds a part of the same errors, at right angles to what sets them
    # apart: a second witness. Of the product x of two chances that of noise is x - x ln x (Fisher
    # 1932).
    both = chances[OF_NEIGHBOURS] * search.structure.parts["runs"]
    in_both = both - both * float(np.log(both)) < VERDICT.beyond_doubt
    # Where a gain, a slope and a bend of each run are the cause, they are specimens: that is told
    # in a note.
    return (in_repeats or in_both) and sets_apart(search.base.data).curves < VERDICT.own_curves


def _all_but_explained(search: Search) -> bool:
    """Whether named effects explain nearly all of a misfit and leave little beside the noise.

    Real measurements always keep some structure at the level of their noise; it is noted, not made
    the verdict.
    """
    spare = search.base.fit.dof
    # What no specimen makes is no explanation, however well it fits.
    possible = [search.base, *(grown.refit for grown in search.grown if not grown.beyond_physics)]
    best = max(possible, key=lambda refit: refit.log_evidence)
    # The degrees of freedom of the base in both: those that effects spent must not count for them.
    before, after = (refit.rss - spare for refit in (search.base, best))
    small = best.relative_rms < VERDICT.small_rest * best.floor
    return (
        before > spare and after < max(VERDICT.remainder * before, VERDICT.nothing_left) and small
    )


def sentence(
    own: Search,
    evidence: Evidence,
    verdict: Verdict,
    outliers: Sequence[Outlier],
    behind: Column | EqualRows | None,
) -> str:
    """The verdict in words.

    Parameters
    ----------
    own : Search
        Fits and scans of the user's model.
    evidence : Evidence
        By which effects are named.
    verdict : {"adequate", "effect-missing", "unexplained", "inconclusive"}
        Overall.
    outliers : sequence of Outlier
        Points set aside.
    behind : Column or EqualRows or None
        With what the misfit goes that no effect knows.
    """
    ratio = own.base.error / own.base.floor
    error = f"the error is {times(ratio)} the noise floor"
    if verdict == "adequate" and is_arithmetic(own.base):
        size = percent(own.base.error)
        return f"nothing is missing: the error, {size}, is that of arithmetic"
    if verdict == "adequate":
        if outliers:
            # The error is that of the data without them.
            standing = "a single point that stands out by itself"
            if len(outliers) > 1:
                standing = f"{len(outliers)} single points that stand out by themselves"
            error = f"without {standing}, {error}"
        return f"nothing is missing down to the noise floor: {error}"
    if verdict == "effect-missing":
        return f"{error}; missing is {_named(evidence)}{left_of(evidence)}"
    if verdict == "inconclusive":
        return f"{error}; these data cannot tell whether something is missing{_or_bad(own.base)}"
    # Before the other sentences: the error is that of the data without these points, and small.
    if only_points(own, outliers):
        points = "a single point stands out"
        if len(outliers) > 1:
            points = f"{len(outliers)} single points stand out"
        unexplained = f"{points} that no effect of the library explains"
        return f"{error} without outliers: {unexplained}, nothing else is missing"
    # As in the table, only where no test is alarmed; else what the tests see is the news.
    if own.alarm > VERDICT.structure_alarm and (doubt := _of_repeats(own)):
        return f"{error}, but {doubt}"
    # "1 x the noise floor; something is missing" would read as a contradiction.
    if ratio < VERDICT.noisy:
        error = f"{error}, but no pattern of noise"
    missing = "something is missing that no effect of the library explains"
    most, confounded = _most_of_it(own, evidence), _by_confounded(evidence.search)
    if most:
        missing = _taken_by(most, own, evidence)
    elif confounded:
        missing = confounded
    if isinstance(behind, EqualRows):
        # No effect is looked for: none of the library, and none beyond it, tells such rows apart.
        missing = behind.headline
    elif behind is not None:
        missing = f"{missing}: {behind.headline}"
    return f"{error}; {missing}{_if_little(own.base)}"


def _or_bad(base: Refit) -> str:
    """What else may leave more than noise without a pattern, as the end of a sentence."""
    return " or some points are bad" if beyond_floor(base) else ""


def left_of(evidence: Evidence) -> str:
    """What the effects that are named leave, as the end of a sentence."""
    if evidence.rest is not None:
        return f"; what is left looks like {evidence.rest.says}"
    search = evidence.search
    over = search.best.error / search.best.floor
    # As the battery sees it: of noise alone nothing is to be told.
    if over < VERDICT.noisy:
        return ""
    if search.left.p_value < VERDICT.structure_alarm:
        return f"; {times(over)} is left, which no effect explains"
    # Among long tails a bad point is beyond no chance, and carries most of the error all the same.
    if beyond_floor(search.best):
        return f"; {times(over)} is left without a pattern: some points may be bad"
    return ""


def _of_repeats(search: Search) -> str:
    """Why the scatter of repeats is no independent noise; nothing where it may be."""
    if drifted(search):
        return "repeats drift by more than chance: something changed while they were measured"
    if _carried_on(search):
        return "the error of a repeat goes on from point to point: that is no independent noise"
    return ""


def _taken_by(most: Sequence[Grown], own: Search, evidence: Evidence) -> str:
    """How far effects take the error, one of which takes most of it by itself, and what is left."""
    names = " or ".join(grown.names[0] for grown in most)
    best = most[0].refit
    taken = f"{names} takes it to {times(best.error / best.floor)}"
    instead = ""
    # Only of an effect by itself, in the user's own model, was it asked if a drift does as well.
    if evidence.drift is not None and evidence.search is own and own.grown[0].names == (names,):
        instead = f", and so does {evidence.drift.says}"
    # "to 1 x, and something is missing beside it" would be a riddle.
    if best.error >= VERDICT.noisy * best.floor:
        rest = evidence.rest
        if rest is not None:
            return f"{taken}{instead}, and what is left looks like {rest.says}"
        return f"{taken}{instead}, and something is missing beside it that no effect explains"
    return taken + (instead or ", but what has no name in the library explains it better")


def _if_little(base: Refit) -> str:
    """The size of what is missing, where its pattern is certain but perhaps too small to matter."""
    if base.error >= VERDICT.certified:
        return ""
    little = f"{percent(base.error)} of {base.fit.measurement.units.magnitude}"
    # In brackets: the headline may go on, and what follows is not of the fluid.
    return (
        f" (it is little, {little}: a reference fluid is certified to {percent(VERDICT.certified)})"
    )


def _by_confounded(search: Search) -> str:
    """What effects of a condition not varied alone would explain, where no other effect does."""
    # An information criterion drops by twice what the log-evidence gains.
    clear = 0.5 * SEARCH.decisive
    better = [
        each
        for each in search.confounded
        if each.refit.log_evidence > search.best.log_evidence + clear
    ]
    if not better:
        return ""
    names = [grown.names[0] for grown in better]
    if len(names) > VERDICT.most_alike:
        names = [*names[: VERDICT.most_alike], f"one of {len(names) - VERDICT.most_alike} more"]
    shown = names[-1]
    if len(names) > 1:
        shown = f"{', '.join(names[:-1])} or {shown}"
    both = better[0].effects[0].needs & moved_along(search.base.fit.measurement)
    moved = " and ".join(sorted(both))
    left = times(better[0].refit.error / better[0].refit.floor)
    alone = f"the {moved} was not varied by itself"
    return f"{shown} would take it to {left}, but {alone}, and no fit can tell"


def leading_names(own: Search, evidence: Evidence, verdict: Verdict) -> list[str]:
    """Effects that a verdict's sentence names and a user can add, the one to begin with first."""
    # Where a condition that moved explains the data as well, that is to be settled first.
    if evidence.search.confounded:
        return []
    if verdict == "effect-missing":
        rivals = [name for name in evidence.classes[0] if name != evidence.leader]
        return [evidence.leader, *rivals]
    if verdict == "unexplained":
        return [grown.names[0] for grown in _most_of_it(own, evidence)]
    return []


def only_points(own: Search, outliers: Sequence[Outlier]) -> bool:
    """Whether single points were set aside and nothing is left beside them."""
    return bool(outliers) and min(own.scan.p_value, own.structure.p_value) > VERDICT.structure_alarm


def _most_of_it(search: Search, evidence: Evidence) -> list[Grown]:
    """Effects one of which takes most of the error by itself, though something is left.

    That much the user can have.

    Where many do so equally well their names say nothing of the cause.
    """
    possible = [
        grown for grown in search.grown if len(grown.effects) == 1 and not grown.beyond_physics
    ]
    singles = [grown for grown in possible if not grown.effects[0].narrow]
    if not singles or search.gain < SEARCH.decisive:
        return []
    least = singles[0].refit.log_evidence - EVIDENCE.as_good
    # Reversed, so that of several fits of one effect the best, which comes first, stays.
    alike = {
        grown.names[0]: grown for grown in reversed(singles) if grown.refit.log_evidence > least
    }
    if evidence.search is search:
        # One that needs more parameters for the same curve is no reason to withhold a name.
        alone = [one for one in evidence.explanations if len(one.names) == 1]
        chances = {one.names[0]: one.probability for one in alone}
        alike = {name: alike[name] for name in credible(chances) if name in alike}
    enough = VERDICT.takes_most * search.base.relative_rms
    some_leave_more = any(each.refit.relative_rms > enough for each in alike.values())
    if len(alike) > VERDICT.most_alike or some_leave_more:
        return []
    return sorted(alike.values(), key=lambda grown: -grown.refit.log_evidence)


def _named(evidence: Evidence) -> str:
    """The effects one of which is missing, and those one of which is missing beside it."""
    named, beside = evidence.classes[0], evidence.beside
    words = " or ".join(named)
    # "missing is A, and beside it A" would be a riddle.
    if beside and set(beside) == set(named):
        words = f"{words}, and a second of these beside it" if named[1:] else f"{words}, twice"
    elif beside:
        words = f"{words}, and beside it {' or '.join(beside)}"
    if evidence.instead:
        words = f"{words}, or {' and '.join(evidence.instead)} together"
    # Only where the headline names the narrow effect itself: the doubt is not its partners'.
    if evidence.imitators & {*named, *beside}:
        words = f"{words} or another narrow feature"
    return words + _in_place_of(evidence, [*named, *beside])


def _in_place_of(evidence: Evidence, named: Sequence[str]) -> str:
    """What is no effect and may stand in the place of those that are named; empty without such."""
    for other in (evidence.drift, evidence.untold):
        if other is not None and other.effect in named:
            return f", or in place of {other.effect} {other.says}"
    if evidence.moved & set(evidence.classes[0]):
        moved = " and ".join(sorted(moved_along(evidence.search.base.fit.measurement)))
        return f", or a cause along the frequency: the {moved} was not varied by itself"
    if evidence.other_shape > VERDICT.worth_a_word:
        owner = "their" if len(named) > 1 else "its"
        return f" (or, in {owner} place, something of another shape)"
    return ""
