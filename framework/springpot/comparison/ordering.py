"""Models in order: the simplest that does what any material can comes first.

Of sweeps and of tests in time alike; see `springpot.comparison.comparing.rank`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from springpot.diagnosis.ladder import Ladder
from springpot.diagnosis.result import Progress
from springpot.identification.held_material import is_relaxing
from springpot.identification.material import is_material
from springpot.misfit.frame import chance_of_squares
from springpot.misfit.residual_tests import Finding
from springpot.rheology.effect import Effect
from springpot.rheology.model import Family, Model
from springpot.thresholds import COMPARISON, SEARCH, VERDICT

from .result import Judgement, RankedFit, Ranking, Skipped

TOO_FREE = (
    "what a free spectrum leaves is less,"
    " but by it none or only models of many parameters would be adequate"
)
"""Why the floor of any material is not taken."""
FIRST_MEMBER, LAST_MEMBER = 2, 6
"""Members of a family of sums that are tried; the first of each has a name of its own."""


class Order(NamedTuple):
    """Models sorted out, each list with its best first.

    Attributes
    ----------
    adequate, near, others : list of Judgement
        As in a ranking.
    outgrown : bool
        Whether the floor of any material may be too low: none is adequate though that material is,
        or the first adequate one spends most of the numbers, or simpler ones as near as any
        material are beyond the floor.
    """

    adequate: list[Judgement]
    near: list[Judgement]
    others: list[Judgement]
    outgrown: bool

    def ranking(
        self,
        ladder: Ladder,
        notes: Iterable[str],
        skipped: Iterable[Skipped],
        harmonics: tuple[Finding, ...] = (),
        one_test: str = "",
    ) -> Ranking:
        """All models in this order.

        Parameters
        ----------
        ladder : Ladder
            The discovery that told what any material needs.
        notes : iterable of str
            What a user should know; empty ones are none.
        skipped : iterable of Skipped
            Models that cannot be judged.
        harmonics, one_test
            As in a `Comparison`, of sweeps alone.
        """
        judged = (*self.adequate, *self.near, *self.others)
        told = tuple(dict.fromkeys(filter(None, notes)))
        adequate, near, out = tuple(self.adequate), tuple(self.near), tuple(dict.fromkeys(skipped))
        return Ranking(ladder.data, judged, harmonics, told, one_test, ladder, adequate, near, out)


def in_order(judged: Iterable[Judgement], material: Judgement) -> Order:
    """Sort models out.

    Parameters
    ----------
    judged : iterable of Judgement
        All of them.
    material : Judgement
        Any material with the effects that it needs, in units of the same noise.
    """
    # Those that are not adequate stand by evidence: how few parameters a model has is no merit
    # while it fails.
    # Those that differ by nothing that is printed stay in the order in which they were given.
    ordered, floor = sorted(judged, key=lambda one: round(one.delta_bic, 2)), material.ranked
    near_enough = [one for one in ordered if chance_beside(one.ranked, floor) >= COMPARISON.chance]
    as_near = [one for one in near_enough if not _outdone(one, ordered)]
    # The fewest parameters first. Sorting keeps the order of equals: of as many parameters the
    # likelier comes first.
    as_near.sort(key=lambda one: len(one.ranked.theta))
    adequate = _no_worse_than_rejected([one for one in as_near if one.adequate], ordered)
    near: list[Judgement] = []
    # Where a material is adequate, a model that is not lacks what the material has: only chance
    # made it as near.
    if not material.adequate:
        near = [one for one in as_near if one not in adequate]
    others = [one for one in ordered if one not in adequate and one not in near]
    # Where any material is far beyond the floor, no smaller noise is to blame.
    outgrown = not near and material.error.relative_rms < VERDICT.small_rest * floor.floor
    if adequate:
        outgrown = adequate[0] is not as_near[0] or spends_most(adequate[0].ranked)
    return Order(adequate, near, others, outgrown)


def _no_worse_than_rejected(
    adequate: Sequence[Judgement], ordered: Sequence[Judgement]
) -> list[Judgement]:
    """The adequate models that are nearer than every inadequate one of no more parameters.

    The fewer numbers a model leaves to judge it by, the larger an error passes for noise: without
    this a richer model could be adequate at an error at which a simpler one is not.
    """
    rejected = [one for one in ordered if one not in adequate]
    return [
        one for one in adequate if not any(_is_simpler_and_nearer(other, one) for other in rejected)
    ]


def _is_simpler_and_nearer(other: Judgement, one: Judgement) -> bool:
    if len(other.ranked.theta) > len(one.ranked.theta):
        return False
    # Crosswise, as a floor may be zero.
    floor, others = one.ranked.floor, other.ranked.floor
    # Of most models the fits by the noise tell, and neither error need be searched for.
    if other.ranked.least_error * floor > one.ranked.relative_rms * others:
        return False
    return other.error.relative_rms * floor <= one.error.relative_rms * others


def chance_beside(found: RankedFit, floor: RankedFit) -> float:
    """Chance that a free spectrum gains so much on a model from noise alone.

    The gain is that in chi-square, with as many degrees of freedom as the spectrum has lines more
    than the model has parameters. Where any material leaves more than noise, that remainder is not
    the model's fault and sets the scale.

    Parameters
    ----------
    found : RankedFit
        The model.
    floor : RankedFit
        Any material, in units of the same noise.
    """
    spare = max(found.dof - floor.dof, 1)
    # Never below one: a spectrum that follows some of the noise must not make the noise seem
    # smaller than it is.
    scale = max(floor.rss / max(floor.dof, 1), 1.0)
    return chance_of_squares(max(found.rss - floor.rss, 0.0) / scale, spare, found.noise_dof)


def _outdone(one: Judgement, others: Sequence[Judgement]) -> bool:
    """Whether a richer model is decisively better; that a simpler one does as well is no fault."""
    # Of computed data only rounding is left, and it is no merit to follow that.
    if one.computed:
        return False
    # A free spectrum may fail to gain beyond chance where a model of a few more parameters does.
    limit, size = one.delta_bic - SEARCH.decisive, len(one.ranked.theta)
    better = [
        other for other in others if other.delta_bic < limit and len(other.ranked.theta) > size
    ]
    # What one that spends most of the numbers gains on a model at the noise is noise that it
    # follows.
    if one.at_noise:
        better = [other for other in better if not spends_most(other.ranked)]
    return bool(better)


def spends_most(found: RankedFit) -> bool:
    """Whether a model has more parameters than it leaves numbers to judge them by."""
    return len(found.theta) > COMPARISON.most_spent * found.numbers


F = TypeVar("F", bound=RankedFit)
Fits: TypeAlias = Callable[[Model, tuple[Effect, ...]], Iterable[F]]


def fits_of(
    installed: Sequence[Model | Family],
    floor: RankedFit,
    one: Fits[F],
    progress: Progress,
) -> list[F]:
    """All models with the effects that any material needs, or without them.

    Without them only what may make by itself what a spectrum cannot: the others are no nearer than
    any material alone, which needs the effects.

    Parameters
    ----------
    installed : sequence of Model or Family
        Of a family, members up to the first that lacks nothing or gains nothing.
    floor : RankedFit
        Any material with the effects.
    one : callable
        Gives the fit of a model with some effects, or none where the data cannot judge it.
    progress : callable
        Told in a few words what is being done.
    """
    fits: list[F] = []
    effects = floor.model.effects
    for number, item in enumerate(installed, 1):
        progress(f"fitting model {number} of {len(installed)}{_with(effects)}: {item.name}")
        fits += _members(item, effects, floor, one)
        if effects and isinstance(item, Model) and not is_relaxing(item):
            fits += one(item, ())
    return fits


def _members(
    item: Model | Family, effects: tuple[Effect, ...], floor: RankedFit, one: Fits[F]
) -> Iterator[F]:
    """Fits of a model; of a family, members up to the first that lacks nothing or gains nothing."""
    if isinstance(item, Model):
        # The material itself is what all are judged by.
        if not is_material(item):
            yield from one(item, effects)
        return
    evidence = -np.inf
    for number in range(FIRST_MEMBER, min(LAST_MEMBER, item.largest) + 1):
        for found in one(item.build(number), effects):
            yield found
            # One more term after that can only follow noise, and each costs a fit of more
            # parameters.
            if found.log_evidence <= evidence or chance_beside(found, floor) >= COMPARISON.chance:
                return
            evidence = found.log_evidence


def _with(effects: tuple[Effect, ...]) -> str:
    if not effects:
        return ""
    return f" with {' and '.join(effect.name for effect in effects)}"
