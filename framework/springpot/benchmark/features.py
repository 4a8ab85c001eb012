"""What a problem is like: features that are measured on it, and on no optimiser's results.

Those of a suite are measured with its optimum known, which nobody has for data of his own.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from springpot.identification.native import BoundedDescent
from springpot.identification.problem import SpecimenProblem
from springpot.identification.recorder import Recorder
from springpot.rheology.points import Real

from .plan import stream_of
from .statistics import pooled_ranks


class Look(NamedTuple):
    """How a problem is looked at."""

    starts: int
    samples: int
    """Descents from uniform points of the box, and points at which the objective is looked at."""
    near: float
    """Share of an objective within which two descents have ended in the same valley."""
    easy: float
    """Share of the problems of a suite that are called easy."""


LOOKED = Look(starts=64, samples=1000, near=1e-3, easy=0.5)


@dataclass(frozen=True)
class Features:
    """What a problem is like, its optimum being known.

    Parameters
    ----------
    parameters : int
        That are searched.
    conditioning : float
        Decades between the longest and the shortest axis of the valley's floor.
    smallness : float
        Decades by which the region of the target is smaller than the box, on average over its axes.
    modality : float
        Share of the descents that do not end at the target.
    funnel : float
        Rank correlation of objective and distance from the optimum over the box: near one all ways
        lead down to it, near nothing or below none does.
    lure : float
        Share of the descents that end in the commonest of the wrong valleys, less that of the right
        one: above nothing most are led astray.
    """

    parameters: int
    conditioning: float
    smallness: float
    modality: float
    funnel: float
    lure: float

    @property
    def deceptive(self) -> bool:
        """Whether most descents end in one wrong valley, or nothing falls to the optimum."""
        return self.lure > 0.0 or self.funnel < 0.0

    def to_dict(self) -> dict[str, float]:
        """By name."""
        return {each.name: float(getattr(self, each.name)) for each in fields(self)}


def descents(problem: SpecimenProblem, points: Real) -> tuple[Real, Real]:
    """Where descents within the box end (s, d), from points (s, d), and their objectives (s,)."""
    with np.errstate(all="ignore"):
        return BoundedDescent(Recorder(problem, sys.maxsize)).from_points(points)


def uniform(problem: SpecimenProblem, count: int, seed: int = 0) -> Real:
    """Points (count, d) of the box, always the same."""
    rng = np.random.default_rng(stream_of(seed, "features", problem.dimension))
    return problem.lower + rng.random((count, problem.dimension)) * (problem.upper - problem.lower)


def features_of(problem: SpecimenProblem, optimum: Real, best: float, target: float) -> Features:
    """Measure a problem.

    Parameters
    ----------
    problem : SpecimenProblem
        With its box.
    optimum : ndarray, shape (d,)
        Where it is best.
    best, target : float
        Objective there, and the one that is good enough.
    """
    width = problem.upper - problem.lower
    with np.errstate(all="ignore"):
        _, jacobian = problem.residuals_and_jacobian(optimum)
        values = problem.evaluate(points := uniform(problem, LOOKED.samples, 1))
    stretch = np.linalg.svd(jacobian * width, compute_uv=False)
    stretch = np.maximum(stretch, stretch[0] * np.finfo(float).eps)
    axes = np.minimum(np.sqrt(max(target - best, 0.0)) / stretch, 1.0)
    away = np.linalg.norm((points - optimum) / width, axis=1)
    finite = np.isfinite(values)
    _, ends = descents(problem, uniform(problem, LOOKED.starts))
    right = float(np.mean(ends <= target))
    return Features(
        problem.dimension,
        float(np.log10(stretch[0] / stretch[-1])),
        float(-np.mean(np.log10(axes))),
        1.0 - right,
        float(np.corrcoef(pooled_ranks(values[finite]), pooled_ranks(away[finite]))[0, 1]),
        _commonest(ends[ends > target]) * float(np.mean(ends > target)) - right,
    )


def _commonest(ends: Real) -> float:
    """Share of descents that end at the commonest objective, but for a thousandth of it."""
    if not len(ends):
        return 0.0
    alike = np.abs(ends[:, None] - ends) <= LOOKED.near * np.minimum(ends[:, None], ends)
    return float(np.max(alike.mean(axis=0)))


def parts_of(measured: Mapping[str, Features]) -> dict[str, str]:
    """The part of each problem: ``easy``, ``hard`` or ``deceptive``, by its features.

    Easy are those half of all whose ranks by modality, conditioning, smallness and number of
    parameters are the lowest together. Of the others those are deceptive that lead most descents
    into one wrong valley, or whose objective does not fall towards the optimum.
    """
    names = list(measured)
    keys = ("modality", "conditioning", "smallness", "parameters")
    table = np.array([[getattr(measured[name], key) for key in keys] for name in names])
    ranks = sum(pooled_ranks(column) for column in table.T)
    order = np.argsort(ranks, kind="stable")
    easy = set(order[: int(LOOKED.easy * len(names))].tolist())
    found = {}
    for i, name in enumerate(names):
        found[name] = "hard"
        if i in easy:
            found[name] = "easy"
        elif measured[name].deceptive:
            found[name] = "deceptive"
    return found
