"""Where a model fails, in plain sentences: which part of K, at which frequencies, and how it grows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from springpot.measurement import Measurement
from springpot.rheology import Complex, Real

from .dependence import Part, condition_axes, dependences, level_words
from .frame import Frame
from .regions import DRAWS, Axis, Blocks, Region, Rows, rare, scales
from .result import Where
from .sweeps import spectrum, sweeps_of

ALARM = 0.003
"""Chance that noise alone makes a place of one part of K."""
BANDS = (24, 12, 6)
"""Intervals at most along each of one, two or three axes, when the place of a misfit is sought."""
MOST = 5
"""Places told of at most: the most telling ones."""
SLIGHT = 0.1
"""Share of the clearest place's standard deviations below which a place is not worth a sentence beside it."""
ONE_PERIOD = 0.4
"""Share of the power beyond the noise's that lies at one period if a misfit is a ripple."""
EVERYWHERE = "at all frequencies"
LEVEL = "level along frequency"
POWERS = {-2.0: "falling as 1/omega^2", -1.0: "falling as 1/omega", -0.5: "falling slowly with frequency",
          0.0: LEVEL, 0.5: "growing slowly with frequency", 1.0: "growing as omega",
          2.0: "growing as omega^2"}  # fmt: skip
PLANES = ("stiffness", "compliance", "log-complex")


def in_plane(plane: str, measured: Complex, modelled: Complex) -> Complex:
    """Residual in one of the planes: K, 1/K or ln K.

    Parameters
    ----------
    plane : {"stiffness", "compliance", "log-complex"}
        The plane.
    measured, modelled : ndarray of complex, shape (n,)
        K.
    """
    if plane == "stiffness":
        return measured - modelled
    if plane == "compliance":
        return 1.0 / measured - 1.0 / modelled
    return np.asarray(np.log(measured / modelled), dtype=np.complex128)


def where(frame: Frame) -> list[Where]:
    """Places at which a fit fails, the most telling first, at most `MOST`; empty where noise explains the residual.

    A place is a range of frequencies, temperatures and amplitudes in which K' or K'' is off to one side.

    Parameters
    ----------
    frame : Frame
        The fit.
    """
    rng = np.random.default_rng(0)  # the same fit is told of in the same words
    conditions = condition_axes(frame.measurement, BANDS[1])
    most = BANDS[len(conditions)]
    axes = [_frequencies(frame.measurement.omega, most), *condition_axes(frame.measurement, most)]
    blocks = Blocks(axes)
    threshold = blocks.threshold(ALARM, scales(frame.scale_dof), rng)
    found = [(part, region) for part in _parts(frame) for region in blocks.regions(part.whitened, threshold)]
    period, clear = _period(frame, rng)
    if period:
        found = [(part, region) for part, region in found if _length(axes[0], region) >= 2.0 * period]
    found.sort(key=lambda pair: -abs(pair[1].sigma))
    found = [(part, region) for part, region in found if abs(region.sigma) > SLIGHT * abs(found[0][1].sigma)]
    plane = _simplest_plane(frame) if found else ""
    places = [_place(frame.measurement, axes, part, region.rows, plane) for part, region in found[:MOST]]
    if period:
        places.insert(sum(abs(region.sigma) > clear for _, region in found[:MOST]), periodic(frame))
    return places[:MOST]


def _length(frequencies: Axis, region: Region) -> float:
    """Points of one sweep that a region spans."""
    first, stop = region.spans[0]
    return (stop - first) * frequencies.points_of_each


def periodic(frame: Frame) -> Where:
    """A misfit that swings along the sweeps, whose mean over any band is nothing.

    Parameters
    ----------
    frame : Frame
        A fit whose residual has this kind of structure.
    """
    power = spectrum(frame.measurement, frame.rest[None])[0]
    period = 2.0 * (len(power) - 1) / max(int(np.argmax(power)), 1)
    longest = max(sweeps_of(frame.measurement), key=lambda sweep: len(sweep.rows))
    step = float(np.ptp(longest.x)) / max(len(longest.rows) - 1, 1) / np.log(10.0)
    decades = np.ptp(longest.x) > 0 and np.array_equal(longest.x, np.log(frame.measurement.omega[longest.rows]))
    frequency = frame.measurement.frequency
    relative = np.abs(frame.measurement.stiffness - frame.model_stiffness) / frame.measurement.magnitude
    size = float(np.sqrt(2.0 * np.mean(relative**2)))
    length = f" ({period * step:.2g} decades)" if decades else ""
    says = f"the misfit swings by about {100 * size:.2g} % of |K| with a period of {period:.2g} points{length}"
    low, high = float(frequency.min()), float(frequency.max())
    return Where("stiffness", _conditions(frame.measurement), low, high, size, says)


def _period(frame: Frame, rng: np.random.Generator) -> tuple[float, float]:
    """Period, in points, of a misfit that is a ripple, and its standard deviations; zero where it is none.

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
    excess = np.maximum(power - np.mean(chance, axis=0) * np.mean(1.0 / np.asarray(scale)), 0.0)
    alone = float(np.sum(excess[max(peak - 2, 0) : peak + 3])) > ONE_PERIOD * float(np.sum(excess))
    if peak < first or not alone or power[peak] < rare(np.max(chance[:, first:], axis=1), ALARM, scale):
        return 0.0, 0.0
    return 2.0 * (len(power) - 1) / peak, float(np.sqrt(2.0 * power[peak] / (len(power) - 1)))


def _parts(frame: Frame) -> Iterator[Part]:
    n = len(frame.measurement)
    residual = frame.measurement.stiffness - frame.model_stiffness
    size = frame.measurement.magnitude
    yield Part("storage modulus", residual.real, residual.real / size, frame.residual[:n])
    yield Part("loss modulus", residual.imag, residual.imag / size, frame.residual[n:])


def _frequencies(omega: Real, most: int) -> Axis:
    """Bands holding equally many distinct frequencies."""
    distinct, which = np.unique(np.round(np.log(omega), 9), return_inverse=True)
    bands = min(most, len(distinct))
    return Axis("frequency", (which.ravel() * bands) // len(distinct), len(distinct) / bands)


def _place(measurement: Measurement, axes: list[Axis], part: Part, rows: Rows, plane: str) -> Where:
    frequency, conditions = measurement.frequency, axes[1:]
    low, high = float(frequency[rows].min()), float(frequency[rows].max())
    size = float(np.mean(part.relative[rows]))
    side = "low" if size > 0 else "high"
    levels = [words for axis in conditions if (words := level_words(measurement, axis, rows))]
    place = f"{part.word} {100 * abs(size):.2g} % of |K| too {side} {_range(low, high, frequency)}"
    growth = _growth(measurement, part, rows)
    told = [
        " ".join([place, *levels]),
        "" if growth == LEVEL and place.endswith(EVERYWHERE) else growth,
        *dependences(measurement, conditions, part, rows),
    ]
    condition = ", ".join(levels) or _conditions(measurement)
    return Where(plane, condition, low, high, size, ", ".join(word for word in told if word))


def _range(low: float, high: float, frequency: Real) -> str:
    least, most = float(frequency.min()), float(frequency.max())
    if most <= least * 1.001:
        return f"at {low:.3g} Hz"
    if low <= least * 1.001 and high >= most / 1.001:
        return EVERYWHERE
    if low <= least * 1.001:
        return f"below {high:.3g} Hz"
    if high >= most / 1.001:
        return f"above {low:.3g} Hz"
    if f"{low:.3g}" == f"{high:.3g}":
        return f"at {low:.3g} Hz"
    return f"between {low:.3g} and {high:.3g} Hz"


def _growth(measurement: Measurement, part: Part, rows: Rows) -> str:
    """How the residual changes with frequency, where the range is wide enough to say."""
    omega = measurement.omega[rows]
    if np.ptp(np.log(omega)) < 0.7 or len(rows) < 4:
        return ""
    sign = np.sign(np.sum(part.residual[rows]))
    kept = sign * part.residual[rows] > 0
    if np.sum(kept) < 4:
        return ""
    slope = float(np.polyfit(np.log(omega[kept]), np.log(np.abs(part.residual[rows][kept])), 1)[0])
    return POWERS[min(POWERS, key=lambda power: abs(power - slope))]


def _conditions(measurement: Measurement) -> str:
    sweeps = len(sweeps_of(measurement))
    return "single sweep" if sweeps == 1 else f"{sweeps} sweeps"


def _simplest_plane(frame: Frame) -> str:
    """The plane in which one straight line in omega^0, omega^1 or omega^2 explains most of the misfit."""
    modelled = frame.model_stiffness
    slopes = {
        "stiffness": np.ones_like(modelled),
        "compliance": -(modelled**2),
        "log-complex": modelled,
    }
    share: dict[str, float] = {}
    scale = frame.measurement.omega / np.exp(np.mean(np.log(frame.measurement.omega)))
    for plane, slope in slopes.items():
        columns = [factor * slope * scale**power for power in (-1, 0, 1, 2) for factor in (1.0, 1.0j)]
        lines = frame.whiten(np.array(columns)).T
        left = frame.project(lines)
        length = np.sqrt(np.sum(left**2, axis=0))
        along = (frame.rest @ left) / np.maximum(length, 1e-6 * np.sqrt(np.sum(lines**2, axis=0)))
        share[plane] = float(np.max(np.abs(along)))
    return max(share, key=lambda plane: share[plane])
