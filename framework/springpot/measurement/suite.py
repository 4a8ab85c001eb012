"""A suite: problems with fixed names on which optimisers are raced, each a data set of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property

from springpot.errors import DataError
from springpot.writing import suggested

from .opening import DataSet


@dataclass(frozen=True)
class Measured:
    """What was measured of a problem, not of an optimiser on it.

    Parameters
    ----------
    part : str
        The part of its suite that it belongs to by these, such as ``hard``.
    features : mapping of str to float
        By name.
    """

    part: str
    features: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Suite:
    """A versioned collection of problems: its name says which version, and nothing in it changes.

    Parameters
    ----------
    name : str
        What users type; its problems are called ``NAME/PROBLEM``.
    summary : str
        One sentence on what it holds.
    load : callable
        Gives the problems, each a `DataSet` with its own model and objective; called only when the
        suite is used.
    measure : callable, optional
        Gives what was measured of each problem, by its name.

    Examples
    --------
    >>> import springpot
    >>> suite = springpot.plugins().find("suite", "springpot-60")
    >>> len(suite.problems)
    60
    """

    name: str
    summary: str
    load: Callable[[], tuple[DataSet, ...]]
    measure: Callable[[], Mapping[str, Measured]] = dict

    @cached_property
    def problems(self) -> tuple[DataSet, ...]:
        """Its problems, in their order."""
        return self.load()

    @cached_property
    def measured(self) -> Mapping[str, Measured]:
        """What was measured of each problem, by its name."""
        return self.measure()

    def problem(self, name: str) -> DataSet:
        """One of them, by its whole name.

        Raises
        ------
        DataError
            If it has none of that name.
        """
        known = {problem.name: problem for problem in self.problems}
        if name in known:
            return known[name]
        # By what follows the suite's own name, which all of them share.
        short = {each.partition("/")[2]: each for each in known}
        near = get_close_matches(name.partition("/")[2], short, n=3)
        hint = f"see '{suggested('list suites', self.name)}'"
        if near:
            hint = f"did you mean {' or '.join(short[each] for each in near)}?"
        raise DataError(f"suite {self.name} has no problem '{name}': {hint}")
