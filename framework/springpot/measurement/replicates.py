"""Repeats and replicates.

Their mean and scatter, the gain that each run has of its own, and how many are kept.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.rheology.points import Complex, Real
from springpot.thresholds import COURSE, OUTLIERS, REPEATS, VARIED

from ..distributions import Links, effective_share, fitted_memory, prewhitened
from ..numerics import SMALLEST, evenly, level_means, rms, set_numbers
from .independence import frequency_numbers
from .instrument import noise_before_rounding, shared_rounding
from .measurement import CONDITIONS, Measurement
from .mixed_up import (
    NOTE as TOGETHER,
    RUNS,
    largest_test,
    longest_memory,
    sweeps_of,
    told_apart,
)
from .rows import SAME_AMPLITUDE
from .scatter import (
    LEAST_RELATIVE,
    Noise,
    Scatter,
    noise_shape,
    steps_as_written,
    tails_of,
    turned_sd,
)

if TYPE_CHECKING:
    from springpot.rheology.model import Model

Rows: TypeAlias = NDArray[np.int64]

SETTLING_TIMES = np.geomspace(0.03, 3.0, 8)
"""Times to settle that are tried, as shares of all rows.

From a thirtieth to what is all but a straight line.
"""


class Thinned(NamedTuple):
    """What is kept of many points."""

    points: int
    """Points that are kept at most: more tell a smooth curve no better and cost time."""
    of_a_sweep: int
    """Points of a sweep that are kept before sweeps are left out."""
    repeats: int
    """Repeats of one point that are kept before points are left out."""


THINNED = Thinned(points=1500, of_a_sweep=10, repeats=30)


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
        By how much the run that a row belongs to is larger than the mean of its replicates,
        relative to K, where runs differ by more than the scatter of their points: another specimen,
        loaded anew. It was taken away before the mean and the scatter were formed.
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
        return rms(np.abs(self.gains))

    @property
    def count(self) -> Rows:
        """How many rows each mean is of, (n,)."""
        return np.bincount(self.group)

    @property
    def apart(self) -> Complex:
        """Each measured row, its run's own gain taken away, less the mean of its repeats, (N,)."""
        stiffness = self.raw.stiffness
        if self.gains is not None:
            stiffness = stiffness / (1.0 + self.gains)
        return np.asarray(stiffness - self.mean.stiffness[self.group], dtype=np.complex128)

    @cached_property
    def shared(self) -> Complex:
        """What all repeats of a point were rounded by alike, (n,): no scatter tells it."""
        size = self.mean.magnitude
        first = np.unique(self.group, return_index=True)[1]
        steps = steps_as_written(self.raw)[first]
        real, imag = (
            shared_rounding(
                noise_before_rounding(squares, self.scatter.dof, step, size) * size, step
            )
            for squares, step in zip(self.scatter[:2], (steps.real, steps.imag), strict=True)
        )
        return np.asarray(real + 1j * imag, dtype=np.complex128)

    def deviations(self) -> Complex:
        """The same over |K|, (N,)."""
        return self.apart / self.raw.magnitude

    def scatter_after(self, turn: Complex) -> Scatter:
        """Of each mean (n,), after its repeats were turned by unit numbers (n,)."""
        return Scatter(*_squares_of(self.apart * turn[self.group], self.group), self.scatter.dof)

    def without(self, rows: NDArray[np.bool_]) -> Averaged:
        """The averages without some of them, (n,); the reference temperature stays."""
        kept = ~rows[self.group]
        return Averaged(
            self.raw.subset(kept),
            self.mean.subset(~rows),
            Scatter(*(column[~rows] for column in self.scatter)),
            (np.cumsum(~rows) - 1)[self.group[kept]],
            None if self.gains is None else self.gains[kept],
        )

    def relative_rms(self, model: Model, theta: Real) -> float:
        """Root mean square of |K_model - K| / |K| over all measured rows."""
        off = np.abs(model.stiffness(theta, self.raw.points) / self.raw.stiffness - 1.0)
        return rms(off)

    def floor(self, noise: Noise) -> float:
        """The same for noise alone: root mean square of its |dK| / |K| over all measured rows."""
        # The noise is that of the means: single rows scatter by the root of their number more, but
        # for what all of them share.
        squares = (noise.sd.real**2 + noise.sd.imag**2) * self.count
        if noise.source == "repeats":
            squares = squares - (self.count - 1.0) * np.abs(self.shared) ** 2
        single = squares / self.mean.magnitude**2
        return float(np.sqrt(np.average(single, weights=self.count) + self.own_gain**2))


def average_repeats(measurement: Measurement) -> Averaged:
    """Mean of the repeats of each point, and their scatter about it.

    Parameters
    ----------
    measurement : Measurement
        The data, (N,); only rows that the column `repeat` marks as such are averaged.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> stiffness = np.array([10.0, 20.0, 12.0, 22.0]) + 1j
    >>> data = Measurement(np.array([1.0, 2.0, 1.0, 2.0]), stiffness, repeat=np.array([0, 0, 1, 1]))
    >>> average_repeats(data).mean.storage.tolist()
    [11.0, 21.0]
    """
    group, first = _groups(measurement)
    count = np.bincount(group).astype(float)
    if len(first) == len(measurement):
        nothing = np.zeros(len(first))
        return Averaged(measurement, measurement, Scatter(nothing, nothing, nothing), group)
    mean = level_means(group, measurement.stiffness)
    if np.all(np.abs(measurement.stiffness / mean[group] - 1.0) < LEAST_RELATIVE):
        # Rows that were written again are no repeats: they tell nothing of the noise.
        return average_repeats(replace(measurement.subset(first), repeat=None))
    gains, spent = _replicate_gains(measurement, measurement.stiffness / mean[group] - 1.0, group)
    stiffness = measurement.stiffness
    if gains is not None:
        stiffness = stiffness / (1.0 + gains)
    mean = level_means(group, stiffness)
    off = stiffness - mean[group]
    # A gain is estimated from all points of a run: each point pays its share of that degree of
    # freedom.
    free = max(1.0 - spent / max(float(np.sum(count - 1.0)), 1.0), 0.0)
    scatter = Scatter(*_squares_of(off, group), (count - 1.0) * free)
    averaged = measurement.subset(first)
    sd = averaged.sd
    if sd is not None:
        sd = sd / np.sqrt(count)
    return Averaged(
        measurement, replace(averaged, stiffness=mean, sd=sd, repeat=None), scatter, group, gains
    )


def _squares_of(values: Complex, group: Rows) -> tuple[Real, Real]:
    """Sums of squares of both parts in each group, shape (groups,)."""
    real, imag = (np.bincount(group, part**2) for part in (values.real, values.imag))
    return real.astype(np.float64), imag.astype(np.float64)


def _replicate_gains(
    measurement: Measurement, relative: Complex, group: Rows
) -> tuple[Complex | None, float]:
    """The gain (N,) of the run that each row belongs to, and how many were estimated.

    A run is what was measured in one repeat under one set of conditions. None where runs do not
    differ as a whole by an analysis of variance, or where they differ in slope as well: then only
    their full scatter is honest. None, too, where one settling curve from row to row tells the runs
    apart better: one specimen that drifts.
    """
    count, run = np.bincount(group)[group], _run_numbers(measurement)
    # A gain of its own must not be one with the scatter of a few points.
    usable = (count > 1.0) & (np.bincount(run)[run] >= REPEATS.points_of_a_run)
    if not np.any(usable):
        return None, 0.0
    # Numbered anew without the runs that are too short, so that no mean is taken of nothing.
    run, values = np.unique(run[usable], return_inverse=True)[1], relative[usable]
    count, x = count[usable], np.log(measurement.omega[usable])
    by_gain, gain_spent = _by_gains(values, run, count)
    # About the middle of each run, so that its gain and its slope do not share what sets it apart.
    x = x - level_means(run, x)[run]
    slope = np.bincount(run, values.real * x) + 1j * np.bincount(run, values.imag * x)
    slope = slope / np.maximum(np.bincount(run, x**2), SMALLEST)
    # An analysis of variance: what a gain of each run explains, against what is left when slopes
    # are gone too.
    by_slope = float(np.sum(np.abs(slope[run] * x) ** 2))
    left = float(np.sum(np.abs(values) ** 2)) - by_gain - by_slope
    # Twice, as each row has a real and an imaginary part; what gains and slopes take is taken away.
    free = 2.0 * (float(np.sum(1.0 - 1.0 / count)) - 2.0 * gain_spent)
    if free < 1.0:
        return None, 0.0
    # Replicates may be equal to the last digit.
    unit = max(left / free, SMALLEST)
    strength = by_gain / (2.0 * gain_spent) / unit
    gain_differs = f_sf(strength, 2.0 * gain_spent, free) < OUTLIERS.rare
    slope_differs = (
        f_sf(by_slope / (2.0 * gain_spent) / unit, 2.0 * gain_spent, free) < OUTLIERS.rare
    )
    if not gain_differs or slope_differs:
        return None, 0.0
    # Each parameter pays for the range that it might have had, of which F tells the size in units
    # of its error: the complex gains, against the complex height of the curve and its time.
    price = float(np.log(strength))
    by_gains = max(
        taken / unit - 2.0 * spent * price
        for taken, spent in (
            (by_gain, gain_spent),
            _by_gains(values, _specimens(measurement)[usable], count),
        )
    )
    by_drift = _by_settling(relative, group, usable) / unit - 3.0 * price
    if by_drift - by_gains > 2.0 * np.log(REPEATS.drift_odds):
        return None, 0.0
    gains = np.zeros(len(relative), dtype=np.complex128)
    gains[usable] = level_means(run, values)[run]
    return gains, gain_spent


def _by_gains(values: Complex, owner: Rows, count: Rows) -> tuple[float, float]:
    """Sum of squares that a gain of each owner of rows takes, and how many of the gains are free.

    Of values (n,) that have lost the means of so many repeats (n,).
    """
    taken = float(np.sum(np.abs(level_means(owner, values)[owner]) ** 2))
    return taken, len(np.unique(owner)) * (1.0 - float(np.mean(1.0 / count)))


def _specimens(measurement: Measurement) -> Rows:
    """The repeat of each row (N,): a specimen has one gain in all its runs, or a mounting has."""
    if measurement.repeat is None:
        return np.zeros(len(measurement), dtype=np.int64)
    return np.asarray(np.unique(measurement.repeat, return_inverse=True)[1], dtype=np.int64)


def _run_numbers(measurement: Measurement) -> Rows:
    """Which run each row belongs to, (N,)."""
    columns = [measurement.levels(name) for name in CONDITIONS if name in measurement.conditions]
    if measurement.repeat is not None:
        columns += [*told_apart(measurement).values(), measurement.repeat]
    return set_numbers(*columns)


def _by_settling(relative: Complex, group: Rows, usable: NDArray[np.bool_]) -> float:
    """Sum of squares that the best curve settling from row to row takes.

    Takes, that is, from what sets the usable rows apart.
    """
    curves = np.exp(-np.linspace(0.0, 1.0, len(relative))[:, None] / SETTLING_TIMES)
    # What is measured has lost the means of its repeats; so must the curves.
    curves = np.stack([curve - level_means(group, curve)[group] for curve in curves.T])
    curves = curves[:, usable]
    taken = np.abs(curves @ relative[usable]) ** 2 / np.maximum(np.sum(curves**2, axis=1), SMALLEST)
    return float(np.max(taken))


def _groups(measurement: Measurement) -> tuple[Rows, Rows]:
    """Which averaged row each row belongs to, and the first row of each.

    Only marked repeats are merged.
    """
    columns: list[Rows] = [np.arange(len(measurement))]
    if measurement.repeat is not None:
        columns = [frequency_numbers(measurement), *told_apart(measurement).values()]
        columns += [
            measurement.levels(name) for name in CONDITIONS if name in measurement.conditions
        ]
    _, first, group = np.unique(
        np.column_stack(columns), axis=0, return_index=True, return_inverse=True
    )
    # In the order of the data, not in that of the numbers, by which `unique` sorts.
    order = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int64)
    rank[order] = np.arange(len(first))
    return rank[group.ravel()], first[order].astype(np.int64)


def noise_of_repeats(averaged: Averaged) -> Noise | None:
    """Noise of the averages, or None where too little is repeated.

    Parameters
    ----------
    averaged : Averaged
        The data with the scatter of their repeats.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import average_repeats
    >>> from springpot.measurement.replicates import noise_of_repeats
    >>> omega, scatter = np.tile([1.0, 2.0, 4.0], 5), np.random.default_rng(1).normal(size=15)
    >>> repeat = np.repeat(np.arange(5), 3)
    >>> data = Measurement(omega, (1.0 + 0.01 * scatter) * (3.0 + 1j), repeat=repeat)
    >>> noise_of_repeats(average_repeats(data)).source
    'repeats'
    """
    mean, scatter = averaged.mean, averaged.scatter
    dof = 2.0 * float(np.sum(scatter.dof))
    if dof < REPEATS.enough:
        return None
    axes = np.asarray(np.conj(mean.stiffness) / mean.magnitude, dtype=np.complex128)
    sd, turn = noise_shape(mean, scatter, averaged.scatter_after(axes), axes, uneven=True)
    sd = sd / np.sqrt(averaged.count)
    scattered = Noise.shaped(sd, turn, dof, "repeats")
    memory = _memory(averaged, scattered)
    tails = _tails(averaged, replace(scattered, memory=memory))
    # Repeats tell the noise but for what was rounded alike in all of them.
    shared = averaged.shared if turn is None else turned_sd(averaged.shared, turn)
    sd = np.asarray(np.hypot(sd.real, shared.real) + 1j * np.hypot(sd.imag, shared.imag))
    whole = Noise.shaped(sd, turn, effective_share(memory**2) * dof, "repeats")
    return replace(whole, memory=memory, tails=tails)


def _places(averaged: Averaged) -> tuple[Rows, Rows]:
    """Rows (N,) by their points and runs, and which repeat of its point each of them is."""
    group, run = averaged.group, averaged.raw.repeat
    assert run is not None, "only numbered rows are repeats"
    order = np.lexsort((run, group))
    return order, np.arange(len(group)) - np.searchsorted(group[order], group[order])


def _whitened(values: Complex, noise: Noise, point: Rows) -> Real:
    """Both parts (2m,) of differences (m,) of some points, each of the size one on the whole."""
    if noise.turn is not None:
        values = values * noise.turn[point]
    parts = noise.parts[point]
    both = (values.real / parts.real, values.imag / parts.imag)
    return np.concatenate([part / max(rms(part), SMALLEST) for part in both])


def _memory(averaged: Averaged, noise: Noise) -> float:
    """Correlation of the errors of neighbours in one run; none where white noise is as likely.

    Each repeat less the mean of those before it is independent of these (Helmert 1876), and goes
    on from point to point as a run does.
    """
    order, place = _places(averaged)
    group, apart = averaged.group[order], averaged.apart[order]
    before = np.cumsum(apart) - apart
    first = np.flatnonzero(place == 0)
    before = before - before[first][group]
    later = np.flatnonzero(place > 0)
    step = place[later]
    told = (apart[later] - before[later] / step) * np.sqrt(step / (step + 1.0))
    runs = sweeps_of(averaged.raw.subset(order[later]))
    links = Links.of_parts([rows for rows, _ in runs], len(step))
    white = _whitened(told / np.sqrt(averaged.count[group[later]]), noise, group[later])
    # What is slower sets specimens apart, by a gain and a slope of each.
    found = fitted_memory(white[:, None], links, longest_memory(runs))
    return found.memory if found.gain > 0.0 else 0.0


def _tails(averaged: Averaged, noise: Noise) -> float:
    """By how many degrees of freedom of Student's t the errors of the means are spread.

    Every other repeat of a point less the others: that is spread about as the error of their mean.
    What a point remembers of the one before it is no error of its own.
    """
    order, place = _places(averaged)
    sign = np.empty(len(order))
    sign[order] = 1.0 - 2.0 * (place % 2)
    count = averaged.count
    # Of an odd number the signs have a mean, which the deviations have not.
    size = np.sqrt(1.0 - (count % 2) / count**2)
    told = np.flatnonzero(count > 1)
    apart = level_means(averaged.group, averaged.apart * sign)[told] / size[told]
    white = _whitened(apart, noise, told)
    lines = [rows for rows, _ in sweeps_of(averaged.mean.subset(told))]
    new = prewhitened(white, noise.memory, Links.of_parts(lines, len(told)))
    return tails_of(new / max(rms(new), SMALLEST))


def thinned(measurement: Measurement) -> Measurement:
    """At most `THINNED.points` rows, in the order in which they stand.

    Every sweep keeps as many points as the longest may have, spread evenly over its own, with all
    their repeats. Only where that leaves fewer than `THINNED.of_a_sweep` of each, whole sweeps are
    left out; only of more than `THINNED.repeats` repeats some are.

    Parameters
    ----------
    measurement : Measurement
        The data; they are handed back as they are where they are few.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import thinned
    >>> omega = np.geomspace(0.1, 10.0, 4000)
    >>> len(thinned(Measurement(omega, omega**0.5 + 1j)))
    1500
    """
    if len(measurement) <= THINNED.points:
        return measurement
    # Points are thinned, and not rows: all repeats of a point that stays go with it.
    data = average_repeats(measurement)
    points = np.split(
        np.argsort(data.group, kind="stable"), np.cumsum(np.bincount(data.group))[:-1]
    )
    most = max(THINNED.repeats, THINNED.points // len(points))
    points = [rows[evenly(len(rows), most)] for rows in points]
    size = np.array([len(rows) for rows in points])
    lines = [sweep.rows for sweep in sweeps_of(data.mean)]

    def fits(lines: Sequence[Rows], each: int) -> bool:
        return (
            sum(int(size[line[evenly(len(line), each)]].sum()) for line in lines) <= THINNED.points
        )

    kept = _largest(
        lambda count: fits([lines[i] for i in evenly(len(lines), count)], THINNED.of_a_sweep),
        len(lines),
    )
    lines = [lines[i] for i in evenly(len(lines), kept)]
    each = _largest(lambda count: fits(lines, count), max(len(line) for line in lines))
    # Row numbers of the repeats of all points that stay, in the order of the file.
    kept_rows = [points[i] for line in lines for i in line[evenly(len(line), each)]]
    return measurement.subset(np.sort(np.concatenate(kept_rows)))


def _largest(fits: Callable[[int], bool], most: int) -> int:
    """The largest number up to `most` that fits, by halving; 1 where none does."""
    return 1 + bisect_right(range(2, most + 1), False, key=lambda count: not fits(count))


NOTE = "note repeats"
"""Key of the note in a measurement's provenance."""
ADVICE = (
    "if the sweep was repeated, number the sweeps in a column repeat; their scatter is the noise"
)
"""What a user can do with rows that nothing tells apart."""


def again_note(measurement: Measurement) -> dict[str, str]:
    """A note where each frequency stands equally often.

    Under the same conditions, or under other ones of a setting.

    Told and not taken for repeats: a sweep up and down, or one before and one after an ageing,
    looks alike.

    Parameters
    ----------
    measurement : Measurement
        The data.
    """
    numbers = [
        name
        for name in told_apart(measurement)
        if name in measurement.conditions and name not in RUNS
    ]
    if numbers:
        chosen = largest_test(measurement, numbers[0])
        return {
            TOGETHER: (
                f"rows of several tests are together, told apart by {' and '.join(numbers)}; "
                f"choose one by '@{chosen}'"
            )
        }
    number = stands_again(measurement)
    if number is None:
        return {}
    count = np.bincount(number)
    repeated = (
        f"each of {len(count)} frequencies stands {count.min()} times under the same conditions"
    )
    return {NOTE: f"{repeated}: {ADVICE}"}


def stands_again(measurement: Measurement) -> NDArray[np.int64] | None:
    """Number of the frequency of each row (n,).

    Where all come equally often and nothing tells their rows apart.

    None where a frequency comes once, or where a column numbers the repeats or names the runs.

    Parameters
    ----------
    measurement : Measurement
        The data.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement.replicates import stands_again
    >>> twice = Measurement([1.0, 2.0, 3.0, 4.0, 5.0] * 2, [1j] * 10)
    >>> stands_again(twice)
    array([0, 1, 2, 3, 4, 0, 1, 2, 3, 4])
    """
    number = frequency_numbers(measurement)
    count = np.bincount(number)
    if len(count) < COURSE.fewest_of_a_round or count.min() < 2 or count.min() != count.max():
        return None
    # What names runs, or was set to several values, tells them apart already.
    if (
        measurement.repeat is not None
        or RUNS & set(measurement.conditions)
        or _is_labelled(measurement)
    ):
        return None
    if told_apart(measurement):
        return None
    for name, width in (("temperature", VARIED.temperature_wanders), ("amplitude", SAME_AMPLITUDE)):
        column = measurement.conditions.get(name)
        if column is None:
            continue
        if name == "amplitude":
            column = np.log(column)
        # Each frequency at several temperatures or amplitudes is a set of sweeps, no repeat of one.
        low, high = np.full(len(count), np.inf), np.full(len(count), -np.inf)
        np.minimum.at(low, number, column)
        np.maximum.at(high, number, column)
        if np.max(high - low) > width:
            return None
    return number


def _is_labelled(measurement: Measurement) -> bool:
    """Whether some column of words has several values."""
    return any(len(np.unique(words)) > 1 for words in measurement.labels.values())
