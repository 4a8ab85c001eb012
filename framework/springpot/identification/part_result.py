"""One of the tests that an answer rests on: how far the model is off in it, beside its noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import inf, nan
from typing import Any

from springpot.plain_data import jsonable, number, some
from springpot.rheology.points import Real

SWEEP = "sweep"
"""Kind of a test at frequencies."""
AGREE = 1.5
"""A test that the common parameters miss by this many times what its own would leave does not agree
with the others: with the fifty numbers of a usual test that is beyond a chance of 1e-3 (F test)."""

MOST_POINTS = 2**53
"""Samples of all tests together: what a float counts exactly."""


@dataclass(frozen=True)
class PartResult:
    """One test of an answer, the same for a sweep and a test in time.

    Attributes
    ----------
    name, kind : str
        Of the test; ``sweep`` for one at frequencies.
    points : int
        Its points or samples.
    relative_rms, noise_floor : float
        Root mean square of the residual and of the noise, each over that of the signal: point by
        point of a sweep, and of a test in time shared among its samples as its noise is, which
        comes to the same where the noise goes with the signal. The floor is nan where the data are
        too few to tell.
    over_floor : float
        Root mean square of the residuals over their noise.
    over_floor_alone : float
        The same with parameters of its own.
    """

    name: str
    kind: str
    points: int
    relative_rms: float
    noise_floor: float
    over_floor: float
    over_floor_alone: float

    @classmethod
    def of_sweep(cls, name: str, points: int, error: float, floor: float) -> PartResult:
        """A sweep that stands alone."""
        ratio = in_floors(error, floor)
        return cls(name, SWEEP, points, error, floor, ratio, ratio)

    @property
    def agrees(self) -> bool:
        """Whether the common parameters serve this test nearly as well as its own would."""
        # What cannot be told disagrees with nothing; to leave less than the noise is chance: no
        # test is asked for that.
        return not self.over_floor > AGREE * max(self.over_floor_alone, 1.0)

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas."""
        return {**jsonable(vars(self)), "agrees": self.agrees}

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> PartResult:
        """What `to_dict` gave."""
        named = {each.name: row[each.name] for each in fields(cls)}
        for name in ("relative_rms", "noise_floor", "over_floor", "over_floor_alone"):
            named[name] = number(named[name])
        return cls(**named)


def parts_of(rows: Sequence[Mapping[str, Any]]) -> tuple[PartResult, ...]:
    """All tests of an answer, as their `to_dict` gave them."""
    return some(PartResult.from_dict(row) for row in rows)


def spare(tests: Sequence[PartResult], theta: Real) -> int:
    """Samples beyond the parameters (p,), one at least.

    Raises
    ------
    ValueError
        If no test can have so many.
    """
    points = sum(test.points for test in tests)
    if not 0 < points < MOST_POINTS:
        raise ValueError(f"{points} samples are none that tests can have")
    return max(points - len(theta), 1)


def in_time(tests: Sequence[PartResult]) -> bool:
    """Whether a test in time is among them."""
    return any(test.kind != SWEEP for test in tests)


def in_floors(error: float, floor: float) -> float:
    """An error in noise floors: infinite beside no noise, unknown beside an unknown one."""
    if floor > 0.0:
        return error / floor
    if error == 0.0 or floor != floor:
        return nan
    return inf
