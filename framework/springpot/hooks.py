"""What a plugin may implement, and what plugins offer, by kind and name.

A plugin is any module or object with functions marked by `hookimpl`, named in the entry-point group
``springpot``; every hook is optional and returns a sequence. A name or alias that two of them claim
is set aside, never guessed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from inspect import isabstract
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, runtime_checkable

import pluggy

from .errors import PluginError
from .measurement.opening import DataSet, Suite, TimeReader
from .measurement.reader import Reader
from .rheology.effect import Effect
from .rheology.model import Family, Model

if TYPE_CHECKING:
    from .identification.problem import Objective
    from .identification.runs import Optimiser, OptimiserFamily

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


T = TypeVar("T")


@dataclass(frozen=True)
class Kind(Generic[T]):
    """One kind of thing that plugins offer.

    Parameters
    ----------
    word : str
        What one of them is called.
    hook : str
        The hook that offers them.
    accepts : callable
        Whether an object is one.
    title : callable
        Its name.
    """

    word: str
    hook: str
    accepts: Callable[[object], bool]
    title: Callable[[T], str] = lambda item: item.name  # type: ignore[attr-defined]

    def aliases(self, item: T) -> tuple[str, ...]:
        """Its other names.

        Raises
        ------
        PluginError
            If they are no tuple of names.
        """
        aliases = getattr(item, "aliases", ())
        if not isinstance(aliases, tuple | list) or not all(
            isinstance(alias, str) for alias in aliases
        ):
            raise PluginError(
                f"{self.hook}: aliases must be a tuple such as ('{self.title(item)}-2',),"
                f" not {aliases!r}"
            )
        return tuple(aliases)


@dataclass(frozen=True)
class Owner:
    """The plugin that offers something.

    Parameters
    ----------
    plugin, distribution : str
        Entry point and the installed distribution it comes from.
    """

    plugin: str
    distribution: str

    def __str__(self) -> str:
        return f"plugin '{self.plugin}' of {self.distribution}"


@dataclass(eq=False)
class Shelf(Generic[T]):
    """All things of one kind by name, with the plugin each came from.

    Attributes
    ----------
    items : dict of str to T
        The first thing of every name.
    owners : dict of str to str
        The plugin that offered it.
    clashes : dict of str to str
        Names and aliases in dispute, each with the sentence that names both sides.
    """

    kind: Kind[T]
    items: dict[str, T] = field(default_factory=dict)
    owners: dict[str, str] = field(default_factory=dict)
    clashes: dict[str, str] = field(default_factory=dict)
    _from: dict[str, Owner] = field(default_factory=dict)
    _by_alias: dict[str, str] = field(default_factory=dict)

    def put(self, item: T, owner: Owner) -> None:
        """Add `item`.

        Raises
        ------
        PluginError
            If it has no name, or one that is taken, or its aliases are no names.
        """
        name = self.kind.title(item)
        # Asked for its refusal alone: an item whose aliases are no names must not be entered by
        # half.
        self.kind.aliases(item)
        if not isinstance(name, str) or not name.strip():
            raise PluginError(f"{self.kind.hook} offers a {self.kind.word} without a name")
        if name in self.items:
            raise PluginError(self._twice(name, owner))
        self.items[name], self.owners[name], self._from[name] = item, owner.plugin, owner

    def _twice(self, name: str, owner: Owner) -> str:
        first, what = self._from[name], f"{self.kind.word} '{name}'"
        # Within one plugin it is a slip of its author, and no doubt for a user.
        if first == owner:
            return f"{what} is offered twice; the first is used"
        self.clashes[name] = (
            f"{what} is offered by two plugins, {first} and {owner}: uninstall one or rename it"
        )
        return self.clashes[name]

    def disputes(self) -> Iterator[tuple[Owner, str]]:
        """Enter aliases and look for disputes once all is offered.

        Yields each with the plugin that is at fault.
        """
        for name, item in self.items.items():
            for alias in self.kind.aliases(item):
                says = self._enter(alias, name)
                if says:
                    yield self._from[name], says
        for family in [item for item in self.items.values() if isinstance(item, Family)]:
            for name in [*self.items, *self._by_alias]:
                if family.number(name) is None:
                    continue
                # One name for two things, though no plugin offers the member by itself.
                owner = self._from[self._by_alias.get(name, name)]
                other = f"the family {family.name} of {self._from[family.name]}"
                self.clashes[name] = (
                    f"{self.kind.word} '{name}' of {owner} is also a member of {other}: rename it"
                )
                yield owner, self.clashes[name]

    def _enter(self, alias: str, name: str) -> str:
        """Let `alias` mean `name`; what is wrong with that, or nothing."""
        what, owner = f"alias '{alias}' of {self.kind.word} '{name}'", self._from[name]
        if alias in self.items:
            # A canonical name is never in doubt: only the alias gives way.
            other = f"the name of another, of {self._from[alias]}"
            if alias == name:
                other = "its own name"
            return f"{what} is {other}; the alias is not used"
        # An alias is no more than a second name: where two things claim it, the name of each still
        # serves.
        first = self._by_alias.setdefault(alias, name)
        if first == name:
            return ""
        self.clashes[alias] = (
            f"{what} of {owner} is also an alias of '{first}' of {self._from[first]}: use one of"
            " these two names"
        )
        return self.clashes[alias]

    def find(self, name: str) -> T | None:
        """The item of that name or alias.

        Raises
        ------
        PluginError
            If two claim it.
        """
        # Told here, not at the start: a name in dispute is no trouble to who never asks for it.
        if name in self.clashes:
            raise PluginError(self.clashes[name])
        return self.items.get(self._by_alias.get(name, name))

    def owner(self, name: str) -> Owner | None:
        """The plugin that offers the item of that name or alias."""
        return self._from.get(self._by_alias.get(name, name))

    def undisputed(self) -> dict[str, T]:
        """What can be used, by name."""
        # A name that two claim would mean another thing once one of them is installed first:
        # neither is used.
        return {name: item for name, item in self.items.items() if name not in self.clashes}

    def known(self) -> list[str]:
        """All names and aliases that can be used."""
        return [name for name in (*self.items, *self._by_alias) if name not in self.clashes]


# The solver, and SciPy's algebra with it, is loaded by those who ask for it: not to look at a file.
def _is_optimiser(item: object) -> bool:
    from springpot.identification.runs import Optimiser

    # An abstract class lacks what it should have written, and would fail only when somebody uses
    # it.
    return isinstance(item, type) and issubclass(item, Optimiser) and not isabstract(item)


def _is_family(item: object) -> bool:
    from springpot.identification.runs import OptimiserFamily

    return isinstance(item, OptimiserFamily)


def _is_objective(item: object) -> bool:
    from springpot.identification.problem import Objective

    return isinstance(item, Objective)


def _model_name(item: Model | Family) -> str:
    if isinstance(item, Model):
        return item.base
    return item.name


KINDS: dict[str, Kind[Any]] = {
    kind.word: kind
    for kind in (
        Kind[Any](
            "model", "springpot_models", lambda x: isinstance(x, Model | Family), _model_name
        ),
        Kind[Any]("effect", "springpot_effects", lambda x: isinstance(x, Effect)),
        Kind[Any]("optimiser", "springpot_optimisers", _is_optimiser),
        Kind[Any]("optimiser family", "springpot_optimiser_families", _is_family),
        Kind[Any]("objective", "springpot_objectives", _is_objective),
        Kind[Any]("data set", "springpot_datasets", lambda x: isinstance(x, DataSet)),
        Kind[Any]("suite", "springpot_suites", lambda x: isinstance(x, Suite)),
        Kind[Any]("reader", "springpot_readers", lambda x: isinstance(x, Reader)),
        Kind[Any]("time reader", "springpot_time_readers", lambda x: isinstance(x, TimeReader)),
        Kind[Any]("writer", "springpot_writers", lambda x: isinstance(x, SolverFormat)),
        Kind[Any]("chapter", "springpot_demo", lambda x: isinstance(x, Chapter), lambda x: x.title),
    )
}
