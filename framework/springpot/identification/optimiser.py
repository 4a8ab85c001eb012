"""What an optimiser is: a frozen dataclass of options with a capability card and one method."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Any, ClassVar

import numpy as np

from springpot.errors import OptionError, StudyError

from .recorder import Recorder, RecorderGroup


@dataclass(frozen=True)
class Card:
    """What an optimiser needs and can do.

    Parameters
    ----------
    summary : str
        One sentence on the method.
    citation : str
        Its source.
    globally : bool
        Searches the whole box rather than descending from one point.
    gradient : bool
        Uses exact derivatives.
    batched : bool
        Carries several repetitions side by side: a `BatchedOptimiser`.
    stochastic : bool
        Depends on the generator.
    distribution : str
        The installed distribution that does the work, whose version is written beside results.
    """

    summary: str
    citation: str = ""
    globally: bool = True
    gradient: bool = False
    batched: bool = False
    stochastic: bool = True
    distribution: str = ""


class Optimiser(ABC):
    """Base of all optimisers; a plugin is a frozen dataclass of this with its options as fields."""

    name: ClassVar[str]
    card: ClassVar[Card]

    @abstractmethod
    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search until done or until the recorder ends the run.

        Parameters
        ----------
        problem : Recorder
            Call it for values; it counts, keeps the best point and raises when the budget is spent.
        budget : int
            Evaluations that will be counted before that.
        rng : numpy.random.Generator
            The only source of randomness.
        """

    def _require(self, option: str, holds: bool, rule: str) -> None:
        """Check an option in ``__post_init__``.

        Raises
        ------
        OptionError
            If the rule does not hold.
        """
        if not holds:
            raise OptionError(
                f"{self.name}: option {option} is {getattr(self, option)!r} but must be {rule}"
            )


class BatchedOptimiser(Optimiser):
    """An optimiser that carries several runs side by side; a single run is a batch of one."""

    @abstractmethod
    def minimise_batch(
        self, problems: RecorderGroup, budget: int, rngs: Sequence[np.random.Generator]
    ) -> None:
        """Search as `minimise` does for each run, with bit-identical results.

        Parameters
        ----------
        problems : RecorderGroup
            Values of all runs in one call.
        budget : int
            Evaluations of each run.
        rngs : sequence of numpy.random.Generator
            The only source of randomness of each run.
        """

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search with a batch of one run."""
        self.minimise_batch(RecorderGroup([problem]), budget, [rng])


@dataclass(frozen=True)
class OptimiserFamily:
    """The optimisers of a large library, imported only when one of them is asked for.

    Parameters
    ----------
    name : str
        As listed: what all their names begin with, and ``NAME``, such as ``optimagic-NAME``.
    summary : str
        One sentence on the library.
    members : callable
        Imports the library and gives its optimisers by name.
    """

    name: str
    summary: str
    members: Callable[[], Mapping[str, type[Optimiser]]]

    @property
    def prefix(self) -> str:
        """What all their names begin with."""
        return self.name.removesuffix("NAME")


def options_of(optimiser: Optimiser) -> dict[str, Any]:
    """An optimiser's options as plain values.

    Raises
    ------
    StudyError
        If one of them is no plain value: it could not be told from another.
    """
    # An optimiser without options need not be one.
    if not is_dataclass(optimiser):
        return {}
    return {
        f.name: _plain(getattr(optimiser, f.name), f"{optimiser.name}.{f.name}")
        for f in fields(optimiser)
    }


def _plain(value: Any, where: str) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        # A word of an enumeration may be a string as well.
        if isinstance(value, Enum):
            return value.value
        return value
    if isinstance(value, Enum):
        return _plain(value.value, where)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(item, where) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item, where) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name), where) for f in fields(value)}
    kind = type(value).__name__
    raise StudyError(
        f"option {where} is a {kind}: options must be numbers, texts or sequences of them"
    )
