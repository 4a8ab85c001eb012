"""What a problem is like, and whether an optimiser prefers some places of the box.

Features of a problem are measured on it, and on no optimiser's results; those of a suite with its
optimum known, which nobody has for data of his own. The bias of an optimiser shows whatever the
problem is: on a flat objective of random numbers the best point should lie anywhere (the test f0 of
Kononova and others 2015, doi:10.1016/j.ins.2014.11.035); on one and the same landscape, moved about
the box, it should do as well at the centre and in a corner as anywhere.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from springpot.errors import StudyError
from springpot.identification.native import BoundedDescent
from springpot.identification.problem import Searched, SpecimenProblem
from springpot.identification.recorder import Recorder
from springpot.identification.runs import Optimiser, run
from springpot.identification.space import SearchSpace
from springpot.registry import parse_model
from springpot.report.page import Entry, Table
from springpot.rheology.points import Real

from .gate.baseline import LEVEL
from .plan import stream_of
from .statistics import a12, holm, mann_whitney_holm, pooled_ranks


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


class TrialSizes(NamedTuple):
    """What an optimiser is tried on."""

    centre: float
    edge: float
    """Shares of the box that are called its centre and its edges: half of it, and a twentieth on
    each side.
    """
    dimension: int
    runs: int
    budget: int


TRIED = TrialSizes(centre=0.5, edge=0.1, dimension=4, runs=60, budget=500)
PLACES = ("anywhere", "centre", "corner")


def box(dimension: int) -> SearchSpace:
    """A cube whose parameters are of one kind, and in the whole of which swarms are born."""
    model = parse_model("kelvin")
    one = np.ones(dimension)
    return SearchSpace(model, (model.parameters[0],) * dimension, 0.0 * one, one, one)


class Formless(Searched):
    """A problem without data."""

    def __init__(self, dimension: int) -> None:
        self.space = box(dimension)

    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """There are none.

        Raises
        ------
        StudyError
            Always: a descent along derivatives has no bias that this could show.
        """
        raise StudyError("the tests of bias are for optimisers without derivatives")


class Flat(Formless):
    """Random numbers, whatever is asked for."""

    def __init__(self, dimension: int, rng: np.random.Generator) -> None:
        super().__init__(dimension)
        self._rng = rng

    def evaluate(self, x: Real) -> Real:
        """Objective (...) at points (..., d)."""
        return np.asarray(self._rng.random(np.shape(x)[:-1]))


class Ripples(Formless):
    """A bowl with ripples around an optimum of which the place is chosen.

    What leaves the box on one side enters it on the other: wherever the optimum is, the same share
    of the box has any value, and blind search does equally well.
    """

    def __init__(self, optimum: Real) -> None:
        super().__init__(len(optimum))
        self._optimum = optimum

    def evaluate(self, x: Real) -> Real:
        """Objective (...) at points (..., d): zero at the optimum."""
        away = (x - self._optimum + 0.5) % 1.0 - 0.5
        return np.asarray(np.sum(away**2 + 0.02 * (1.0 - np.cos(8 * np.pi * away)), axis=-1))


@dataclass(frozen=True, eq=False)
class Bias:
    """What an optimiser did on the two tests.

    Parameters
    ----------
    label : str
        The optimiser.
    found : ndarray, shape (runs, d)
        Best points of the flat objective, in the unit cube.
    reached : mapping of str to ndarray, shape (runs,)
        Objective reached with the optimum anywhere, at the centre, and in a corner.
    """

    label: str
    found: Real
    reached: Mapping[str, Real]

    @property
    def centre(self) -> float:
        """Share of the coordinates in the middle half of the box."""
        return float(np.mean(np.abs(self.found - 0.5) <= 0.5 * TRIED.centre))

    @property
    def edge(self) -> float:
        """Share of the coordinates at the edges."""
        return float(np.mean(np.abs(self.found - 0.5) >= 0.5 - 0.5 * TRIED.edge))

    def chances(self, place: str) -> float:
        """That a run with its optimum at a place ends below one with it anywhere (A12)."""
        return a12(self.reached[place], self.reached["anywhere"])

    def p_values(self) -> Real:
        """Of the tests (5,) that there is no bias.

        Uniform (Cramer and von Mises, the coordinates by Holm), its centre, its edges, and centre
        and corner against anywhere.
        """
        from scipy.stats import binomtest, cramervonmises

        number = self.found.size
        uniform = holm(
            np.array([cramervonmises(column, "uniform").pvalue for column in self.found.T])
        ).min()
        shares = [
            binomtest(round(share * number), number, expected).pvalue
            for share, expected in ((self.centre, TRIED.centre), (self.edge, TRIED.edge))
        ]
        moved = [
            mann_whitney_holm(np.stack([self.reached[place], self.reached["anywhere"]]))[0, 1]
            for place in PLACES[1:]
        ]
        return np.array([uniform, *shares, *moved])


def bias_of(
    optimiser: Optimiser,
    label: str = "",
    dimension: int = TRIED.dimension,
    runs: int = TRIED.runs,
    budget: int = TRIED.budget,
    seed: int = 1,
) -> Bias:
    """Test an optimiser for bias.

    Parameters
    ----------
    optimiser : Optimiser
        One without derivatives.
    label : str
        As it is shown; its name by default.
    dimension, runs, budget, seed : int
        Parameters of the box, runs of each test, evaluations of each run, source of all randomness.

    Raises
    ------
    StudyError
        If it uses derivatives, or a run fails.
    """
    if optimiser.card.gradient:
        raise StudyError(f"{optimiser.name} uses derivatives: the tests of bias are for others")

    def best(problem: Searched, *names: object) -> tuple[Real, float]:
        rng = np.random.default_rng(stream_of(seed, "bias", *names))
        done = run(optimiser, problem, budget, rng)
        if done.failed:
            raise StudyError(f"{optimiser.name}: {done.status}")
        return np.clip(done.point, 0.0, 1.0), done.best

    def numbers(*names: object) -> np.random.Generator:
        return np.random.default_rng(stream_of(seed, "landscape", *names))

    found = [best(Flat(dimension, numbers("flat", i)), "flat", i)[0] for i in range(runs)]
    reached = {}
    for place in PLACES:
        optima = [_placed(place, numbers("optimum", i), dimension) for i in range(runs)]
        values = [best(Ripples(optimum), "moved", i)[1] for i, optimum in enumerate(optima)]
        reached[place] = np.array(values)
    return Bias(label or optimiser.name, np.array(found), reached)


def _placed(place: str, rng: np.random.Generator, dimension: int) -> Real:
    """Where the optimum is."""
    anywhere = rng.random(dimension)
    if place == "centre":
        return np.full(dimension, 0.5)
    if place == "corner":
        return np.round(anywhere)
    return anywhere


def bias_table(name: str, tested: Sequence[Bias]) -> Table:
    """Shares and chances of all, and what is certain of them."""
    rows: list[tuple[Entry, ...]] = []
    p = holm(np.concatenate([each.p_values() for each in tested])).reshape(len(tested), -1)
    for bias, own in zip(tested, p, strict=True):
        rows.append(
            (
                *(bias.label, bias.centre, bias.edge, float(own[:3].min())),
                *(bias.chances("centre"), bias.chances("corner"), float(own[3:].min())),
                _verdict(bias, own),
            )
        )
    columns = (
        *("optimiser", "in the centre", "at the edges", "p (flat)"),
        *("better at the centre", "better in a corner", "p (moved)", "bias"),
    )
    note = (
        f"Flat: the best points of {len(tested[0].found)} runs on random numbers; of a search"
        f" without bias {100 * TRIED.centre:g} % of their coordinates lie in the middle half of the"
        f" box and {100 * TRIED.edge:g} % at its edges. Moved: chance that a run ends lower with"
        " the optimum at the centre, or in a corner, than anywhere, ties by half; one half without"
        " bias: the landscape goes on over the edges, so that blind search does equally well"
        " anywhere. p: the least of the optimiser's, adjusted by Holm over all optimisers and"
        f" tests; bias: what is certain at {100 * LEVEL:g} %."
    )
    return Table(f"{name}: bias", columns, rows, note)


def _verdict(bias: Bias, p: Real) -> str:
    told = []
    uniform, centre, edge, to_centre, to_corner = (p <= LEVEL).tolist()
    if centre:
        told.append("to the centre" if bias.centre > TRIED.centre else "away from the centre")
    if edge:
        told.append("to the edges" if bias.edge > TRIED.edge else "away from the edges")
    if uniform and not told:
        told.append("uneven")
    if to_centre:
        told.append(_better("the centre", bias.chances("centre")))
    if to_corner:
        told.append(_better("a corner", bias.chances("corner")))
    return ", ".join(told) or "none seen"


def _better(place: str, chance: float) -> str:
    if chance > 0.5:
        return f"better at {place}"
    return f"worse at {place}"
