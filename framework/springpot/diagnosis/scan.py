"""The score scan: how much of the residual each effect would explain, before anything is refitted.

Every direction in which an effect could push K is projected off what the fitted parameters can follow; its score is
the squared component of the residual along it, one-sided because the direction is a physically possible change.
Thresholds come from projecting simulated noise in the same way, jointly over all directions of all effects, so that
the number of effects tried, their kinship and their nuisance grids are all accounted for (Davies 1987,
doi:10.1093/biomet/74.1.33, treats one nuisance parameter; simulation treats any number).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Real

from .directions import Influence
from .frame import Frame
from .structure import EDGE, MORE

SMALL = (1e-5, 0.15)
"""Relative changes of K that count as small: there a direction is a tangent."""
ABSORBED = 1e-3
"""A direction of which less than this is left after projection cannot be seen in these data."""
PER_EFFECT = 64
DRAWS = 3000
WHOLE_STARTS = 3
POWER = 1.645
"""One-sided normal quantile of the 95 % power at which bounds are stated."""


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
    def of(cls, frame: Frame, influence: Influence) -> Directions:
        """The directions of an effect at a fit."""
        small = np.flatnonzero((influence.relative > SMALL[0]) & (influence.relative < SMALL[1]))[:PER_EFFECT]
        columns = frame.whiten(influence.change[small]).T
        left = frame.project(columns)
        length = np.sqrt(np.sum(left * left, axis=0))
        share = length / np.maximum(np.sqrt(np.sum(columns * columns, axis=0)), 1e-300)
        seen = share > ABSORBED
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
        Relative change of K (root mean square) above which the effect would have been seen; infinite if never.
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
    """

    scores: list[Score]
    p_value: float
    threshold: float


def scan(
    frame: Frame, influences: Sequence[Influence], rng: np.random.Generator | None, threshold: float = inf
) -> Scan:
    """Score all effects at a fit.

    Parameters
    ----------
    frame : Frame
        The fit.
    influences : sequence of Influence
        What each effect could change.
    rng : numpy.random.Generator or None
        For the simulated noise; without it there are scores but no chances.
    threshold : float
        Score that noise alone exceeds with a chance of 1 %, where that is known already.
    """
    tried = [Directions.of(frame, influence) for influence in influences]
    simulated = np.zeros(0) if rng is None else _simulated_maxima(frame, tried, rng)
    rest = frame.standard(frame.rest[None, :])[0]
    along = max((float(np.max(rest @ each.unit, initial=0.0)) for each in tried), default=0.0)
    if rng is not None and EDGE[0] < float(np.mean(simulated >= along**2)) < EDGE[1]:
        simulated = np.concatenate([simulated, *(_simulated_maxima(frame, tried, rng) for _ in range(MORE))])
    threshold = float(np.quantile(simulated, 0.99)) if len(simulated) else threshold
    scores = [
        _score(frame, influence, directions, threshold)
        for influence, directions in zip(influences, tried, strict=True)
    ]
    scores.sort(key=lambda score: score.predicted)
    p_value = (1.0 + float(np.sum(simulated >= along**2))) / (1.0 + len(simulated)) if len(simulated) else 1.0
    return Scan(scores, p_value, threshold)


def _simulated_maxima(frame: Frame, tried: Sequence[Directions], rng: np.random.Generator) -> Real:
    """Largest score over the library in each of many draws of noise alone, shape (draws,)."""
    unit = np.concatenate([np.zeros((frame.size, 0)), *(each.unit for each in tried)], axis=1).astype(np.float32)
    if unit.shape[1] == 0:
        return np.zeros(0)
    maxima = np.empty(DRAWS)
    for part in np.array_split(np.arange(DRAWS), 4):
        noise = frame.draws(len(part), rng).astype(np.float32)
        maxima[part] = np.max(noise @ unit, axis=1)
    return np.asarray(np.square(np.maximum(maxima, 0.0)), dtype=np.float64)


def _score(frame: Frame, influence: Influence, directions: Directions, threshold: float) -> Score:
    along = np.maximum(frame.rest @ directions.unit, 0.0)
    score = float(np.max(along**2, initial=0.0))
    needed = (np.sqrt(threshold) + POWER) * influence.relative[directions.setting] / directions.length
    bound = float(np.quantile(needed, 0.9)) if len(needed) and threshold < np.inf else np.inf
    left = frame.project(frame.whiten(influence.change).T)
    cost = np.sum((frame.rest[:, None] - left) ** 2, axis=0)
    starts = influence.theta[np.argsort(cost)[:WHOLE_STARTS]]
    if score > 0.0:
        best = int(np.argmax(along))
        tangent = influence.sized(int(directions.setting[best]), float(along[best] / directions.length[best]))
        starts = np.concatenate([_with(influence, tangent)[None], starts])
    predicted = min(float(np.min(cost)), float(frame.rest @ frame.rest) - score)
    return Score(influence, directions, score, bound, predicted, starts)


def _with(influence: Influence, values: dict[str, float]) -> Real:
    """Parameters (p,) of the grown model with these of the effect's own."""
    theta: Real = influence.theta[0].copy()
    for name, value in values.items():
        theta[influence.model.names.index(name)] = value
    return theta
