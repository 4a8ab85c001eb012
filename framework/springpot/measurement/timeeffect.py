"""Effects that only a test in time can have.

A ramp, a drift, a clock of the material's own, what a record clips.

A test in time goes three ways: what was imposed reaches the specimen, the specimen answers by its
own clock, and something records the answer. An effect of time tests acts at one of these *stages*,
by one vectorised function with its derivatives; everything else (where it shows, how sure it is,
what it cannot be told from) follows from that.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real

from .imposed import Loading
from .timetest import TimeTest

Tries: TypeAlias = Sequence[tuple[float, ...]]


class Stage(Enum):
    """Where on its way from what was imposed to the record an effect acts."""

    LOADING = "loading"
    CLOCK = "clock"
    RESPONSE = "response"


@dataclass(frozen=True, eq=False)
class Record:
    """What a law is told about a test, at each of its samples.

    Attributes
    ----------
    time : ndarray, shape (n,)
        In s since the load first moved; nothing happens before, when it is negative.
    imposed, rate : ndarray, shape (n,)
        What was imposed, and its change per second; steps that take no time have none.
    largest : float
        Largest size of what was imposed.
    cycles : ndarray, shape (n,)
        The way that was gone until each sample, in cycles: four times the largest value each.
    control : {"displacement", "force"}
        Which of the two that was.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import TimeTest
    >>> from springpot.measurement import Record
    >>> test = TimeTest.of_relaxation([0.5, 1.0], [3.0, 2.0])
    >>> Record.of(test, test.time).imposed
    array([1., 1.])
    """

    time: Real
    imposed: Real
    rate: Real
    largest: float
    cycles: Real
    control: str

    @classmethod
    def of(cls, test: TimeTest, at: Real | None = None) -> Record:
        """That of a test, at its own samples or at the times `at` (n,)."""
        t = test.time
        if at is not None:
            t = at
        imposed, rate = followed(test.loading, t)
        largest = float(np.abs(test.loading.value).max())
        # By the knots of the loading, so that it does not matter how many samples are looked at.
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(test.loading.value)))])
        # A cycle takes a load four times its largest value.
        cycles = np.interp(t, test.loading.time, way) / (4.0 * largest)
        return cls(t - test.start, imposed, rate, largest, cycles, test.control)


class Answered(NamedTuple):
    """What a record shows of a response.

    Attributes
    ----------
    value : ndarray, shape (n,)
        What was recorded.
    by_parameters : sequence of ndarray, shape (n,)
        Its derivative by each parameter of the effect.
    by_response : ndarray, shape (n,)
        Its derivative by the response itself.
    """

    value: Real
    by_parameters: Sequence[Real]
    by_response: Real


@dataclass(frozen=True)
class TimeEffect:
    """An effect of tests in time.

    Parameters
    ----------
    name : str
        What users type, such as ``"force-drift"``.
    stage : Stage
        Where it acts.
    parameters : tuple of Parameter
        The first is its *size*: by itself it decides whether the effect is there.
    law : callable
        At the stage LOADING ``law(loading, *parameters)`` gives the `Loading` that reached the
        specimen and its derivative by each parameter, as loadings too. At CLOCK ``law(time,
        *parameters)`` gives the time (n,) by the material's clock at the times (n,) since the load
        first moved, and its derivatives. At RESPONSE ``law(record, response, *parameters)`` gives
        what is recorded of a response (n,), as `Answered`.
    summary : str
        One sentence of physics.
    signature : str
        How it shows in a record: one sentence.
    citation : str
        Source of the law (DOI where there is one).
    controls : tuple of str
        Tests that can have it: those in which the displacement was imposed, the force, or both.
    suits : callable
        Whether a test can show it at all.
    tries : callable, optional
        Values of the parameters from which a search in a test begins; by default those that the
        units suggest.
    aliases : tuple of str
        Other names for the same thing.
    absent_at : float
        Size at which nothing is left of it.
    prior : float
        How common it is beside the others: 1 for what every laboratory meets, less for rarer
        things.
    of_one : bool
        Whether it tells one of several tests from the others, so that it must be said of which:
        ``NAME:TEST``.
    test : str
        The only test that has it; empty where all can.
    """

    name: str
    stage: Stage
    parameters: tuple[Parameter, ...]
    law: Callable[..., Any]
    summary: str
    signature: str
    citation: str = ""
    controls: tuple[str, ...] = ("displacement", "force")
    suits: Callable[[TimeTest], bool] = lambda test: True
    tries: Callable[[TimeTest], Tries] | None = None
    aliases: tuple[str, ...] = ()
    absent_at: float = 0.0
    prior: float = 1.0
    of_one: bool = False
    test: str = ""

    def is_for(self, test: TimeTest) -> bool:
        """Whether a test can have it, and show it."""
        if self.test and self.test != in_expression(test.name):
            return False
        return test.control in self.controls and bool(self.suits(test))

    def of_test(self, name: str) -> TimeEffect:
        """The same effect of one test alone, called ``NAME:TEST``."""
        test = in_expression(name)
        return replace(self, name=f"{self.name}:{test}", test=test, aliases=())

    @cached_property
    def own(self) -> tuple[Parameter, ...]:
        """Its parameters under the names that they have in a model."""
        return tuple(
            parameter.renamed(f"{self.name}.{parameter.name}") for parameter in self.parameters
        )


def in_expression(name: str) -> str:
    """The name of a test as it stands in a model expression, without blanks and signs.

    Examples
    --------
    >>> in_expression("creep 25 C + glue.csv")
    'creep-25-C-glue.csv'
    """
    return re.sub(r"[^\w.]+", "-", name).strip("-")


def followed(loading: Loading, t: Real) -> tuple[Real, Real]:
    """What a loading is at the times t (n,), and how fast it changes there.

    A step is over at its own instant.
    """
    times, sizes = loading.jumps
    # Steps are added by hand, as interpolation knows no two values at one time.
    value = (t[:, None] >= times).astype(float) @ sizes
    smooth = loading.smooth
    if smooth is None:
        return value, np.zeros(len(t))
    if len(smooth.time) < 2:
        return value + smooth.value[0], np.zeros(len(t))
    return value + np.interp(t, smooth.time, smooth.value), _rate(smooth, t)


def _rate(smooth: Loading, t: Real) -> Real:
    """Change per second between samples.

    At a knot the mean of both sides, and nothing beyond the ends.
    """
    slope = np.diff(smooth.value) / np.diff(smooth.time)
    # Before the first knot and after the last one everything rests.
    after = np.concatenate([[0.0], slope, [0.0]])
    left = after[np.searchsorted(smooth.time, t, side="left")]
    right = after[np.searchsorted(smooth.time, t, side="right")]
    rate: Real = 0.5 * (left + right)
    return rate
