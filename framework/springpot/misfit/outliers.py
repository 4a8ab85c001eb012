"""Single points that stand out: no effect may be inferred from them or hide behind them.

They are told by the scatter about slow curves, without the ripples of an instrument.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betainc

from springpot.distributions import (
    chi2_quantile,
    chi2_sf,
    f_log_density,
    f_quantile,
    f_sf,
    gamma_sf,
)
from springpot.identification.problem import weighted
from springpot.measurement.independence import frequency_numbers, rounded_log_omega
from springpot.measurement.instrument import HARMONICS, near_mains
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import sweeps_of
from springpot.measurement.replicates import average_repeats, noise_of_repeats
from springpot.measurement.timenoise import FEWEST
from springpot.rheology.points import Real
from springpot.thresholds import OUTLIERS, SCATTER, VERDICT

from ..numerics import ALIKE, ROUNDING, SMALLEST, orthonormal, projected_out
from .error import plain, point_in_words
from .frame import (
    FEWEST_OWN,
    LEAST_LEFT,
    LEAST_SEEN,
    NoiseFrame,
    chance_of_squares,
    drift_shapes,
    spectrum,
    waves,
)
from .where import Where

if TYPE_CHECKING:
    from .refit import Refit

MOST_TURNS = 10
"""Times that the points which stand out are found anew; nearly all settle in three."""
FINE = 41
"""Periods tried between the neighbours of the strongest one."""
MOST_RIPPLES = 2
"""Periods that are taken out of the scatter; a third could follow noise."""
SLOWEST_RIPPLE = 16.0
"""Points of the longest period: longer waves are slow structure already."""
SLOW_WAVES = 2
"""Waves along a sweep up to which its polynomials of degree 5 are that structure, however many its
points.
"""
LEAST_KEPT = 0.7
"""Share of the data below which what is left out is no few frequencies any more."""
LEAST_FREE = 0.5
"""Share of the degrees of freedom that must stay, likewise.

An estimate from half of them is uncertain by 1.4 x.
"""


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


def trimmed(frame: NoiseFrame, kept: NDArray[np.bool_] | None = None) -> Trimmed:
    """The whitened scatter of a fit about slow curves.

    Without the frequencies at which it is far larger.

    Parameters
    ----------
    frame : NoiseFrame
        The fit.
    kept : ndarray of bool, shape (n,), optional
        Rows known to be free of what stands out; without them the median over frequencies is the
        first guess.
    """
    followed = np.concatenate([frame.absorbed, frame.structured], axis=1)
    omega = frame.measurement.omega
    found = trimmed_residual(frame.residual, followed, omega, kept)
    # Only what chance does not explain is taken out: shapes chosen to follow noise make the floor
    # too low.
    drift = frame.relative(drift_shapes(len(frame.measurement)))
    if found.dof >= FEWEST_OWN and _explains(drift, followed, found):
        followed = _beside(followed, drift)
        found = trimmed_residual(frame.residual, followed, omega)
    for _ in range(MOST_RIPPLES):
        if found.dof < FEWEST_OWN or (period := _ripple(frame, followed, found)) == 0.0:
            break
        ripple = frame.relative(waves(frame.measurement, period))
        followed = _beside(followed, ripple)
        found = trimmed_residual(frame.residual, followed, omega)
    return found


def left_by(followed: Real, values: Real, rows: NDArray[np.bool_]) -> Real:
    """What curves that are fitted to some rows alone leave of values in all of them.

    A row that is left out is one with a parameter of its own, whose value is its residual over
    the share of the row that the curves do not follow (Cook 1977,
    doi:10.1080/00401706.1977.10489493).

    Parameters
    ----------
    followed : ndarray, shape (2n, q)
        Orthonormal basis of the curves.
    values : ndarray, shape (2n,) or (2n, m)
        What is fitted.
    rows : ndarray of bool, shape (2n,)
        To which rows.
    """
    left = projected_out(values, followed)
    out = followed[~rows]
    if not len(out):
        return np.asarray(left, dtype=np.float64)
    share, ways = np.linalg.eigh(np.eye(len(out)) - out @ out.T)
    # A curve that the other rows do not show has no size, and leaves all that is there.
    own = ways.T @ values[~rows]
    shown = share > ROUNDING
    own[shown] = ((ways.T @ left[~rows])[shown].T / share[shown]).T
    return np.asarray(left + followed @ (out.T @ (ways @ own)), dtype=np.float64)


def _beside(followed: Real, columns: Real) -> Real:
    """An orthonormal basis (2n, q) with further columns (2n, m)."""
    left = projected_out(columns, followed)
    seen = np.linalg.norm(left, axis=0) > LEAST_SEEN * np.linalg.norm(columns, axis=0)
    return np.concatenate([followed, orthonormal(left[:, seen])], axis=1)


def _explains(columns: Real, followed: Real, scatter: Trimmed) -> bool:
    """Whether columns explain more of a scatter than noise would, by the ratio of variances."""
    rows = scatter.kept
    inner = left_by(followed, columns, rows)[rows]
    kept = np.linalg.norm(inner, axis=0) > LEAST_SEEN * np.linalg.norm(columns[rows], axis=0)
    basis = orthonormal(inner[:, kept])
    # In one sweep of even steps drift is slow structure already: nothing of it is left to explain.
    spent = float(basis.shape[1])
    if spent == 0.0 or scatter.dof <= spent:
        return False
    explained = float(np.sum((basis.T @ scatter.left[rows]) ** 2))
    left = max(float(np.sum(scatter.left[rows] ** 2)) - explained, SMALLEST)
    ratio = (explained / spent) / (left / (scatter.dof - spent))
    return bool(f_sf(ratio, spent, scatter.dof - spent) < OUTLIERS.rare)


def _ripple(frame: NoiseFrame, followed: Real, scatter: Trimmed) -> float:
    """Period, in points, of a ripple that the scatter holds.

    Zero where the strongest one may be chance.

    Of white noise the power at each of n independent frequencies is a sum of exponentials, one for
    each part of each sweep, but for what the curves have taken there: slow ones leave only what is
    fast. A periodic error of the analysis or of a resonance of the chain is no such sum (Fisher
    1929, doi:10.1098/rspa.1929.0151).
    """
    left = np.where(scatter.kept, scatter.left, 0.0)
    power = spectrum(frame.measurement, left[None])[0]
    lines = 2 * len(sweeps_of(frame.measurement))
    longest = len(power) - 1
    # Slow waves are structure, and told of elsewhere. The spectrum counts in half waves along a
    # sweep.
    first = min(int(np.ceil(2.0 * longest / SLOWEST_RIPPLE)), 2 * SLOW_WAVES)
    # Of a computed curve nothing is left.
    if first + 1 >= len(power) or scatter.variance == 0.0:
        return 0.0
    taken = np.sum(spectrum(frame.measurement, followed.T), axis=0)
    # Half a wave at least: where curves take all, the power is nothing too.
    pairs = np.maximum(lines - 0.5 * taken, 0.5)
    chances = gamma_sf(power / (2.0 * scatter.variance), pairs)
    peak = first + int(np.argmin(chances[first:]))
    # The strongest of so many periods is told: each of them might have been it (Bonferroni).
    if longest * float(chances[peak]) > OUTLIERS.rare:
        return 0.0
    # A ripple hardly ever has a period of the coarse grid, and one that is off leaves much of it at
    # the ends.
    periods = 2.0 * longest / np.linspace(peak - 1.0, peak + 1.0, FINE)[1:-1]
    return float(periods[np.argmax(_energy_of_ripples(frame, followed, left, periods))])


def _energy_of_ripples(frame: NoiseFrame, followed: Real, left: Real, periods: Real) -> Real:
    """Energy (m,) of a whitened scatter along ripples in size and phase of K.

    The ripples are of some periods (m,), in points, and fitted beside the curves (2n, q) that were
    fitted before: what these have of a ripple would draw its period off.
    """
    n, energy = len(frame.measurement), np.zeros(len(periods))
    # Sweep by sweep: a ripple of one says nothing of the others, and small matrices are quickly
    # done.
    for rows, _ in sweeps_of(frame.measurement):
        phase = 2.0 * np.pi * np.arange(len(rows)) / periods[:, None]
        waves_of_sweep = np.stack([np.cos(phase), np.sin(phase)], axis=-1)
        relative = np.stack(
            [factor * frame.model_stiffness[rows] for factor in (1.0, 1.0j)], axis=-1
        )
        change = (relative[:, :, None] * waves_of_sweep[:, :, None, :]).reshape(
            len(periods), len(rows), -1
        )
        turn = None if frame.turn is None else frame.turn[rows]
        columns = weighted(np.swapaxes(change, 1, 2), frame.weights[rows], turn)
        size = np.linalg.norm(columns, axis=-1, keepdims=True)
        columns = columns / np.where(size > 0.0, size, 1.0)
        both = np.concatenate([rows, rows + n])
        beside = columns @ followed[both]
        squares = columns @ columns.swapaxes(1, 2) - beside @ beside.swapaxes(1, 2)
        sizes, ways = np.linalg.eigh(squares)
        along = np.einsum("mki,mk->mi", ways, columns @ left[both])
        # The fastest alternation has no sine, and curves may have all of a ripple: what is left of
        # such a direction is rounding.
        seen = sizes > LEAST_SEEN**2
        energy += np.sum(along**2 * seen / np.where(seen, sizes, 1.0), axis=1)
    return energy


def trimmed_residual(
    residual: Real, followed: Real, omega: Real, first: NDArray[np.bool_] | None = None
) -> Trimmed:
    """What curves leave of a residual, without the frequencies at which it is far larger.

    An outlier, a notch or line interference is confined to a few frequencies, whatever the sweep;
    noise is not. The curves are fitted anew without them, or they would be drawn towards what is
    left out; the first guess is the median over frequencies, which a notch of a few points does not
    move.

    Parameters
    ----------
    residual : ndarray, shape (2n,)
        Whitened residual.
    followed : ndarray, shape (2n, q)
        Orthonormal basis of the curves.
    omega : ndarray, shape (n,)
        Angular frequencies.
    first : ndarray of bool, shape (n,), optional
        Rows from which to start; all of them by default.
    """
    # Frequencies that differ by rounding in the file are one.
    _, group = np.unique(rounded_log_omega(omega), return_inverse=True)
    group = np.concatenate([group.ravel(), group.ravel()])
    count = np.bincount(group).astype(float)
    middle = chi2_quantile(0.5, count)
    kept = np.ones(len(count), dtype=bool)
    if first is not None:
        kept[group[: len(omega)][~first]] = False
    for turn in range(MOST_TURNS):
        rows = kept[group]
        left = left_by(followed, residual, rows)
        found = Trimmed(left, rows, max(float(np.sum(rows)) - followed.shape[1], 1.0))
        # Curves take their share from every frequency alike.
        squares = np.bincount(group, left**2) * float(np.sum(rows)) / found.dof
        mean = float(np.sum(squares[kept]) / np.sum(count[kept]))
        variance = mean
        if turn == 0 and first is None:
            variance = float(np.median(squares / middle))
        # By the ratio of variances: beside a few numbers that are left over one frequency is easily
        # far larger.
        usual = count * f_quantile(1.0 - SCATTER.outlying_frequency, count, found.dof)
        within = squares <= usual * variance
        # Where a good part of the data would go, these are no few frequencies: what scatters so is
        # the noise. Where sweeps are short, so that each frequency holds a tenth of the data, the
        # curves would soon follow the rest.
        free = float(np.sum(count[within])) - followed.shape[1]
        too_many = np.sum(count[within]) < LEAST_KEPT * len(residual)
        too_many |= free < LEAST_FREE * (len(residual) - followed.shape[1])
        if too_many or (turn > 0 and np.array_equal(within, kept)):
            return found
        kept = within
    return found


END = 2
"""Rows of an end of a sweep at which the beginning of an effect is easily taken for a bad point.

A mass that has just
come up at the last row bends the model there, and the row before it then stands out."""
TAILS = [(nu, s) for nu in (1e6, 10.0, 5.0, 3.0, 2.0) for s in (1.0, 0.8, 0.6, 0.45, 0.3)]
"""Degrees of freedom and scale of the scatter that may be: normal first.

The variance is taken without the furthest
frequencies, so that a scale below one goes with long tails."""


@dataclass(frozen=True)
class Outlier:
    """A point that stands out from its neighbours.

    Attributes
    ----------
    frequency : float
        Where it is, in Hz.
    size : float
        By how many standard deviations it is off.
    relative : complex
        By how much it is off, over |K|.
    at : str
        Where it is in words: frequency, and temperature and amplitude where these vary.
    stiffness : complex
        What was measured there.
    magnitude : str
        What the size of K is called.
    row : int or None
        Number of its row as ``--exclude row=3`` counts; None where the data were thinned.
    alone : bool
        Whether nothing else is off beside it: a bad reading stands alone, an interference or a
        resonance is seen at the next frequencies, or at this one in other sweeps.
    """

    frequency: float
    size: float
    relative: complex
    at: str
    stiffness: complex
    magnitude: str = "|K|"
    row: int | None = None
    alone: bool = True

    @property
    def place(self) -> Where:
        """As a place at which the model fails."""
        says = f"a single point at {self._located} stands out by {plain(self.size, 2)} sd"
        return Where(
            "stiffness", "single point", self.frequency, self.frequency, abs(self.relative), says
        )

    @property
    def _located(self) -> str:
        if self.row is None:
            return self.at
        return f"{self.at}, row {self.row},"

    def __str__(self) -> str:
        off = f"{100 * abs(self.relative):.2g} % of {self.magnitude}, {plain(self.size, 2)} sd"
        return f"{self._located.rstrip(',')} ({off})"

    @property
    def at_mains(self) -> bool:
        """Whether its frequency is that of the mains, or twice or three times as much."""
        return bool(near_mains(np.array([self.frequency]), HARMONICS)[0])

    def counted_in(self, measurement: Measurement) -> Outlier:
        """The same with its row in the whole measurement, of which a fit may use a part."""
        # By what was measured: thinning and exclusion have renumbered the rows.
        same = np.isclose(measurement.stiffness, self.stiffness, rtol=ALIKE, atol=0.0)
        rows = np.flatnonzero(same & np.isclose(measurement.frequency, self.frequency, rtol=ALIKE))
        if len(rows) == 0:
            return self
        return replace(self, row=int(rows[0]) + 1)


def outlying(frame: NoiseFrame) -> NDArray[np.int64]:
    """Rows that neither the model nor slow structure nor noise explains.

    None where there are too many.

    The largest is taken out first and the rest judged anew, since one bad point drags the curve
    from its neighbours.

    Parameters
    ----------
    frame : NoiseFrame
        A fit.
    """
    n = len(frame.measurement)
    most = max(2, int(OUTLIERS.most * n))
    if n < FEWEST:
        return np.zeros(0, dtype=np.int64)
    # Slow structure is no outlier: of a wrong model every point would stand out from the fit.
    followed = np.concatenate([frame.absorbed, frame.smooth], axis=1)
    found: list[int] = []
    while len(found) <= most:
        rows = np.array([row for row in range(n) if row not in found])
        worst, chance = _worst(frame, followed, rows)
        if chance > OUTLIERS.rare:
            return np.array(sorted(found), dtype=np.int64)
        found.append(worst)
    return np.zeros(0, dtype=np.int64)


def off_from_repeats(measurement: Measurement) -> NDArray[np.int64]:
    """Rows that are further from the other repeats of their point than noise takes them.

    No model is asked, and none of two repeats: either may be the one that is off.

    Parameters
    ----------
    measurement : Measurement
        The data, repeats and all.
    """
    rows, off = np.arange(len(measurement)), np.zeros(0)
    most = max(2, int(OUTLIERS.most * len(rows)))
    found = taken = np.zeros(0, dtype=np.int64)
    # One may hide beside another: the search ends where two more are none.
    while len(taken) <= min(len(found) + 2, most):
        told = _off_from_others(measurement.subset(rows))
        if told is None:
            break
        scaled, dof = told
        if len(taken) > len(found) and _chance(scaled, off, max(2, len(off)), dof) < OUTLIERS.rare:
            found = taken
        furthest = int(np.argmax(scaled))
        off, taken = np.append(off, scaled[furthest]), np.append(taken, rows[furthest])
        rows = np.delete(rows, furthest)
    return np.sort(found) if len(found) <= most else found[:0]


def _off_from_others(measurement: Measurement) -> tuple[Real, float] | None:
    """Squared deviations (N,) of rows from the others of their point, both parts, and their dof.

    In units of the noise that repeats tell; None where they tell too little.
    """
    data = average_repeats(measurement)
    noise = noise_of_repeats(data)
    if noise is None:
        return None
    count, group = data.count, data.group
    single = noise.weights / np.sqrt(count)
    turn = None if noise.turn is None else noise.turn[group]
    squares = np.sum(weighted(data.apart, single[group], turn).reshape(2, -1) ** 2, axis=0)
    several = count[group] > 2
    free = 1.0 - 1.0 / count[group]
    return np.where(several, squares / np.where(several, free, 1.0), 0.0), noise.dof


def pulling(frames: Iterable[NoiseFrame], alarmed: bool = True) -> NDArray[np.int64]:
    """The one row (1,) that bends a fit most, where it carries most of what that fit leaves.

    Else none. Where no test is `alarmed` it must carry more than any of so many rows does by
    chance, once in `OUTLIERS.rare`: of a dozen points a bad one looks as if all scattered.

    At the end of a sweep a bad point has too few neighbours to stand out from them, and every model
    bows to it. What is left without it follows from the fit itself (Cook and Weisberg, Residuals
    and Influence in Regression, 1982).

    Parameters
    ----------
    frames : iterable of NoiseFrame
        Fits of the same data: the user's model and those grown from it.
    alarmed : bool
        Whether these fits plainly leave more than noise.
    """
    largest, row = OUTLIERS.carries, -1
    for frame in _in_plain_noise(frames, alarmed):
        n = len(frame.measurement)
        basis = np.stack([frame.absorbed[:n], frame.absorbed[n:]], axis=1)
        rest = np.stack([frame.rest[:n], frame.rest[n:]], axis=1)
        # Of each point the 2 x 2 block of I - H: what the parameters leave of its storage and its
        # loss.
        free = np.eye(2) - basis @ basis.transpose(0, 2, 1)
        seen = np.linalg.eigvalsh(free)[:, 0] > LEAST_LEFT
        lost = np.zeros(n)
        lost[seen] = np.sum(
            rest[seen] * np.linalg.solve(free[seen], rest[seen][..., None])[..., 0], axis=1
        )
        share = float(lost.max()) / max(float(frame.rest @ frame.rest), SMALLEST)
        # What is left without it has two degrees of freedom less (Cook & Weisberg, section 2.2).
        dof = max(2.0 * n - frame.absorbed.shape[1] - 2.0, 1.0)
        ratio = 0.5 * share * dof / max(1.0 - share, SMALLEST)
        chance = _chance_of_any(f_sf(ratio, 2.0, dof), n)
        # Of few points one carries half of a residual by chance.
        if share > largest and (chance < OUTLIERS.rare or (alarmed and n >= FEWEST)):
            largest, row = share, int(np.argmax(lost))
    return np.array([row], dtype=np.int64)[: int(row >= 0)]


def _in_plain_noise(frames: Iterable[NoiseFrame], alarmed: bool) -> Iterator[NoiseFrame]:
    """The fits, and where no test is alarmed their geometry beside noise in proportion to K.

    A bad point at an end looks as if the noise were larger there.
    """
    for frame in frames:
        yield frame
        if not alarmed and frame.estimated:
            plain = np.asarray((1.0 + 1.0j) / frame.measurement.magnitude, dtype=np.complex128)
            yield replace(frame, weights=plain, turn=None)


def side_by_side(measurement: Measurement, rows: NDArray[np.int64]) -> bool:
    """Whether two of these rows are neighbours in a sweep.

    A wrong reading stands alone, a notch does not.
    """
    for sweep in sweeps_of(measurement):
        places = np.flatnonzero(np.isin(sweep.rows, rows))
        if np.any(np.diff(places) == 1):
            return True
    return False


def ends_beside(measurement: Measurement, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """The last two rows of each end of a sweep at which one of these rows is.

    There an effect may begin.

    Parameters
    ----------
    measurement : Measurement
        The data.
    rows : ndarray of int
        Rows that stand out.
    """
    beside: list[int] = []
    for sweep in sweeps_of(measurement):
        for end in (sweep.rows[:END], sweep.rows[-END:]):
            if np.any(np.isin(end, rows)):
                beside += end.tolist()
    return np.unique(np.array(beside, dtype=np.int64))


def _worst(
    frame: NoiseFrame, followed: NDArray[np.float64], rows: NDArray[np.int64]
) -> tuple[int, float]:
    """The row that stands out most from a fit to these rows.

    With the chance that noise alone lets one of them, or several together, stand out as far.
    """
    scaled, _ = _squares(frame, followed, rows)
    worst = int(rows[np.argmax(scaled)])
    # In units of a known noise nothing of the others is needed.
    if frame.scale_dof == inf:
        return worst, _chance_of_any(chi2_sf(np.max(scaled), 2), len(rows))
    # The others are judged without it: a bad point drags the curve from its neighbours, whose tails
    # then seem long. So are those beside two, or more of them.
    doubtful, least = max(2, int(OUTLIERS.most * len(rows))), 1.0
    off, others = np.zeros(0), rows
    for _ in range(doubtful):
        furthest = int(np.argmax(scaled))
        off, others = np.append(off, scaled[furthest]), np.delete(others, furthest)
        scaled, variance = _squares(frame, followed, others)
        dof = max(2.0 * len(others) - followed.shape[1], 1.0)
        # Exact data leave no variance at all.
        unit = max(variance, np.finfo(float).tiny)
        least = min(least, _chance(scaled / unit, off / unit, doubtful, dof))
    return worst, least


def _squares(
    frame: NoiseFrame, followed: NDArray[np.float64], rows: NDArray[np.int64]
) -> tuple[NDArray[np.float64], float]:
    """Squared deviations (m,), both parts, from a fit to these rows alone, and their variance."""
    n = len(frame.measurement)
    both = np.concatenate([rows, rows + n])
    basis, _ = np.linalg.qr(followed[both])
    left = projected_out(frame.residual[both], basis)
    # Where curves follow most of a point, its residual is small however wrong it is: so it is
    # brought to full size.
    free = 1.0 - np.sum(basis**2, axis=1)
    variance = trimmed_residual(frame.residual[both], basis, frame.measurement.omega[rows]).variance
    scaled = np.where(free > LEAST_LEFT, left**2 / np.maximum(free, LEAST_LEFT), 0.0)
    return scaled.reshape(2, -1).sum(axis=0), variance


def _chance(others: Real, off: Real, doubtful: int, dof: float) -> float:
    """Chance that noise lets so many points be as far off as these, by the tails of the others.

    Each squared deviation is of both parts of a point.

    Half the sum of two squares follows F(2, nu) if the scatter is Student's with nu degrees of
    freedom; which of few the others have is told by their likelihood. Those that may be outliers
    themselves, of all `doubtful` ones, count as no more than beyond the rest (censored). Noise with
    long tails makes no outliers.
    """
    half = 0.5 * np.sort(others)
    inner = np.maximum(half[: len(half) + len(off) - doubtful], ROUNDING)
    likelihood = []
    for nu, scale in TAILS:
        of_inner = float(np.sum(f_log_density(inner / scale, 2, nu) - np.log(scale)))
        beyond = np.maximum(f_sf(inner[-1] / scale, 2, nu), SMALLEST)
        likelihood.append(of_inner + doubtful * float(np.log(beyond)))
    best = int(np.argmax(likelihood))
    # Normal unless the others clearly say otherwise: some long tail always fits few points a little
    # better.
    if likelihood[best] < likelihood[0] + OUTLIERS.heavier:
        best = 0
    nu, scale = TAILS[best]
    # The size of the scatter is known as well as its degrees of freedom say.
    known = 1.0 / (1.0 / nu + 1.0 / dof)
    tail = f_sf(0.5 * float(np.min(off)) / scale, 2, known)
    return _chance_of_any(tail, len(others) + len(off), len(off))


def _chance_of_any(chance: ArrayLike, n: int, count: int = 1) -> float:
    """Chance that some `count` of n points or more are as far off as one is by this chance.

    Each of them might have been it: a binomial tail.
    """
    return float(betainc(count, n - count + 1, chance))


def described(frame: NoiseFrame, rows: NDArray[np.int64]) -> list[Outlier]:
    """What is to be told of rows that stand out from a fit."""
    n = len(frame.measurement)
    off = frame.measurement.stiffness - frame.model_stiffness
    size = np.hypot(frame.residual[:n], frame.residual[n:])
    alone = stands_alone(frame, rows)
    return [
        Outlier(
            float(frame.measurement.frequency[row]),
            float(size[row]),
            complex(off[row] / frame.measurement.magnitude[row]),
            point_in_words(frame.measurement, int(row)),
            complex(frame.measurement.stiffness[row]),
            frame.measurement.units.magnitude,
            alone=alone,
        )
        for row in rows
    ]


def stands_alone(frame: NoiseFrame, rows: NDArray[np.int64]) -> bool:
    """Whether rows that stand out do so by themselves, as bad readings do.

    They are no neighbours, of different frequencies, and what lies beside them, along the sweep and
    at the same frequency in others, is no further from the fit than noise takes it.

    Parameters
    ----------
    frame : NoiseFrame
        A fit without these rows, seen at all.
    rows : ndarray of int
        Those that stand out.
    """
    if side_by_side(frame.measurement, rows):
        return False
    which = frequency_numbers(frame.measurement)
    if len(np.unique(which[rows])) < len(rows):
        return False
    beside = set(np.flatnonzero(np.isin(which, which[rows])).tolist())
    for sweep in sweeps_of(frame.measurement):
        for place in np.flatnonzero(np.isin(sweep.rows, rows)):
            beside |= set(sweep.rows[max(place - 1, 0) : place + 2].tolist())
    others = np.array(sorted(beside - set(rows.tolist())), dtype=np.int64)
    if not len(others):
        return True
    n = len(which)
    squares = frame.residual[others] ** 2 + frame.residual[others + n] ** 2
    chance = chance_of_squares(float(np.sum(squares)), 2.0 * len(others), frame.scale_dof)
    return chance > VERDICT.structure_alarm


def without(measurement: Measurement, rows: NDArray[np.int64]) -> Measurement:
    """The measurement without these rows; the reference temperature stays."""
    kept = measurement.subset(np.setdiff1d(np.arange(len(measurement)), rows))
    kept = replace(kept, name=measurement.name)
    kept.__dict__["reference_temperature"] = measurement.reference_temperature
    return kept


def are_outliers(
    with_points: tuple[Refit, Refit], without_points: tuple[Refit, Refit], count: int
) -> bool:
    """Whether bad points explain more than the best effect that was found with them.

    Parameters
    ----------
    with_points, without_points : (Refit, Refit)
        The user's model and the best grown one, fitted to the data with and without the points.
    count : int
        How many they are.
    """
    (base, best), (base_without, best_without) = with_points, without_points
    data = base.fit.measurement
    size = 2 * len(data)
    # Both in units of the noise of the data without the points: an estimate that holds them cannot
    # judge them.
    left = base_without.frame_of(data).whiten(data.stiffness - best.stiffness)
    gain = float(left @ left) - best_without.rss
    # As an effect is judged: by chi-square and a price, which for a point is that of choosing it
    # among all.
    spent = len(best.own) - len(best_without.own)
    return bool(gain + spent * np.log(size) > 2.0 * count * (np.log(0.5 * size) + OUTLIERS.price))
