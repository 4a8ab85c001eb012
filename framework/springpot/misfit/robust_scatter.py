"""The scatter about slow curves.

Without the frequencies that stand out and without the ripples of an instrument.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_quantile, f_quantile, f_sf, gamma_sf
from springpot.measurement.one_frequency import rounded_log_omega
from springpot.measurement.sweeps import sweeps_of
from springpot.rheology.points import Real
from springpot.thresholds import SCATTER

from .frame import LEAST_SEEN, Frame
from .shapes import drift_shapes, orthonormal, spectrum, waves

MOST_TURNS = 10
"""Times that the points which stand out are found anew; nearly all settle in three."""
FINE = 41
"""Periods tried between the neighbours of the strongest one."""
LEAST_WAVE = 1e-9
"""Singular value, beside the largest, below which a direction of a ripple is rounding."""
MOST_RIPPLES = 2
"""Periods that are taken out of the scatter; a third could follow noise."""
SLOWEST_RIPPLE = 16.0
"""Points of the longest period: longer waves are slow structure already."""
SLOW_WAVES = 2
"""Waves along a sweep up to which its polynomials of degree 5 are that structure, however many its
points.
"""
FEWEST_FREE = 20.0
"""Degrees of freedom below which a period would take too many of them."""
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


def trimmed(frame: Frame, kept: NDArray[np.bool_] | None = None) -> Trimmed:
    """The whitened scatter of a fit about slow curves.

    Without the frequencies at which it is far larger.

    Parameters
    ----------
    frame : Frame
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
    inner = (
        columns[rows]
        - followed[rows] @ np.linalg.lstsq(followed[rows], columns[rows], rcond=None)[0]
    )
    kept = np.linalg.norm(inner, axis=0) > LEAST_SEEN * np.linalg.norm(columns[rows], axis=0)
    basis = orthonormal(inner[:, kept])
    # In one sweep of even steps drift is slow structure already: nothing of it is left to explain.
    spent = float(basis.shape[1])
    if spent == 0.0 or scatter.dof <= spent:
        return False
    explained = float(np.sum((basis.T @ scatter.left[rows]) ** 2))
    left = max(float(np.sum(scatter.left[rows] ** 2)) - explained, 1e-300)
    ratio = (explained / spent) / (left / (scatter.dof - spent))
    return bool(f_sf(ratio, spent, scatter.dof - spent) < SCATTER.ripple_alarm)


def _ripple(frame: Frame, scatter: Trimmed) -> float:
    """Period, in points, of a ripple that the scatter holds.

    Zero where the strongest one may be chance.

    Of white noise the power at each of n independent frequencies is a sum of exponentials, one for
    each part of each sweep; a periodic error of the analysis or of a resonance of the chain is not
    (Fisher 1929, doi:10.1098/rspa.1929.0151).
    """
    left = np.where(scatter.kept, scatter.left, 0.0)
    power = spectrum(frame.measurement, left[None])[0]
    lines = 2 * len(sweeps_of(frame.measurement))
    longest = len(power) - 1
    # Slow waves are structure, and told of elsewhere. The spectrum counts in half waves along a
    # sweep.
    first = min(int(np.ceil(2.0 * longest / SLOWEST_RIPPLE)), 2 * SLOW_WAVES)
    if first + 1 >= len(power):
        return 0.0
    peak = first + int(np.argmax(power[first:]))
    mean = float(np.sum(left**2)) / len(frame.measurement)
    # The strongest of so many periods is told: each of them might have been it (Bonferroni).
    chance = longest * float(gamma_sf(power[peak] / mean, lines))
    if chance > SCATTER.ripple_alarm:
        return 0.0
    # A ripple hardly ever has a period of the coarse grid, and one that is off leaves much of it at
    # the ends.
    periods = 2.0 * longest / np.linspace(peak - 1.0, peak + 1.0, FINE)[1:-1]
    return float(periods[np.argmax(_energy_of_ripples(frame, left, periods))])


def _energy_of_ripples(frame: Frame, left: Real, periods: Real) -> Real:
    """Energy (m,) of a whitened scatter along ripples in size and phase of K.

    The ripples are of some periods (m,), in points.
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
        weights = frame.weights[rows][:, None]
        columns = np.concatenate([change.real * weights.real, change.imag * weights.imag], axis=1)
        size = np.linalg.norm(columns, axis=1, keepdims=True)
        axes, sizes, _ = np.linalg.svd(
            columns / np.where(size > 0.0, size, 1.0), full_matrices=False
        )
        along = np.einsum("kji,j->ki", axes, np.concatenate([left[rows], left[rows + n]]))
        # The fastest alternation has no sine: its direction is rounding.
        energy += np.sum(along**2 * (sizes > LEAST_WAVE * sizes[:, :1]), axis=1)
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
        left = residual - followed @ np.linalg.lstsq(followed[rows], residual[rows], rcond=None)[0]
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
