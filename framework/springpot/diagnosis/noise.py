"""The data as they are diagnosed: repeats averaged, points thinned, and the noise of the averages."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_quantile, f_sf
from springpot.measurement import CONDITIONS, Measurement, sweeps_of
from springpot.rheology import Complex, Model, Real

from .policy import NOISE

Rows: TypeAlias = NDArray[np.int64]


LEAST_VARIANCE = 1e-30
"""Stands for no scatter at all, of which there is no logarithm."""
Source = Literal["given", "repeats", "estimated"]


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

    def of(self, rows: NDArray[np.bool_]) -> Noise:
        """The noise of some of the points, (n,)."""
        return replace(self, sd=self.sd[rows])

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
    """One hypothesis on how the noise depends on the point; its scales are fitted.

    Parameters
    ----------
    real, imag : ndarray, shape (n,)
        Standard deviations of K' and K'' up to a scale.
    tied : bool
        Whether both have the same scale.
    price : float
        Minus twice the log-likelihood by which it must outdo the first shape.
    """

    real: Real
    imag: Real
    tied: bool
    price: float

    def of(self, rows: NDArray[np.bool_]) -> Shape:
        """The same for some of the points, (n,)."""
        return replace(self, real=self.real[rows], imag=self.imag[rows])

    def fit(self, scatter: Scatter) -> tuple[float, Complex]:
        """Minus twice the log-likelihood plus its price, and the standard deviations (n,)."""
        total = float(np.sum(scatter.dof))
        real = float(np.sum(scatter.real / self.real**2)) / total
        imag = float(np.sum(scatter.imag / self.imag**2)) / total
        scales = 2
        if self.tied:
            real = imag = 0.5 * (real + imag)
            scales = 1
        real, imag = max(real, LEAST_VARIANCE), max(imag, LEAST_VARIANCE)
        logs = 2.0 * float(np.sum(scatter.dof * (np.log(self.real) + np.log(self.imag))))
        cost = total * (np.log(real) + np.log(imag)) + logs
        penalty = scales * np.log(2.0 * max(total, 1.0))
        sd = np.sqrt(real) * self.real + 1.0j * np.sqrt(imag) * self.imag
        return float(cost + penalty + self.price), np.asarray(sd, dtype=np.complex128)


def shapes_of(measurement: Measurement) -> Iterator[Shape]:
    """Noise proportional to |K|, to each part by itself, or with a constant-force floor beside it."""
    size = measurement.magnitude
    parts = [np.maximum(np.abs(part), 1e-6 * size) for part in (measurement.storage, measurement.loss)]
    yield Shape(size, size, True, 0.0)
    yield Shape(size, size, False, NOISE.unusual_shape)
    yield Shape(parts[0], parts[1], True, NOISE.unusual_shape)
    amplitude = measurement.conditions.get("amplitude", np.ones(len(measurement)))
    force = size * amplitude
    if force.max() > NOISE.force_range * force.min():
        for level in NOISE.force_levels:
            floor = np.hypot(size, level * force.min() / amplitude)
            yield Shape(floor, floor, True, NOISE.force_floor)


def best_shape(measurement: Measurement, scatter: Scatter) -> Complex:
    """Standard deviations (n,) of the shape that the scatter favours."""
    fits = [shape.fit(scatter) for shape in shapes_of(measurement)]
    return min(fits, key=lambda fit: fit[0])[1]


def robust_shape(measurement: Measurement, residual: Complex, rows: NDArray[np.bool_]) -> Complex:
    """Standard deviations (n,), up to a scale, of the shape that a residual favours, whatever stands out from it.

    By the likelihood of Student's t (Lange, Little and Taylor 1989, doi:10.2307/2290063): where the noise of some
    points is larger, they must not be set aside as outliers before their noise is known.

    Parameters
    ----------
    measurement : Measurement
        The data.
    residual : ndarray of complex, shape (m,)
        The scatter of some of them about slow curves, in the unit of K.
    rows : ndarray of bool, shape (n,)
        Which these are.
    """
    shapes = list(shapes_of(measurement))
    costs = [_student_cost(shape.of(rows), residual) + shape.price for shape in shapes]
    best = shapes[int(np.argmin(costs))]
    real, imag = _student_scales(best.of(rows), residual)
    return np.asarray(real * best.real + 1j * imag * best.imag, dtype=np.complex128)


def _student_scales(shape: Shape, residual: Complex) -> tuple[float, float]:
    """Scales of both parts, by iterated reweighting."""
    parts = [np.abs(residual.real / shape.real), np.abs(residual.imag / shape.imag)]
    if shape.tied:
        scale = _student_scale(np.concatenate(parts))
        return scale, scale
    return _student_scale(parts[0]), _student_scale(parts[1])


def _student_scale(size: Real) -> float:
    square = size**2
    variance = max(float(np.mean(square)), LEAST_VARIANCE)
    for _ in range(NOISE.student_rounds):
        weight = (NOISE.student_dof + 1.0) / (NOISE.student_dof + square / variance)
        variance = max(float(np.mean(weight * square)), LEAST_VARIANCE)
    return float(np.sqrt(variance))


def _student_cost(shape: Shape, residual: Complex) -> float:
    """Minus twice the log-likelihood, and what a second scale costs."""
    total = 0.0
    scales = _student_scales(shape, residual)
    for part, form, scale in zip((residual.real, residual.imag), (shape.real, shape.imag), scales, strict=True):
        square = (part / (scale * form)) ** 2
        tails = (NOISE.student_dof + 1.0) * np.log1p(square / NOISE.student_dof)
        total += float(np.sum(2.0 * np.log(scale * form) + tails))
    spent = 1 if shape.tied else 2
    return total + spent * float(np.log(2.0 * len(residual)))


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
        if self.gains is None:
            return 0.0
        return float(np.sqrt(np.mean(np.abs(self.gains) ** 2)))

    def deviations(self) -> Complex:
        """Each measured row, its run's own gain taken away, less the mean of its repeats, over |K|; shape (N,)."""
        gains = 0.0 if self.gains is None else self.gains
        return (self.raw.stiffness / (1.0 + gains) - self.mean.stiffness[self.group]) / self.raw.magnitude

    def without(self, rows: NDArray[np.bool_]) -> Averaged:
        """The averages without some of them, (n,); the reference temperature stays."""
        mean = self.mean.subset(np.flatnonzero(~rows))
        scatter = Scatter(*(column[~rows] for column in self.scatter))
        return Averaged(mean, mean, scatter, np.arange(len(mean)))

    def relative_rms(self, model: Model, theta: Real) -> float:
        """Root mean square of |K_model - K| / |K| over all measured rows."""
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
    size = NOISE.least_relative * measurement.magnitude
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
    for power in range(12, -NOISE.most_digits, -1):
        step = 10.0 ** power_of(power)
        steps = size / step
        if np.all(np.abs(steps - np.round(steps)) <= 1e-9 * np.abs(steps)):
            return power if np.max(np.abs(steps)) < 10.0**NOISE.most_digits else None
    return None


def average_repeats(measurement: Measurement) -> Averaged:
    """Mean of the repeats of each point, and their scatter about it."""
    group, first = _groups(measurement)
    count = np.bincount(group).astype(float)
    if len(first) == len(measurement):
        nothing = np.zeros(len(first))
        return Averaged(measurement, measurement, Scatter(nothing, nothing, nothing), group)
    mean = _means(measurement.stiffness, group)
    if np.all(np.abs(measurement.stiffness / mean[group] - 1.0) < NOISE.least_relative):
        # Rows that were written again are no repeats: they tell nothing of the noise.
        return average_repeats(replace(measurement.subset(first), repeat=None))
    gains, spent = _replicate_gains(measurement, measurement.stiffness / mean[group] - 1.0, count[group])
    stiffness = measurement.stiffness
    if gains is not None:
        stiffness = stiffness / (1.0 + gains)
    mean = _means(stiffness, group)
    off = stiffness - mean[group]
    real, imag = (np.bincount(group, part**2).astype(float) for part in (off.real, off.imag))
    # A gain is estimated from all points of a run: each point pays its share of that degree of freedom.
    free = max(1.0 - spent / max(float(np.sum(count - 1.0)), 1.0), 0.0)
    scatter = Scatter(real, imag, (count - 1.0) * free)
    averaged = measurement.subset(first)
    sd = averaged.sd
    if sd is not None:
        sd = sd / np.sqrt(count)
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
    usable = (count > 1.0) & (np.bincount(run)[run] >= NOISE.points_of_a_run)
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
    differ = [f_sf(part / (2.0 * gain_spent) / unit, 2.0 * gain_spent, free) < NOISE.runs_differ
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
    if dof < NOISE.enough_repeats:
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
    low, high = chi2_quantile([NOISE.doubt / 2, 1 - NOISE.doubt / 2], dof) / dof
    return float(low), float(high)


def thinned(measurement: Measurement) -> Measurement:
    """At most `MOST_POINTS` rows, in the order in which they stand.

    Every sweep keeps as many points as the longest may have, spread evenly over its own, with all their repeats. Only
    where that leaves fewer than `FEWEST` of each, whole sweeps are left out; only of more than `MOST_REPEATS` repeats
    some are.
    """
    if len(measurement) <= NOISE.most_points:
        return measurement
    data = average_repeats(measurement)
    points = np.split(np.argsort(data.group, kind="stable"), np.cumsum(np.bincount(data.group))[:-1])
    most = max(NOISE.most_repeats, NOISE.most_points // len(points))
    points = [_even(rows, most) for rows in points]
    size = np.array([len(rows) for rows in points])
    lines = [sweep.rows for sweep in sweeps_of(data.mean)]

    def fits(lines: Sequence[Rows], each: int) -> bool:
        return sum(int(size[_even(line, each)].sum()) for line in lines) <= NOISE.most_points

    kept = _largest(
        lambda count: fits([lines[i] for i in _spread(len(lines), count)], NOISE.fewest_of_a_sweep), len(lines)
    )
    lines = [lines[i] for i in _spread(len(lines), kept)]
    each = _largest(lambda count: fits(lines, count), max(len(line) for line in lines))
    return measurement.subset(np.sort(np.concatenate([points[i] for line in lines for i in _even(line, each)])))


def _largest(fits: Callable[[int], bool], most: int) -> int:
    """The largest number up to `most` that fits, by halving; 1 where none does."""
    low, high = 1, most + 1
    while high - low > 1:
        middle = (low + high) // 2
        if fits(middle):
            low = middle
        else:
            high = middle
    return low


def _even(rows: Rows, most: int) -> Rows:
    return rows[_spread(len(rows), most)]


def _spread(count: int, most: int) -> Rows:
    """At most so many of the numbers 0, ..., count - 1, from end to end."""
    return np.linspace(0, count - 1, min(count, most)).round().astype(np.int64)
