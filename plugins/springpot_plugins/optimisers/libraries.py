"""Optimisers of further libraries, each imported when one of its names is asked for.

Differential evolutions and swarms of the CEC competitions, of minionpy; trust regions without
derivatives by the makers of DFO-LS and Py-BOBYQA; MINUIT, the minimiser of particle physics, by
iminuit; algorithms of pymoo and of nevergrad; and, for evaluations that cost much, Gaussian
processes by bayesian-optimization and LIPO of dlib, whose package is built from source and whose
own cost grows with the evaluations: it is for some hundreds of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from math import inf, log10
from typing import Any, ClassVar

import numpy as np

from springpot.errors import ModelError
from springpot.identification import (
    AskingOptimiser,
    Card,
    Enquiry,
    Optimiser,
    OptimiserFamily,
    Recorder,
)
from springpot.rheology import Real

from .cube import Cube, integer, keep_on, seeded


def _algorithms(
    base: type[Optimiser], prefix: str, library: str, about: Mapping[str, tuple[str, str]]
) -> dict[str, type[Optimiser]]:
    """A class for each algorithm of a library, by our name of it.

    Parameters
    ----------
    base : type of Optimiser
        Whose `algorithm` is the library's name of one.
    prefix, library : str
        Before each of our names, and the distribution that does the work.
    about : mapping of str to tuple of str
        By our name: the library's, and the source of the method.
    """
    made = {}
    for name, (algorithm, citation) in about.items():
        card = Card(f"{algorithm} of {library}", citation, distribution=library)
        space = {"name": prefix + name, "card": card, "algorithm": algorithm}
        # In the module of its base, where a worker finds it by its own name.
        space |= {"__module__": base.__module__, "__doc__": base.__doc__}
        made[prefix + name] = type(f"{base.__name__}_{algorithm}", (base,), space)
    return made


def _family(
    prefix: str,
    offers: str,
    needs: str,
    extra: str,
    kinds: Mapping[str, Mapping[str, type[Optimiser]]],
) -> OptimiserFamily:
    """The optimisers of libraries, which says how to get them where none is installed.

    Parameters
    ----------
    prefix, offers, needs, extra : str
        Before each name, what there is, the libraries in words, and our extra that brings them.
    kinds : mapping of str to mapping of str to type of Optimiser
        By the module that does the work: its optimisers by name.
    """

    def installed() -> dict[str, type[Optimiser]]:
        found: dict[str, type[Optimiser]] = {}
        for module, named in kinds.items():
            if find_spec(module) is not None:
                found |= named
        if not found:
            install = f"pip install 'springpot[{extra}]'"
            raise ModelError(f"optimisers {prefix}... need {needs}: {install}")
        return found

    return OptimiserFamily(f"{prefix}NAME", offers, installed)


_MINION = {
    "lshade": ("LSHADE", "Tanabe and Fukunaga 2014, doi:10.1109/CEC.2014.6900380"),
    "jso": ("jSO", "Brest et al. 2017, doi:10.1109/CEC.2017.7969456"),
    "arrde": ("ARRDE", "Muzakka, github.com/khoirulmuzakka/Minion"),
    "jade": ("JADE", "Zhang and Sanderson 2009, doi:10.1109/TEVC.2009.2014613"),
    "j2020": ("j2020", "Brest et al. 2020, doi:10.1109/CEC48606.2020.9185551"),
    "lshade-cnepsin": ("LSHADE_cnEpSin", "Awad et al. 2017, doi:10.1109/CEC.2017.7969336"),
    "imode": ("IMODE", "Sallam et al. 2020, doi:10.1109/CEC48606.2020.9185577"),
    "agsk": ("AGSK", "Mohamed et al. 2020, doi:10.1109/CEC48606.2020.9185901"),
    "dms-pso": ("DMSPSO", "Liang and Suganthan 2005, doi:10.1109/SIS.2005.1501611"),
    "bipop-acma-es": ("BIPOP_aCMAES", "Hansen and Ros 2010, doi:10.1145/1830761.1830788"),
    "spso-2011": ("SPSO2011", "Zambrano-Bigiarini et al. 2013, doi:10.1109/CEC.2013.6557848"),
    "nl-shade-rsp": ("NLSHADE_RSP", "Stanovov et al. 2021, doi:10.1109/CEC45853.2021.9504959"),
    "lsrtde": ("LSRTDE", "Stanovov and Semenkin 2024, doi:10.1109/CEC60901.2024.10611907"),
}
"""The library's name of an algorithm and the source of the method."""
ENDED_BY_FEW = ("NLSHADE_RSP", "LSRTDE")
"""Algorithms that end the process where they are told of few evaluations.

With up to 7 a parameter the first, and with 20 to 40 the second, reads beyond its own tables in
version 1.9.1.
"""


@dataclass(frozen=True)
class Minion(Optimiser):
    """An algorithm of minionpy in the unit cube, with the library's own settings.

    Its schedules run over the whole budget, as in the competitions.
    """

    algorithm: ClassVar[str] = ""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search once over the budget, and anew with what is left of it."""
        cube = Cube(problem)
        keep_on(problem, lambda: self._attempt(cube, budget - problem.evaluations, rng))

    def _attempt(self, cube: Cube, budget: int, rng: np.random.Generator) -> None:
        from minionpy import Minimizer

        ended: list[BaseException] = []

        def values(points: Real, _: object = None) -> list[float]:
            # An exception that crosses the library comes out as another one: keep it until then.
            if not ended:
                try:
                    return [float(value) for value in cube.batch(np.asarray(points))]
                except BaseException as error:
                    ended.append(error)
            return [inf] * len(points)

        box = [(0.0, 1.0)] * cube.dimension
        if self.algorithm in ENDED_BY_FEW:
            # Fewer are no schedule beside populations of 30 and 20 a parameter; the recorder ends
            # the run.
            budget = max(budget, 60 * cube.dimension)
        Minimizer(values, box, None, self.algorithm, budget, None, integer(rng)).optimize()
        if ended:
            raise ended[0]


MINION = _algorithms(Minion, "minion-", "minionpy", _MINION)
globals().update({kind.__name__: kind for kind in MINION.values()})


@dataclass(frozen=True)
class _TrustRegion(Optimiser):
    """Descents from one uniform start after another, with the library's own settings."""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend until the recorder ends it."""
        cube = Cube(problem)
        solve, objective = self._parts(cube)
        box = np.zeros(cube.dimension), np.ones(cube.dimension)

        def descend() -> None:
            # Never reached: the recorder ends the run when the budget is spent.
            most = budget + 1
            solve(objective, cube.start(rng), bounds=box, maxfun=most, do_logging=False)

        with seeded(rng):
            keep_on(problem, descend)

    def _parts(self, cube: Cube) -> tuple[Callable[..., Any], Callable[[Real], Any]]:
        raise NotImplementedError


class DfoLs(_TrustRegion):
    """A linear model of every residual: the rival of a solver that has their derivatives."""

    name = "dfo-ls"
    card = Card(
        "DFO-LS, linear models of the residuals, multi-start",
        "Cartis et al. 2019, doi:10.1145/3338517",
        globally=False,
        started=True,
        distribution="DFO-LS",
    )

    def _parts(self, cube: Cube) -> tuple[Callable[..., Any], Callable[[Real], Any]]:
        from dfols import solve

        return solve, lambda u: cube.problem.misfit(cube.place(u))


class PyBobyqa(_TrustRegion):
    """A quadratic model of the objective."""

    name = "dfo-bobyqa"
    card = Card(
        "Py-BOBYQA, quadratic models, multi-start",
        "Cartis et al. 2019, doi:10.1145/3338517",
        globally=False,
        started=True,
        distribution="Py-BOBYQA",
    )

    def _parts(self, cube: Cube) -> tuple[Callable[..., Any], Callable[[Real], Any]]:
        from pybobyqa import solve

        return solve, cube


STEP = 0.1
"""First step as a part of the box."""


@dataclass(frozen=True)
class Migrad(Optimiser):
    """Variable metric with numerical derivatives, from one uniform start after another.

    As its users run it: limits by MINUIT's own transformation, strategy 1.

    Parameters
    ----------
    strategy : int
        0, 1 or 2: how much is spent on derivatives.
    """

    strategy: int = 1

    name: ClassVar[str] = "minuit-migrad"
    card: ClassVar[Card] = Card(
        "MIGRAD of MINUIT with numerical derivatives, multi-start (iminuit)",
        "James and Roos 1975, doi:10.1016/0010-4655(75)90039-9",
        globally=False,
        started=True,
        distribution="iminuit",
    )

    def __post_init__(self) -> None:
        self._require("strategy", self.strategy in (0, 1, 2), "0, 1 or 2")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend until the recorder ends it."""
        cube, ended = Cube(problem), list[BaseException]()

        def value(u: Real) -> float:
            # What passes through compiled code may come out as another exception: keep it.
            try:
                return cube(u)
            except BaseException as error:
                ended.append(error)
                raise

        def descend() -> None:
            from iminuit import Minuit

            search = Minuit(value, cube.start(rng))
            search.limits = [(0.0, 1.0)] * cube.dimension
            search.errors = STEP
            search.errordef, search.strategy = Minuit.LEAST_SQUARES, self.strategy
            # Its own is a part of the error of a chi-squared; an objective has no such unit.
            search.tol = 0.0
            try:
                # Never reached: the recorder ends the run when the budget is spent.
                search.migrad(ncall=budget + 1)
            except RuntimeError:
                # The descent is over: where minionpy is in the same process iminuit cannot read its
                # own result, which nobody wants here.
                pass
            finally:
                if ended:
                    raise ended[0]

        keep_on(problem, descend)


_PYMOO = {
    "de": ("DE", "Storn and Price 1997, doi:10.1023/A:1008202821328"),
    "es": ("ES", "Runarsson and Yao 2005, doi:10.1109/TSMCC.2004.841906"),
    "g3pcx": ("G3PCX", "Deb et al. 2002, doi:10.1162/106365602760972767"),
    "ga": ("GA", "Blank and Deb 2020, doi:10.1109/ACCESS.2020.2990567"),
    "pso": ("PSO", "Zhan et al. 2009, doi:10.1109/TSMCB.2009.2015956"),
}
"""The library's name of an algorithm and the source of the method."""


@dataclass(frozen=True)
class Pymoo(Optimiser):
    """An algorithm of pymoo in the unit cube, with the library's own settings."""

    algorithm: ClassVar[str] = ""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search over the budget, and anew where the library ends before."""
        cube = Cube(problem)
        keep_on(problem, lambda: self._attempt(cube, rng))

    def _attempt(self, cube: Cube, rng: np.random.Generator) -> None:
        from pymoo.core.problem import Problem
        from pymoo.optimize import minimize

        class InCube(Problem):  # type: ignore[misc]
            def _evaluate(self, x: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
                out["F"] = cube.batch(np.asarray(x, dtype=float))

        module = import_module(f"pymoo.algorithms.soo.nonconvex.{self.algorithm.lower()}")
        problem = InCube(n_var=cube.dimension, n_obj=1, xl=0.0, xu=1.0)
        minimize(
            problem,
            getattr(module, self.algorithm)(),
            ("n_eval", cube.problem.left),
            seed=integer(rng),
            verbose=False,
        )


PYMOO = _algorithms(Pymoo, "pymoo-", "pymoo", _PYMOO)
globals().update({kind.__name__: kind for kind in PYMOO.values()})


_NEVERGRAD = {
    "ngopt": ("NGOpt", "Meunier et al. 2022, doi:10.1109/TEVC.2021.3108185"),
    "tbpsa": ("TBPSA", "Hellwig and Beyer 2016, doi:10.1007/978-3-319-45823-6_24"),
    "two-points-de": ("TwoPointsDE", "Rapin and Teytaud 2018, github.com/facebookresearch"),
    "one-plus-one": ("OnePlusOne", "Rapin and Teytaud 2018, github.com/facebookresearch"),
}
"""The library's name of an algorithm and the source of the method."""


@dataclass(frozen=True)
class Nevergrad(Optimiser):
    """An algorithm of nevergrad in the unit cube, told the budget, with the library's settings."""

    algorithm: ClassVar[str] = ""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search over the budget, and anew with what an algorithm leaves of it."""
        cube = Cube(problem)
        with seeded(rng):
            keep_on(problem, lambda: self._attempt(cube, rng))

    def _attempt(self, cube: Cube, rng: np.random.Generator) -> None:
        import nevergrad

        left = cube.problem.left
        place: Any = nevergrad.p.Array(shape=(cube.dimension,), lower=0.0, upper=1.0)
        # The only generator that the library knows is of the old kind.
        place.random_state = np.random.RandomState(integer(rng))
        search = nevergrad.optimizers.registry[self.algorithm](place, budget=left)
        for _ in range(left):
            asked = search.ask()
            search.tell(asked, cube(asked.value))


NEVERGRAD = _algorithms(Nevergrad, "nevergrad-", "nevergrad", _NEVERGRAD)
globals().update({kind.__name__: kind for kind in NEVERGRAD.values()})


@dataclass(frozen=True)
class MaxLipo(AskingOptimiser):
    """Upper bounds by a Lipschitz constant that is learnt, in turn with a trust region."""

    name: ClassVar[str] = "lipo-tr"
    card: ClassVar[Card] = Card(
        "LIPO with a trust region (dlib)",
        "Malherbe and Vayatis 2017, arXiv:1703.02628; King 2017, blog.dlib.net",
        distribution="lipo",
    )

    def enquiry(self, dimension: int, budget: int, rng: np.random.Generator) -> Enquiry:
        """A search that can be asked for points."""
        return _Candidates(dimension, integer(rng))


class _Candidates(Enquiry):
    def __init__(self, dimension: int, seed: int) -> None:
        from lipo import GlobalOptimizer

        self._names = [f"u{i:03d}" for i in range(dimension)]
        self._search: Any = GlobalOptimizer(
            lower_bounds=dict.fromkeys(self._names, 0.0),
            upper_bounds=dict.fromkeys(self._names, 1.0),
            log_args=[],
            maximize=False,
            random_state=seed,
        )
        self._out: dict[bytes, Any] = {}

    def ask(self) -> Real:
        """Next point (d,) of the cube."""
        candidate = self._search.get_candidate()
        told = candidate.x
        u = np.array([float(told[name]) for name in self._names])
        self._out[u.tobytes()] = candidate
        return u

    def tell(self, u: Real, value: float) -> None:
        """Take the objective at a point (d,) that was asked for."""
        candidate = self._out.pop(u.tobytes())
        # What is infinite has no upper bound: that candidate stays open.
        if np.isfinite(value):
            candidate.set(value)


LEAST = 1e-12
"""Objective below which its logarithm tells no more."""


@dataclass(frozen=True)
class ExpectedImprovement(AskingOptimiser):
    """A Gaussian process of the objective's logarithm, asked where it expects the most.

    Points that are still being evaluated are taken for as good as the mean of those told (a
    constant liar), so that several can be out at once: as good as the best, the library's own
    choice, it would rather ask anywhere else.

    Parameters
    ----------
    initial : int
        Uniform points before the process is asked; 0 takes two for each parameter.
    xi : float
        Improvement of the logarithm that is not worth an evaluation.
    """

    initial: int = 0
    xi: float = 0.0

    name: ClassVar[str] = "bayesian-ei"
    card: ClassVar[Card] = Card(
        "Gaussian process and expected improvement (bayesian-optimization)",
        "Jones et al. 1998, doi:10.1023/A:1008306431147; Ginsbourger et al. 2010 (constant liar)",
        distribution="bayesian-optimization",
    )

    def __post_init__(self) -> None:
        self._require("initial", self.initial >= 0, "at least 0")
        self._require("xi", self.xi >= 0, "at least 0")

    def enquiry(self, dimension: int, budget: int, rng: np.random.Generator) -> Enquiry:
        """A search that can be asked for points."""
        return _Asked(self, dimension, rng)


class _Asked(Enquiry):
    def __init__(
        self, options: ExpectedImprovement, dimension: int, rng: np.random.Generator
    ) -> None:
        from bayes_opt import BayesianOptimization, acquisition

        self._rng, self._first = rng, options.initial or 2 * dimension
        self._names = [f"u{i:03d}" for i in range(dimension)]
        self._search: Any = BayesianOptimization(
            None,
            dict.fromkeys(self._names, (0.0, 1.0)),
            acquisition_function=acquisition.ConstantLiar(
                acquisition.ExpectedImprovement(xi=options.xi), strategy="mean"
            ),
            random_state=integer(rng),
            verbose=0,
            allow_duplicate_points=True,
        )
        self._asked = self._told = 0

    def ask(self) -> Real:
        """Next point (d,) of the cube."""
        self._asked += 1
        # Before anything is told there is nothing to model.
        if self._asked <= self._first or self._told == 0:
            return self._rng.random(len(self._names))
        with seeded(self._rng):
            asked = self._search.suggest()
        return np.array([float(asked[name]) for name in self._names])

    def tell(self, u: Real, value: float) -> None:
        """Take the objective at a point (d,) that was asked for."""
        if not np.isfinite(value):
            return
        self._told += 1
        # The library climbs.
        height = -log10(max(value, LEAST))
        self._search.register(dict(zip(self._names, u.tolist(), strict=True)), height)


FAMILIES = (
    _family(
        "minion-",
        "L-SHADE, jSO, IMODE, AGSK, ARRDE, SPSO-2011 and others of minionpy",
        "minionpy",
        "race",
        {"minionpy": MINION},
    ),
    _family(
        "dfo-",
        "ls and bobyqa, of DFO-LS and Py-BOBYQA",
        "DFO-LS or Py-BOBYQA",
        "race",
        {"dfols": {DfoLs.name: DfoLs}, "pybobyqa": {PyBobyqa.name: PyBobyqa}},
    ),
    _family(
        "minuit-",
        "migrad of MINUIT, by iminuit",
        "iminuit",
        "race",
        {"iminuit": {Migrad.name: Migrad}},
    ),
    _family("pymoo-", "DE, ES, G3PCX, GA and PSO of pymoo", "pymoo", "pymoo", {"pymoo": PYMOO}),
    _family(
        "nevergrad-",
        "NGOpt, TBPSA, TwoPointsDE and OnePlusOne of nevergrad",
        "nevergrad",
        "nevergrad",
        {"nevergrad": NEVERGRAD},
    ),
    _family(
        "bayesian-",
        "ei: a Gaussian process, by bayesian-optimization",
        "bayes_opt",
        "surrogate",
        {"bayes_opt": {ExpectedImprovement.name: ExpectedImprovement}},
    ),
    _family(
        "lipo-", "tr: LIPO of dlib, by lipo", "lipo", "lipo", {"lipo": {MaxLipo.name: MaxLipo}}
    ),
)
"""Libraries of many optimisers."""
