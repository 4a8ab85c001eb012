"""The transient with which a test starts: its time constant by variable projection."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.rheology.points import Real
from springpot.thresholds import SIGNALS

from .fit import GONE, Basis, Fit, fit_harmonics
from .record import Record

STEP = 1.25
"""Ratio of neighbouring time constants.

The fit's second transient column makes up for what lies between them.
"""
LONGEST = 4.0
"""Periods; what dies away more slowly than that is a drift and cannot pass for a harmonic."""
ROUNDING = 1e-20
"""Share of the square of exact signals that is left over."""


def fit_with_transient(record: Record, basis: Basis) -> tuple[Basis, Fit]:
    """Least squares with a decaying transient from the beginning of the part on, if there is one.

    The evidence is what the transient takes from the squared residuals, counted in the noise that
    it leaves near omega: slow noise of the same colour is not mistaken for it.
    """
    from scipy.special import chdtri, fdtri

    # Two sieves, the cheap one first: most records have no transient, and are spared the second
    # fit.
    trial, gain, noise = _strongest(record, basis)
    if np.any(gain > chdtri(1, SIGNALS.transient_alarm) * noise):
        fit = fit_harmonics(record, trial)
        if np.any(gain > fdtri(1, fit.freedom, 1 - SIGNALS.transient_alarm) * fit.noise[:2]):
            return trial, fit
    return basis, fit_harmonics(record, basis)


def unsteady_cycles(fit: Fit) -> int:
    """How many leading groups of cycles have a stiffness unlike that of the second half.

    Compared with the mean and scatter of the second half (F test); what comes after the first
    steady group is scatter and stays.
    """
    from scipy.special import fdtri

    each = fit.groups[:, 1] / fit.groups[:, 0]
    # A transient dies away, so that the later half is what the first cycles are measured by.
    settled = each[len(each) // 2 :]
    n = len(settled)
    if n < 3 or not np.isfinite(each).all():
        return 0
    centre = settled.mean()
    scatter = float(np.sum(np.abs(settled - centre) ** 2))
    # Computed signals scatter by rounding only, which must not make every cycle an exception.
    variance = max(scatter / (2 * (n - 1)), ROUNDING * float(abs(centre)) ** 2)
    limit = 2 * variance * (1 + 1 / n) * fdtri(2, 2 * (n - 1), 1 - SIGNALS.first_cycle_alarm)
    unlike = np.abs(each[: len(each) // 2] - centre) ** 2 > limit
    # Only an unbroken beginning is a transient; what comes later is scatter.
    return int(np.argmin(np.append(unlike, False)))


def _strongest(record: Record, basis: Basis) -> tuple[Basis, Real, Real]:
    """The basis with the transient that explains most, its gain and the noise variance.

    The variance is (2,), of the channels.

    A transient is linear but for its time constant, so that this alone is searched: each trial is
    one more column, made orthogonal to the rest (variable projection, doi:10.1137/0710036).
    """
    period = 2 * np.pi / basis.omega
    # In a short part even less: what lasts through it cannot be told from level and drift.
    longest = min(LONGEST * period, (basis.stop - basis.start) / 4)
    # By equal ratios: nobody knows beforehand how fast it dies.
    trials = np.exp(np.arange(np.log(period / 16), np.log(longest), np.log(STEP)))
    size = basis.size
    total = size + len(trials)
    normal, right, square, count = np.zeros((total, total)), np.zeros((total, 2)), np.zeros(2), 0
    for time, both in record.blocks(basis.start, basis.stop):
        if not len(time):
            continue
        columns = basis.columns(time)
        # Later blocks hold nothing of it but rounding.
        if time[0] - basis.start < GONE * longest:
            columns = np.concatenate(
                [columns, np.exp(-(time - basis.start)[:, None] / trials)], axis=1
            )
        have = columns.shape[1]
        normal[:have, :have] += columns.T @ columns
        right[:have] += columns.T @ both
        square += np.sum(both**2, axis=0)
        count += len(time)
    gain, explained = _gains(normal, right, size)
    left = np.maximum(square - explained, ROUNDING * square) + np.finfo(float).tiny
    best = int(np.argmax(np.sum(gain / left, axis=1)))
    noise = np.maximum(left - gain[best], ROUNDING * square) / max(count - size - 2, 1)
    # Too few samples to tell a transient from what the other columns leave.
    if count <= 2 * size:
        return basis, np.zeros(2), np.ones(2)
    return replace(basis, transient=float(trials[best])), gain[best], noise


def _gains(normal: Real, right: Real, size: int) -> tuple[Real, Real]:
    """What each trial takes from the squared residuals, (t, 2).

    Also what the columns before them explain, (2,).
    """
    # Columns of one size: a transient that dies at once is small beside a level, which would cost
    # digits.
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    normal, right = normal / np.outer(scale, scale), right / scale[:, None]
    shared = np.linalg.lstsq(
        normal[:size, :size], np.column_stack([right[:size], normal[:size, size:]]), rcond=1e-13
    )[0]
    remaining = 1 - np.sum(normal[:size, size:] * shared[:, 2:], axis=0)
    reach = right[size:] - normal[size:, :size] @ shared[:, :2]
    # A trial that the other columns can imitate gains nothing.
    gain = np.where(remaining[:, None] > 1e-3, reach**2 / np.maximum(remaining, 1e-3)[:, None], 0.0)
    return gain, np.sum(right[:size] * shared[:, :2], axis=0)
