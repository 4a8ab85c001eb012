"""What a test report tells of one cycle of a loop: forces, stiffness, damping, energy.

All follow from the samples themselves, without a model. Slow drift of either channel is taken out
within a cycle, by the means of the cycles beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from springpot.distributions import normal_quantile, student
from springpot.numerics import SMALLEST, evenly
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, SIGNALS

from .record import (
    WINDOW,
    Channel,
    Estimate,
    Found,
    LoopRecord,
    Turning,
    forces_at_turnings,
    noise_of,
    smooth_value,
    turning_point,
    value_at,
)


class LoopQuantity(NamedTuple):
    """One column of a test report.

    Attributes
    ----------
    name : str
        As in tables, answers and codes.
    dimension : str
        Which of a record's units it has.
    means : str
        In words.
    force, way, turn : float
        Powers by which it goes with the scale of force and displacement; `turn` is 1 where an error
        of the phase moves it too.
    """

    name: str
    dimension: str
    means: str
    force: float = 0.0
    way: float = 0.0
    turn: float = 0.0


QUANTITIES = (
    LoopQuantity("D+", "displacement", "greatest displacement", way=1.0),
    LoopQuantity("D-", "displacement", "least displacement", way=1.0),
    LoopQuantity("F+", "force", "force at the greatest displacement", force=1.0, turn=1.0),
    LoopQuantity("F-", "force", "force at the least displacement", force=1.0, turn=1.0),
    LoopQuantity("F0", "force", "half the height of the loop at its middle", force=1.0, turn=1.0),
    LoopQuantity("K_eff", "stiffness", "(F+ - F-) / (D+ - D-)", force=1.0, way=-1.0, turn=1.0),
    LoopQuantity("C_eff", "damping", "W_d / (pi omega D^2)", 1.0, -1.0, 1.0),
    LoopQuantity("xi_eff", "ratio", "W_d / (2 pi |K_eff| D^2)", turn=1.0),
    LoopQuantity("W_d", "energy", "area of the loop", force=1.0, way=1.0, turn=1.0),
    LoopQuantity("K'", "stiffness", "force in phase over displacement", 1.0, -1.0, 1.0),
    LoopQuantity("K''", "stiffness", "W_d / (pi D^2)", force=1.0, way=-1.0, turn=1.0),
    LoopQuantity("eta", "ratio", "K'' / K'", turn=1.0),
    LoopQuantity("F_peak", "force", "greatest force, of either sign", force=1.0),
    LoopQuantity("v_peak", "velocity", "speed at the middle of the loop", way=1.0),
    LoopQuantity("T", "temperature", "mean temperature"),
)
"""D is half of D+ - D-, omega that of the cycle."""
MOST = 200
"""Cycles whose means tell a drift: more pairs of them would tell no more."""
BY_NAME = {each.name: each for each in QUANTITIES}


@dataclass(frozen=True, eq=False)
class Cycle:
    """One cycle.

    Parameters
    ----------
    number : int
        From 1 on.
    start, stop : float
        In s, or samples.
    values : dict of str to Estimate
        Quantities by name; those that cannot be told are missing.
    """

    number: int
    start: float
    stop: float
    values: dict[str, Estimate]


def cycles_of(record: LoopRecord, found: Found, first: int, last: int) -> list[Cycle]:
    """The quantities of each whole cycle.

    Parameters
    ----------
    record : LoopRecord
        What was measured.
    found : Found
        Where the cycles are.
    first, last : int
        Those that drift is read from: where the motion grows, its mean moves with it.
    """
    bounds = [bound.value for bound in found.bounds]
    noise = noise_of(record.displacement), noise_of(record.force)
    steady = bounds[first - 1 : last + 1]
    drifts = [_drift(record.time, values, steady) for values in (record.displacement, record.force)]
    loops = []
    for i, (start, stop) in enumerate(pairwise(bounds)):
        # The part that fits of this cycle can see, with the level that it has in its middle.
        ends = [1.5 * start - 0.5 * stop, 1.5 * stop - 0.5 * start]
        near = slice(*np.searchsorted(record.time, ends).tolist())
        away = record.time[near] - 0.5 * (start + stop)
        moved = Channel(record.time[near], record.displacement[near] - drifts[0] * away, noise[0])
        pulled = Channel(record.time[near], record.force[near] - drifts[1] * away, noise[1])
        loops.append(_loop(moved, pulled, found, i))
    turned = [(each.pulled, turning) for each in loops for turning in each.turnings]
    forces = forces_at_turnings(turned, WINDOW.share * found.period)
    made = []
    for i, loop in enumerate(loops):
        start, stop = bounds[i : i + 2]
        values = _values(loop, forces[2 * i], forces[2 * i + 1], record.timed)
        if record.temperature is not None:
            inside = (record.time >= start) & (record.time <= stop)
            values["T"] = Estimate(float(np.mean(record.temperature[inside])), 0.0)
        made.append(Cycle(i + 1, start, stop, values))
    return made


def energy_of(record: LoopRecord, cycles: list[Cycle]) -> Estimate:
    """Work done on the specimen in the whole run, partial cycles too.

    With the force counted from its mean in the whole cycles: an offset of the load cell does no
    work.
    """
    start, stop = cycles[0].start, cycles[-1].stop
    inside = (record.time >= start) & (record.time <= stop)
    moved = Channel(record.time, record.displacement, noise_of(record.displacement))
    level = float(np.mean(record.force[inside]))
    pulled = Channel(record.time, record.force - level, noise_of(record.force))
    return _work(moved, pulled, record.time[0], record.time[-1])


def _drift(time: Real, values: Real, bounds: list[float]) -> float:
    """Drift of a channel per time: the median slope between the means of whole cycles.

    Between like parts of the motion a drift is seen alone, whatever the motion is; the median
    passes over a first cycle that is unlike the others (Theil and Sen, doi:10.2307/2285891).
    """
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])
    edges = np.array(bounds)
    levels = np.diff(np.interp(edges, time, area)) / np.diff(edges)
    middles = 0.5 * (edges[1:] + edges[:-1])
    one, other = np.triu_indices(min(len(levels), MOST), 1)
    # Of very many cycles some, evenly spread, tell the same.
    few = evenly(len(levels), MOST)
    levels, middles = levels[few], middles[few]
    if not len(one):
        return 0.0
    return float(np.median((levels[other] - levels[one]) / (middles[other] - middles[one])))


def _jumps(channel: Channel) -> Real:
    """Heights of the steps between neighbouring samples that are jumps (n - 1,), 0 elsewhere.

    A step unlike those beside it by more than noise makes: where in it the jump lies, nobody knows.
    """
    steps = np.diff(channel.value)
    unlike = np.zeros(len(steps))
    unlike[1:-1] = steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])
    # Four samples enter, with weights of which the squares sum to five.
    limit = float(normal_quantile(1.0 - SIGNALS.ruled_out / len(steps)))
    return np.where(np.abs(unlike) > limit * np.sqrt(5.0) * channel.noise, steps, 0.0)


class _Loop(NamedTuple):
    """One cycle: its channels, its three crossings, where it turns, the direction it begins in."""

    moved: Channel
    pulled: Channel
    start: Estimate
    middle: Estimate
    stop: Estimate
    speeds: tuple[Estimate, ...]
    turnings: tuple[Turning, Turning]
    first: float

    @property
    def width(self) -> float:
        """Of the window of fits."""
        return WINDOW.share * (self.stop.value - self.start.value)


def _loop(moved: Channel, pulled: Channel, found: Found, i: int) -> _Loop:
    start, stop, middle = found.bounds[i], found.bounds[i + 1], found.middles[i]
    width = WINDOW.share * (stop.value - start.value)
    first = 1.0 if found.speeds[2 * i].value > 0 else -1.0
    ahead = turning_point(moved, _extreme(moved, start, middle, first), width, first)
    back = turning_point(moved, _extreme(moved, middle, stop, -first), width, -first)
    turnings = (ahead, back) if first > 0 else (back, ahead)
    speeds = found.speeds[2 * i : 2 * i + 2]
    return _Loop(moved, pulled, start, middle, stop, speeds, turnings, first)


def _values(loop: _Loop, top: Estimate, bottom: Estimate, timed: bool) -> dict[str, Estimate]:
    upper, lower = (turning.way for turning in loop.turnings)
    start, stop, pulled = loop.start, loop.stop, loop.pulled
    stroke = _difference(upper, lower)
    stiffness = _ratio(_difference(top, bottom), stroke)
    half = Estimate(0.5 * stroke.value, 0.5 * stroke.sd)
    ends = (value_at(pulled, start, loop.width), value_at(pulled, loop.middle, loop.width))
    height = _difference(*ends)
    level = _mean(pulled, start.value, stop.value)
    about = Channel(pulled.time, pulled.value - level, pulled.noise)
    work = _work(loop.moved, about, start.value, stop.value, loop=True)
    area = Estimate(np.pi * half.value**2, 2.0 * np.pi * half.value * half.sd)
    loss = _ratio(work, area)
    values = {"D+": upper, "D-": lower, "F+": top, "F-": bottom}
    values["F0"] = Estimate(0.5 * loop.first * height.value, 0.5 * height.sd)
    values |= {"K_eff": stiffness, "W_d": work, "K''": loss}
    values["xi_eff"] = _ratio(loss, Estimate(2.0 * abs(stiffness.value), 2.0 * stiffness.sd))
    values["F_peak"] = _greatest(pulled, start.value, stop.value, (top, bottom))
    if timed:
        period = stop.value - start.value
        omega = Estimate(
            2.0 * np.pi / period, 2.0 * np.pi / period**2 * np.hypot(start.sd, stop.sd)
        )
        values["C_eff"] = _ratio(loss, omega)
        values["K'"] = _in_phase(loop.moved, pulled, start.value, stop.value)
        values["eta"] = _ratio(loss, values["K'"])
        values["v_peak"] = _joined(loop.speeds)
    return values


def _joined(speeds: tuple[Estimate, ...]) -> Estimate:
    """Mean speed, of which the surer one counts more: at the ends of a record slopes are unsure."""
    weights = np.array([1.0 / max(each.sd, SMALLEST) ** 2 for each in speeds])
    sizes = np.array([abs(each.value) for each in speeds])
    return Estimate(float(weights @ sizes / weights.sum()), float(weights.sum() ** -0.5))


def _difference(one: Estimate, other: Estimate) -> Estimate:
    return Estimate(one.value - other.value, float(np.hypot(one.sd, other.sd)))


def _ratio(over: Estimate, under: Estimate) -> Estimate:
    if under.value == 0.0:
        return Estimate(float("nan"), float("nan"))
    quotient = over.value / under.value
    return Estimate(quotient, float(np.hypot(over.sd, quotient * under.sd) / abs(under.value)))


def _extreme(channel: Channel, start: Estimate, stop: Estimate, sign: float) -> float:
    """Where the mean over a sixteenth of the part between two crossings is greatest."""
    time, values = channel.within(start.value, stop.value)
    few = max(len(values) // 8, 1)
    smooth = np.convolve(values, np.ones(few), mode="same")
    inner = slice(few // 2, max(len(values) - few // 2, few // 2 + 1))
    return float(time[inner][np.argmax(sign * smooth[inner])])


def _mean(channel: Channel, start: float, stop: float) -> float:
    time, values = channel.within(start, stop)
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


def _work(
    moved: Channel, pulled: Channel, start: float, stop: float, loop: bool = False
) -> Estimate:
    """Integral of force over displacement between two moments, through all samples.

    A loop ends where it began: what noise leaves open is closed at the force of its ends.

    By splines, of which a coarsely sampled ellipse loses nothing; an ellipse of straight pieces
    would lose 2 % of its area at eighteen samples a cycle.
    """
    from scipy.interpolate import CubicSpline

    margin = 3
    first, last = np.searchsorted(moved.time, [start, stop]).tolist()
    rows = slice(max(first - margin, 0), min(last + margin, len(moved.time)))
    time = moved.time[rows]
    way, force = CubicSpline(time, moved.value[rows]), CubicSpline(time, pulled.value[rows])
    knots = np.concatenate([[start], time[(time > start) & (time < stop)], [stop]])
    # Exact for cubics: three Gauss points take a product of degree five.
    nodes, weights = np.polynomial.legendre.leggauss(3)
    steps = np.diff(knots)
    at = knots[:-1, None] + 0.5 * steps[:, None] * (1.0 + nodes)
    work = float(np.sum(0.5 * steps[:, None] * weights * force(at) * way(at, 1)))
    if loop:
        work -= float(0.5 * (force(start) + force(stop)) * (way(stop) - way(start)))
    # Each sample stands for the step between its neighbours.
    steps_way = 0.5 * (moved.value[rows][2:] - moved.value[rows][:-2])
    steps_force = 0.5 * (pulled.value[rows][2:] - pulled.value[rows][:-2])
    variance = pulled.noise**2 * np.sum(steps_way**2) + moved.noise**2 * np.sum(steps_force**2)
    variance += 0.5 * len(time) * (moved.noise * pulled.noise) ** 2
    jumps = _jumps(Channel(time, pulled.value[rows], pulled.noise))
    # Of a sampling that keeps step with the motion all jumps lie alike.
    variance += np.sum(np.abs(jumps * np.diff(moved.value[rows]))) ** 2 / 12.0
    return Estimate(work, float(np.sqrt(variance)))


def _in_phase(moved: Channel, pulled: Channel, start: float, stop: float) -> Estimate:
    """Real part of the first harmonic of the force over that of the displacement."""
    time, way = moved.within(start, stop)
    _, force = pulled.within(start, stop)
    turns = np.exp(-2j * np.pi * (time - start) / (stop - start))
    # Weighted by the time that each sample stands for, so that a sampling that is not even costs
    # nothing.
    steps = np.gradient(time)
    first = [np.sum(values * turns * steps) for values in (way, force)]
    ratio = first[1] / first[0]
    white = 0.5 * (pulled.noise**2 + (abs(ratio) * moved.noise) ** 2) * np.sum(steps**2)
    # A jump that lies anywhere between two samples turns the harmonic.
    jumps = np.abs(_jumps(Channel(time, force, pulled.noise)) * np.diff(time))
    return Estimate(
        float(ratio.real), float(np.sqrt(white + np.sum(jumps) ** 2 / 12.0) / abs(first[0]))
    )


def _greatest(
    channel: Channel,
    start: float,
    stop: float,
    ends: tuple[Estimate, Estimate],
) -> Estimate:
    """The greatest force: at a turning point, or between them.

    Looked for with means over wide and narrow windows: a narrow one finds a peak, and a wide one
    the middle of a part that stays above all others. What counts is the fit around that place.
    """
    time, values = channel.within(start, stop)
    best = max(ends, key=lambda each: abs(each.value))
    best = Estimate(abs(best.value), best.sd)
    few = max(len(values) // 16, 1)
    while few:
        inner = np.abs(np.convolve(values, np.ones(few), mode="valid"))
        place = int(np.argmax(inner)) + few // 2
        found = smooth_value(channel, float(time[place]), WINDOW.share * (stop - start))
        few //= 4
        if found is None:
            # Beside a jump there is no smooth piece: the sample itself, once the highest is meant.
            if few:
                continue
            found = Estimate(float(values[place]), channel.noise)
        if abs(found.value) > best.value:
            # Of a force that stays at its greatest, the highest of many windows is so by chance.
            by_chance = float(normal_quantile(1.0 - 1.0 / max(len(values), 2)))
            best = Estimate(
                abs(found.value), found.sd * (1.0 + by_chance / student(INTERVAL, np.inf))
            )
    return best
