"""Whether an optimiser prefers some places of the box whatever the problem is.

On a flat objective of random numbers the best point should lie anywhere (the test f0 of Kononova
and others 2015, doi:10.1016/j.ins.2014.11.035); on one and the same landscape, moved about the box,
it should do as well at the centre and in a corner as anywhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from springpot.errors import StudyError
from springpot.identification.problem import Searched
from springpot.identification.runs import Optimiser, run
from springpot.identification.space import SearchSpace
from springpot.registry import parse_model
from springpot.report.page import Entry, Table
from springpot.rheology.points import Real

from .gate.baseline import LEVEL
from .plan import stream_of
from .statistics import a12, holm, mann_whitney_holm


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
