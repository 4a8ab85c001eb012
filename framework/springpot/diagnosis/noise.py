"""The noise floor: from repeats, else as given, else estimated; every error is read against it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, gamma
from scipy.stats import f as f_distribution

from springpot.measurement import CONDITIONS, Measurement
from springpot.rheology import Complex, Model, Real

from .bases import orthonormal
from .sweeps import drift_shapes, spectrum, sweeps_of, waves

if TYPE_CHECKING:
    from .frame import Frame

Rows: TypeAlias = NDArray[np.int64]
Source = Literal["given", "repeats", "estimated"]
LEAST_RELATIVE = 1e-7
"""No measurement scatters less than this share of |K|; smaller differences are arithmetic."""
MOST_RIPPLES = 2
"""Periods that are taken out of the scatter; a third could follow noise."""
RIPPLE_ALARM = 1e-4
"""Chance of white noise whose strongest period is as strong as one that is taken out."""
SLOWEST_RIPPLE = 16.0
"""Points of the longest period: longer waves are slow structure already."""
LEAST_NEW = 1e-3
"""Share of a curve that those already taken out must leave for it to count."""
FEWEST_FREE = 20.0
"""Degrees of freedom below which a period would take too many of them."""
LEAST_KEPT = 0.7
"""Share of the data below which what is left out is no few frequencies any more."""
MOST_DIGITS = 9
"""Digits from which a value counts as written in full: single precision has seven."""
POINTS_OF_A_RUN = 6
"""Points of a run from which its own gain says little of each of them."""
RUNS_DIFFER = 1e-4
"""Chance of replicates that differ as a whole by so much where only their points scatter."""
DOUBT = 1e-4
"""Chance below which given standard deviations are held to be misstated."""
OUTLYING = 2e-4
"""Chance below which the scatter at one frequency is held to be no noise."""
UNUSUAL = 10.0
"""Minus twice the log-likelihood that noise of another shape than "proportional to |K|" must bring: of few points
some shape fits chance best, and structure is then seen where there is none."""
ENOUGH_REPEATS = 8
"""Degrees of freedom below which the scatter of repeats says too little about the noise."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Standard deviations of the measured points, and how well they are known.

    Parameters
    ----------
    sd : ndarray of complex, shape (n,)
        Of K' (real part) and K'' (imaginary part) of each point.
    dof : float
        Degrees of freedom behind their common scale; infinite where it is known.
    source : {"given", "repeats", "estimated"}
        Where they come from.
    doubt : str
        One sentence where the given ones disagree with the data's own scatter.
    """

    sd: Complex
    dof: float
    source: Source
    doubt: str = ""

    @property
    def overruled(self) -> bool:
        """Whether other standard deviations were given."""
        return self.source == "estimated" and bool(self.doubt)

    @property
    def weights(self) -> Complex:
        """Reciprocal standard deviations."""
        return np.asarray(1.0 / self.sd.real + 1.0j / self.sd.imag, dtype=np.complex128)

    def log_likelihood(self, rss: float, size: int) -> float:
        """Log-likelihood of a whitened residual sum of squares, an unknown scale integrated or profiled out."""
        if self.dof == inf:
            return -0.5 * rss
        if self.source == "repeats":
            return -0.5 * (self.dof + size) * float(np.log1p(rss / self.dof))
        return -0.5 * size * float(np.log(max(rss, 1e-300)))

    def scaled(self, factor: float) -> Noise:
        """The same shape with every standard deviation multiplied."""
        return replace(self, sd=self.sd * factor)


class Scatter(NamedTuple):
    """Squared scatter of each point about its mean or about a smooth curve.

    Attributes
    ----------
    real, imag : ndarray, shape (n,)
        Sums of squared deviations of K' and of K''.
    dof : ndarray, shape (n,)
        Degrees of freedom behind each of them.
    """

    real: Real
    imag: Real
    dof: Real


@dataclass(frozen=True, eq=False)
class Shape:
    """One hypothesis on how the noise depends on the point; its scales are fitted."""

    real: Real
    imag: Real
    tied: bool

    def fit(self, scatter: Scatter) -> tuple[float, Complex]:
        """Minus twice the log-likelihood plus its penalty, and the standard deviations (n,)."""
        total = float(np.sum(scatter.dof))
        var = [
            float(np.sum(s / size**2)) / total for s, size in ((scatter.real, self.real), (scatter.imag, self.imag))
        ]
        if self.tied:
            var = [0.5 * (var[0] + var[1])] * 2
        var = [max(v, 1e-30) for v in var]
        logs = 2.0 * float(np.sum(scatter.dof * (np.log(self.real) + np.log(self.imag))))
        cost = total * (np.log(var[0]) + np.log(var[1])) + logs
        penalty = (1 if self.tied else 2) * np.log(2.0 * max(total, 1.0))
        sd = np.sqrt(var[0]) * self.real + 1.0j * np.sqrt(var[1]) * self.imag
        return float(cost + penalty), np.asarray(sd, dtype=np.complex128)


def shapes_of(measurement: Measurement) -> Iterator[Shape]:
    """Noise proportional to |K|, to each part by itself, or with a constant-force floor beside it."""
    size = measurement.magnitude
    parts = [np.maximum(np.abs(part), 1e-6 * size) for part in (measurement.storage, measurement.loss)]
    yield Shape(size, size, True)
    yield Shape(size, size, False)
    yield Shape(parts[0], parts[1], True)
    amplitude = measurement.conditions.get("amplitude", np.ones(len(measurement)))
    force = size * amplitude
    if force.max() > 3.0 * force.min():
        for level in np.geomspace(force.min(), force.max(), 7)[1:]:
            floor = np.hypot(size, level / amplitude)
            yield Shape(floor, floor, True)


def best_shape(measurement: Measurement, scatter: Scatter) -> Complex:
    """Standard deviations (n,) of the shape that the scatter favours."""
    usual, *others = (shape.fit(scatter) for shape in shapes_of(measurement))
    other = min(others, key=lambda fit: fit[0])
    return usual[1] if other[0] > usual[0] - UNUSUAL else other[1]


@dataclass(frozen=True, eq=False)
class Averaged:
    """Data with their repeats averaged.

    Attributes
    ----------
    raw : Measurement
        As measured.
    mean : Measurement
        One row for each frequency and set of conditions; `raw` itself where nothing is repeated.
    scatter : Scatter
        Of the repeats about their mean, with no degree of freedom where nothing is repeated.
    group : ndarray of int, shape (N,)
        Row of `mean` that each measured row belongs to.
    gains : ndarray of complex, shape (N,), optional
        By how much the run that a row belongs to is larger than the mean of its replicates, relative to K, where
        runs differ by more than the scatter of their points: another specimen, loaded anew. It was taken away before
        the mean and the scatter were formed.
    """

    raw: Measurement
    mean: Measurement
    scatter: Scatter
    group: Rows
    gains: Complex | None = None

    @property
    def own_gain(self) -> float:
        """Root mean square of what sets replicates apart as a whole, relative to |K|."""
        return 0.0 if self.gains is None else float(np.sqrt(np.mean(np.abs(self.gains) ** 2)))

    def deviations(self) -> Complex:
        """Each measured row, its run's own gain taken away, less the mean of its repeats, over |K|; shape (N,)."""
        gains = 0.0 if self.gains is None else self.gains
        return (self.raw.stiffness / (1.0 + gains) - self.mean.stiffness[self.group]) / self.raw.magnitude

    def relative_rms(self, model: Model, theta: Real) -> float:
        """Root mean square of |K - K_m| / |K_m| over all measured rows."""
        off = np.abs(model.stiffness(theta, self.raw.points) / self.raw.stiffness - 1.0)
        return float(np.sqrt(np.mean(off**2)))

    def floor(self, noise: Noise) -> float:
        """The same for noise alone: root mean square of its |dK| / |K| over all measured rows."""
        count = self.scatter.dof + 1.0
        single = (noise.sd.real**2 + noise.sd.imag**2) * count / self.mean.magnitude**2
        return float(np.sqrt(np.sum(count * single) / np.sum(count) + self.own_gain**2))


def at_least_rounding(sd: Complex, measurement: Measurement) -> Complex:
    """Standard deviations (n,) no smaller than what writing the values with few digits has rounded away."""
    least = [rounding_step(part) / np.sqrt(12.0) for part in (measurement.storage, measurement.loss)]
    size = LEAST_RELATIVE * measurement.magnitude
    parts = [np.maximum(np.maximum(part, digit), size) for part, digit in zip((sd.real, sd.imag), least, strict=True)]
    return np.asarray(parts[0] + 1j * parts[1], dtype=np.complex128)


def rounding_step(values: Real) -> Real:
    """How far apart the next values lie that could have been written in place of each; shape (n,).

    A column is written with so many decimals, or with so many significant digits, or both: the coarser step counts.
    Zero where the values carry all the digits of a number.
    """
    size = np.abs(values[values != 0.0])
    if len(size) == 0:
        return np.zeros(len(values))
    decimals = _fewest(lambda power: np.full(len(size), float(power)), size)
    exponent = np.floor(np.log10(np.maximum(np.abs(values), size.min())))
    digits = _fewest(lambda power: np.floor(np.log10(size)) + power, size)
    step = np.zeros(len(values))
    if decimals is not None:
        step = np.maximum(step, 10.0**decimals)
    if digits is not None:
        step = np.maximum(step, 10.0 ** (exponent + digits))
    return step


def _fewest(power_of: Callable[[int], Real], size: Real) -> int | None:
    """The largest number whose powers of ten (n,) divide all values; None where only a full number's digits do."""
    for power in range(12, -MOST_DIGITS, -1):
        step = 10.0 ** power_of(power)
        steps = size / step
        if np.all(np.abs(steps - np.round(steps)) <= 1e-9 * np.abs(steps)):
            return power if np.max(np.abs(steps)) < 10.0**MOST_DIGITS else None
    return None


def average_repeats(measurement: Measurement) -> Averaged:
    """Mean of the repeats of each point, and their scatter about it."""
    group, first = _groups(measurement)
    count = np.bincount(group).astype(float)
    if len(first) == len(measurement):
        nothing = np.zeros(len(first))
        return Averaged(measurement, measurement, Scatter(nothing, nothing, nothing), group)
    mean = _means(measurement.stiffness, group)
    gains, spent = _replicate_gains(measurement, measurement.stiffness / mean[group] - 1.0, count[group])
    stiffness = measurement.stiffness if gains is None else measurement.stiffness / (1.0 + gains)
    mean = _means(stiffness, group)
    off = stiffness - mean[group]
    real, imag = (np.bincount(group, part**2).astype(float) for part in (off.real, off.imag))
    # A gain is estimated from all points of a run: each point pays its share of that degree of freedom.
    free = max(1.0 - spent / max(float(np.sum(count - 1.0)), 1.0), 0.0)
    scatter = Scatter(real, imag, (count - 1.0) * free)
    averaged = measurement.subset(first)
    sd = None if averaged.sd is None else averaged.sd / np.sqrt(count)
    return Averaged(measurement, replace(averaged, stiffness=mean, sd=sd, repeat=None), scatter, group, gains)


def _means(values: Complex, group: Rows) -> Complex:
    """Mean of each group, shape (groups,)."""
    count = np.bincount(group)
    return np.asarray((np.bincount(group, values.real) + 1j * np.bincount(group, values.imag)) / count)


def _replicate_gains(measurement: Measurement, relative: Complex, count: Real) -> tuple[Complex | None, float]:
    """The gain (N,) of the run that each row belongs to, and how many were estimated.

    A run is what was measured in one repeat under one set of conditions. None where runs do not differ as a whole by
    an analysis of variance, or where they differ in slope as well: then only their full scatter is honest.
    """
    columns = [measurement.levels(name) for name in CONDITIONS if name in measurement.conditions]
    if measurement.repeat is not None:
        columns.append(measurement.repeat)
    _, run = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    run = run.ravel()
    usable = (count > 1.0) & (np.bincount(run)[run] >= POINTS_OF_A_RUN)
    if not np.any(usable):
        return None, 0.0
    run, values = np.unique(run[usable], return_inverse=True)[1], relative[usable]
    x = np.log(measurement.omega[usable])
    mean = _means(values, run)
    gain_spent = float(np.max(run) + 1) * (1.0 - float(np.mean(1.0 / count[usable])))
    x = x - _means(x.astype(np.complex128), run).real[run]
    slope = np.bincount(run, values.real * x) + 1j * np.bincount(run, values.imag * x)
    slope = slope / np.maximum(np.bincount(run, x**2), 1e-300)
    by_gain = float(np.sum(np.abs(mean[run]) ** 2))
    by_slope = float(np.sum(np.abs(slope[run] * x) ** 2))
    left = float(np.sum(np.abs(values) ** 2)) - by_gain - by_slope
    free = 2.0 * (float(np.sum(1.0 - 1.0 / count[usable])) - 2.0 * gain_spent)
    if free < 1.0:
        return None, 0.0
    unit = max(left / free, 1e-300)
    differ = [f_distribution.sf(part / (2.0 * gain_spent) / unit, 2.0 * gain_spent, free) < RUNS_DIFFER
              for part in (by_gain, by_slope)]  # fmt: skip
    if not differ[0] or differ[1]:
        return None, 0.0
    gains = np.zeros(len(relative), dtype=np.complex128)
    gains[usable] = mean[run]
    return gains, gain_spent


def _groups(measurement: Measurement) -> tuple[Rows, Rows]:
    """Which averaged row each row belongs to, and the first row of each; only marked repeats are merged."""
    columns: list[Real] = [np.asarray(np.round(np.log(measurement.omega), 6), dtype=np.float64)]
    columns += [measurement.levels(name).astype(float) for name in CONDITIONS if name in measurement.conditions]
    if measurement.repeat is None:
        columns = [np.arange(len(measurement), dtype=float)]
    _, first, group = np.unique(np.column_stack(columns), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int64)
    rank[order] = np.arange(len(first))
    return rank[group.ravel()], first[order].astype(np.int64)


def noise_of_repeats(averaged: Averaged) -> Noise | None:
    """Noise of the averages, or None where too little is repeated."""
    scatter = averaged.scatter
    dof = 2.0 * float(np.sum(scatter.dof))
    if dof < ENOUGH_REPEATS:
        return None
    return Noise(best_shape(averaged.mean, scatter) / np.sqrt(scatter.dof + 1.0), dof, "repeats")


def checked(noise: Noise, variance: float, dof: float) -> Noise:
    """Noise as stated, with a word of doubt where the data's own scatter disagrees; too small noise is rescaled.

    Parameters
    ----------
    noise : Noise
        As given.
    variance : float
        Of the whitened scatter that neither the model nor structure follows; one if all is well.
    dof : float
        Its degrees of freedom.
    """
    if dof < 10:
        return noise
    low, high = plausible(dof)
    if low < variance < high:
        return noise
    factor = float(np.sqrt(variance))
    if factor < 1.0:
        doubt = (
            f"the given standard deviations are {1 / factor:.2g} times the data's own scatter: "
            "too large, or they hold errors that neighbouring points share; they are used as given"
        )
        return replace(noise, doubt=doubt)
    doubt = (
        f"the given standard deviations look too small: the data scatter {factor:.2g} times as much; "
        "the scatter is used instead"
    )
    return replace(noise.scaled(factor), dof=dof, source="estimated", doubt=doubt)


def plausible(dof: float) -> tuple[float, float]:
    """Least and largest variance of whitened scatter that standard deviations of the right size leave."""
    low, high = chi2.ppf([DOUBT / 2, 1 - DOUBT / 2], dof) / dof
    return float(low), float(high)


class Trimmed(NamedTuple):
    """What slow curves leave of a residual, and the frequencies whose scatter is noise.

    Attributes
    ----------
    left : ndarray, shape (2n,)
        The residual without the curves, which are fitted to the kept rows alone.
    kept : ndarray of bool, shape (2n,)
        Rows that are kept.
    dof : float
        Degrees of freedom of what is left in them.
    """

    left: Real
    kept: NDArray[np.bool_]
    dof: float

    @property
    def variance(self) -> float:
        """Of the scatter."""
        return float(np.sum(self.left[self.kept] ** 2)) / self.dof


def trimmed(frame: Frame) -> Trimmed:
    """The whitened scatter of a fit about slow curves, without the frequencies at which it is far larger."""
    followed, omega = np.concatenate([frame.absorbed, frame.structured], axis=1), frame.measurement.omega
    found = trimmed_residual(frame.residual, followed, omega)
    drift = frame.relative(drift_shapes(len(frame.measurement)))
    if found.dof >= FEWEST_FREE and _explains(drift, followed, found):
        followed = np.concatenate([followed, drift], axis=1)
        found = trimmed_residual(frame.residual, followed, omega)
    for _ in range(MOST_RIPPLES):
        if found.dof < FEWEST_FREE or (period := _ripple(frame, found)) == 0.0:
            break
        ripple = frame.relative(waves(frame.measurement, period))
        followed = np.concatenate([followed, ripple], axis=1)
        found = trimmed_residual(frame.residual, followed, omega)
    return found


def _explains(columns: Real, followed: Real, scatter: Trimmed) -> bool:
    """Whether columns explain more of a scatter than noise would, by the ratio of variances."""
    rows = scatter.kept
    inner = columns[rows] - followed[rows] @ np.linalg.lstsq(followed[rows], columns[rows], rcond=None)[0]
    kept = np.linalg.norm(inner, axis=0) > LEAST_NEW * np.linalg.norm(columns[rows], axis=0)
    basis = orthonormal(inner[:, kept])
    spent = float(basis.shape[1])
    if spent == 0.0 or scatter.dof <= spent:
        return False
    explained = float(np.sum((basis.T @ scatter.left[rows]) ** 2))
    left = max(float(np.sum(scatter.left[rows] ** 2)) - explained, 1e-300)
    ratio = (explained / spent) / (left / (scatter.dof - spent))
    return bool(f_distribution.sf(ratio, spent, scatter.dof - spent) < RIPPLE_ALARM)


def _ripple(frame: Frame, scatter: Trimmed) -> float:
    """Period, in points, of a ripple that the scatter holds; zero where the strongest one may be chance.

    Of white noise the power at each of n independent frequencies is a sum of exponentials, one for each part of each
    sweep; a periodic error of the analysis or of a resonance of the chain is not (Fisher 1929,
    doi:10.1098/rspa.1929.0151).
    """
    left = np.where(scatter.kept, scatter.left, 0.0)
    power = spectrum(frame.measurement, left[None])[0]
    lines = 2 * len(sweeps_of(frame.measurement))
    longest = len(power) - 1
    # Slow waves are structure, and told of elsewhere.
    first = int(np.ceil(2.0 * longest / SLOWEST_RIPPLE))
    if first + 1 >= len(power):
        return 0.0
    peak = first + int(np.argmax(power[first:]))
    mean = float(np.sum(left**2)) / lines
    chance = longest * float(gamma.sf(power[peak] / mean, lines))
    if chance > RIPPLE_ALARM:
        return 0.0
    fine = np.linspace(peak - 1.0, peak + 1.0, 41)[1:-1]
    tried = [float(np.sum((orthonormal(frame.relative(waves(frame.measurement, 2.0 * longest / x))).T @ left) ** 2))
             for x in fine]  # fmt: skip
    return 2.0 * longest / float(fine[int(np.argmax(tried))])


def trimmed_residual(residual: Real, followed: Real, omega: Real) -> Trimmed:
    """What curves leave of a residual, without the frequencies at which it is far larger.

    An outlier, a notch or line interference is confined to a few frequencies, whatever the sweep; noise is not. The
    curves are fitted anew without them, or they would be drawn towards what is left out; the first guess is the
    median over frequencies, which a notch of a few points does not move.

    Parameters
    ----------
    residual : ndarray, shape (2n,)
        Whitened residual.
    followed : ndarray, shape (2n, q)
        Orthonormal basis of the curves.
    omega : ndarray, shape (n,)
        Angular frequencies.
    """
    _, group = np.unique(np.round(np.log(omega), 6), return_inverse=True)
    group = np.concatenate([group.ravel(), group.ravel()])
    count = np.bincount(group).astype(float)
    usual, middle = chi2.ppf(1.0 - OUTLYING, count), chi2.median(count)
    kept = np.ones(len(count), dtype=bool)
    for turn in range(10):
        rows = kept[group]
        left = residual - followed @ np.linalg.lstsq(followed[rows], residual[rows], rcond=None)[0]
        found = Trimmed(left, rows, max(float(np.sum(rows)) - followed.shape[1], 1.0))
        # Curves take their share from every frequency alike.
        squares = np.bincount(group, left**2) * float(np.sum(rows)) / found.dof
        mean = float(np.sum(squares[kept]) / np.sum(count[kept]))
        variance = float(np.median(squares / middle)) if turn == 0 else mean
        within = squares <= usual * variance
        too_many = np.sum(count[within]) < LEAST_KEPT * len(residual)
        if too_many or (turn > 0 and np.array_equal(within, kept)):
            return found
        kept = within
    return found
