"""Is anything left? One battery of tests on the residual of a fit, which needs no list of effects.

Each test looks for another kind of structure (slow curves, neighbours that are alike, ripples,
single points, too much scatter), and is a statistic and the words for what it finds. The statistic
becomes a chance by simulated noise that has lost what the parameters follow, and the smallest of
these chances is itself judged against its own distribution in the same simulation: looking in
several ways costs no false alarm. `diagnose` and `compare` ask this battery and no other. Whether
repeats differ by chance alone is tested too, and what sets them apart where they do not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.instrument import near_mains
from springpot.measurement.measurement import CONDITIONS
from springpot.measurement.mixed_up import sweeps_of
from springpot.measurement.replicates import Averaged, noise_of_repeats
from springpot.plain_data import Plain
from springpot.rheology.points import Real
from springpot.thresholds import OUTLIERS, REPEATS, VERDICT

from ..distributions import autoregressive
from ..numerics import SMALLEST, orthonormal
from .error import plain, point_in_words, times
from .frame import (
    DRAWN,
    DRAWS,
    ENOUGH_NEIGHBOURS,
    FURTHER,
    Drawn,
    NoiseFrame,
    drift_curves,
    folds_of,
    near_an_alarm,
    relative_to,
    spectrum,
    unseen_error,
)
from .outliers import outlying

Rows: TypeAlias = NDArray[np.int64]
NEIGHBOURS = np.exp(-0.5 * (np.arange(1, 7) / 3.0) ** 2)
"""Weights of the first to sixth neighbour in runs.

An error that is shared is mostly shared by several points, and a
sum over them sees it where the products of next neighbours alone are too few."""


class ResidualTest(NamedTuple):
    """One test of the battery.

    Attributes
    ----------
    name : str
        What is looked for.
    statistic : callable
        Of a fit and residuals (m, 2n) the statistics (m,), larger where there is more structure;
        None where the data have nothing to test.
    says : callable
        Of a fit a number and a sentence on it.
    """

    name: str
    statistic: Callable[[NoiseFrame, Drawn], Real | None]
    says: Callable[[NoiseFrame], tuple[float, str]]


# Too much scatter: noise that was estimated from it cannot be exceeded, but one part may exceed the
# other.
def _scatter(frame: NoiseFrame, sample: Drawn) -> Real | None:
    if frame.estimated:
        return None
    return np.asarray(np.einsum("ij,ij->i", sample, sample), dtype=np.float64)


def _scatter_in_words(frame: NoiseFrame) -> tuple[float, str]:
    value, free = float(frame.rest @ frame.rest), frame.size - frame.absorbed.shape[1]
    ratio = times(np.sqrt(value / max(free, 1)))
    says = (
        f"the residual is {ratio} what the noise leaves (chi-square {value:.4g} on"
        f" {free} degrees of freedom)"
    )
    return value, says


# An estimated noise is brought to unit scatter over both parts together: one of them may still be
# too large.
def _part(number: int) -> Callable[[NoiseFrame, Drawn], Real]:
    def statistic(frame: NoiseFrame, sample: Drawn) -> Real:
        n = len(frame.measurement)
        return np.asarray(
            np.sum(sample[:, number * n : (number + 1) * n] ** 2, axis=1), dtype=np.float64
        )

    return statistic


def _part_in_words(number: int, word: str) -> Callable[[NoiseFrame], tuple[float, str]]:
    def says(frame: NoiseFrame) -> tuple[float, str]:
        n = len(frame.measurement)
        rows = slice(number * n, (number + 1) * n)
        # What the parameters follow of this part alone: a fit may spend nearly all of its freedom
        # on the storage.
        free = max(float(n - np.sum(frame.absorbed[rows] ** 2)), 1.0)
        ratio = float(np.sqrt(np.sum(frame.rest[rows] ** 2) / free))
        return ratio, f"{word} alone is {times(ratio)} what its noise leaves"

    return says


# Structure along sweeps: slow curves, of each sweep or of all, and errors that all sweeps share at
# a frequency.
def _along(basis_of: Callable[[NoiseFrame], Real]) -> Callable[[NoiseFrame, Drawn], Real | None]:
    def statistic(frame: NoiseFrame, sample: Drawn) -> Real | None:
        basis = basis_of(frame)
        if basis.shape[1] == 0:
            return None
        along = sample @ basis.astype(sample.dtype)
        return np.asarray(np.einsum("ij,ij->i", along, along), dtype=np.float64)

    return statistic


def _along_in_words(
    basis_of: Callable[[NoiseFrame], Real], word: str
) -> Callable[[NoiseFrame], tuple[float, str]]:
    def says(frame: NoiseFrame) -> tuple[float, str]:
        basis = basis_of(frame)
        there = float(np.sum((basis.T @ frame.rest) ** 2)) / basis.shape[1]
        scatter = float(frame.rough @ frame.rough) / max(frame.rough_dof, 1)
        ratio = float(np.sqrt(there / max(scatter, SMALLEST)))
        return ratio, f"{word} is {times(ratio)} what point-to-point scatter leaves"

    return says


def _smooth(frame: NoiseFrame) -> Real:
    return frame.smooth


def _shared(frame: NoiseFrame) -> Real:
    return frame.shared


def _common(frame: NoiseFrame) -> Real:
    return frame.common


# Neighbours that are alike, along frequency and in the order in which they were measured; and what
# swings.
def _along_frequency(frame: NoiseFrame) -> list[Rows]:
    return [sweep.rows for sweep in sweeps_of(frame.measurement)]


def _in_order(frame: NoiseFrame) -> list[Rows]:
    return [np.arange(len(frame.measurement))]


def _alike(orders: Callable[[NoiseFrame], list[Rows]]) -> Callable[[NoiseFrame, Drawn], Real]:
    def statistic(frame: NoiseFrame, sample: Drawn) -> Real:
        n = len(frame.measurement)
        total: Real = np.zeros(len(sample))
        for rows in orders(frame):
            for offset in (0, n):
                total += kinship(sample[:, rows + offset])
        return total

    return statistic


def kinship(rows: Drawn) -> Real:
    """Weighted sum of products of neighbours along the last axis."""
    total: Drawn = np.zeros(rows.shape[:-1], dtype=rows.dtype)
    for lag, weight in enumerate(NEIGHBOURS[: rows.shape[-1] - 1], 1):
        total += weight * np.einsum("...i,...i->...", rows[..., lag:], rows[..., :-lag])
    return np.asarray(total, dtype=np.float64)


def _alike_in_words(
    orders: Callable[[NoiseFrame], list[Rows]], word: str
) -> Callable[[NoiseFrame], tuple[float, str]]:
    def says(frame: NoiseFrame) -> tuple[float, str]:
        n, rest = len(frame.measurement), frame.rest
        pairs = [(rows[:-1] + k, rows[1:] + k) for rows in orders(frame) for k in (0, n)]
        first, second = (np.concatenate(side) for side in zip(*pairs, strict=True))
        # By the size of the very points that are paired (Cauchy and Schwarz): within -1 and 1.
        size = float(np.linalg.norm(rest[first]) * np.linalg.norm(rest[second])) or 1.0
        correlation = float(np.clip(np.sum(rest[first] * rest[second]) / size, -1.0, 1.0))
        return correlation, f"neighbouring residuals {word} correlate by {correlation:.2f}"

    return says


def _ripple(frame: NoiseFrame, sample: Drawn) -> Real:
    """Largest energy of a periodic residual along the sweeps, of one period in all of them.

    Where the noise is told by these data, as a share of all: the scatter beside slow curves holds
    the ripple itself.
    """
    # The largest over all periods, in the data and in each draw alike: so the number of periods
    # costs no false alarm.
    largest = spectrum(frame.measurement, sample).max(axis=1)
    if frame.estimated:
        # Of three points a fit may leave nothing at all.
        largest = largest / np.maximum(
            np.einsum("ij,ij->i", sample, sample), np.finfo(sample.dtype).tiny
        )
    return np.asarray(largest)


def _ripple_in_words(frame: NoiseFrame) -> tuple[float, str]:
    power = spectrum(frame.measurement, frame.rest[None])[0]
    # The place 0 is a constant, of no period at all.
    peak = max(int(np.argmax(power)), 1)
    period = 2.0 * (len(power) - 1) / peak
    return period, f"the residual swings with a period of {period:.2g} points"


# What stands out: one frequency in all sweeps, single points, multiples of the mains.
def _one_frequency(frame: NoiseFrame, sample: Drawn) -> Real:
    narrow = frame.narrow.astype(sample.dtype)
    return np.asarray(np.max(np.abs(sample @ narrow), axis=1, initial=0.0), dtype=np.float64)


def _one_frequency_in_words(frame: NoiseFrame) -> tuple[float, str]:
    along, measurement = np.abs(frame.rest @ frame.narrow), frame.measurement
    size = float(np.max(along, initial=0.0))
    where = "at one frequency"
    if size > 0.0:
        # What is fixed at a frequency is largest there.
        row = int(np.argmax(np.abs(frame.narrow[:, np.argmax(along)]))) % len(measurement)
        where = f"at {measurement.units.at(float(measurement.frequency[row]))}"
    sweeps = " in all sweeps" if len(sweeps_of(measurement)) > 1 else ""
    words = f"{where}, with its neighbours or alone, the residual is off by"
    return size, f"{words} {plain(size, 2)} sd{sweeps}"


def _largest(frame: NoiseFrame, sample: Drawn) -> Real | None:
    """The furthest point.

    Where the data's own scatter is dealt out, it is dealt out too, and tells nothing.
    """
    if frame.estimated:
        return None
    return np.asarray(np.max(np.abs(sample), axis=1), dtype=np.float64)


def _largest_in_words(frame: NoiseFrame) -> tuple[float, str]:
    size = float(np.max(np.abs(frame.rest)))
    return size, f"the furthest point is off by {plain(size, 2)} sd"


def points_in_words(frame: NoiseFrame, points: Sequence[int]) -> tuple[float, float, bool, str]:
    """Size, chance and sentence of points that stand out by the rule of `outliers`."""
    rows = list(points)
    n = len(frame.measurement)
    storage, loss = frame.rest[rows], frame.rest[np.add(rows, n)]
    size = float(np.max(np.hypot(storage, loss)))
    hertz = frame.measurement.frequency[rows]
    places = "; ".join(point_in_words(frame.measurement, row) for row in rows[:3])
    if len(rows) > 3:
        places = f"{places} and {len(rows) - 3} more"
    if np.all(near_mains(hertz)):
        places = f"{places} (a multiple of the mains frequency)"
    verb = "a single point stands out"
    if len(rows) > 1:
        verb = "single points stand out"
    return size, OUTLIERS.rare, True, f"{verb} at {places}"


def _bends(frame: NoiseFrame) -> tuple[Rows, Rows, Rows]:
    """Every inner point of a sweep with its neighbours, in both parts: rows of (2n,)."""
    n = len(frame.measurement)
    lines = [rows + k for rows in _along_frequency(frame) for k in (0, n)]
    # The ends have one neighbour only, from which a slope of the residual would be a difference
    # too.
    before = np.concatenate([rows[:-2] for rows in lines])
    here = np.concatenate([rows[1:-1] for rows in lines])
    after = np.concatenate([rows[2:] for rows in lines])
    return before, here, after


def _hum(frame: NoiseFrame, sample: Drawn) -> Real | None:
    """Whether points at mains multiples stand off from their neighbours more than others do."""
    before, here, after = _bends(frame)
    near = np.tile(near_mains(frame.measurement.frequency), 2)[here]
    if not np.any(near) or np.sum(~near) < ENOUGH_NEIGHBOURS:
        return None
    off = sample[:, here] - 0.5 * (sample[:, before] + sample[:, after])
    # In double precision: of exact data next to nothing is left, whose square is none in single.
    others = np.mean(off[:, ~near] ** 2, axis=1, dtype=np.float64)
    at_mains = np.mean(off[:, near] ** 2, axis=1, dtype=np.float64)
    return np.asarray(at_mains / np.maximum(others, SMALLEST), dtype=np.float64)


def _hum_in_words(frame: NoiseFrame) -> tuple[float, str]:
    value = _hum(frame, frame.rest[None])
    ratio = 1.0
    if value is not None:
        ratio = float(value[0])
    frequency = frame.measurement.frequency
    units = frame.measurement.units
    places = ", ".join(units.at(x) for x in np.unique(frequency[near_mains(frequency)])[:4])
    says = (
        f"at multiples of the mains ({places}) points stand off"
        f" {times(np.sqrt(ratio))} as far as others"
    )
    return ratio, says


# Trends with a condition that the model does not follow.
def _trend_basis(name: str) -> Callable[[NoiseFrame], Real]:
    def basis(frame: NoiseFrame) -> Real:
        return frame.trends[name]

    return basis


def _trend_in_words(name: str) -> Callable[[NoiseFrame], tuple[float, str]]:
    def says(frame: NoiseFrame) -> tuple[float, str]:
        x = frame.condition(name)
        assert x is not None, "the test was made"
        # All that is seen against the model, not its part beyond the parameters: the user can look
        # that up.
        measured = frame.measurement.stiffness
        off = np.log(measured / relative_to(frame.model_stiffness, frame.measurement))
        size, phase = (off.real @ x) / (x @ x), np.degrees((off.imag @ x) / (x @ x))
        verb = "loses"
        if size > 0:
            verb = "gains"
        words = (
            f"from the lowest to the highest {name} the measured |K| {verb}"
            f" {100 * abs(np.expm1(size)):.2g} % and its phase {phase:+.2g} deg against the model"
        )
        return float(size), words

    return says


# Levels of a condition that a fit without them would not foretell.
def _unseen(name: str) -> ResidualTest:
    return ResidualTest(
        f"unseen {name}",
        lambda frame, sample: unseen_error(frame, sample, name),
        lambda frame: unseen_in_words(frame, name),
    )


TESTS = (
    ResidualTest("scatter", _scatter, _scatter_in_words),
    ResidualTest("storage alone", _part(0), _part_in_words(0, "storage")),
    ResidualTest("loss alone", _part(1), _part_in_words(1, "loss")),
    ResidualTest(
        "slow", _along(_smooth), _along_in_words(_smooth, "slow structure along the sweeps")
    ),
    ResidualTest(
        "shared", _along(_shared), _along_in_words(_shared, "what all sweeps share at a frequency")
    ),
    ResidualTest(
        "common", _along(_common), _along_in_words(_common, "slow structure that all sweeps share")
    ),
    ResidualTest(
        "runs", _alike(_along_frequency), _alike_in_words(_along_frequency, "along frequency")
    ),
    ResidualTest("order", _alike(_in_order), _alike_in_words(_in_order, "from row to row")),
    ResidualTest("ripple", _ripple, _ripple_in_words),
    ResidualTest("one frequency", _one_frequency, _one_frequency_in_words),
    ResidualTest("furthest point", _largest, _largest_in_words),
    ResidualTest("mains frequency", _hum, _hum_in_words),
    *(
        ResidualTest(f"trend with {name}", _along(_trend_basis(name)), _trend_in_words(name))
        for name in CONDITIONS
    ),
    *(_unseen(name) for name in CONDITIONS),
)
"""All that is looked for."""


@dataclass(frozen=True)
class Finding(Plain):
    """The outcome of one test.

    Attributes
    ----------
    test : str
        What was looked for.
    statistic : float
        In the units named by the sentence.
    p_value : float
        Chance that noise alone goes at least as far.
    found : bool
        Whether this is rarer than the tests together may be by chance.
    says : str
        One plain sentence.
    """

    test: str
    statistic: float
    p_value: float
    found: bool
    says: str


@dataclass(frozen=True, eq=False)
class Battery:
    """Chances that noise alone leaves a residual like this.

    Attributes
    ----------
    p_value : float
        Of the most telling test, with the others taken into account.
    parts : dict of str to float
        Of each test by itself.
    frame : NoiseFrame, optional
        The fit; without it there are no sentences.
    points : tuple of int
        Rows that stand out by themselves, by the rule of `outliers`.
    """

    p_value: float
    parts: dict[str, float]
    frame: NoiseFrame | None = None
    points: tuple[int, ...] = ()

    @property
    def alarm(self) -> bool:
        """Whether noise is no credible cause of the residual."""
        return self.p_value < VERDICT.structure_alarm or bool(self.points)

    @property
    def kind(self) -> str:
        """The most telling test."""
        return min(self.parts, key=lambda name: self.parts[name])

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Every test in a sentence, the surest first.

        None counts where the battery as a whole is silent.
        """
        if self.frame is None:
            return ()
        rows = []
        for test in TESTS:
            if test.name in self.parts:
                chance = self.parts[test.name]
                counts = self.p_value < VERDICT.structure_alarm and chance < VERDICT.structure_alarm
                value, says = test.says(self.frame)
                rows.append(Finding(test.name, value, chance, counts, says))
        if self.points:
            rows.append(Finding("single points", *points_in_words(self.frame, self.points)))
        return tuple(sorted(rows, key=lambda one: (not one.found, one.p_value)))


def battery(frame: NoiseFrame, rng: np.random.Generator) -> Battery:
    """Test the residual of a fit for structure of any kind.

    Parameters
    ----------
    frame : NoiseFrame
        The fit.
    rng : numpy.random.Generator
        For the simulated noise.
    """
    # In the precision of the draws, or all of them would be brought to that of the data.
    measured = frame.standard(frame.rest[None, :]).astype(DRAWN)
    sample = np.concatenate([measured, frame.draws(DRAWS, rng)])
    statistics = _statistics(frame, sample)
    tested = judged(statistics, frame)
    for rounds in FURTHER:
        # More only where the seed would decide. All data have the test "runs": so it tells how many
        # were drawn.
        if not near_an_alarm(tested.p_value, len(statistics["runs"])):
            break
        more = [_statistics(frame, frame.draws(DRAWS, rng)) for _ in range(rounds)]
        statistics = {
            name: np.concatenate([known, *(m[name] for m in more)])
            for name, known in statistics.items()
        }
        tested = judged(statistics, frame)
    # By a rule of their own: where the data's scatter is dealt out, a far point is dealt out too
    # and tells nothing.
    return replace(tested, points=tuple(outlying(frame).tolist()))


def _statistics(frame: NoiseFrame, sample: Drawn) -> dict[str, Real]:
    values = {test.name: test.statistic(frame, sample) for test in TESTS}
    return {name: value for name, value in values.items() if value is not None}


def judged(statistics: dict[str, Real], frame: NoiseFrame | None = None) -> Battery:
    """Chances of the sample's first member, the smallest judged by its own distribution."""
    # The smallest of many chances is no chance itself; that of every draw, found in the same way,
    # calibrates it.
    chances = {name: _chances(values) for name, values in statistics.items()}
    smallest = np.min(np.array(list(chances.values())), axis=0)
    p_value = float(np.mean(smallest <= smallest[0]))
    return Battery(p_value, {name: float(values[0]) for name, values in chances.items()}, frame)


def _chances(values: Real) -> Real:
    """Share of the sample that is at least as large, for every member of it."""
    # The measured one counts as a draw, so that no chance is zero.
    ordered = np.sort(values)
    return (len(values) - np.searchsorted(ordered, values, side="left")) / len(values)


OF_NEIGHBOURS = "neighbours"
"""The test of repeats for errors that neighbours share, as specimens with own curves make them."""
WITHIN = "within runs"
"""The test of repeats for errors that go on from point to point."""


def repeats_structure(data: Averaged, rng: np.random.Generator) -> Battery:
    """Test whether repeats differ by chance, drift in time, or move together along a sweep.

    Replicates of several specimens differ by a gain, a shift and a bend each: neighbours are alike,
    but not beyond such curves. Where they still are (`WITHIN`), the error of one point goes on in
    the next.

    Parameters
    ----------
    data : Averaged
        Data with repeats; without them nothing can be said and the chance is one.
    rng : numpy.random.Generator
        For the simulated noise.
    """
    if np.sum(data.scatter.dof) < REPEATS.enough:
        return Battery(1.0, {})
    told = noise_of_repeats(data)
    assert told is not None, "there are enough"
    count, lines = data.count, [sweep.rows for sweep in sweeps_of(data.raw)]
    noise = rng.standard_normal((DRAWS, 2, len(data.raw)))
    if told.memory:
        for rows in lines:
            noise[..., rows] = autoregressive(noise[..., rows], told.memory)
    # Simulated repeats lose the mean of their group, as the measured ones did.
    order = np.argsort(data.group, kind="stable")
    starts = np.searchsorted(data.group[order], np.arange(len(count)))
    mean = np.add.reduceat(noise[..., order], starts, axis=-1) / count
    noise -= mean[:, :, data.group]
    # In units of the noise at their place, which a load cell's floor makes large where K is small:
    # there all runs would seem to change together.
    sd = (told.sd * np.sqrt(count))[data.group]
    off = data.apart
    sample = np.concatenate([np.stack([off.real / sd.real, off.imag / sd.imag])[None], noise])
    # In units of their own scatter: how large repeats scatter is the noise itself, and only order
    # is evidence.
    sample /= np.sqrt(np.mean(sample**2, axis=-1, keepdims=True))
    drift = orthonormal(drift_curves(len(data.raw)))
    statistics = {
        "drift": np.sum((sample @ drift) ** 2, axis=(1, 2)),
        OF_NEIGHBOURS: sum(np.sum(kinship(sample[:, :, rows]), axis=1) for rows in lines),
        WITHIN: sum(np.sum(kinship(_without_bend(sample[:, :, rows])), axis=1) for rows in lines),
    }
    return judged(statistics)


def _without_bend(values: Drawn) -> Drawn:
    """Values along the last axis without their own gain, slope and bend."""
    count = values.shape[-1]
    # Specimens differ by a gain, a slope and a bend; higher degrees would follow the noise.
    bend = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count), min(2, count - 1))
    curves = orthonormal(np.asarray(bend, dtype=np.float64))
    return values - (values @ curves) @ curves.T


class Apart(NamedTuple):
    """What sets repeats apart, beside the scatter of points.

    Attributes
    ----------
    drift : float
        Share that one slow curve from row to row explains; one is a drift and nothing else.
    curves : float
        Share that a gain, a slope and a bend of each run explain, as of replicates of several
        specimens.
    one_curve : bool
        Whether the one slow curve leaves about as little as the curves of all runs, and rows of
        several runs do not alternate: else it is no drift.
    """

    drift: float
    curves: float
    one_curve: bool


def sets_apart(data: Averaged) -> Apart:
    """What sets the repeats of data apart."""
    measured = data.deviations()
    parts = np.stack([measured.real, measured.imag])
    size = float(np.sum(parts**2))
    # Copied rows are no repeats: nothing sets them apart.
    if size == 0.0:
        return Apart(0.0, 0.0, False)
    slow = drift_curves(len(measured))
    count = data.count
    # The deviations have lost the means of the repeats; so must the curves.
    sums = np.column_stack([np.bincount(data.group, curve)[data.group] for curve in slow.T])
    lost = sums / count[data.group, None]
    drift = orthonormal(slow - lost)
    by_drift = float(np.sum((parts @ drift) ** 2))
    lines = [sweep.rows for sweep in sweeps_of(data.raw)]
    left = sum(float(np.sum(_without_bend(parts[:, rows]) ** 2)) for rows in lines)
    free = len(measured) - len(count)
    # For each degree of freedom: the curves of all runs are many more, and always leave less in
    # sum.
    left_of_each = left / max(free - 3 * len(lines), 1)
    left_of_drift = (size - by_drift) / max(free - drift.shape[1], 1)
    one_curve = left_of_drift < VERDICT.one_curve * left_of_each
    by_curves = 1.0 - left / size
    # In a table that stands by frequency the runs alternate, and what sets specimens apart goes on
    # from row to row.
    alternate = any(np.ptp(rows) >= len(rows) for rows in lines)
    if alternate and by_curves > VERDICT.own_curves:
        one_curve = False
    return Apart(by_drift / size, by_curves, one_curve)


def unseen_in_words(frame: NoiseFrame, name: str) -> tuple[float, str]:
    """By how much such levels are missed, over what noise makes of it, and the sentence."""
    error = unseen_error(frame, frame.rest[None], name)
    assert error is not None, "the test was made"
    count = 2.0 * sum(float(np.sum(fold)) for fold in folds_of(frame.measurement, name))
    ratio = float(np.sqrt(error[0] / count))
    return ratio, f"{one_of(name)} that a fit has not seen is predicted to {times(ratio)} the noise"


def one_of(name: str) -> str:
    """A level of a condition with its article: ``an amplitude``."""
    article = "a"
    if name[0] in "aeiou":
        article = "an"
    return f"{article} {name}"
