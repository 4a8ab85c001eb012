"""Whether a misfit goes with the time at which points were measured, in numbers and in words.

So it does of a specimen that cures, dries or breaks down.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.measurement.independence import (
    POINTS_PER_DEGREE,
    at_one_frequency,
    frequency_numbers,
)
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.mixed_up import TIME, settings_of
from springpot.measurement.units import TIME_UNITS
from springpot.rheology.points import STEADY, Real
from springpot.thresholds import COURSE, VERDICT

from ..numerics import SMALLEST, projected_out, rows_alike
from .error import plain
from .frame import LEAST_SEEN, NoiseFrame, beyond

FOLD = 2.0
"""Ratio from which a change is told in times rather than in per cent."""


@dataclass(frozen=True)
class Course:
    """How a specimen changed while it was measured.

    Attributes
    ----------
    start, end : float
        First and last time, in the unit of the file.
    unit : str
        That unit; empty where the file has none.
    at : str
        The frequency at which the moduli are told, such as ``1 Hz``.
    storage, loss : tuple of float
        At the start and at the end, in the measurement's own unit.
    modulus : str
        That unit.
    mutation : float or None
        Largest relative change of |K| in one period; None where the unit of the time is unknown.
    share : float
        Of the misfit beyond the noise, in chi-square, that slow curves of gain and phase in time
        take, over what each frequency and each level of a condition may have of its own.
    gain : float
        Chi-square that they take, less the price of each of them by the information criterion.
    force_held : bool
        Whether the amplitude only followed the specimen, as the force was held.
    last_round : str
        How to choose the last rows that hold every frequency once, such as ``time=600..720``; empty
        without a sweep. Of a beginning, the rows after it.
    begun : int
        First rows, taken within one period of the start, with which alone the misfit goes; zero
        where the later ones change too.
    """

    start: float
    end: float
    unit: str
    at: str
    storage: tuple[float, float]
    loss: tuple[float, float]
    modulus: str
    mutation: float | None
    share: float
    gain: float
    force_held: bool
    last_round: str
    begun: int = 0

    @property
    def has_ends(self) -> bool:
        """Whether some point was measured at two times, so that a start and an end can be told."""
        return self.end > self.start

    @property
    def ends(self) -> str:
        """What changed, from where to where."""
        when = f"between {plain(self.start, 4)} and {plain(self.end, 4)} {self.unit}".rstrip()
        storage = _moved("storage", self.storage, self.modulus)
        loss = _moved("loss", self.loss, self.modulus)
        return f"{storage}, {loss}, {when} at {self.at}"

    @property
    def headline(self) -> str:
        """The end of the diagnosis's first sentence."""
        if self.begun:
            return (
                f"{self._beginning}, before anything swings steadily,"
                " and differ from all that come later"
            )
        if not self.has_ends:
            return (
                "the specimen changes with time: neither frequency nor what was set is what moves"
                " it; from what to what is not known, as no point was measured again later"
            )
        return f"the specimen changes with time: {self.ends}; frequency is not what moves it"

    @property
    def _beginning(self) -> str:
        """Which rows are of the start."""
        return f"the first {self.begun} points stand within one period of the start ({self.at})"

    @property
    def meaning(self) -> str:
        """What does so."""
        before, after = (
            float(np.hypot(*pair)) for pair in zip(self.storage, self.loss, strict=True)
        )
        if abs(after / before - 1.0) < STEADY:
            return "its phase, while |K| stays"
        if after > before:
            return "it cures, sets, ages or dries"
        return "it breaks down, softens, swells or loses its hold"

    @property
    def says(self) -> str:
        """What the misfit goes with, and how much of a change one point holds."""
        if self.begun:
            return (
                f"what is missing goes with the beginning: {self._beginning}; a period must pass"
                " before K is known"
            )
        change = "the specimen changes"
        if self.has_ends:
            change = f"{change} ({self.meaning})"
        taken = (
            "what is missing goes with the time: a slow course of gain and phase takes"
            f" {100 * self.share:.0f} % of the misfit, beyond all that frequency, temperature and"
            f" amplitude could; {change}, or the rig does"
        )
        if self.mutation is None:
            return taken
        quick = "so that each point is of one state"
        if self.mutation > COURSE.largest_mutation:
            quick = "too much for a steady state: measure at a higher frequency"
        size = f"{plain(100 * self.mutation, 2)} % within one period"
        return (
            f"{taken}; |K| changes by at most {size}, {quick} (mutation number,"
            " doi:10.1007/BF00369354)"
        )

    @property
    def advice(self) -> str:
        """What to measure."""
        if self.begun:
            return (
                "begin to take points when some periods have passed, and take them a period apart"
            )
        if self.last_round:
            return (
                "measure until the moduli stand still, or sweep faster than they move; until then"
                " each round is a material of its own: number the rounds in a column"
            )
        return (
            "hold the frequency until storage and loss stand still, and sweep the frequency then;"
            " or sweep several frequencies round and round, each round faster than the moduli move"
        )


def _moved(name: str, ends: tuple[float, float], unit: str) -> str:
    """How one part changed, such as ``storage rises from 12.1 to 1010 Pa (83 times)``."""
    before, after = ends
    if before == after:
        return f"{name} stays at {plain(before)} {unit}"
    verb = "rises"
    if after < before:
        verb = "falls"
    told = f"{name} {verb} from {plain(before)} to {plain(after)} {unit}"
    # What begins below zero has no ratio.
    if min(before, after) <= 0.0:
        return told
    if abs(after / before - 1.0) < STEADY:
        return f"{name} stays near {plain(before)} {unit}"
    ratio = max(after / before, before / after)
    if ratio < FOLD:
        return f"{told} (by {plain(100.0 * abs(after / before - 1.0), 2)} %)"
    if verb == "rises":
        return f"{told} ({plain(ratio, 2)} times)"
    return f"{told} (to {plain(100.0 / ratio, 2)} %)"


CLOCKS = frozenset({"s", "min", "h"})
"""Units in which another column is one of times; shorter ones are of delays."""
DEGREE = 8
"""Highest degree of the slow curves in time: they follow what happens within an eighth of the test.
"""
STEADY_DEGREE = 4
"""Degree of the curve whose slope tells how fast the modulus moves.

A higher one swings at its ends.
"""
END = 0.1
"""Share of the rows of one frequency whose mean stands for the start, and for the end."""


def course_behind(frame: NoiseFrame) -> Course | None:
    """How the specimen changed with time, where that is what the misfit goes with; else None.

    A time that only rose with the frequency, as in one sweep, or with a temperature, tells nothing:
    then None too.

    Parameters
    ----------
    frame : NoiseFrame
        The fit of a model.
    """
    data = frame.measurement
    time = _time_of(data)
    if time is None:
        return None
    nothing = np.zeros(len(data), dtype=bool)
    seen = _seen(frame, time, nothing)
    if seen is None:
        return None
    begun = _first_period(data, time)
    # Without the beginning: what only its rows differ by is no course.
    if begun.any() and _seen(frame, time, begun) is None:
        rows = int(np.count_nonzero(begun))
        return replace(_told(data, time, *seen), begun=rows, last_round=_later(data, time, begun))
    return _told(data, time, *seen)


def _seen(frame: NoiseFrame, time: Real, aside: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Share and gain of slow curves in time, some rows (n,) set aside.

    None where they are not what it goes with.
    """
    data = frame.measurement
    lost = frame.beyond(frame.relative(np.eye(len(data))[aside]), LEAST_SEEN)
    others = beyond(frame.beyond(frame.relative(_of_others(data)), LEAST_SEEN), lost)
    curves = beyond(frame.beyond(frame.relative(_slow(time, _slopes(data))), LEAST_SEEN), lost)
    basis = beyond(curves, others)
    spent = int(basis.shape[1])
    spare = frame.size - sum(int(each.shape[1]) for each in (frame.absorbed, lost, others, basis))
    if spent == 0 or spare <= 0:
        return None
    judged = projected_out(frame.rest, lost)
    misfit = float(judged @ judged)
    taken, beside = (float(np.sum((each.T @ judged) ** 2)) for each in (basis, others))
    rest = max(misfit - taken - beside, SMALLEST)
    chance = f_sf((taken / spent) / (rest / spare), spent, spare)
    # Of both without their noise: of a small misfit most is noise.
    excess = max(misfit - spare - float(others.shape[1]) - spent, taken - spent)
    share = (taken - spent) / max(excess, SMALLEST)
    if share <= VERDICT.takes_most or chance >= VERDICT.sentence_alarm:
        return None
    return share, taken - spent * float(np.log(frame.size))


def _first_period(data: Measurement, time: Real) -> NDArray[np.bool_]:
    """Rows (n,) of a test at one frequency that were taken within one period of its first.

    None where that is alone.

    Where the frequency moves each begins anew, and an instrument waits.
    """
    seconds = TIME_UNITS.get(data.provenance.get(f"unit {_name_of_time(data)}", ""))
    if seconds is None or not at_one_frequency(data):
        return np.zeros(len(data), dtype=bool)
    early = seconds * (time - np.min(time)) < 1.0 / np.min(data.frequency)
    return np.asarray(early & (np.count_nonzero(early) > 1), dtype=bool)


def _later(data: Measurement, time: Real, begun: NDArray[np.bool_]) -> str:
    """How to choose the rows after the beginning; empty without any."""
    if begun.all():
        return ""
    return f"{_name_of_time(data)}={np.min(time[~begun]):.10g}..{np.max(time):.10g}"


def moves_with_frequency(measurement: Measurement) -> bool:
    """Whether the time of rows only rises or only falls with frequency, as in a single sweep.

    Parameters
    ----------
    measurement : Measurement
        The data.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from .drift_search import moves_with_frequency
    >>> omega, time = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0], [0.0, 9.0, 15.0, 19.0, 22.0, 24.0]
    >>> moves_with_frequency(Measurement(omega, [1j] * 6, conditions={"time": time}))
    True
    """
    time = _time_of(measurement)
    if time is None or at_one_frequency(measurement):
        return False
    steps = np.diff(measurement.omega[np.argsort(time, kind="stable")])
    return bool(np.all(steps >= 0.0) or np.all(steps <= 0.0))


def change_in_order(measurement: Measurement, column: str) -> str:
    """What changed, where the values of a column, or the repeats, follow one another in time.

    Else empty.

    Parameters
    ----------
    measurement : Measurement
        The data, repeats and all.
    column : str
        One of its conditions or labels, or ``repeat``.
    """
    time = _time_of(measurement)
    values = {**measurement.conditions, **measurement.labels, "repeat": measurement.repeat}.get(
        column
    )
    if time is None or values is None:
        return ""
    each = [time[values == value] for value in np.unique(values)]
    # A cell that was left empty is equal to none.
    spans = sorted((times.min(), times.max()) for times in each if len(times))
    course = _told(measurement, time, 0.0, 0.0)
    if not course.has_ends or any(earlier[1] >= later[0] for earlier, later in pairwise(spans)):
        return ""
    return f"in the order of time, as which {column} stands, {course.ends}"


def _name_of_time(data: Measurement) -> str:
    """The column that holds when a point was measured: by its name, else by its unit.

    Empty without one.
    """
    if TIME in data.conditions:
        return TIME
    settings = settings_of(data)
    for name in data.conditions:
        # An age that was set, such as of three batches, is a setting and told of as one.
        if data.provenance.get(f"unit {name}") in CLOCKS and name not in settings:
            return name
    return ""


def _time_of(data: Measurement) -> Real | None:
    """The times (n,), where they are there and are enough."""
    time = data.conditions.get(_name_of_time(data))
    if time is None or not np.all(np.isfinite(time)) or len(np.unique(time)) < COURSE.fewest_times:
        return None
    return time


def _slopes(data: Measurement) -> Real:
    """Ln omega (n,) over its range, about its middle; zero at one frequency."""
    along = np.log(data.omega)
    # Its rounding would be made a slope.
    if at_one_frequency(data):
        return np.zeros_like(along)
    return np.asarray((along - np.mean(along)) / np.ptp(along), dtype=np.float64)


def _slow(values: Real, slopes: Real) -> Real:
    """Slow curves (m, n) in the order of some values, each also sloping along the frequency."""
    # By order, not by size: a reaction that is followed at ever longer times is as smooth.
    levels, rank = np.unique(values, return_inverse=True)
    degree = min(DEGREE, len(levels) // POINTS_PER_DEGREE)
    x = 2.0 * rank.ravel() / max(len(levels) - 1, 1) - 1.0
    curves = np.polynomial.legendre.legvander(x, degree).T
    return np.asarray(np.concatenate([curves, curves * slopes]), dtype=np.float64)


def _of_others(data: Measurement) -> Real:
    """Shapes (m, n) of what each frequency, level and setting may have of its own.

    The levels are those of a condition.
    """
    slopes = _slopes(data)
    shapes = [_at_each(frequency_numbers(data))]
    for name in CONDITIONS:
        if name not in data.conditions or (name == "amplitude" and _force_was_held(data)):
            continue
        level = data.levels(name)
        # What was swept row by row has no levels, only a course.
        if int(level.max()) + 1 > len(level) // POINTS_PER_DEGREE:
            shapes.append(_slow(data.conditions[name], slopes))
        else:
            shapes += [_at_each(level), _at_each(level) * slopes]
    for number in settings_of(data).values():
        shapes += [_at_each(number), _at_each(number) * slopes]
    return np.concatenate(shapes)


def _at_each(number: NDArray[np.int64]) -> Real:
    """Shapes (m, n) that are one at one value and zero elsewhere."""
    return np.asarray(number == np.arange(int(number.max()) + 1)[:, None], dtype=np.float64)


def _force_was_held(data: Measurement) -> bool:
    """Whether the amplitude is what a held force made of it.

    Then it follows the specimen, and is no cause.

    A dry slider's force is the same at all amplitudes too; but amplitudes that were chosen know
    nothing of the noise.
    """
    time, reach = _time_of(data), data.conditions.get("amplitude")
    if time is None or reach is None:
        return False
    order = np.argsort(time, kind="stable")
    moved = np.log(np.maximum(np.abs(reach[order]), SMALLEST))
    force = moved + np.log(data.magnitude[order])
    steadier = np.std(force) < COURSE.held_force * np.std(moved)
    smoother = _roughness(force) < COURSE.held_force * _roughness(moved)
    return bool(steadier and smoother)


def _roughness(values: Real) -> float:
    """How far a value lies off the line through its neighbours, mostly."""
    return float(np.median(np.abs(np.diff(values, 2))))


def _told(data: Measurement, time: Real, share: float, gain: float) -> Course:
    """What is told of a course, with the share of the misfit it takes and what that is worth."""
    rows = _most_alike(data)
    rows = rows[np.argsort(time[rows], kind="stable")]
    count = max(1, round(END * len(rows)))
    first, last = (np.mean(data.stiffness[part]) for part in (rows[:count], rows[-count:]))
    unit = data.provenance.get(f"unit {_name_of_time(data)}", "")
    last_round = ""
    # Where no point comes again there are no rounds.
    if time[rows[-1]] > time[rows[0]]:
        last_round = _last_round(data, time)
    return Course(
        start=float(time[rows[0]]),
        end=float(time[rows[-1]]),
        unit=unit,
        at=data.units.at(float(data.frequency[rows[0]])),
        storage=(float(first.real), float(last.real)),
        loss=(float(first.imag), float(last.imag)),
        modulus=data.units.stiffness,
        mutation=_mutation(data, time, rows, unit),
        share=share,
        gain=gain,
        force_held=_force_was_held(data),
        last_round=last_round,
    )


def _most_alike(data: Measurement) -> NDArray[np.int64]:
    """The rows of the frequency, temperature and amplitude that were measured most often."""
    columns = [frequency_numbers(data)]
    columns += [data.levels(name) for name in CONDITIONS if name in data.conditions]
    if "amplitude" in data.conditions and _force_was_held(data):
        columns = columns[:-1]
    groups = rows_alike(*columns)
    most = [rows for rows in groups if len(rows) == max(map(len, groups))]
    # Of many alike the middle one: the ends of a sweep are measured worst.
    return most[len(most) // 2]


def _mutation(data: Measurement, time: Real, rows: NDArray[np.int64], unit: str) -> float | None:
    """Largest relative change of |K| in one of the longest periods."""
    if unit not in TIME_UNITS or len(np.unique(time[rows])) < 2:
        return None
    seconds, size = TIME_UNITS[unit] * time[rows], np.log(data.magnitude[rows])
    degree = max(1, min(STEADY_DEGREE, len(rows) // POINTS_PER_DEGREE))
    x = np.linspace(-1.0, 1.0, len(rows))
    curve = np.polynomial.Legendre.fit(x, size, degree)(x)
    # Over some rows: the curve goes by order, and points that came in pairs lie much nearer in time
    # than the next.
    apart = max(1, len(rows) // (2 * degree))
    steps, moved = seconds[apart:] - seconds[:-apart], curve[apart:] - curve[:-apart]
    rate = np.max(np.abs(moved[steps > 0.0] / steps[steps > 0.0]))
    return float(rate / np.min(data.frequency))


def _last_round(data: Measurement, time: Real) -> str:
    """How to choose the last rows that hold every frequency.

    Empty where these are too few, or most of the rows.
    """
    number, order = frequency_numbers(data), np.argsort(time, kind="stable")[::-1]
    count = int(number.max()) + 1
    if count < COURSE.fewest_of_a_round:
        return ""
    needed = max(int(np.flatnonzero(number[order] == each)[0]) for each in range(count)) + 1
    if 2 * needed > len(order):
        return ""
    chosen = order[:needed]
    # A round at two temperatures is no sweep of one material.
    if any(np.ptp(data.levels(name)[chosen]) > 0 for name in CONDITIONS if name in data.conditions):
        return ""
    return f"{_name_of_time(data)}={time[order[needed - 1]]:.10g}..{time[order[0]]:.10g}"
