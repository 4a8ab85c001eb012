"""The algorithms of optimagic, which gives those of many libraries one call.

Each an optimiser ``optimagic-...``.

Which there are depends on what is installed beside it: some forty with SciPy and NLopt, a hundred
with the rest. The library takes seconds to import and is imported when one of its names is asked
for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, make_dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

from springpot.errors import ModelError
from springpot.identification import Card, Optimiser, OptimiserFamily, Recorder
from springpot.rheology import Real

from .cube import Cube, integer, keep_on, seeded
from .evolution import UNENDING

PREFIX = "optimagic-"
INSTALL = "pip install 'springpot[optimagic]'"
CITATION = "Gabler and others, optimagic, github.com/optimagic-dev/optimagic"
OWN = frozenset({"seed", "n_cores", "batch_evaluator", "display"})
"""Options that are ours.

The recorder's generator seeds, and a trial has one process and prints nothing.
"""
PLAIN = (bool, int, float, str)
"""What an option may be, to be written in a study and kept in its store."""
LIMITS = frozenset({"stopping_maxfun", "stopping_maxiter"})


@dataclass(frozen=True)
class Unified(Optimiser):
    """An algorithm of optimagic in the unit cube, from uniform starts until the budget is spent."""

    algorithm: ClassVar[str] = ""
    squares: ClassVar[bool] = False
    limits: ClassVar[tuple[str, ...]] = ()
    seeded: ClassVar[bool] = False

    def __reduce__(self) -> tuple[Callable[..., Unified], tuple[str, dict[str, Any]]]:
        # A class that was made on the way has no place from which a worker could import it.
        return _again, (
            self.name,
            {option.name: getattr(self, option.name) for option in fields(self)},
        )

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Start anew until the recorder ends it."""
        misfit = _Misfit(Cube(problem), self.squares, self.card.gradient)
        import nlopt

        with seeded(rng):
            nlopt.srand(integer(rng))
            keep_on(problem, lambda: self._attempt(misfit, rng))

    def _attempt(self, misfit: _Misfit, rng: np.random.Generator) -> None:
        import optimagic

        options = {option.name: getattr(self, option.name) for option in fields(self)}
        options |= dict.fromkeys(self.limits, UNENDING)
        if self.seeded:
            options["seed"] = integer(rng)
        mark = optimagic.mark.scalar
        if self.squares:
            mark = optimagic.mark.least_squares
        jacobian = None
        if self.card.gradient:
            jacobian = mark(misfit.slope)
        dimension = misfit.cube.dimension
        try:
            optimagic.minimize(
                fun=mark(misfit.value),
                params=rng.random(dimension),
                algorithm=self.algorithm,
                algo_options=options,
                jac=jacobian,
                bounds=optimagic.Bounds(lower=np.zeros(dimension), upper=np.ones(dimension)),
                # The recorder keeps the history, and has checked the problem.
                collect_history=False,
                skip_checks=True,
            )
        except Exception:
            # Some algorithms give up loudly, and some libraries turn what ended the run into a
            # fault of their own.
            if misfit.ended is None and misfit.calls == misfit.before:
                raise
        misfit.before = misfit.calls
        if misfit.ended is not None:
            raise misfit.ended


class _Misfit:
    """Value and slope at a point of the cube, evaluated once for both.

    Parameters
    ----------
    cube : Cube
        Where values come from.
    squares : bool
        Whether residuals (2n,) and their Jacobian are asked for, not their sum of squares and its
        gradient.
    graded : bool
        Whether derivatives are wanted at all.
    """

    def __init__(self, cube: Cube, squares: bool, graded: bool) -> None:
        self.cube, self._squares, self._graded = cube, squares, graded
        self._at: Real = np.empty(0)
        self._found: tuple[Any, Any] = (np.inf, None)
        self.ended: BaseException | None = None
        self.calls = self.before = 0

    def value(self, u: Real) -> Any:
        """Objective, or residuals."""
        return self._both(u)[0]

    def slope(self, u: Real) -> Any:
        """Its gradient (d,), or their Jacobian (2n, d)."""
        return self._both(u)[1]

    def _both(self, u: Real) -> tuple[Any, Any]:
        if self.ended is not None:
            # A library that swallowed the end of the run and goes on is told again.
            raise self.ended
        if not np.array_equal(u, self._at):
            try:
                self._found = self._evaluated(np.asarray(u, dtype=np.float64))
            except BaseException as error:
                self.ended = error
                raise
            self._at = np.array(u, dtype=np.float64)
            self.calls += 1
        return self._found

    def _evaluated(self, u: Real) -> tuple[Any, Any]:
        if self._squares:
            problem = self.cube.problem
            residuals, jacobian = problem.residuals(self.cube.place(u))
            return residuals, jacobian * (problem.upper - problem.lower)
        if self._graded:
            return self.cube.gradient(u)
        return self.cube(u), None


@cache
def members() -> Mapping[str, type[Optimiser]]:
    """The algorithms that are installed, by our names of them.

    Raises
    ------
    ModelError
        If optimagic is not installed.
    """
    try:
        from optimagic.algorithms import AVAILABLE_ALGORITHMS
    except ImportError:
        raise ModelError(f"optimisers {PREFIX}... need optimagic: {INSTALL}") from None
    made = {}
    for name, algorithm in sorted(AVAILABLE_ALGORITHMS.items()):
        about: Any = algorithm.algo_info
        # A problem has no second derivatives to offer.
        if about.solver_type.value in ("scalar", "least_squares") and not about.needs_hess:
            kind = _made(name, algorithm)
            made[kind.name] = kind
    return made


def _made(name: str, algorithm: Any) -> type[Unified]:
    """The optimiser of one algorithm, with those options that are plain numbers and words."""
    about, own = algorithm.algo_info, {option.name: option for option in fields(algorithm)}
    options = [
        (option.name, type(option.default), field(default=option.default))
        for option in own.values()
        if option.name not in OWN | LIMITS and isinstance(option.default, PLAIN)
    ]
    squares = about.solver_type.value == "least_squares"
    # Residuals come with their exact Jacobian, so that it costs a least-squares method nothing.
    graded = bool(about.needs_jac) or squares
    space = {
        "__doc__": _explained(name, {option: kind for option, kind, _ in options}),
        "__module__": __name__,
        "name": f"{PREFIX}{name.replace('_', '-')}",
        "card": Card(
            f"{name} of optimagic, restarted",
            CITATION,
            globally=bool(about.is_global),
            gradient=graded,
            distribution="optimagic",
        ),
        "algorithm": name,
        "squares": squares,
        "limits": tuple(sorted(LIMITS & own.keys())),
        "seeded": "seed" in own,
    }
    return make_dataclass(
        f"Optimagic_{name}", options, bases=(Unified,), namespace=space, frozen=True
    )


def _explained(name: str, options: Mapping[str, type]) -> str:
    lines = [
        f"{name} of optimagic, from one uniform start after another until the budget is spent."
    ]
    if options:
        lines += ["", "Parameters", "----------"]
    for option, kind in options.items():
        lines += [
            f"{option} : {kind.__name__}",
            f"    See {name} in optimagic's list of algorithms.",
        ]
    return "\n".join(lines)


def _again(name: str, options: dict[str, Any]) -> Unified:
    kind = members()[name]
    assert issubclass(kind, Unified)
    return kind(**options)


FAMILY = OptimiserFamily(
    f"{PREFIX}NAME",
    "algorithms of SciPy, NLopt, nevergrad, pygmo and others through optimagic",
    members,
)
