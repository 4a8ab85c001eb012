"""Pairs of effects that explain a residual together, also where neither does alone.

Two effects may hide each other: what one adds the other takes away, and no search that adds one at a time begins with
either. In the linear geometry of a fit every pair can be judged at once from the products of their directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.rheology import Model, Real

from .frame import Frame
from .scan import Score

REPRESENTATIVES = 10
"""Directions kept for each effect: the best one, and those least alike it and each other."""
PARALLEL = 0.9995
"""Directions more alike than this are one direction."""


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


def best_pairs(frame: Frame, scores: Sequence[Score], model: Model, theta: Real, count: int) -> list[Pair]:
    """The pairs of effects that should leave least, best first.

    Parameters
    ----------
    frame : Frame
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
    seen = [score for score in scores if score.directions.unit.shape[1]]
    chosen = [_representatives(frame, score) for score in seen]
    unit = np.concatenate([score.directions.unit[:, rows] for score, rows in zip(seen, chosen, strict=True)], axis=1)
    owner = np.repeat(np.arange(len(seen)), [len(rows) for rows in chosen])
    gain, first = _joint_gain(unit, frame.rest)
    best = np.full((len(seen), len(seen)), -np.inf)
    np.maximum.at(best, (owner[:, None], owner[None, :]), gain)
    found = []
    rows = np.concatenate(chosen)
    upper = np.where(np.triu(np.ones_like(best), 1) > 0, best, -np.inf)
    for flat in np.argsort(upper.ravel())[::-1][:count]:
        a, b = divmod(int(flat), len(seen))
        if upper[a, b] <= 0.0:
            break
        inside = np.where((owner[:, None] == a) & (owner[None, :] == b), gain, -np.inf)
        i, j = np.unravel_index(int(np.argmax(inside)), inside.shape)
        sizes = float(first[i, j]), float(first[j, i])
        found.append(_pair(model, theta, (seen[a], seen[b]), (int(rows[i]), int(rows[j])), sizes, float(gain[i, j])))
    return found


def _representatives(frame: Frame, score: Score) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Directions of an effect that differ: the one along the residual, then ever the least like those kept."""
    unit = score.directions.unit
    kept = [int(np.argmax(frame.rest @ unit))]
    alike = np.abs(unit.T @ unit[:, kept[0]])
    while len(kept) < REPRESENTATIVES and alike.min() < PARALLEL:
        kept.append(int(np.argmin(alike)))
        alike = np.maximum(alike, np.abs(unit.T @ unit[:, kept[-1]]))
    return np.array(kept, dtype=np.int64)


def _joint_gain(unit: Real, rest: Real) -> tuple[Real, Real]:
    """Drop of the sum of squares by every two directions together (m, m), and the step along the first (m, m)."""
    cosine = unit.T @ unit
    along = unit.T @ rest
    room = np.maximum(1.0 - cosine**2, 1e-12)
    first = (along[:, None] - cosine * along[None, :]) / room
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
    first, second = scores
    grown = model + first.influence.effect + second.influence.effect
    values = dict(zip(model.names, theta.tolist(), strict=True))
    for score, row, size in zip(scores, rows, sizes, strict=True):
        directions = score.directions
        values |= score.influence.sized(int(directions.setting[row]), size / float(directions.length[row]))
    return Pair(first, second, grown, grown.vector(values), gain)
