"""A study as a user declares it, and its resolution into a plan.

A study that is run as a program of its own.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import product
from math import isfinite
from pathlib import Path
from runpy import run_module
from typing import TypeAlias, TypeGuard

import numpy as np

from springpot.constraints import optimiser_of
from springpot.errors import StudyError
from springpot.identification.problem import Objective
from springpot.identification.runs import Optimiser, options_of
from springpot.measurement.covered import OtherTest
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import DataSet, Test
from springpot.registry import open_measurement, parse_model, plugins

from .plan import (
    ASKED,
    COMMON,
    Cell,
    Entrant,
    Plan,
    RaceCase,
    Source,
    case_of,
    cell_digest,
    digest_of,
    with_noise_axis,
)


def main(study: object, arguments: Sequence[str] | None = None) -> None:
    """Run a study as a program.

    What ``springpot run`` does with the path of the script that declares it.

    Raises
    ------
    StudyError
        If the running program is not that script, so that workers could not find what it defines.
    """
    script = getattr(sys.modules["__main__"], "__file__", None)
    if script is None or getattr(sys.modules["__main__"], "study", None) is not study:
        raise StudyError("call study.main() in the script that declares it as study = Study(...)")
    # As the user wrote it where that is the script: the command is told in the report, to be
    # repeated elsewhere.
    written = script
    if Path(sys.argv[0]).resolve() == Path(script).resolve():
        written = sys.argv[0]
    if arguments is None:
        arguments = sys.argv[1:]
    sys.argv = ["springpot", "run", written, *arguments]
    # The command stands above this room and is started like any other program, not imported.
    run_module("springpot", run_name="__main__")


OWN = "own"
"""Stands for a data set's own model or objective where one is named."""

REQUIREMENTS = ("min_success", "max_parameter_error", "max_seconds")
"""Fields of a study that the accuracy gate holds every cell to."""

AnyData: TypeAlias = str | Measurement | DataSet
AnyOptimiser: TypeAlias = str | type[Optimiser] | Optimiser
Labelled: TypeAlias = AnyOptimiser | tuple[str, AnyOptimiser]


@dataclass(frozen=True, eq=False)
class Study:
    """Data sets x models x objectives x optimisers x repetitions.

    Parameters
    ----------
    name : str
        Names the folder under results/.
    datasets : sequence
        Names of registered data sets or files (``name@temperature=20`` chooses rows), of suites of
        problems or one of them (``springpot-60``, ``springpot-60/prony-5``), or `DataSet` or
        `Measurement` objects.
    models : sequence of str, or mapping of str to sequence of str
        Model expressions; ``"own"`` is the data set's own model. A mapping pairs data sets (by
        name) with models; data sets that it does not name get their own.
    objectives : sequence
        Names or `Objective` objects; ``"own"`` is that of a suite's problem.
    optimisers : sequence
        Names, with options as in ``"pso-paper:particles=40"``, classes or instances; ``(label,
        optimiser)`` names an option set.
    repetitions : int
        Trials of each cell.
    budget : int
        Evaluations of each trial.
    seed : int
        Source of all randomness, together with the names of data set, model, objective and the
        repetition.
    target : float
        A trial succeeds once its objective is at most f_best + target (g - f_best), where f_best is
        the best known value of its problem and g the value at the centre of the box, or that of a
        model without any response where this is smaller (after More and Wild 2009,
        doi:10.1137/080724083).
    accuracy : float
        Relative error within which every parameter is right, where the truth is known.
    noise : sequence of float
        Levels of noise, such as ``[0, 0.01, 0.03]``: data of known truth are raced at each of them,
        with a fresh draw of eq. (53), of both signs, for every repetition.
    x0 : {"own", "common"}
        Whether optimisers begin where they like, or all of a repetition get the same first point:
        it is the first evaluation of each, and those that begin at a point begin there.
    asks : sequence of str
        The question, the measure and what would answer it, a sentence or two each: the report says
        them before its tables. Written before the study is run, they cannot follow its result.
    stop_at_target : bool
        End a trial at the target instead of using up the budget, where the optimum in the search
        box is known beforehand, from the native solver or from descents that agree.
    deadline : float
        Seconds after which a trial is ended and counted as failed, from the first value that its
        process asks for: the import of a library is no part of it.
    memory : int
        MiB that a trial may take.
    min_success : float, optional
        Share of every cell's trials that must reach the target, or the accuracy gate fails,
        whatever was before.
    max_parameter_error, max_seconds : float, optional
        Largest relative error of any parameter, and largest time of a trial, that the gate lets
        pass: in the share `min_success` of the trials, in half of them where none is given. Without
        a known truth the error is taken from the baseline's best trial.
    finish : callable, optional
        Called with the path of the store and the folder of the tables after a run, to write what
        else belongs there.

    Raises
    ------
    StudyError
        If a field cannot be used.

    Examples
    --------
    >>> from springpot.benchmark import Study
    >>> data, models = ["artificial-hidden"], ["kelvin"]
    >>> study = Study("small", data, models, ["relative"], ["native"], repetitions=3)
    >>> study.plan().size
    3
    """

    name: str
    datasets: Sequence[AnyData]
    models: Sequence[str] | Mapping[str, Sequence[str]]
    objectives: Sequence[str | Objective]
    optimisers: Sequence[Labelled]
    repetitions: int = 20
    budget: int = 8000
    seed: int = 1
    target: float = 1e-6
    accuracy: float = 0.01
    stop_at_target: bool = False
    deadline: float = 300.0
    memory: int = 2048
    min_success: float | None = None
    max_parameter_error: float | None = None
    max_seconds: float | None = None
    finish: Callable[[Path, Path], None] | None = None
    noise: Sequence[float] = ()
    x0: str = OWN
    asks: Sequence[str] = ()

    def __post_init__(self) -> None:
        # A name is a folder on any system: no slash, no blank, and no dot in front that hides it.
        if not re.fullmatch(r"[A-Za-z0-9][\w.-]*", self.name):
            raise StudyError(
                f"study name '{self.name}' must be letters, digits, '-', '_' or '.': it names a"
                " folder"
            )
        for key in ("datasets", "models", "objectives", "optimisers"):
            value = getattr(self, key)
            # A single name is a sequence too, of letters.
            if isinstance(value, str) or not value:
                raise StudyError(
                    f"study {self.name}: {key} must be a list with at least one entry, such as"
                    " ['...']"
                )
        for key in ("repetitions", "budget", "memory"):
            # 1e4 is how many write ten thousand: what is whole is taken, and kept as what it is.
            object.__setattr__(self, key, self._whole(key))
        for key in ("deadline", "target", "accuracy"):
            self._require(
                key, _is_number(getattr(self, key)) and getattr(self, key) > 0, "a positive number"
            )
            # A store that seals 6 gets 6.0 back from a column of real numbers.
            object.__setattr__(self, key, float(getattr(self, key)))
        self._require_requirements()
        self._require("x0", self.x0 in (OWN, COMMON), f"'{OWN}' or '{COMMON}'")
        self._require(
            "noise", _is_levels(self.noise), "a list of different levels from 0 to below 1"
        )
        object.__setattr__(self, "noise", tuple(sorted(float(level) for level in self.noise)))
        self._require("seed", _is_whole(self.seed), "a whole number")
        # As a plain one: the digests of trials are made of JSON, which knows no other.
        object.__setattr__(self, "seed", int(self.seed))
        self._require(
            "stop_at_target", isinstance(self.stop_at_target, bool | np.bool), "True or False"
        )
        object.__setattr__(self, "stop_at_target", bool(self.stop_at_target))
        self._require(
            "finish", self.finish is None or callable(self.finish), "a function of two paths"
        )
        self._require(
            "asks",
            not isinstance(self.asks, str) and len(self.asks) in (0, len(ASKED)),
            f"{len(ASKED)} sentences: {', '.join(ASKED)}",
        )

    def _require_requirements(self) -> None:
        for key in REQUIREMENTS:
            value = getattr(self, key)
            self._require(
                key, value is None or (_is_number(value) and value > 0), "a positive number"
            )
        self._require(
            "min_success", self.min_success is None or self.min_success <= 1, "a share of at most 1"
        )

    def _whole(self, key: str) -> int:
        value = getattr(self, key)
        self._require(key, _is_whole(value) and value > 0, "a whole number from 1 on")
        return int(value)

    def _require(self, key: str, right: bool, what: str) -> None:
        if not right:
            raise StudyError(
                f"study {self.name}: {key} must be {what}, not {getattr(self, key)!r:.60}"
            )

    def with_options(self, budget: int | None = None, repeats: int | None = None) -> Study:
        """The study with another budget or number of repetitions."""
        study = self
        if budget is not None:
            study = replace(study, budget=budget)
        if repeats is not None:
            study = replace(study, repetitions=repeats)
        return study

    def plan(self) -> Plan:
        """Look everything up.

        Raises
        ------
        SpringpotError
            If a name is unknown, a data set cannot be loaded or two entries share a name.
        """
        sources = tuple(_source(given) for given in _each(self.datasets))
        _unique("data set", [source.name for source in sources], self.name)
        self._require_known([source.name for source in sources])
        entrants = tuple(_entrant(given) for given in self.optimisers)
        _unique("optimiser", [entrant.label for entrant in entrants], self.name)
        _unique(
            "optimiser with options",
            [f"{e.optimiser.name} {e.options}" for e in entrants],
            self.name,
        )
        cases = self._cases(sources)
        plan = Plan(
            self.name,
            cases,
            entrants,
            (),
            self.repetitions,
            self.budget,
            self.seed,
            self.target,
            self.accuracy,
            self.stop_at_target,
            self.deadline,
            self.memory,
            self._requirements(),
            self.x0,
            tuple(self.noise),
            tuple(self.asks),
        )
        pairs = product(range(len(cases)), range(len(entrants)))
        return replace(plan, cells=tuple(_cell(plan, i, c, e) for i, (c, e) in enumerate(pairs)))

    def _requirements(self) -> dict[str, float]:
        """What is required of every cell, by name."""
        given = {key: getattr(self, key) for key in REQUIREMENTS}
        return {key: float(value) for key, value in given.items() if value is not None}

    def _cases(self, sources: tuple[Source, ...]) -> tuple[RaceCase, ...]:
        # The optimum is looked for only where trials end by it: many descents are made for that.
        wanted = None
        if self.stop_at_target:
            wanted = self.target
        cases = []
        for source in sources:
            # Two expressions may name the same model, such as its name and its alias.
            models = dict.fromkeys(self._models_of(source))
            objectives = [self._objective_of(source, given) for given in self.objectives]
            for data, noise in with_noise_axis(source, self.noise, self.seed):
                for model, objective in product(models, objectives):
                    # Of data whose noise is yet to be drawn there is no optimum to find.
                    found = case_of(data, model, objective, None if noise else wanted)
                    cases.append(replace(found, noise=noise))
        return tuple(cases)

    def _objective_of(self, source: Source, given: str | Objective) -> Objective:
        if given != OWN:
            return _objective(given)
        if not source.objective:
            raise StudyError(
                f"study {self.name}: {source.name} has no objective of its own: name one"
            )
        return _objective(source.objective)

    def _require_known(self, names: list[str]) -> None:
        if not isinstance(self.models, Mapping):
            return  # the same models for all data sets
        for name in self.models:
            if name not in names:
                raise StudyError(
                    f"study {self.name}: models are given for '{name}', which is not among the data"
                    " sets"
                )

    def _models_of(self, source: Source) -> list[str]:
        given = self.models
        if isinstance(given, Mapping):
            given = given.get(source.name, (OWN,))
        if OWN in given and not source.model:
            raise StudyError(
                f"study {self.name}: {source.name} has no model of its own: name the models to fit"
            )
        names = []
        for expression in given:
            if expression == OWN:
                expression = source.model
            names.append(parse_model(expression).name)
        return names

    def main(self, arguments: Sequence[str] | None = None) -> None:
        """Run the study as a script: the same as ``springpot run`` with the script's path."""
        main(self, arguments)


def _is_number(value: object) -> TypeGuard[float]:
    # True and False are whole numbers to Python, and to nobody else.
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return False
    return isfinite(value)


def _is_levels(value: object) -> bool:
    """Whether these are levels of noise."""
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray):
        return False
    right = all(_is_number(level) and 0 <= level < 1 for level in value)
    return right and len(set(value)) == len(value)


def _is_whole(value: object) -> TypeGuard[float]:
    return _is_number(value) and value == int(value)


def _each(given: Sequence[AnyData]) -> Iterator[AnyData]:
    """The data sets, each suite as all of its problems."""
    for data in given:
        suite = plugins().shelf("suite").find(data) if isinstance(data, str) else None
        if suite is None:
            yield data
        else:
            yield from (problem.name for problem in suite.problems)


def _source(given: AnyData) -> Source:
    if isinstance(given, Measurement):
        return Source(given.name, (given,), given.digest(), "measured", "", {}, None)
    if isinstance(given, DataSet):
        return _source_of(given.name, given.tests(), given)
    problem = plugins().problem(given)
    if problem is not None:
        return _source_of(given, problem.tests(), problem)
    measurement = open_measurement(given)
    registered = plugins().shelf("data set").find(given.partition("@")[0])
    name = measurement.name
    if registered:
        # As the study writes it: its mapping of models names the data in the same words.
        name = given
    return _source_of(name, (measurement,), registered)


def _source_of(name: str, tests: tuple[Test, ...], card: DataSet | None) -> Source:
    if any(isinstance(test, OtherTest) for test in tests):
        raise StudyError(f"{name}: optimisers are raced on sweeps and tests in time only")
    digests = [test.digest() for test in tests if not isinstance(test, OtherTest)]
    # Of one test its own, as it was before there were several.
    digest = digests[0] if len(digests) == 1 else digest_of(*digests)
    if card is None:
        return Source(name, tests, digest, "measured", "", {}, None)
    # As plain numbers of one kind: digests are made of JSON, in which 1000 and 1000.0 are two
    # things.
    truth = {key: float(value) for key, value in card.truth.items()}
    scale = card.stiffness_scale
    if scale is not None:
        scale = float(scale)
    told = (card.kind, card.model, truth, scale, card.objective, card.best)
    return Source(name, tests, digest, *told)


def _objective(given: str | Objective) -> Objective:
    if not isinstance(given, str):
        return given
    objective: Objective = plugins().find("objective", given)
    return objective


def _entrant(given: Labelled) -> Entrant:
    if isinstance(given, tuple):
        label, optimiser = given
    else:
        label, optimiser = "", given
    if isinstance(optimiser, str):
        optimiser = optimiser_of(optimiser)
    if isinstance(optimiser, type):
        optimiser = optimiser()
    if not isinstance(optimiser, Optimiser):
        raise StudyError(f"{optimiser!r:.60} is no optimiser: give a name, a class or an instance")
    # Options that cannot be written down are refused here, before anything runs.
    options_of(optimiser)
    return Entrant(label or _label(optimiser), optimiser)


def _label(optimiser: Optimiser) -> str:
    """The name, with the options that differ from their defaults."""
    if not is_dataclass(optimiser):
        return optimiser.name
    shown = options_of(optimiser)
    changed = [
        f"{f.name}={shown[f.name]}"
        for f in fields(optimiser)
        if getattr(optimiser, f.name) != f.default
    ]
    if not changed:
        return optimiser.name
    return f"{optimiser.name}({', '.join(changed)})"


def _unique(word: str, names: list[str], study: str) -> None:
    # Trials are known by names: two of one name would be taken for repetitions.
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise StudyError(
            f"study {study}: {word} '{twice[0]}' occurs twice: give one of them another name"
        )


def _cell(plan: Plan, index: int, case: int, entrant: int) -> Cell:
    stop = plan.stop_value(plan.cases[case])
    if plan.stop_at_target and plan.cases[case].noise is not None:
        # Each repetition has its own, from this share of its data.
        stop = plan.target
    digest = cell_digest(
        plan.cases[case], plan.entrants[entrant], plan.budget, plan.seed, stop, plan.x0
    )
    return Cell(index, case, entrant, digest)
