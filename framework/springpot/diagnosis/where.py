"""Where a model fails, in plain sentences: which part of K, at which frequencies, and how it grows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from springpot.measurement import Measurement
from springpot.rheology import Complex, Real

from .frame import Frame
from .result import Where
from .structure import spectrum
from .sweeps import sweeps_of

TELLING = 4.0
"""Standard deviations by which the mean of a band must be off to be mentioned."""
BANDS = 12
"""Frequency bands into which a sweep is cut when the place of a misfit is sought."""
POWERS = {-2.0: "falling as 1/omega^2", -1.0: "falling as 1/omega", -0.5: "falling slowly with frequency",
          0.0: "the same at all frequencies", 0.5: "growing slowly with frequency", 1.0: "growing as omega",
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


@dataclass(frozen=True, eq=False)
class _Part:
    """K' or K'' of a fit: residual, deviation of each point and what to call it."""

    word: str
    residual: Real
    relative: Real
    whitened: Real


def where(frame: Frame) -> list[Where]:
    """Places at which a fit fails, the worst first; empty where noise explains the residual.

    Parameters
    ----------
    frame : Frame
        The fit.
    """
    found = [place for part in _parts(frame) for place in _places(frame, part)]
    found.sort(key=lambda place: -abs(place.size))
    return found


def periodic(frame: Frame) -> Where:
    """A misfit that swings along the sweeps, whose mean over any band is nothing.

    Parameters
    ----------
    frame : Frame
        A fit whose residual has this kind of structure.
    """
    power = spectrum(frame, frame.rest[None])[0]
    period = 2.0 * (len(power) - 1) / max(int(np.argmax(power)), 1)
    longest = max(sweeps_of(frame.measurement), key=lambda sweep: len(sweep.rows))
    step = float(np.ptp(longest.x)) / max(len(longest.rows) - 1, 1) / np.log(10.0)
    frequency = frame.measurement.frequency
    relative = np.abs(frame.measurement.stiffness - frame.model_stiffness) / frame.measurement.magnitude
    size = float(np.sqrt(2.0 * np.mean(relative**2)))
    length = f" ({period * step:.2g} decades)" if np.ptp(frequency) > 0 else ""
    says = f"the misfit swings by about {100 * size:.2g} % of |K| with a period of {period:.2g} points{length}"
    low, high = float(frequency.min()), float(frequency.max())
    return Where("stiffness", _conditions(frame.measurement), low, high, size, says)


def _parts(frame: Frame) -> Iterator[_Part]:
    n = len(frame.measurement)
    residual = frame.measurement.stiffness - frame.model_stiffness
    size = frame.measurement.magnitude
    yield _Part("storage modulus", residual.real, residual.real / size, frame.residual[:n])
    yield _Part("loss modulus", residual.imag, residual.imag / size, frame.residual[n:])


def _places(frame: Frame, part: _Part) -> Iterator[Where]:
    """Runs of neighbouring bands whose mean is off to the same side."""
    measurement = frame.measurement
    band = _bands(measurement.omega)
    count = np.bincount(band)
    mean = np.bincount(band, part.whitened) / np.sqrt(np.maximum(count, 1))
    off = np.where(np.abs(mean) > TELLING, np.sign(mean), 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], off, [0.0]])))
    for start, stop in pairwise(edges.tolist()):
        if off[start] == 0.0:
            continue
        rows = np.flatnonzero((band >= start) & (band < stop))
        yield _place(frame, part, rows)


def _bands(omega: Real) -> NDArray[np.int64]:
    """Band number of each point, bands holding equally many distinct frequencies."""
    distinct, which = np.unique(np.round(np.log(omega), 9), return_inverse=True)
    bands = min(BANDS, len(distinct))
    return (which.ravel() * bands) // len(distinct)


def _place(frame: Frame, part: _Part, rows: NDArray[np.int64]) -> Where:
    measurement = frame.measurement
    frequency = measurement.frequency
    low, high = float(frequency[rows].min()), float(frequency[rows].max())
    size = float(np.mean(part.relative[rows]))
    side = "low" if size > 0 else "high"
    plane = _simplest_plane(frame)
    words = [
        f"{part.word} {100 * abs(size):.2g} % of |K| too {side} {_range(low, high, frequency)}",
        _growth(measurement, part, rows),
        *_dependences(measurement, part, rows),
    ]
    return Where(plane, _conditions(measurement), low, high, size, ", ".join(word for word in words if word))


def _range(low: float, high: float, frequency: Real) -> str:
    least, most = float(frequency.min()), float(frequency.max())
    if low <= least * 1.001 and high >= most / 1.001:
        return "at all frequencies"
    if low <= least * 1.001:
        return f"below {high:.3g} Hz"
    if high >= most / 1.001:
        return f"above {low:.3g} Hz"
    if f"{low:.3g}" == f"{high:.3g}":
        return f"at {low:.3g} Hz"
    return f"between {low:.3g} and {high:.3g} Hz"


def _growth(measurement: Measurement, part: _Part, rows: NDArray[np.int64]) -> str:
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


def _dependences(measurement: Measurement, part: _Part, rows: NDArray[np.int64]) -> Iterator[str]:
    """Whether the misfit changes with amplitude or temperature."""
    for name in ("amplitude", "temperature"):
        column = measurement.conditions.get(name)
        if column is None or np.ptp(column[rows]) < 1e-3 * np.max(np.abs(column)):
            continue
        x = column[rows] - np.mean(column[rows])
        slope = float(np.sum(x * part.whitened[rows]) / np.sqrt(np.sum(x * x)))
        plural = f"{name}s"
        if abs(slope) < TELLING:
            yield f"the same at all {plural}"
        else:
            rising = slope * np.sum(part.whitened[rows]) > 0
            yield f"{'larger' if rising else 'smaller'} at higher {plural}"


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
