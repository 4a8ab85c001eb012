"""Finds the frequency of a record and the part of it in which the oscillation is steady.

Displacement and force against time, read by blocks: a long record never needs room twice.
"""

from __future__ import annotations

import mmap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from springpot.errors import DataError
from springpot.rheology.points import STEADY, Complex, Real

from ..numerics import ROUNDING

SHORTEST = 8
"""Samples of a record, of a period, or of what is held, at least."""
BLOCK = 1 << 16
"""Rows worked on at a time."""
FORGET = 32 * BLOCK
"""Rows after which the pages of a mapped file are given back."""


@dataclass(frozen=True, eq=False)
class Signals:
    """One test: displacement and force (strain and stress, angle and torque) against time.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Seconds, in any order, irregular or with gaps.
    displacement, force : ndarray, shape (n,)
        The two channels; nan where a sample is missing.
    displacement_unit, force_unit : str
        Their units, such as ``mm`` and ``N``.
    name : str
        Shown in reports.
    provenance : mapping of str to str
        Where the signals come from.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import Signals, measurement_from_signals
    >>> t = np.linspace(0.0, 5.0, 2000)
    >>> test = Signals(t, np.cos(6.0 * t), 3.0 * np.cos(6.0 * t + 0.5), "mm", "N", "pad")
    >>> np.angle(measurement_from_signals([test]).stiffness).round(3)
    array([0.5])
    """

    time: Real
    displacement: Real
    force: Real
    displacement_unit: str = "mm"
    force_unit: str = "N"
    name: str = "signals"
    provenance: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class MendedSignals:
    """Signals in order of time, with what had to be mended.

    Parameters
    ----------
    time, displacement, force : ndarray, shape (n,)
        The channels; `time` does not fall.
    name : str
        Shown in errors.
    notes : tuple of str
        What was mended.
    """

    time: Real
    displacement: Real
    force: Real
    name: str
    notes: tuple[str, ...] = ()

    def blocks(self, start: float = -np.inf, stop: float = np.inf) -> Iterator[tuple[Real, Real]]:
        """Complete samples with start <= time < stop.

        Times (m,) and the two channels (m, 2), block by block.
        """
        first, last = np.searchsorted(self.time, [start, stop]).tolist()
        for low in range(first, last, BLOCK):
            if (low - first) % FORGET == 0:
                forget(self.time, self.displacement, self.force)
            rows = slice(low, min(low + BLOCK, last))
            both = np.column_stack([self.displacement[rows], self.force[rows]])
            # Both channels or none: a sample that lacks one tells no stiffness.
            good = np.isfinite(both).all(axis=1)
            yield np.asarray(self.time[rows])[good], both[good]

    @property
    def span(self) -> float:
        """Duration in seconds."""
        return float(self.time[-1] - self.time[0])


def forget(*channels: Real) -> None:
    """Give back the memory of channels that are mapped from a file.

    They are read again when they are needed.
    """
    for channel in channels:
        below: object = channel
        # A column is a view of a view: the map lies under all of them.
        while isinstance(below, np.ndarray):
            below = below.base
        if isinstance(below, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
            below.madvise(mmap.MADV_DONTNEED)


def in_order(time: Real, displacement: Real, force: Real, name: str = "signals") -> MendedSignals:
    """The signals as a record: cut to the common length, sorted by time if need be.

    Raises
    ------
    DataError
        If fewer than eight samples are left, or time stands still.
    """
    notes = []
    lengths = {len(time), len(displacement), len(force)}
    if len(lengths) > 1:
        # Loggers stop their channels one after the other: what all have is one test.
        common = min(lengths)
        notes.append(f"time, displacement and force differ in length: cut to {common} samples")
        time, displacement, force = time[:common], displacement[:common], force[:common]
    if len(time) and not _rises(time):
        keep = np.flatnonzero(np.isfinite(time))
        # Stable, so that samples of one time stay in the order of the file.
        keep = keep[np.argsort(time[keep], kind="stable")]
        notes.append("time runs backwards or has gaps: samples were put in order")
        time, displacement, force = time[keep], displacement[keep], force[keep]
    record = MendedSignals(time, displacement, force, name, tuple(notes))
    complete = sum(len(t) for t, _ in record.blocks())
    if complete < SHORTEST:
        raise DataError(
            f"{name}: {complete} complete samples of time, displacement and force; at least"
            f" {SHORTEST} are needed"
        )
    if not record.span > 0:
        raise DataError(f"{name}: time stands still at {time[0]:g} s")
    return record


def _rises(time: Real) -> bool:
    """Whether time is finite and never falls."""
    for low in range(0, len(time), BLOCK):
        # One sample of overlap sees a fall at the seam of two blocks.
        block = time[max(low - 1, 0) : low + BLOCK]
        if low % FORGET == 0:
            forget(time)
        if not (np.isfinite(block).all() and (np.diff(block) >= 0).all()):
            return False
    return True


EXCERPT = 1 << 17
"""Samples from which the frequency is first read."""
CYCLES = 16
"""From which a frequency can be refined in any case."""
QUARTERS = 4
"""Parts of a period: amplitudes are taken over four, a new one from each quarter on."""
MOST = 1 << 16
"""Quarters of periods in which a record is looked at.

In longer ones, of several periods: memory stays the same.
"""
TOLD = 2.5
"""Times the tolerance from which the user is told how steady a steady part is."""
LOUD = 0.2
"""Share of the largest amplitude from which a period belongs to the motion, not to a pause."""
TRIALS = 61
"""Frequencies across the peak of a spectrum among which the best is taken."""
UNLIKE = 1e4
"""Condition number from which the samples of a period tell cosine and sine no longer apart."""


@dataclass(frozen=True)
class Steady:
    """The steady part of a record.

    Parameters
    ----------
    start, stop : float
        Its limits in seconds.
    notes : tuple of str
        What a user should know about it.
    """

    start: float
    stop: float
    notes: tuple[str, ...] = ()


def coarse_frequency(record: MendedSignals) -> float:
    """Angular frequency of the strongest oscillation of the displacement, in rad/s.

    It is good to a fraction of 1/duration.

    Raises
    ------
    DataError
        If the displacement does not move.
    """
    n = len(record.time)
    # From the middle: at its ends a record runs up and down.
    middle = slice(max(0, (n - EXCERPT) // 2), max(0, (n - EXCERPT) // 2) + EXCERPT)
    omega, cycles = _peak(record, middle)
    if cycles < 4 and n > EXCERPT:
        # Sampled so finely that the excerpt holds no few cycles: every k-th sample of the whole
        # shows them.
        omega, _ = _peak(record, slice(None, None, -(-n // EXCERPT)))
    return omega


def excerpt_span(record: MendedSignals, omega: float) -> float:
    """Seconds for which `coarse_frequency` is good to part of a cycle, at least some cycles."""
    return max(record.span * min(1.0, EXCERPT / len(record.time)), CYCLES * 2 * np.pi / omega)


def _peak(record: MendedSignals, rows: slice) -> tuple[float, float]:
    """Frequency with the largest Fourier amplitude, and the cycles that the rows hold at it."""
    time, moved = np.asarray(record.time[rows]), np.asarray(record.displacement[rows])
    good = np.isfinite(moved)
    time, moved = time[good] - time[0], moved[good]
    if len(time) < 8 or not np.ptp(moved) > ROUNDING * np.max(np.abs(moved)):
        raise DataError(f"{record.name}: the displacement does not move")
    # A Fourier transform needs even sampling; interpolation is good enough for a first guess.
    even = np.linspace(time[0], time[-1], len(time))
    span = even[-1] - even[0]
    # A drift has the largest amplitudes of all, at the lowest frequencies.
    trend = np.polynomial.Polynomial.fit(even, moved, 1)
    level = np.interp(even, time, moved)
    smooth = level - trend(even)
    padded = 1 << int(np.ceil(np.log2(8 * len(even))))
    # The window keeps a strong line from spilling over its neighbours; padding gives places between
    # the lines.
    power = np.abs(np.fft.rfft(smooth * np.hanning(len(even)), padded))
    # Less than half a cycle in all is no oscillation.
    power[: padded // (2 * len(even))] = 0.0
    best = int(np.argmax(power))
    omega = 2 * np.pi * best * (len(even) - 1) / (padded * span)
    omega = _sharpened(even, level, omega)
    return omega, omega * span / (2 * np.pi)


def _sharpened(time: Real, values: Real, omega: float) -> float:
    """The frequency near `omega` whose sinusoid fits best.

    A short record displaces the peak of its spectrum.
    """
    per_cycle = 2 * np.pi / omega * len(time) / (time[-1] - time[0])
    step = max(1, min(len(time) // 4096, int(per_cycle // 16)))
    time, values = time[::step][: 1 << 14], values[::step][: 1 << 14]
    width = 1.5 * np.pi / (time[-1] - time[0])
    # One and a half lines of the spectrum to either side, by which a short record may displace its
    # peak.
    trials = np.linspace(max(omega - width, 0.3 * omega), omega + width, TRIALS)
    return float(trials[int(np.argmax(_explained(time, values, trials)))])


def _explained(time: Real, values: Real, omega: Real) -> Real:
    """Sum of squares that each frequency's sinusoid takes from `values` less level and drift."""
    # A drift of a short record looks like part of a slow oscillation: it is taken out of all trials
    # alike.
    straight, _ = np.linalg.qr(np.column_stack([np.ones_like(time), time - time[0]]))
    turns = np.multiply.outer(omega, time - time[0])
    # Level and drift taken out of all three, only the two by two normal equations of cosine and
    # sine are left.
    c, s, rest = (
        part - (part @ straight) @ straight.T for part in (np.cos(turns), np.sin(turns), values)
    )
    cc, cs, ss = (np.einsum("ij,ij->i", one, other) for one, other in ((c, c), (c, s), (s, s)))
    cr, sr = c @ rest, s @ rest
    # Within a small part of a period cosine and sine look like level and drift, and explain nothing
    # more.
    spare = cc * ss - cs**2
    apart = spare > ROUNDING * cc * ss
    gain = np.where(apart, ss * cr**2 - 2.0 * cs * cr * sr + cc * sr**2, 0.0)
    return gain / np.where(apart, spare, 1.0)


def steady_part(record: MendedSignals, omega: float) -> Steady:
    """The longest part with constant displacement amplitude and no initial force transient.

    Parameters
    ----------
    record : MendedSignals
        The signals.
    omega : float
        Angular frequency in rad/s.

    Returns
    -------
    Steady
        The part; the whole record where the amplitude never settles, with a note that says so.
    """
    begin, end = float(record.time[0]), float(record.time[-1])
    whole = Steady(begin, np.nextafter(end, np.inf))
    quarter = _quarter(record, omega)
    if record.span < 4 * np.pi / omega:
        return Steady(
            whole.start, whole.stop, ("fewer than two cycles: the whole record was used",)
        )
    moved, force, spread = _demodulated(record, omega, quarter)
    size = np.abs(moved)
    if not np.nanmax(size, initial=0.0) > 0:
        return whole
    # Of pauses and run-ups the amplitude is mostly noise: they do not say how large that is.
    loud = size > LOUD * np.nanmax(size)
    noise = float(np.nanmedian(spread[loud] / size[loud]))
    # As strict as the noise allows, and less so only where nothing is found.
    for tolerance in max(STEADY, 4 * noise) * np.array([1.0, 2.0, 4.0]):
        first, last = _longest_level(np.where(loud, size, np.nan), float(tolerance))
        # A shorter run is a single period, of which nobody can say that it was steady.
        if last - first > QUARTERS:
            first += _transient(force[first:last] / moved[first:last])
            start, stop = begin + first * quarter, begin + (last + QUARTERS - 1) * quarter
            notes: tuple[str, ...] = ()
            if tolerance > TOLD * STEADY:
                notes = (f"the amplitude is steady only within {100 * tolerance:.2g} %",)
            return Steady(start, min(stop, whole.stop), notes)
    return Steady(
        whole.start, whole.stop, ("the amplitude never settles: the whole record was used",)
    )


def _quarter(record: MendedSignals, omega: float) -> float:
    """A quarter of a period, or of so many that a long record has at most `MOST` quarters, in s."""
    quarter = 2 * np.pi / omega / QUARTERS
    return float(quarter * max(1, np.ceil(record.span / quarter / MOST)))


def _demodulated(
    record: MendedSignals, omega: float, quarter: float
) -> tuple[Complex, Complex, Real]:
    """First-harmonic amplitudes of both channels over four quarters, from each quarter on.

    Returns
    -------
    displacement, force : ndarray of complex, shape (m,)
        Amplitudes, nan where samples are missing.
    spread : ndarray, shape (m,)
        Standard deviation of the displacement amplitude.
    """
    sums = _quarter_sums(record, omega, quarter)
    # Sums of quarters are added up: no sample is looked at twice, however much the periods overlap.
    rolled = np.lib.stride_tricks.sliding_window_view(sums, QUARTERS, axis=0).sum(axis=-1)
    normal = rolled[:, :9].reshape(-1, 3, 3)
    right = np.swapaxes(rolled[:, 9:15].reshape(-1, 2, 3), 1, 2)
    # A period with gaps leaves cosine and sine alike: it tells nothing.
    good = np.linalg.cond(np.nan_to_num(normal)) < UNLIKE
    normal[~good] = np.eye(3)
    solved = np.linalg.solve(normal, right)
    amplitude = solved[:, 1] - 1j * solved[:, 2]
    amplitude[~good] = np.nan
    count = rolled[:, 0]
    left = np.maximum(rolled[:, 15] - np.sum(solved[:, :, 0] * right[:, :, 0], axis=1), 0.0)
    spread = np.sqrt(2 * left / np.maximum(count - 3, 1) / np.maximum(count, 1))
    return amplitude[:, 0], amplitude[:, 1], spread


def _quarter_sums(record: MendedSignals, omega: float, quarter: float) -> Real:
    """Sums (bins, 16) over each quarter.

    Of (1, cos, sin) by itself, by the channels, and of the squared displacement.
    """
    begin = float(record.time[0])
    bins = int(record.span / quarter) + 1
    sums, origin = np.zeros((bins, 16)), None
    for time, both in record.blocks():
        # About the first sample: squares of a large offset would leave no digits for the
        # oscillation.
        if origin is None:
            origin = both[0]
        phase = omega * (time - begin)
        which = np.minimum(((time - begin) / quarter).astype(int), bins - 1)
        c, s = np.cos(phase), np.sin(phase)
        q, u = (both - origin).T
        by_itself = (None, c, s, c, c * c, c * s, s, c * s, s * s)
        by_channels = (q, q * c, q * s, u, u * c, u * s)
        # A block holds few of the quarters of a long record.
        low = high = 0
        if len(which):
            low, high = int(which[0]), int(which[-1]) + 1
        for column, term in enumerate((*by_itself, *by_channels, q * q)):
            sums[low:high, column] += np.bincount(which - low, term, high - low)
    return sums


def _longest_level(size: Real, tolerance: float) -> tuple[int, int]:
    """The longest run of values within a relative `tolerance` of one level.

    The higher level wins a tie.
    """
    best = (0, 0)
    # Levels are tried among those that occur: whichever is held longest is the one that was set.
    levels = np.unique(np.nanquantile(size, np.linspace(0.0, 1.0, 65)))[::-1]
    for level in levels:
        inside = np.abs(size - level) <= tolerance * level
        edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
        starts, stops = edges[::2], edges[1::2]
        if len(starts):
            longest = int(np.argmax(stops - starts))
            run = int(starts[longest]), int(stops[longest])
            best = max(best, run, key=lambda r: r[1] - r[0])
    return best


def _transient(stiffness: Complex) -> int:
    """How many leading values differ from those of the second half by more than their scatter."""
    settled = stiffness[len(stiffness) // 2 :]
    # A transient is over in the second half, if ever.
    centre = np.median(settled.real) + 1j * np.median(settled.imag)
    away = np.abs(stiffness - centre)
    # Median and not variance, as a transient must not widen the limit that it is told by.
    limit = max(0.05 * abs(centre), 6 * float(np.median(away[len(away) // 2 :])))
    outside = np.flatnonzero(away[: len(away) // 2] > limit)
    # Only an unbroken beginning is a transient; what comes later is scatter.
    leading = 0
    if len(outside):
        leading = int(np.argmin(np.append(away[: len(away) // 2] > limit, False)))
    return min(leading, max(0, len(stiffness) - QUARTERS - 1))
