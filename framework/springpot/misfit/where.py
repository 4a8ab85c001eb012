"""Where a model fails, in plain sentences: which part of K, at which frequencies, how it grows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from springpot.distributions import chi2_sf
from springpot.measurement.independence import HELD_ALIKE, frequency_numbers
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import sweeps_of, temperatures_differ
from springpot.measurement.scatter import turned_sd
from springpot.measurement.units import Units
from springpot.plain_data import jsonable, read
from springpot.rheology.nodes import Chain, Parallel, Response, Series
from springpot.rheology.points import HELD, Real
from springpot.thresholds import WHERE
from springpot.writing import SHOWN

from ..numerics import SMALLEST, level_means
from .error import plain, with_unit
from .frame import NoiseFrame, relative_to, spectrum
from .regions import DRAWS, Blocks, MeasuredAxis, Region, Rows, rare, scales

WIDE = 0.7
"""Range of ln omega, a factor of two, from which it is told how a misfit changes along it."""
FEWEST_OF_A_LAW = 4
"""Points from which a power is told."""
AMPLITUDES = 3.0
"""Largest over smallest amplitude from which a power of it is told."""
STEADY = 0.5
"""Correlation with the number of the level from which a misfit is said to grow or to fall."""
BANDS = (24, 12, 6)
"""Intervals at most along each of one, two or three axes, when the place of a misfit is sought."""
SWEPT = 10.0
"""Span, in units of how nearly a rig holds a value, from which values are a sweep, not a drift."""
AMPLITUDE_POWERS = {
    -2.0: "falling as 1/amplitude^2",
    -1.0: "falling as 1/amplitude",
    1.0: "growing as amplitude",
    2.0: "growing as amplitude^2",
}
EVERYWHERE = "at all frequencies"
LEVEL = "level along frequency"
FREQUENCY_POWERS = {
    -2.0: "falling as 1/omega^2",
    -1.0: "falling as 1/omega",
    -0.5: "falling slowly with frequency",
    0.0: LEVEL,
    0.5: "growing slowly with frequency",
    1.0: "growing as omega",
    2.0: "growing as omega^2",
}
PLANES = {kind.plane: kind for kind in (Parallel, Series, Chain)}
"""Planes in which a residual is read at each point by itself."""


@dataclass(frozen=True)
class Where:
    """One place or direction in which the model fails.

    Attributes
    ----------
    plane, condition : str
        In which plane it is simplest, and of which sweeps or test it is.
    low, high : float
        The frequencies in Hz between which it lies, of a record times in s.
    size : float
        Of the misfit: of one side measured less modelled, as a share.
    says : str
        It in a sentence.
    part : str
        ``storage`` or ``loss``, where it is of one of them; a file does not hold it.
    levels : mapping of str to (float, float)
        Ends of each condition that sets it apart, in the unit of its column; nor this.
    """

    plane: str
    condition: str
    low: float
    high: float
    size: float
    says: str
    part: str = field(default="", compare=False)
    levels: Mapping[str, tuple[float, float]] = field(default_factory=dict, compare=False)

    @property
    def spot(self) -> dict[str, Any]:
        """Which points it is of, beside its range: for those who show them."""
        return {"part": self.part, "levels": dict(self.levels)}

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where the ends of the range are called from and to."""
        names = {"low": "from", "high": "to"}
        told = ("plane", "condition", "low", "high", "size", "says")
        return {names.get(key, key): jsonable(getattr(self, key)) for key in told}

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Where:
        """What `to_dict` gave."""
        return read(cls, {**row, "low": row["from"], "high": row["to"]})


@dataclass(frozen=True, eq=False)
class PlaneOfFit:
    """K' or K'' of a fit.

    Attributes
    ----------
    word, name : str
        What to call it, and ``storage`` or ``loss``.
    residual, relative, whitened : ndarray, shape (n,)
        Measured minus modelled: in the unit of K, as a share of |K|, in units of the noise.
    """

    word: str
    residual: Real
    relative: Real
    whitened: Real
    name: str = ""


def condition_axes(measurement: Measurement, most: int) -> list[MeasuredAxis]:
    """The conditions that vary, with `most` levels at most."""
    found = []
    for name in HELD:
        column = measurement.conditions.get(name)
        if column is None or (name == "temperature" and not temperatures_differ(measurement)):
            continue
        number = _set_values(measurement, name, most)
        count = int(number.max()) + 1
        if count > 1:
            if count > most:
                number = number * most // count
            found.append(MeasuredAxis(name, number))
    return found


# A chain of close values is one level; where it spans far more than a rig drifts, it is a sweep and
# has parts.
def _set_values(measurement: Measurement, name: str, most: int) -> Rows:
    """Number of the value that was set, ascending.

    Of a sweep without steps, of the part of it, `most` at most.
    """
    column, number = measurement.conditions[name], measurement.levels(name)
    x = column
    if name == "amplitude":  # a rig holds it to a share, a temperature to a part of a kelvin
        x = np.log(np.maximum(np.abs(column), SMALLEST))
    part = np.zeros_like(number)
    for value in range(int(number.max()) + 1):
        rows = np.flatnonzero(number == value)
        span = float(np.ptp(x[rows])) / HELD[name]
        if span > SWEPT:
            distinct, rank = np.unique(x[rows], return_inverse=True)
            part[rows] = rank.ravel() * min(most, int(span), len(distinct)) // len(distinct)
    return np.asarray(
        np.unique(number * most + part, return_inverse=True)[1].ravel(), dtype=np.int64
    )


def level_words(measurement: Measurement, axis: MeasuredAxis, rows: Rows) -> str:
    """Which levels some points hold: ``at 40 degC and above``; nothing where they hold all."""
    level = axis.level[rows]
    if level.min() == 0 and level.max() == axis.count - 1:
        return ""
    low, high = _ends(measurement, axis, rows)
    start = "at amplitudes of "
    if axis.name == "temperature":
        start = "at "
    if _number(low) == _number(high):
        return (
            f"{start.replace('amplitudes', 'an amplitude')}{with_unit(measurement, axis.name, low)}"
        )
    if level.min() == 0:
        return f"{start}{with_unit(measurement, axis.name, high)} and below"
    if level.max() == axis.count - 1:
        return f"{start}{with_unit(measurement, axis.name, low)} and above"
    return f"{start}{_number(low)} to {with_unit(measurement, axis.name, high)}"


def _ends(measurement: Measurement, axis: MeasuredAxis, rows: Rows) -> tuple[float, float]:
    column = measurement.conditions[axis.name][rows]
    return float(column.min()), float(column.max())


def _number(value: float) -> str:
    return f"{value:.3g}"


def dependences(
    measurement: Measurement, axes: list[MeasuredAxis], part: PlaneOfFit, rows: Rows
) -> Iterator[str]:
    """Whether the misfit of some points changes with the conditions.

    Nothing where the data cannot tell.
    """
    for axis in axes:
        _, level = np.unique(axis.level[rows], return_inverse=True)
        if level.max() > 0:
            yield _dependence(measurement, axis.name, part, rows, level.ravel())


def _dependence(
    measurement: Measurement, name: str, part: PlaneOfFit, rows: Rows, level: Rows
) -> str:
    count = np.bincount(level)
    relative = level_means(level, part.relative[rows])
    whitened = level_means(level, part.whitened[rows])
    middle = float(np.average(whitened, weights=count))
    spread = np.sum(count * (whitened - middle) ** 2)
    uneven = float(chi2_sf(spread, len(count) - 1)) < WHERE.levels_differ
    # "The same" by size and not by chance: of exact data any two levels differ beyond all noise.
    if np.ptp(relative) <= WHERE.alike * np.abs(np.mean(relative)):
        if _some(measurement, name, rows):
            return f"the same at all these {name}s"
        return f"the same at all {name}s"
    if not uneven:
        return ""
    at = level_means(level, measurement.conditions[name][rows])
    size = np.abs(relative)
    law = ""
    # A misfit that changes sign elsewhere is the difference of two laws and follows neither.
    if name == "amplitude" and not _some(measurement, name, rows):
        law = _power(at, level_means(level, part.residual[rows]))
    rank = float(np.corrcoef(np.arange(len(size)), size)[0, 1])
    if not law and abs(rank) < STEADY:
        return f"varying with {name}"
    ends = ", ".join(
        f"{plain(100 * size[i], 2)} % at {with_unit(measurement, name, float(at[i]))}"
        for i in (0, -1)
    )
    trend = f"smaller at higher {name}s"
    if rank > 0:
        trend = f"larger at higher {name}s"
    return f"{law or trend} ({ends})"


def _some(measurement: Measurement, name: str, rows: Rows) -> bool:
    """Whether some points hold only a part of the range of a condition."""
    column = measurement.conditions[name]
    return float(np.ptp(column[rows])) < 0.999 * float(np.ptp(column))


def _power(amplitude: Real, residual: Real) -> str:
    """The law by which a residual changes with amplitude, where levels are enough to say."""
    same = residual * np.sign(np.sum(residual)) > 0
    if len(amplitude) < FEWEST_OF_A_LAW or not np.all(same):
        return ""
    # Over a narrow range every power looks like every other.
    if amplitude[0] <= 0 or amplitude[-1] < AMPLITUDES * amplitude[0]:
        return ""
    slope = float(np.polyfit(np.log(amplitude), np.log(np.abs(residual)), 1)[0])
    # Unlike that of the frequency an exponent far from all of these is not told: effects have whole
    # powers here.
    power = min(AMPLITUDE_POWERS, key=lambda each: abs(each - slope))
    if abs(power - slope) < WHERE.close_power:
        return AMPLITUDE_POWERS[power]
    return ""


def where(frame: NoiseFrame) -> list[Where]:
    """Places at which a fit fails, the most telling first, at most `SHOWN`.

    Empty where noise explains the residual.

    A place is a range of frequencies, temperatures and amplitudes in which K' or K'' is off to one
    side.

    Parameters
    ----------
    frame : NoiseFrame
        The fit.
    """
    rng = np.random.default_rng(0)  # the same fit is told of in the same words
    # How many axes there are decides how fine they may be: blocks go with the square of the bands
    # of each.
    conditions = condition_axes(frame.measurement, BANDS[1])
    most = BANDS[len(conditions)]
    axes = [_frequencies(frame.measurement, most), *condition_axes(frame.measurement, most)]
    blocks = Blocks(axes)
    threshold = blocks.threshold(WHERE.alarm, scales(frame.scale_dof), rng)
    found = [
        (part, region)
        for part in _parts(frame)
        for region in blocks.regions(part.whitened, threshold)
    ]
    period, clear = _period(frame, rng)
    if period:
        # Half a swing is a band that is off to one side: the period says so once, not each of its
        # halves.
        found = [
            (part, region) for part, region in found if _length(axes[0], region) >= 2.0 * period
        ]
    found.sort(key=lambda pair: -abs(pair[1].sigma))
    if found:
        # Beside a misfit of a thousand deviations one of five is what the curve of the first leaves
        # elsewhere.
        least = WHERE.slight * abs(found[0][1].sigma)
        found = [(part, region) for part, region in found if abs(region.sigma) > least]
    plane = ""
    if found:
        plane = _simplest_plane(frame)
    places = [
        _place(frame.measurement, axes, part, region.rows, plane) for part, region in found[:SHOWN]
    ]
    if period:
        clearer = sum(abs(region.sigma) > clear for _, region in found[:SHOWN])
        places.insert(clearer, periodic(frame))
    return places[:SHOWN]


def _length(frequencies: MeasuredAxis, region: Region) -> float:
    """Points of one sweep that a region spans."""
    first, stop = region.spans[0]
    return (stop - first) * frequencies.points_of_each


def periodic(frame: NoiseFrame) -> Where:
    """A misfit that swings along the sweeps, whose mean over any band is nothing.

    Parameters
    ----------
    frame : NoiseFrame
        A fit whose residual has this kind of structure.
    """
    power = spectrum(frame.measurement, frame.rest[None])[0]
    period = 2.0 * (len(power) - 1) / max(int(np.argmax(power)), 1)
    longest = max(sweeps_of(frame.measurement), key=lambda sweep: len(sweep.rows))
    step = float(np.ptp(longest.x)) / max(len(longest.rows) - 1, 1) / np.log(10.0)
    decades = np.ptp(longest.x) > 0 and np.array_equal(
        longest.x, np.log(frame.measurement.omega[longest.rows])
    )
    frequency = frame.measurement.frequency
    relative = (
        np.abs(frame.measurement.stiffness - frame.model_stiffness) / frame.measurement.magnitude
    )
    # The amplitude of a sinusoid is the square root of two times its root mean square.
    size = float(np.sqrt(2.0 * np.mean(relative**2)))
    length = ""
    if decades:
        length = f" ({period * step:.2g} decades)"
    share = f"about {plain(100 * size, 2)} % of {frame.measurement.units.magnitude}"
    says = f"the misfit swings by {share} with a period of {period:.2g} points{length}"
    # Of which no sweep holds one whole period is no wave along them.
    if period > len(longest.rows):
        says = f"the misfit goes slowly along each sweep, by {share}"
    low, high = float(frequency.min()), float(frequency.max())
    return Where("stiffness", _conditions(frame.measurement), low, high, size, says)


def _period(frame: NoiseFrame, rng: np.random.Generator) -> tuple[float, float]:
    """Period, in points, of a misfit that is a ripple, and its standard deviations.

    Zero where it is none.

    A slow misfit swings too, about as often as there are parameters that follow it.
    """
    power = spectrum(frame.measurement, frame.rest[None])[0]
    followed = int(frame.absorbed.shape[1])
    first = followed + 3
    if first + 2 >= len(power):
        return 0.0, 0.0
    scale = scales(frame.scale_dof)
    chance = spectrum(frame.measurement, rng.standard_normal((DRAWS, frame.size)))
    peak = int(np.argmax(power))
    of_noise = np.mean(chance, axis=0) * np.mean(1.0 / np.asarray(scale))
    excess = np.maximum(power - of_noise, 0.0)
    # With two neighbours on each side, over which a period between those of the grid spreads.
    near_peak = float(np.sum(excess[max(peak - 2, 0) : peak + 3]))
    alone = near_peak > WHERE.one_period * float(np.sum(excess))
    if (
        peak < first
        or not alone
        or power[peak] < rare(np.max(chance[:, first:], axis=1), WHERE.alarm, scale)
    ):
        return 0.0, 0.0
    return 2.0 * (len(power) - 1) / peak, float(np.sqrt(power[peak]))


def _parts(frame: NoiseFrame) -> Iterator[PlaneOfFit]:
    n = len(frame.measurement)
    residual = frame.measurement.stiffness - frame.model_stiffness
    size = frame.measurement.magnitude
    units = frame.measurement.units
    rows = frame.residual[:n], frame.residual[n:]
    if frame.turn is not None:
        # A noise of gain and phase weighs the parts along K: where K' is negative, they are no K'.
        along = 1.0 / frame.weights.real + 1.0j / frame.weights.imag
        sd = turned_sd(along.astype(np.complex128), np.conj(frame.turn))
        rows = residual.real / sd.real, residual.imag / sd.imag
    yield PlaneOfFit(units.storage, residual.real, residual.real / size, rows[0], "storage")
    yield PlaneOfFit(units.loss, residual.imag, residual.imag / size, rows[1], "loss")


def _frequencies(measurement: Measurement, most: int) -> MeasuredAxis:
    """Bands holding equally many distinct frequencies."""
    # Not equally wide: where frequencies lie dense a band would hold many of them, elsewhere none.
    which = frequency_numbers(measurement)
    distinct = int(which.max()) + 1
    bands = min(most, distinct)
    return MeasuredAxis("frequency", (which * bands) // distinct, distinct / bands)


def _place(
    measurement: Measurement, axes: list[MeasuredAxis], part: PlaneOfFit, rows: Rows, plane: str
) -> Where:
    frequency, conditions = measurement.frequency, axes[1:]
    low, high = float(frequency[rows].min()), float(frequency[rows].max())
    size = float(np.mean(part.relative[rows]))
    side = "high"
    if size > 0:
        side = "low"
    # Levels are told only where they set the place apart: "at all temperatures" would be a word for
    # nothing.
    apart = {axis: level_words(measurement, axis, rows) for axis in conditions}
    levels = list(filter(None, apart.values()))
    units = measurement.units
    share = f"{plain(100 * abs(size), 2)} % of {units.magnitude}"
    place = f"{part.word} {share} too {side} {_range(low, high, frequency, units)}"
    growth = _growth(measurement, part, rows)
    if growth == LEVEL and place.endswith(EVERYWHERE):
        growth = ""  # "at all frequencies" says so already
    told = [" ".join([place, *levels]), growth, *dependences(measurement, conditions, part, rows)]
    condition = ", ".join(levels) or _conditions(measurement)
    says = ", ".join(word for word in told if word)
    ends = {axis.name: _ends(measurement, axis, rows) for axis, words in apart.items() if words}
    return Where(plane, condition, low, high, size, says, part.name, ends)


def _range(low: float, high: float, frequency: Real, units: Units) -> str:
    least, most = float(frequency.min()), float(frequency.max())
    if most <= least * (1.0 + HELD_ALIKE):
        return f"at {units.at(low)}"
    if low <= least * (1.0 + HELD_ALIKE) and high >= most / (1.0 + HELD_ALIKE):
        return EVERYWHERE
    if low <= least * (1.0 + HELD_ALIKE):
        return f"below {units.at(high)}"
    if high >= most / (1.0 + HELD_ALIKE):
        return f"above {units.at(low)}"
    if units.at(low) == units.at(high):
        return f"at {units.at(low)}"
    return f"between {units.on_clock(low):.3g} and {units.at(high)}"


def _growth(measurement: Measurement, part: PlaneOfFit, rows: Rows) -> str:
    """How the residual changes with frequency, where the range is wide enough to say."""
    omega = measurement.omega[rows]
    # Points that scatter to the other side have no logarithm, and say nothing of how the misfit
    # grows.
    sign = np.sign(np.sum(part.residual[rows]))
    kept = sign * part.residual[rows] > 0
    # Over less than a factor of two every power looks like every other.
    if np.sum(kept) < FEWEST_OF_A_LAW or np.ptp(np.log(omega[kept])) < WIDE:
        return ""
    size = np.abs(part.residual[rows][kept])
    slope = float(np.polyfit(np.log(omega[kept]), np.log(size), 1)[0])
    return FREQUENCY_POWERS[min(FREQUENCY_POWERS, key=lambda power: abs(power - slope))]


def _conditions(measurement: Measurement) -> str:
    sweeps = len(sweeps_of(measurement))
    if sweeps == 1:
        return "single sweep"
    return f"{sweeps} sweeps"


def _simplest_plane(frame: NoiseFrame) -> str:
    """The plane in which a straight line in omega^0, omega^1 or omega^2 explains most misfit.

    At one frequency there is no line, and it is the plane of stiffness.
    """
    if not np.ptp(frame.measurement.omega):
        return Parallel.plane
    modelled = Response(relative_to(frame.model_stiffness, frame.measurement))
    share: dict[str, float] = {}
    # Over their geometric mean, so that no power of the frequencies is beyond what numbers hold.
    scale = frame.measurement.omega / np.exp(np.mean(np.log(frame.measurement.omega)))
    for plane, kind in PLANES.items():
        slope = kind.slope(modelled)
        columns = [
            factor * slope * scale**power for power in (-1, 0, 1, 2) for factor in (1.0, 1.0j)
        ]
        lines = frame.whiten(np.array(columns)).T
        left = frame.project(lines)
        length = np.sqrt(np.sum(left**2, axis=0))
        # What the parameters follow all but whole would divide rounding by rounding.
        least = 1e-6 * np.sqrt(np.sum(lines**2, axis=0))
        along = (frame.rest @ left) / np.maximum(length, least)
        share[plane] = float(np.max(np.abs(along)))
    # Of planes in which it is alike the first: rounding chooses nothing.
    return max(share, key=lambda plane: float(f"{share[plane]:.5g}"))
