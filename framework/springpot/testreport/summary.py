"""The cycles of a test with their intervals, their means over a range, and the law of the speed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from springpot.distributions import f_quantile, student
from springpot.errors import DataError, OptionError
from springpot.numerics import FEWEST
from springpot.rheology.points import STEADY, Real
from springpot.thresholds import INTERVAL, WHERE

from .quantities import BY_NAME, QUANTITIES, Cycle, cycles_of, energy_of
from .record import WINDOW, Estimate, Found, LoopRecord, find_cycles


class Told(NamedTuple):
    """A number with its interval.

    Attributes
    ----------
    value, low, high : float
        The ends hold it in 95 of 100 cases.
    sd, freedom : float
        Standard deviation and its degrees of freedom; infinite for that of the noise.
    source : str
        ``noise`` of the record, or ``cycles``: their scatter, where that is more than noise makes.
    """

    value: float
    low: float
    high: float
    sd: float
    freedom: float
    source: str

    @classmethod
    def of(cls, value: float, sd: float, freedom: float, source: str) -> Told:
        """With the interval that Student's t gives."""
        reach = student(INTERVAL, freedom) * sd
        return cls(value, value - reach, value + reach, sd, freedom, source)

    def to_dict(self) -> dict[str, Any]:
        """As in answers."""
        return {"value": self.value, "low": self.low, "high": self.high, "from": self.source}


@dataclass(frozen=True, eq=False)
class EvaluatedTest:
    """One test.

    Parameters
    ----------
    record : LoopRecord
        What was measured.
    found : Found
        Where its cycles are.
    cycles : tuple of Cycle
        What each is.
    each : tuple of dict
        The same with intervals, quantities by name.
    first, last : int
        The cycles of the means.
    means : dict
        Means with intervals, quantities by name.
    frequency : Told
        In Hz, without a clock per sample.
    energy : Told
        Work done in the whole run.
    notes : tuple of str
        What a user should know.
    """

    record: LoopRecord
    found: Found
    cycles: tuple[Cycle, ...]
    each: tuple[dict[str, Told], ...]
    first: int
    last: int
    means: dict[str, Told]
    frequency: Told
    energy: Told
    notes: tuple[str, ...]

    @property
    def name(self) -> str:
        """Of the record."""
        return self.record.name

    def unit(self, name: str) -> str:
        """Unit of a quantity."""
        return self.record.units[BY_NAME[name].dimension]

    @property
    def amplitude(self) -> float:
        """Half the stroke, in the unit of the displacement."""
        return 0.5 * (self.means["D+"].value - self.means["D-"].value)

    def names(self) -> list[str]:
        """Quantities that can be told of it, in order."""
        return [each.name for each in QUANTITIES if each.name in self.means]

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        frequency = None
        if self.record.timed:
            frequency = {**self.frequency.to_dict(), "unit": "Hz"}
        return {
            "name": self.name,
            "frequency": frequency,
            "units": {name: self.unit(name) for name in self.names()},
            "cycles": [
                {
                    "number": cycle.number,
                    "start": cycle.start,
                    "stop": cycle.stop,
                    "values": {name: each[name].to_dict() for name in self.names() if name in each},
                }
                for cycle, each in zip(self.cycles, self.each, strict=True)
            ],
            "mean": {
                "first": self.first,
                "last": self.last,
                "values": {name: self.means[name].to_dict() for name in self.names()},
            },
            "energy": {**self.energy.to_dict(), "unit": self.record.units["energy"]},
            "notes": list(self.notes),
        }


def range_of(text: str) -> tuple[int, int]:
    """The cycles that a user names: ``3..10``, or one of them.

    Raises
    ------
    OptionError
        If it is none.

    Examples
    --------
    >>> range_of("3..10"), range_of("4")
    ((3, 10), (4, 4))
    """
    match = re.fullmatch(r"\s*(\d{1,6})\s*(?:\.\.\s*(\d{1,6})\s*)?", text)
    first, last = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not 1 <= first <= last:
        raise OptionError(
            f"cycles '{text:.40}' are none: write the first and the last, as in 3..10"
        )
    return first, last


def evaluate(record: LoopRecord, wanted: tuple[int, int] | None = None) -> EvaluatedTest:
    """The cycles of a record, each with what a test report tells, and the means of some.

    Parameters
    ----------
    record : LoopRecord
        What was measured.
    wanted : tuple of int, optional
        First and last cycle of the means; by default all but the first and the last where there are
        four or more.

    Raises
    ------
    DataError
        If there is no whole cycle, or none of those that are wanted.
    """
    found = find_cycles(record)
    first, last = _range(record, len(found.middles), wanted)
    cycles = tuple(cycles_of(record, found, first, last))
    names = [each.name for each in QUANTITIES if each.name in cycles[0].values]
    columns = {name: [cycle.values[name] for cycle in cycles] for name in names}
    each = {name: _each(values, first, last) for name, values in columns.items()}
    means = {name: _mean(values[first - 1 : last]) for name, values in columns.items()}
    rates = [
        Estimate(1.0 / (after.value - before.value), _of_frequency(before, after))
        for before, after in pairwise(found.bounds)
    ]
    work = energy_of(record, list(cycles))
    notes = [*record.notes, *found.notes, *_remarks(record, found, means)]
    if other := _other_strokes(cycles, first, last):
        notes.append(
            f"the mean is of cycles of unequal strokes: {', '.join(map(str, other))} differ by more"
            f" than {100 * STEADY:.0f} %; others are chosen by --cycles A..B"
        )
    if wanted is not None and last < wanted[1]:
        notes.append(f"there are {len(cycles)} whole cycles: the means are of {first} to {last}")
    return EvaluatedTest(
        record,
        found,
        cycles,
        tuple({name: each[name][i] for name in names} for i in range(len(cycles))),
        first,
        last,
        means,
        _mean(rates[first - 1 : last]),
        Told.of(work.value, work.sd, np.inf, "noise"),
        tuple(notes),
    )


def _other_strokes(cycles: Sequence[Cycle], first: int, last: int) -> list[int]:
    """Cycles of the mean whose stroke is not that of most."""
    meant = cycles[first - 1 : last]
    strokes = np.array([each.values["D+"].value - each.values["D-"].value for each in meant])
    usual = float(np.median(strokes))
    return [
        each.number
        for each, stroke in zip(meant, strokes, strict=True)
        if abs(stroke - usual) > STEADY * usual
    ]


def _of_frequency(before: Estimate, after: Estimate) -> float:
    return float(np.hypot(before.sd, after.sd) / (after.value - before.value) ** 2)


def _range(record: LoopRecord, count: int, wanted: tuple[int, int] | None) -> tuple[int, int]:
    if wanted is None:
        return (2, count - 1) if count > FEWEST else (1, count)
    if wanted[0] > count:
        raise DataError(
            f"{record.name}: there are {count} whole cycles, and none of {wanted[0]} to {wanted[1]}"
        )
    return wanted[0], min(wanted[1], count)


def _each(values: Sequence[Estimate], first: int, last: int) -> list[Told]:
    """The values of all cycles, with the deviation of each: of noise, or from one to the next.

    From one to the next of those that the mean is of: a first or last cycle that runs up or down
    says nothing of how the others scatter.
    """
    numbers, sds = np.array(values).T
    # What warms up or wears in changes over many of them.
    steps = np.diff(numbers[first - 1 : last])
    if len(steps) + 1 >= FEWEST:
        variance = float(np.mean(steps**2)) / 2.0
        if _more(variance, float(np.mean(sds[first - 1 : last] ** 2)), len(steps)):
            sd = float(np.sqrt(variance))
            return [Told.of(float(value), sd, len(steps), "cycles") for value in numbers]
    return [Told.of(value, sd, np.inf, "noise") for value, sd in values]


def _mean(values: Sequence[Estimate]) -> Told:
    """Their mean: its deviation is that of noise, unless they scatter more than that allows."""
    numbers, sds = np.array(values).T
    count = len(values)
    by_noise = float(np.sqrt(np.sum(sds**2))) / count
    mean = float(np.mean(numbers))
    if count >= FEWEST:
        variance = float(np.var(numbers, ddof=1))
        if _more(variance, float(np.mean(sds**2)), count - 1):
            return Told.of(mean, float(np.sqrt(variance / count)), count - 1, "cycles")
    return Told.of(mean, by_noise, np.inf, "noise")


def _more(variance: float, of_noise: float, freedom: int) -> bool:
    """Whether a variance is larger than noise makes it by chance."""
    return variance > of_noise * float(f_quantile(1.0 - WHERE.levels_differ, freedom, 1e9))


def _remarks(record: LoopRecord, found: Found, means: dict[str, Told]) -> list[str]:
    remarks = []
    if means["W_d"].high < 0.0:
        remarks.append(
            "the specimen gives out energy: one channel counts the other way; open"
            f" 'FILE?force=-{record.force_unit}'"
        )
    for channel, values in (("displacement", record.displacement), ("force", record.force)):
        if (count := _cut(values, record, found)) > 0:
            remarks.append(
                f"the {channel} stands still at its greatest value for {count} samples in"
                " each cycle: it looks clipped, and peaks and stiffness are too small"
            )
    if not record.timed:
        remarks.append(
            "there is no time: what needs one (C_eff, K', eta, peak speed, frequency) is left out"
        )
    return remarks


def _cut(values: Real, record: LoopRecord, found: Found) -> int:
    """Samples that stand at an extreme of a channel that moves elsewhere, in each cycle; or 0."""
    steps = np.abs(np.diff(values))
    moved = steps[steps > 0.0]
    if not len(moved):
        return 0
    counts = []
    spacing = float(np.median(np.diff(record.time)))
    start, stop = found.bounds[0].value, found.bounds[-1].value
    inside = values[(record.time >= start) & (record.time <= stop)]
    cycles = len(found.bounds) - 1
    digit, half = float(moved.min()), 0.5 * float(np.ptp(values))
    # So long a sinusoid stays within one digit of its peak.
    dwell = np.arccos(np.clip(1.0 - 2.0 * digit / half, -1.0, 1.0)) / np.pi * found.period / spacing
    for extreme in (inside.max(), inside.min()):
        still = np.concatenate([[0], (inside == extreme).astype(int), [0]])
        edges = np.flatnonzero(np.diff(still))
        runs = edges[1::2] - edges[::2]
        long = runs[runs > 2.0 * dwell + FEWEST]
        # Once is chance; in each cycle it is a limit.
        if len(long) >= max(cycles, 2):
            counts.append(int(np.median(long)))
    most = max(counts, default=0)
    # Most of a cycle at rest is how it was loaded.
    return most if most * spacing < WINDOW.share * 2 * found.period else 0


@dataclass(frozen=True, eq=False)
class VelocityLaw:
    """Force at the middle of the loop over the speed there, F0 = C |v|^alpha.

    Parameters
    ----------
    constant, exponent : float
        C and alpha.
    constant_ends, exponent_ends : tuple of float
        Their intervals.
    unit : str
        Of C.
    scatter : float
        Relative deviation of a test from the law.
    source : str
        Where the intervals come from: ``noise`` of the tests, or ``tests``: their scatter about the
        law.
    """

    constant: float
    exponent: float
    constant_ends: tuple[float, float]
    exponent_ends: tuple[float, float]
    unit: str
    scatter: float
    source: str

    def force(self, speed: Real) -> Real:
        """The force at speeds."""
        return np.asarray(self.constant * np.abs(speed) ** self.exponent * np.sign(speed))

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        (c_low, c_high), (low, high) = self.constant_ends, self.exponent_ends
        return {
            "C": {"value": self.constant, "low": c_low, "high": c_high, "unit": self.unit},
            "alpha": {"value": self.exponent, "low": low, "high": high, "unit": "-"},
            "scatter": self.scatter,
            "from": self.source,
        }


def velocity_law(tests: Sequence[EvaluatedTest]) -> VelocityLaw | None:
    """The law of tests at different speeds, by least squares of the logarithms.

    None of fewer than two speeds, of other units, or where a force has no logarithm.

    Parameters
    ----------
    tests : sequence of EvaluatedTest
        At least two that differ in speed.
    """
    known = [test for test in tests if {"F0", "v_peak"} <= test.means.keys()]
    units = {(test.record.displacement_unit, test.record.force_unit) for test in known}
    if len(known) < 2 or len(units) > 1:
        return None
    means = [(test.means["v_peak"], test.means["F0"]) for test in known]
    speed, force = np.array([[each.value for each in pair] for pair in means]).T
    speed_sd, force_sd = np.array([[each.sd for each in pair] for pair in means]).T
    if not ((speed > 0).all() and (force > 0).all()):
        return None
    x, y = np.log(speed), np.log(force)
    if np.ptp(x) <= student(INTERVAL, np.inf) * np.hypot.reduce(speed_sd / speed):
        return None
    exponent = 1.0
    # The slope says how much of the error of a speed is one of the force.
    for _ in range(3):
        variance = (force_sd / force) ** 2 + (exponent * speed_sd / speed) ** 2
        variance = np.maximum(variance, np.finfo(float).eps ** 2)
        design = np.stack([np.ones_like(x), x], axis=1) / np.sqrt(variance)[:, None]
        covariance = np.linalg.inv(design.T @ design)
        level, exponent = (covariance @ design.T @ (y / np.sqrt(variance))).tolist()
    left = y - level - exponent * x
    freedom, source = float("inf"), "noise"
    chi = float(np.sum(left**2 / variance))
    count = len(x) - 2
    if count and chi > count * float(f_quantile(1.0 - WHERE.levels_differ, count, 1e9)):
        # Tests that scatter by more than their own noise count alike: what parts them is theirs.
        design = np.stack([np.ones_like(x), x], axis=1)
        level, exponent = np.linalg.lstsq(design, y, rcond=None)[0].tolist()
        left = y - level - exponent * x
        covariance = np.linalg.inv(design.T @ design) * float(left @ left) / count
        freedom, source = float(count), "tests"
    reach = student(INTERVAL, freedom) * np.sqrt(np.diag(covariance))
    way, pull = next(iter(units))
    per = "1/s" if way == "-" else f"{way}/s"
    return VelocityLaw(
        float(np.exp(level)),
        exponent,
        (float(np.exp(level - reach[0])), float(np.exp(level + reach[0]))),
        (exponent - float(reach[1]), exponent + float(reach[1])),
        f"{pull}/({per})^alpha",
        float(np.sqrt(left @ left / count)) if count else 0.0,
        source,
    )
