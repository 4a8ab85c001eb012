"""The score scan: how much of the residual each effect would explain, before anything is refitted.

Every direction in which an effect could push K is projected off what the fitted parameters can
follow; its score is the squared component of the residual along it, one-sided because the direction
is a physically possible change. Thresholds come from projecting simulated noise in the same way,
jointly over all directions of all effects, so that the number of effects tried, their kinship and
their nuisance grids are all accounted for (Davies 1987, doi:10.1093/biomet/74.1.33, treats one
nuisance parameter; simulation treats any number).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import normal_quantile
from springpot.errors import owned
from springpot.identification.convex import within_material
from springpot.identification.starts import Window, settings
from springpot.measurement.independence import telling
from springpot.measurement.measurement import Measurement
from springpot.measurement.scatter import LEAST_RELATIVE
from springpot.misfit.frame import (
    DRAWN,
    FURTHER,
    LEAST_SEEN,
    Drawn,
    NoiseFrame,
    near_an_alarm,
    relative_to,
)
from springpot.rheology.effect import Effect
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real
from springpot.thresholds import INTERVAL

from ..numerics import ROUNDING, SMALLEST

if TYPE_CHECKING:
    from springpot.misfit.refit import Refit


SMALL = (1e-05, 0.15)
"""Relative changes of K that count as small: there a direction is a tangent."""


class Settings(NamedTuple):
    """How closely all settings of an effect are looked at."""

    of_one: int
    """Settings of an effect of one parameter, over all that is physically possible."""
    of_more: int
    """Settings of an effect of more parameters, beside those for each further one."""
    of_each: int
    """Settings for each further parameter, of a sequence that fills space evenly."""
    kept: int
    """Directions kept of one effect: its grid is finer than the data resolve."""
    told: int
    """Directions kept for each effect: the best one, and those least alike it and each other."""
    starts: int
    """Settings of the grid from which a refit starts beside the tangent."""


SETTINGS = Settings(of_one=64, of_more=96, of_each=160, kept=64, told=10, starts=3)
DRAWS = 3000
"""Simulated residuals, jointly for all effects."""
POWER = float(normal_quantile(INTERVAL))
"""Standard deviations, on one side, of the power at which bounds are stated."""
PARALLEL = 0.9995
"""Directions more alike than this are one direction."""


@dataclass(frozen=True, eq=False)
class Influence:
    """How K changes when an effect joins a fitted model with the model's parameters held.

    Parameters
    ----------
    effect : Effect
        The effect.
    model : Model
        The grown model.
    theta : ndarray, shape (g, p)
        Parameters of the grown model on the grid: the fitted ones and a setting of the effect.
    change : ndarray of complex, shape (g, n)
        K of the grown model minus K of the fitted one.
    relative : ndarray, shape (g,)
        Root mean square of |change| / |K|.
    added : tuple of str
        Names of the effect's own parameters, its size first.
    told : bool
        Whether K is a number at any setting of the whole grid.
    """

    effect: Effect
    model: Model
    theta: Real
    change: Complex
    relative: Real
    added: tuple[str, ...]
    told: bool

    def sized(self, setting: int, factor: float) -> dict[str, float]:
        """Own parameters at a setting, of a size that changes K `factor` times as much."""
        values = {
            name: float(self.theta[setting, self.model.names.index(name)]) for name in self.added
        }
        # What vanishes where it is infinite, such as a rigid mounting, changes K as the reciprocal
        # of its size.
        if self.effect.vanishes_at != 0.0:
            factor = 1.0 / factor
        values[self.added[0]] *= factor
        return values


def influence(
    model: Model, theta: Real, stiffness: Complex, effect: Effect, measurement: Measurement
) -> Influence:
    """What `effect` would change at a fitted model, over a grid of its settings.

    Parameters
    ----------
    model : Model
        The fitted model.
    theta : ndarray, shape (p,)
        Its parameters.
    stiffness : ndarray of complex, shape (n,)
        Its K at the measured points.
    effect : Effect
        The effect that may be missing.
    measurement : Measurement
        The data.
    """
    grown = model + effect
    old = [grown.names.index(name) for name in model.names]
    new = [i for i in range(len(grown.names)) if i not in old]
    added = tuple(grown.parameters[i] for i in new)
    count = SETTINGS.of_one
    if len(added) > 1:
        count = SETTINGS.of_more + SETTINGS.of_each * (len(added) - 1)
    grid = settings(added, Window.of(measurement), count)
    # The model's own parameters stand fixed: their part of the change is projected off later, to
    # first order.
    full = np.empty((len(grid), len(grown.names)))
    full[:, old] = theta
    full[:, new] = grid
    whole = relative_to(stiffness, measurement)
    # Settings beyond what floating-point numbers hold are left out below.
    with np.errstate(all="ignore"):
        with_effect = model.fixed_at(theta) + effect
        change = with_effect.network.respond(grid, measurement.points).value - stiffness
        change = np.where(np.isfinite(change), change, np.nan)
        relative = np.sqrt(np.mean(np.abs(change / whole) ** 2, axis=-1))
    usable = np.isfinite(relative) & (relative > LEAST_RELATIVE)
    names = tuple(parameter.name for parameter in added)
    told = bool(np.any(np.isfinite(relative)))
    return Influence(effect, grown, full[usable], change[usable], relative[usable], names, told)


@dataclass(frozen=True, eq=False)
class Directions:
    """Small settings of an effect as unit directions in which the fitted parameters cannot follow.

    Attributes
    ----------
    setting : ndarray of int, shape (m,)
        Row of the effect's grid.
    unit : ndarray, shape (2n, m)
        Unit directions.
    length : ndarray, shape (m,)
        Whitened change of K along them at this setting.
    share : float
        Largest share of a change that the parameters cannot follow.
    """

    setting: NDArray[np.int64]
    unit: Real
    length: Real
    share: float

    @classmethod
    def of(cls, frame: NoiseFrame, influence: Influence) -> Directions:
        """The directions of an effect at a fit."""
        # Below the least, differences of K are rounding; above the most, a change is no tangent any
        # more.
        is_small = (influence.relative > SMALL[0]) & (influence.relative < SMALL[1])
        small = np.flatnonzero(is_small)[: SETTINGS.kept]
        columns = frame.whiten(influence.change[small]).T
        left = frame.project(columns)
        length = np.sqrt(np.sum(left * left, axis=0))
        share = length / np.maximum(np.sqrt(np.sum(columns * columns, axis=0)), SMALLEST)
        # What the parameters follow but for rounding would be a direction of rounding, and as
        # likely as any to win.
        seen = share > LEAST_SEEN
        unit = left[:, seen] / length[seen]
        return cls(small[seen], unit, length[seen], float(np.max(share, initial=0.0)))


@dataclass(frozen=True, eq=False)
class Score:
    """What the scan says of one effect.

    Attributes
    ----------
    influence : Influence
        The effect and its grid.
    directions : Directions
        The directions that were tried.
    score : float
        Largest squared component of the residual along one of them, in units of noise variance.
    bound : float
        Relative change of K (root mean square) above which the effect would have been seen;
        infinite if never.
    predicted : float
        Whitened residual sum of squares that the effect should leave.
    starts : ndarray, shape (s, p)
        Parameters of the grown model from which a refit should start, best first.
    """

    influence: Influence
    directions: Directions
    score: float
    bound: float
    predicted: float
    starts: Real


@dataclass(frozen=True, eq=False)
class Scan:
    """Scores of all effects at one fit, with the chance that noise alone does as well.

    Attributes
    ----------
    scores : list of Score
        The one that should leave least first.
    p_value : float
        Chance that noise alone gives the best score somewhere in the library.
    threshold : float
        Score that noise alone exceeds with a chance of 1 %.
    mute : dict of str to str
        Effects that give no number whatever their parameters, and that this is why.
    """

    scores: list[Score]
    p_value: float
    threshold: float
    mute: dict[str, str] = field(default_factory=dict)


def scan(
    frame: NoiseFrame,
    influences: Sequence[Influence],
    rng: np.random.Generator | None,
    threshold: float = inf,
) -> Scan:
    """Score all effects at a fit.

    Parameters
    ----------
    frame : NoiseFrame
        The fit.
    influences : sequence of Influence
        What each effect could change.
    rng : numpy.random.Generator or None
        For the simulated noise; without it there are scores but no chances.
    threshold : float
        Score that noise alone exceeds with a chance of 1 %, where that is known already.
    """
    tried = [Directions.of(frame, influence) for influence in influences]
    rest = frame.standard(frame.rest[None, :])[0]
    # Signed: a size below zero is no physics, and a residual the other way is no sign of the
    # effect.
    largest = max((float(np.max(rest @ each.unit, initial=0.0)) for each in tried), default=0.0)
    furthest = largest**2
    p_value = 1.0
    if rng is not None:
        simulated = _simulated_maxima(frame, tried, rng)
        for rounds in FURTHER:
            if not len(simulated) or not near_an_alarm(
                float(np.mean(simulated >= furthest)), len(simulated)
            ):
                break
            more = _simulated_maxima(frame, tried, rng, rounds * DRAWS, frame.has_mirror)
            simulated = np.concatenate([simulated, more])
        if len(simulated):
            threshold = float(np.quantile(simulated, 0.99))
        # The measured one counts as a draw: a chance of zero would be more than the draws can say.
        p_value = (1.0 + float(np.sum(simulated >= furthest))) / (1.0 + len(simulated))
    scores = [
        _score(frame, influence, directions, threshold)
        for influence, directions in zip(influences, tried, strict=True)
    ]
    # By what should be left, not by the score: a large effect leaves its tangent, and its score
    # says too little.
    scores.sort(key=lambda score: score.predicted)
    return Scan(scores, p_value, threshold)


def applicable(library: Sequence[Effect], measurement: Measurement) -> list[Effect]:
    """Effects whose conditions these data tell of.

    What only moved with the frequency is no evidence for them.

    Factors without a law are left out: they can imitate every law.
    """
    columns = telling(measurement)
    unvaried = {name for name, values in measurement.conditions.items() if np.ptp(values) == 0.0}
    # One without parameters has no size to be found.
    sized = [effect for effect in library if effect.element.parameters]
    mine = [effect for effect in sized if effect.applies_to(measurement) and not effect.by_levels]
    shown = [effect for effect in mine if effect.needs <= columns]
    return [effect for effect in shown if not (effect.only_varied and effect.needs & unvaried)]


def shifted_twice(model: Model, effect: Effect) -> bool:
    """Whether a model already has this shift.

    Two of one law are a law with a kink, which is no physics.
    """
    return effect.plane == "shift" and effect.name in {own.name for own in model.effects}


def enough_for(base: Refit, model: Model) -> bool:
    """Whether the data are numbers enough for a grown model."""
    return len(model.names) <= 2 * len(base.fit.measurement)


def scan_effects(
    base: Refit,
    frame: NoiseFrame,
    effects: Sequence[Effect],
    rng: np.random.Generator | None = None,
    threshold: float = inf,
) -> Scan:
    """Score effects at a fit; see `scan`."""
    measurement = base.fit.measurement
    influences = [
        influence(base.model, base.theta, base.stiffness, effect, measurement) for effect in effects
    ]
    found = scan(frame, [each for each in influences if len(each.theta)], rng, threshold)
    names = [each.effect.name for each in influences if not each.told]
    why = "the {} gives no number (nan), whatever its parameters"
    return replace(found, mute={name: why.format(owned("effect", name)) for name in names})


def _simulated_maxima(
    frame: NoiseFrame,
    tried: Sequence[Directions],
    rng: np.random.Generator,
    count: int = DRAWS,
    mirrored: bool = False,
) -> Real:
    """Largest score over the library in each of many draws of noise alone, shape (count,).

    Mirrored, each draw serves twice, with either sign: antithetic variates.
    """
    # All directions against the same draws: their kinship is then in the largest of them.
    unit = np.concatenate(
        [np.zeros((frame.size, 0)), *(each.unit for each in tried)], axis=1
    ).astype(DRAWN)
    if unit.shape[1] == 0:
        return np.zeros(0)
    maxima: list[Drawn] = []
    drawn = count // 2 if mirrored else count
    # In parts, which need a quarter of the memory of the first draws at a time.
    for part in np.array_split(np.arange(drawn), -(-4 * drawn // DRAWS)):
        scores = frame.draws(len(part), rng) @ unit
        maxima.append(np.max(scores, axis=1))
        if mirrored:
            maxima.append(-np.min(scores, axis=1))
    return np.square(np.maximum(np.concatenate(maxima).astype(np.float64), 0.0))


def _score(
    frame: NoiseFrame, influence: Influence, directions: Directions, threshold: float
) -> Score:
    along = np.maximum(frame.rest @ directions.unit, 0.0)
    score = float(np.max(along**2, initial=0.0))
    # A change is seen at threshold plus power, in standard deviations along what the parameters
    # cannot follow.
    needed = (
        (np.sqrt(threshold) + POWER) * influence.relative[directions.setting] / directions.length
    )
    bound = np.inf
    if len(needed) and threshold < np.inf:
        # Nine settings in ten would have been seen at this size; the last may lie where these data
        # hardly show it.
        bound = float(np.quantile(needed, 0.9))
    left = frame.project(frame.whiten(influence.change).T)
    # Settings as they are, beside the tangent: a large change follows its own curve. One beyond all
    # numbers costs endlessly much.
    with np.errstate(over="ignore"):
        cost = np.sum((frame.rest[:, None] - left) ** 2, axis=0)
    starts = influence.theta[np.argsort(cost)[: SETTINGS.starts]]
    if score > 0.0:
        best = int(np.argmax(along))
        # First of the starts, as for a small effect it is nearly the answer.
        tangent = influence.sized(
            int(directions.setting[best]), float(along[best] / directions.length[best])
        )
        starts = np.concatenate([_with(influence, tangent)[None], starts])
    # The better of the tangent and the settings as they are: each holds where the other does not.
    predicted = min(float(np.min(cost)), float(frame.rest @ frame.rest) - score)
    return Score(influence, directions, score, bound, predicted, starts)


def _with(influence: Influence, values: dict[str, float]) -> Real:
    """Parameters (p,) of the grown model with these of the effect's own."""
    theta: Real = influence.theta[0].copy()
    for name, value in values.items():
        theta[influence.model.names.index(name)] = value
    return theta


@dataclass(frozen=True, eq=False)
class Pair:
    """Two effects that explain the residual together.

    Attributes
    ----------
    first, second : Score
        What the scan says of each.
    model : Model
        The model with both.
    start : ndarray, shape (p,)
        Parameters from which its refit should start.
    gain : float
        Drop of the whitened residual sum of squares that both should bring.
    """

    first: Score
    second: Score
    model: Model
    start: Real
    gain: float


def best_pairs(
    frame: NoiseFrame, scores: Sequence[Score], model: Model, theta: Real, count: int
) -> list[Pair]:
    """The pairs of effects that should leave least, best first.

    Parameters
    ----------
    frame : NoiseFrame
        A fit.
    scores : sequence of Score
        The scan on it.
    model : Model
        The fitted model.
    theta : ndarray, shape (p,)
        Its parameters.
    count : int
        How many pairs.
    """
    # All pairs at once, from a few directions of each: whole grids would make some forty times as
    # many pairs.
    seen = [score for score in scores if score.directions.unit.shape[1]]
    if not seen:
        return []
    chosen = [_representatives(frame, score) for score in seen]
    unit = np.concatenate(
        [score.directions.unit[:, rows] for score, rows in zip(seen, chosen, strict=True)], axis=1
    )
    owner = np.repeat(np.arange(len(seen)), [len(rows) for rows in chosen])
    gain, first = _joint_gain(unit, frame.rest)
    best = np.full((len(seen), len(seen)), -np.inf)
    np.maximum.at(best, (owner[:, None], owner[None, :]), gain)
    pairs = []
    rows = np.concatenate(chosen)
    # Of two different effects, each pair once; what is needed twice is sought one by one.
    upper = np.where(np.triu(np.ones_like(best), 1) > 0, best, -np.inf)
    for flat in np.argsort(upper.ravel())[::-1][:count]:
        a, b = divmod(int(flat), len(seen))
        if upper[a, b] <= 0.0:
            break
        inside = np.where((owner[:, None] == a) & (owner[None, :] == b), gain, -np.inf)
        i, j = np.unravel_index(int(np.argmax(inside)), inside.shape)
        sizes = float(first[i, j]), float(first[j, i])
        pairs.append(
            _pair(
                model,
                theta,
                (seen[a], seen[b]),
                (int(rows[i]), int(rows[j])),
                sizes,
                float(gain[i, j]),
            )
        )
    return pairs


def _representatives(frame: NoiseFrame, score: Score) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Directions of an effect that differ.

    The one along the residual, then ever the least like those kept.
    """
    unit = score.directions.unit
    kept = [int(np.argmax(frame.rest @ unit))]
    # Not the best ten: these are neighbours on the grid, and beside a partner another one may be
    # the best.
    alike = np.abs(unit.T @ unit[:, kept[0]])
    while len(kept) < SETTINGS.told and alike.min() < PARALLEL:
        kept.append(int(np.argmin(alike)))
        alike = np.maximum(alike, np.abs(unit.T @ unit[:, kept[-1]]))
    return np.array(kept, dtype=np.int64)


def _joint_gain(unit: Real, rest: Real) -> tuple[Real, Real]:
    """Drop of the sum of squares by each two directions (m, m), and the step along the first."""
    cosine = unit.T @ unit
    along = unit.T @ rest
    room = np.maximum(1.0 - cosine**2, ROUNDING)
    first = (along[:, None] - cosine * along[None, :]) / room
    # Both steps forward, as sizes are; of two directions that are nearly one the difference would
    # be rounding.
    allowed = (first > 0.0) & (first.T > 0.0) & (np.abs(cosine) < PARALLEL)
    return np.where(allowed, along[:, None] * first + along[None, :] * first.T, -np.inf), first


def _pair(
    model: Model,
    theta: Real,
    scores: tuple[Score, Score],
    rows: tuple[int, int],
    sizes: tuple[float, float],
    gain: float,
) -> Pair:
    # Sizes are those of both together: each alone would take the other's part of the residual as
    # well.
    first, second = scores
    grown = model + first.influence.effect + second.influence.effect
    values = model.named(theta)
    for score, row, size in zip(scores, rows, sizes, strict=True):
        directions = score.directions
        values |= score.influence.sized(
            int(directions.setting[row]), size / float(directions.length[row])
        )
    return Pair(first, second, grown, grown.vector(values), gain)


def possible(base: Refit, library: Sequence[Effect]) -> list[Effect]:
    """Candidates that these data are enough for, and that are no part of any material."""
    return [
        effect
        for effect in library
        if enough_for(base, base.model + effect) and not within_material(base.model, effect)
    ]
