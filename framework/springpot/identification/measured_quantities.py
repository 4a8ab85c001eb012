"""Quantities that measured points say by themselves: a smooth curve through those around them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import student
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.numerics import FEWEST, MOST_STEPS, REWEIGHTINGS, rows_alike
from springpot.rheology.parameters import AMPLITUDE, FORCE, STIFFNESS
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .leastsquares import Rows, levenberg_marquardt
from .value import Quantity, Value, energy_unit, in_logarithm, noun

AROUND = 9
"""Points through which a parabola goes, and 6 of them tell its scatter."""
CURVE = 5
"""Points of a curve from which anything is read."""
FALL = 0.05
"""Share by which storage has fallen at the linear limit (ISO 6721-10, ASTM D7175: 5 or 10 %)."""
FITTED = 4.0
"""Falls up to so many times that are fitted: what comes later is another story."""


class Read(NamedTuple):
    """A value on a curve in logarithms, its slope there, and how sure both are.

    Attributes
    ----------
    value, slope, bend : float
        Of the parabola at the place.
    covariance : ndarray, shape (3, 3)
        Of these three, the bend being half the second derivative.
    dof : int
        Degrees of freedom.
    """

    value: float
    slope: float
    bend: float
    covariance: Real
    dof: int

    @property
    def quantile(self) -> float:
        """Standard deviations to the end of an interval."""
        return student(INTERVAL, self.dof)

    @property
    def reach(self) -> float:
        """Half of the interval of the value."""
        return self.quantile * float(np.sqrt(self.covariance[0, 0]))


def read(x: Real, y: Real, place: float, count: int = AROUND) -> Read:
    """A curve of points (n,) at a place, by the parabola through those around it."""
    near = np.argsort(np.abs(x - place), kind="stable")[:count]
    design = (x[near, None] - place) ** np.arange(3.0)
    solved, *_ = np.linalg.lstsq(design, y[near], rcond=None)
    dof = len(near) - 3
    scatter = float(np.sum((y[near] - design @ solved) ** 2)) / dof
    covariance: Real = scatter * np.linalg.pinv(design.T @ design)
    value, slope, bend = solved.tolist()
    return Read(value, slope, bend, covariance, dof)


def crossings(x: Real, y: Real) -> Iterator[tuple[float, Read]]:
    """Places where a curve goes through zero, each once."""
    found: list[float] = []
    # A sample that is zero itself lies between its neighbours.
    sided = np.flatnonzero(y)
    before, after = sided[:-1], sided[1:]
    for i in before[np.sign(y[before]) * np.sign(y[after]) < 0]:
        place = float(x[i])
        for _ in range(MOST_STEPS):
            curve = read(x, y, place)
            if not curve.slope:
                break
            place = float(np.clip(place - curve.value / curve.slope, x[0], x[-1]))
        near = np.ptp(x) / len(x)
        curve = read(x, y, place)
        # Scatter about zero crosses it several times, at what is one place of the curve.
        inside = x[0] < place < x[-1] and abs(curve.value) < 1e-6
        if inside and all(abs(place - other) > near for other in found):
            found.append(place)
            yield place, curve


class OneSweep(NamedTuple):
    """A curve along one column, all else being held.

    Attributes
    ----------
    x : ndarray, shape (n,)
        Logarithm of the column, rising.
    storage, loss : ndarray, shape (n,)
        ln K' and ln K''.
    at : mapping of str to float
        What was held; the frequency in Hz.
    """

    x: Real
    storage: Real
    loss: Real
    at: Mapping[str, float]


def curves(data: Measurement, along: str) -> Iterator[OneSweep]:
    """Curves along the frequency or the amplitude, one for each set of what else was held."""
    frequency = data.omega / (2.0 * np.pi)
    columns = {"frequency": frequency, **data.conditions}
    held = {name: columns[name] for name in columns if name != along}
    if along not in columns:
        return
    for rows in _groups(data, held):
        rows = rows[
            (data.storage[rows] > 0.0) & (data.loss[rows] > 0.0) & (columns[along][rows] > 0.0)
        ]
        rows = rows[np.argsort(columns[along][rows], kind="stable")]
        if len(np.unique(columns[along][rows])) < CURVE:
            continue
        at = {
            name: float(np.mean(column[rows]))
            for name, column in held.items()
            if name in ("frequency", *CONDITIONS) or np.ptp(column[rows]) == 0.0
        }
        x, storage, loss = (
            np.log(column[rows]) for column in (columns[along], data.storage, data.loss)
        )
        yield OneSweep(x, storage, loss, at)


def _groups(data: Measurement, held: Mapping[str, Real]) -> list[NDArray[np.intp]]:
    keys = [np.zeros(len(data), dtype=np.int64)]
    for name, column in held.items():
        if name == "frequency":
            keys.append(np.unique(np.round(np.log(column), 3), return_inverse=True)[1].ravel())
        # As many levels as leave a curve for each: more are what was measured beside it.
        elif name in CONDITIONS or CURVE * len(np.unique(column)) <= len(data):
            keys.append(data.levels(name))
    return rows_alike(*keys)


def of_frequency(data: Measurement, hertz: float | None) -> Iterator[Quantity]:
    """Crossover and plateau of each frequency sweep, and what it shows at a frequency."""
    units = data.units
    clock = 1.0 if units.clock == "rad/s" else 0.5 / np.pi
    for sweep in curves(data, "frequency"):
        x, damping = sweep.x + np.log(2.0 * np.pi), sweep.loss - sweep.storage
        for place, curve in crossings(x, damping):
            error = float(np.sqrt(curve.covariance[0, 0])) / abs(curve.slope)
            reach, says = curve.quantile * error, "where storage and loss are equal"
            value = in_logarithm(place, reach, units.clock, clock)
            yield Quantity("crossover frequency", value, "data", sweep.at, says=says)
            size = read(x, 0.5 * (sweep.storage + sweep.loss), place)
            value = _there(size, error, units.of(STIFFNESS))
            yield Quantity(f"crossover {noun(units)}", value, "data", sweep.at, says=says)
        yield from _plateau(x, sweep, data)
        if hertz is not None and x[0] <= np.log(2.0 * np.pi * hertz) <= x[-1]:
            yield from _at(x, sweep, data, hertz)


def _there(curve: Read, error: float, unit: tuple[float, str]) -> Value:
    """A value at a place that is itself uncertain."""
    whole = np.hypot(np.sqrt(curve.covariance[0, 0]), curve.slope * error)
    return in_logarithm(curve.value, curve.quantile * float(whole), unit[1], unit[0])


def _plateau(x: Real, sweep: OneSweep, data: Measurement) -> Iterator[Quantity]:
    """Storage at the least loss factor, where that is a minimum and no end."""
    damping = sweep.loss - sweep.storage
    place = float(x[np.argmin(damping)])
    for _ in range(MOST_STEPS):
        curve = read(x, damping, place)
        if curve.bend <= 2.0 * np.sqrt(curve.covariance[2, 2]):
            return
        place -= curve.slope / (2.0 * curve.bend)
        if not x[1] < place < x[-2]:
            return
    if curve.value >= 0.0:
        return
    error = float(np.sqrt(curve.covariance[1, 1])) / (2.0 * curve.bend)
    value = _there(read(x, sweep.storage, place), error, data.units.of(STIFFNESS))
    at = {**sweep.at, "frequency": float(np.exp(place)) / (2.0 * np.pi)}
    yield Quantity("plateau", value, "data", at, says="storage where the loss factor is least")


def _at(x: Real, sweep: OneSweep, data: Measurement, hertz: float) -> Iterator[Quantity]:
    units, place = data.units, float(np.log(2.0 * np.pi * hertz))
    at = {**sweep.at, "frequency": hertz}
    size = 0.5 * np.logaddexp(2.0 * sweep.storage, 2.0 * sweep.loss)
    for name, values, (factor, unit), says in (
        (units.magnitude, size, units.of(STIFFNESS), "size of the complex value"),
        ("loss factor", sweep.loss - sweep.storage, (1.0, "-"), "loss over storage"),
    ):
        curve = read(x, values, place)
        value = in_logarithm(curve.value, curve.reach, unit, factor)
        yield Quantity(name, value, "data", at, says=says)
    amplitude = sweep.at.get("amplitude", 0.0)
    if amplitude > 0.0:
        curve, (factor, unit) = read(x, sweep.loss, place), energy_unit(units)
        log = curve.value + float(np.log(np.pi * amplitude**2))
        value = in_logarithm(log, curve.reach, unit, factor)
        yield Quantity("energy of a cycle", value, "data", at, says="area of the loop")


def of_amplitude(data: Measurement) -> Iterator[Quantity | str]:
    """Linear limit, yield and flow point of each sweep of the amplitude, or why it has none."""
    for sweep in curves(data, "amplitude"):
        found = linear_limit(sweep.x, sweep.storage)
        if found is None:
            yield _no_limit(sweep, data.units.amplitude)
        else:
            says = f"storage has fallen by {100 * FALL:g} %"
            yield from _place(sweep, data, *found, ("linear limit", "yield"), says)
        for place, curve in crossings(sweep.x, sweep.loss - sweep.storage):
            error = float(np.sqrt(curve.covariance[0, 0])) / abs(curve.slope)
            says, names = "where storage and loss are equal", ("flow point", "flow")
            yield from _place(sweep, data, place, error, curve.dof, names, says)


def _no_limit(sweep: OneSweep, unit: str) -> str:
    """Why a sweep shows no linear limit: it lies above all amplitudes, or below."""
    first, last = (
        float(np.median(part)) for part in (sweep.storage[:FEWEST], sweep.storage[-FEWEST:])
    )
    if last - first > np.log1p(-FALL):
        largest = f"{float(np.exp(sweep.x[-1])):.3g} {unit}".removesuffix(" -")
        return f"storage falls by less than {100 * FALL:g} % up to {largest}: no limit"
    least = f"{float(np.exp(sweep.x[0])):.3g} {unit}".removesuffix(" -")
    return f"storage falls from {least} on: the linear limit lies below what was measured"


def _place(
    sweep: OneSweep,
    data: Measurement,
    place: float,
    error: float,
    dof: int,
    names: tuple[str, str],
    says: str,
) -> Iterator[Quantity]:
    """An amplitude, and the force or stress there."""
    units, reach = data.units, student(INTERVAL, dof) * error
    factor, unit = units.of(AMPLITUDE)
    value = in_logarithm(place, reach, unit, factor)
    yield Quantity(names[0], value, "data", sweep.at, says=says)
    size = 0.5 * np.logaddexp(2.0 * sweep.storage, 2.0 * sweep.loss) + sweep.x
    word = "stress" if units.is_modulus else "force"
    value = _there(read(sweep.x, size, place), error, units.of(FORCE))
    yield Quantity(f"{names[1]} {word}", value, "data", sweep.at, says=says)


def linear_limit(x: Real, storage: Real) -> tuple[float, float, int] | None:
    """Logarithm of the amplitude at which storage has fallen, its error and degrees of freedom.

    By ln K' = ln K0 + ln(1 - fall) (X / X0)^n through the points up to a few falls: the beginning
    of any softening, with its own power.

    Parameters
    ----------
    x, storage : ndarray, shape (n,)
        Logarithms of amplitude, rising, and storage.

    Returns
    -------
    tuple or None
        None where it falls by less.
    """
    depth = -float(np.log1p(-FALL))
    level = float(np.median(storage[:FEWEST]))
    # The points before the fall are chosen by the last fit; they mostly stay from the second.
    for _ in range(REWEIGHTINGS):
        deep = np.flatnonzero(level - storage > FITTED * depth)
        used = max(int(deep[0]) if len(deep) else len(x), CURVE)
        theta, covariance, dof = _onset(x[:used], storage[:used], level, depth)
        level = float(theta[0])
    place = float(theta[1])
    if not x[0] < place < x[-1]:
        return None
    return place, float(np.sqrt(covariance[1, 1])), dof


def _onset(x: Real, y: Real, level: float, depth: float) -> tuple[Real, Real, int]:
    """Level, place and power of a fall by least squares, and their covariance."""
    fallen = np.flatnonzero(level - y > depth)
    start, dof = float(x[fallen[0]] if len(fallen) else x[-1]), len(x) - 3

    def evaluate(theta: Real, rows: Rows) -> tuple[Real, Real]:
        at, place, power = theta.T[..., None]
        fall = depth * np.exp(power * (x - place))
        slopes = np.ones_like(fall), power * fall, (place - x) * fall
        return at - fall - y, np.stack(slopes, axis=1)

    low, high = np.array([-np.inf, -np.inf, 0.2]), np.array([np.inf, np.inf, 8.0])
    found = levenberg_marquardt(evaluate, np.array([[level, start, 2.0]]), low, high)
    covariance = np.asarray(found.cost[0] / dof * np.linalg.pinv(found.jtj[0]))
    return found.u[0], covariance, dof
