"""The noise floor: from repeats, else as given, else estimated; every error is read against it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from springpot.measurement import CONDITIONS, Measurement
from springpot.rheology import Complex, Model, Real

Rows: TypeAlias = NDArray[np.int64]
Source = Literal["given", "repeats", "estimated"]
LEAST_RELATIVE = 1e-7
"""No measurement scatters less than this share of |K|; smaller differences are arithmetic."""
DOUBT = 1e-4
"""Chance below which given standard deviations are held to be misstated."""
OUTLYING = 2e-4
"""Chance below which the scatter at one frequency is held to be no noise."""
HELD = {"amplitude": 0.02, "temperature": 0.5}
"""How nearly a rig holds what was set: repeats whose amplitudes (as a share) or temperatures (in kelvin) lie closer
than this to one another are repeats of one point."""
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
    """

    raw: Measurement
    mean: Measurement
    scatter: Scatter
    group: Rows

    def deviations(self) -> Complex:
        """Each measured row less the mean of its repeats, over |K|; shape (N,)."""
        return (self.raw.stiffness - self.mean.stiffness[self.group]) / self.raw.magnitude

    def relative_rms(self, model: Model, theta: Real) -> float:
        """Root mean square of |K - K_m| / |K_m| over all measured rows."""
        off = np.abs(model.stiffness(theta, self.raw.points) / self.raw.stiffness - 1.0)
        return float(np.sqrt(np.mean(off**2)))

    def floor(self, noise: Noise) -> float:
        """The same for noise alone: root mean square of its |dK| / |K| over all measured rows."""
        count = self.scatter.dof + 1.0
        single = (noise.sd.real**2 + noise.sd.imag**2) * count / self.mean.magnitude**2
        return float(np.sqrt(np.sum(count * single) / np.sum(count)))


def at_least_rounding(sd: Complex, measurement: Measurement) -> Complex:
    """Standard deviations (n,) no smaller than what writing the values with few digits has rounded away."""
    least = [_last_digit(part) / np.sqrt(12.0) for part in (measurement.storage, measurement.loss)]
    size = LEAST_RELATIVE * measurement.magnitude
    parts = [np.maximum(np.maximum(part, digit), size) for part, digit in zip((sd.real, sd.imag), least, strict=True)]
    return np.asarray(parts[0] + 1j * parts[1], dtype=np.complex128)


def _last_digit(values: Real) -> float:
    """Power of ten of which all values are multiples; 0 where they carry all the digits of a number."""
    if not np.any(values):
        return 0.0
    for power in range(12, -13, -1):
        step = 10.0**power
        steps = values / step
        if np.all(np.abs(steps - np.round(steps)) <= 1e-9 * np.abs(steps)):
            return step if np.max(np.abs(steps)) < 1e9 else 0.0
    return 0.0


def average_repeats(measurement: Measurement) -> Averaged:
    """Mean of the repeats of each point, and their scatter about it."""
    group, first = _groups(measurement)
    count = np.bincount(group).astype(float)
    mean = (np.bincount(group, measurement.storage) + 1j * np.bincount(group, measurement.loss)) / count
    off = measurement.stiffness - mean[group]
    real, imag = (np.bincount(group, part**2).astype(float) for part in (off.real, off.imag))
    scatter = Scatter(real, imag, count - 1.0)
    if len(first) == len(measurement):
        return Averaged(measurement, measurement, scatter, group)
    averaged = measurement.subset(first)
    sd = None if averaged.sd is None else averaged.sd / np.sqrt(count)
    return Averaged(measurement, replace(averaged, stiffness=mean, sd=sd, repeat=None), scatter, group)


def _groups(measurement: Measurement) -> tuple[Rows, Rows]:
    """Which averaged row each row belongs to, and the first row of each; only marked repeats are merged."""
    columns: list[Real] = [np.asarray(np.round(np.log(measurement.omega), 6), dtype=np.float64)]
    columns += [_nominal(measurement, name) for name in CONDITIONS if name in measurement.conditions]
    if measurement.repeat is None:
        columns = [np.arange(len(measurement), dtype=float)]
    _, first, group = np.unique(np.column_stack(columns), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int64)
    rank[order] = np.arange(len(first))
    return rank[group.ravel()], first[order].astype(np.int64)


def _nominal(measurement: Measurement, name: str) -> Real:
    """Number of the value that was set, in ascending order, for values that a rig holds only nearly."""
    column = measurement.conditions[name]
    x = np.log(np.maximum(np.abs(column), 1e-300)) if name == "amplitude" else column
    order = np.argsort(x, kind="stable")
    step = np.concatenate([[0], np.diff(x[order]) > HELD[name]])
    number = np.empty(len(x))
    number[order] = np.cumsum(step)
    return number


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


def robust_variance(rough: Real, dof: int, omega: Real) -> float:
    """Variance of whitened scatter without the frequencies at which it is far larger than elsewhere.

    An outlier, a notch or line interference is confined to a few frequencies, whatever the sweep; noise is not.

    Parameters
    ----------
    rough : ndarray, shape (2n,)
        Whitened scatter, of variance one if the weights are right.
    dof : int
        Its degrees of freedom.
    omega : ndarray, shape (n,)
        Angular frequencies.
    """
    _, group = np.unique(np.round(np.log(omega), 6), return_inverse=True)
    group = np.concatenate([group.ravel(), group.ravel()])
    count = np.bincount(group).astype(float)
    squares = np.bincount(group, rough**2) * len(rough) / dof
    usual = chi2.ppf(1.0 - OUTLYING, count)
    kept = np.ones(len(count), dtype=bool)
    for _ in range(10):
        variance = np.sum(squares[kept]) / np.sum(count[kept])
        within = squares <= usual * variance
        if np.array_equal(within, kept) or np.sum(count[within]) < 0.7 * len(rough):
            break
        kept = within
    return float(np.sum(squares[kept]) / np.sum(count[kept]))
