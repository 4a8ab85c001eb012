"""What a plugin may implement; every hook is optional and returns a sequence.

A plugin is any module or object with functions marked by `hookimpl`, named in the entry-point group
``springpot``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import pluggy

# For type checkers only: the rooms below need not be loaded to say what a hook is called.
if TYPE_CHECKING:
    from springpot.identification.problem import Objective
    from springpot.identification.runs import Optimiser, OptimiserFamily
    from springpot.measurement.opening import DataSet, Suite, TimeReader
    from springpot.measurement.reader import Reader
    from springpot.rheology.effect import Effect
    from springpot.rheology.model import Family, Model

GROUP = "springpot"

hookspec = pluggy.HookspecMarker(GROUP)
hookimpl = pluggy.HookimplMarker(GROUP)


@dataclass(frozen=True)
class Race:
    """A small study of optimisers, each data set with its own model.

    Parameters
    ----------
    name : str
        Names its folder.
    datasets, optimisers : tuple of str
        Names.
    objective : str
        How the misfit is measured.
    repetitions, budget : int
        Trials of each cell, and evaluations of each trial.
    """

    name: str
    datasets: tuple[str, ...]
    optimisers: tuple[str, ...]
    objective: str
    repetitions: int
    budget: int


@dataclass(frozen=True)
class Chapter:
    """A part of the demonstration: a command, or a race.

    Parameters
    ----------
    title : str
        What it shows, in one line.
    command : tuple of str
        What a user would type behind ``springpot``; ``{out}`` stands for the folder of the results.
    race : Race, optional
        Run where there is no command.
    left_to_user : bool
        The command is shown only: one that waits for its user, such as a page in a browser, would
        end the story.
    """

    title: str
    command: tuple[str, ...] = ()
    race: Race | None = None
    left_to_user: bool = False


@runtime_checkable
class SolverFormat(Protocol):
    """What the core must know of a format for solvers; `springpot.solvers.Writer` is one."""

    name: str
    summary: str
    suffix: str
    aliases: tuple[str, ...]

    def written(self, handoff: Any) -> str:
        """The text of a model that is handed over."""

    def aspects(
        self, read: Callable[[str, Any], Any] | None = None
    ) -> Mapping[str, Callable[[], Iterable[str]]]:
        """Its contract: what must hold, by name; each yields sentences on what does not."""


@hookspec
def springpot_models() -> Iterable[Model | Family]:  # type: ignore[empty-body]
    """Rheological models, or families of them such as ``prony-N``."""


@hookspec
def springpot_effects() -> Iterable[Effect]:  # type: ignore[empty-body]
    """Physical effects that may be missing; each takes part in the diagnosis of its tests."""


@hookspec
def springpot_optimisers() -> Iterable[type[Optimiser]]:  # type: ignore[empty-body]
    """Optimisers, as classes whose default instance is used."""


@hookspec
def springpot_optimiser_families() -> Iterable[OptimiserFamily]:  # type: ignore[empty-body]
    """Libraries of many optimisers, imported only when one of them is asked for."""


@hookspec
def springpot_objectives() -> Iterable[Objective]:  # type: ignore[empty-body]
    """Ways to measure the misfit."""


@hookspec
def springpot_datasets() -> Iterable[DataSet]:  # type: ignore[empty-body]
    """Registered data sets, loaded only when used."""


@hookspec
def springpot_suites() -> Iterable[Suite]:  # type: ignore[empty-body]
    """Collections of problems on which optimisers are raced, loaded only when used."""


@hookspec
def springpot_readers() -> Iterable[Reader]:  # type: ignore[empty-body]
    """Readers of measurement files, chosen by content."""


@hookspec
def springpot_time_readers() -> Iterable[TimeReader]:  # type: ignore[empty-body]
    """Readers of files with tests in time, chosen by content."""


@hookspec
def springpot_writers() -> Iterable[SolverFormat]:  # type: ignore[empty-body]
    """Formats in which an identified model is handed to a solver."""


@hookspec
def springpot_demo() -> Iterable[Chapter]:  # type: ignore[empty-body]
    """Chapters of ``springpot demo``, in order."""
