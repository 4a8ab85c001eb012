"""Exponentials driven by a sampled history.

The exact recursion for an input that is linear between its samples.

With g = (1 - exp(-r h))/(r h) and steps h, q(t), the integral of exp(-r (t - u)) dx(u), obeys
q_k = exp(-r h) q_(k-1) + g (x_k - x_(k-1)):
each step needs the last state only, whatever the sampling, and a ramp is exact (Taylor, Pister &
Goudreau 1970, 10.1002/nme.1620020106).
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..numerics import ALIKE, ROUNDING
from .points import Real

Modes: TypeAlias = NDArray[np.inexact[Any]]
"""Real rates, or complex ones of oscillations."""

BLOCK = 4096
"""Samples in work at a time: with some 100 modes they stay in the processor's cache."""
ROWS = 64
"""Parts of a block that are scanned side by side, as long as they are many."""
RUN = 64
"""Evenly spaced samples that are one product of matrices."""
SMALL = 1e-2
"""Below this |r h| the power series of g' is as exact as its closed form."""


def driven(rates: Modes, steps: Modes, changes: Real, mix: Modes, rate_mix: Modes) -> Modes:
    """Sums over modes q_j that follow the same input, without ever holding them all.

    Parameters
    ----------
    rates : ndarray, shape (m,)
        Of the modes, in 1/s.
    steps : ndarray, shape (n,)
        Time from the sample before to each sample, in (reduced) seconds; the first one is of no
        account.
    changes : ndarray, shape (n,)
        Change of the input from the sample before to each sample.
    mix, rate_mix : ndarray, shape (m, c)
        How much of q_j, and of dq_j/dr_j, goes into each of the c outputs.

    Returns
    -------
    ndarray, shape (n, c)
        q @ mix + dq/dr @ rate_mix.
    """
    n, kind = len(steps), np.result_type(rates, steps, changes, mix)
    out = np.zeros((n, mix.shape[1]), dtype=kind)
    if not len(rates):
        return out
    # Only modes whose rate is asked for need the second, costlier recursion of the slopes.
    moving = np.flatnonzero(np.any(rate_mix != 0.0, axis=1))
    last, last_slope = np.zeros(len(rates), dtype=kind), np.zeros(len(moving), dtype=kind)
    inner = steps[1:]
    if n > BLOCK and not np.iscomplexobj(inner) and np.ptp(inner) <= ALIKE * np.max(inner):
        return _driven_evenly(rates, float(np.mean(inner)), changes, mix, rate_mix)
    for start in range(0, n, BLOCK):
        part = slice(start, min(start + BLOCK, n))
        one, step = changes[part], steps[part]
        decay, gain = _step(rates, step[:, None])
        q = _scan(decay, gain * one[:, None], last)
        if len(moving):
            # dq/dr obeys the same recursion, driven by the derivatives of its two factors.
            before = np.vstack([last[moving], q[:-1, moving]])
            kicks = _gain_slope(rates[moving], step[:, None]) * one[:, None]
            kicks = kicks - step[:, None] * decay[:, moving] * before
            turned = _scan(decay[:, moving], kicks, last_slope)
            out[part] = turned @ rate_mix[moving]
            last_slope = turned[-1]
        out[part] += q @ mix
        last = q[-1]
    return out


def mean_of_exponential(first: Modes, last: Modes) -> Modes:
    """Mean of exp(y) where y runs linearly from `first` to `last`."""
    return np.exp(first) * _step(np.ones(1), first - last)[1]


def _step(rates: Modes, step: Modes) -> tuple[Modes, Modes]:
    z = rates * step
    # 1 - exp(-z) as it stands would lose all digits of a slow mode in a short step.
    lost = -np.expm1(-z)
    gain = np.where(np.abs(z) < ROUNDING, 1.0, lost / np.where(z == 0.0, 1.0, z))
    return 1.0 - lost, gain


def _gain_slope(rates: Modes, step: Modes) -> Modes:
    """Derivative of g by the rate."""
    z = rates * step
    near = np.abs(z) < SMALL
    far = np.where(near, 1.0, z)
    # Its two terms cancel where z is small: there the series takes over.
    closed = (np.exp(-far) - -np.expm1(-far) / far) / far
    series = -0.5 + z / 3.0 - z**2 / 8.0 + z**3 / 30.0 - z**4 / 144.0 + z**5 / 840.0
    slope: Modes = step * np.where(near, series, closed)
    return slope


def _driven_evenly(rates: Modes, step: float, changes: Real, mix: Modes, rate_mix: Modes) -> Modes:
    """The same where all steps are alike: then what many samples do is one product of matrices.

    Samples are taken in runs of `RUN`. Within a run the outputs are a convolution with a short
    kernel; from run to run only the modes are carried, q and s = dq/dr, by the same recursion with
    longer steps.
    """
    n, (m, outputs) = len(changes), mix.shape
    runs = -(-n // RUN)
    # Filled up with changes of nothing, so that all runs are equally long.
    moved = np.zeros((runs, RUN), dtype=changes.dtype)
    moved.ravel()[:n] = changes
    _, gain = _step(rates, np.array([step]))
    gain_slope = _gain_slope(rates, np.array([step]))
    # Of a change, k steps later (RUN + 1, m): what is left of q and of s.
    time = step * np.arange(RUN + 1)[:, None]
    fading = np.exp(-rates * time)
    left, left_slope = gain * fading, (gain_slope - time * gain) * fading
    kernel = left[:RUN] @ mix + left_slope[:RUN] @ rate_mix
    lag = np.arange(RUN) - np.arange(RUN)[:, None]
    within = np.where((lag >= 0)[..., None], kernel[lag], 0.0)  # (from, to, outputs)
    out = moved @ within.reshape(RUN, RUN * outputs)
    # What each run leaves behind by itself, and what had gathered before it.
    q = _before(fading[RUN], moved @ left[RUN - 1 :: -1][:RUN])
    kicks = moved @ left_slope[RUN - 1 :: -1][:RUN] - time[RUN] * fading[RUN] * q
    s = _before(fading[RUN], kicks)
    later, times = fading[1:].T[..., None], time[1:]
    by_q = later * (mix[:, None] - times * rate_mix[:, None])
    out = out + q @ by_q.reshape(m, RUN * outputs)
    out = out + s @ (later * rate_mix[:, None]).reshape(m, RUN * outputs)
    return np.asarray(out.reshape(runs * RUN, outputs)[:n])


def _before(decay: Modes, kicks: Modes) -> Modes:
    """What the recursion q_k = decay q_(k-1) + kicks_k from rest holds before each step, (n, m)."""
    after = _scan(np.broadcast_to(decay, kicks.shape), kicks, np.zeros_like(kicks[0]))
    return np.vstack([np.zeros_like(kicks[:1]), after[:-1]])


def _scan(decay: Modes, kicks: Modes, start: Modes) -> Modes:
    """q_k = decay_k q_(k-1) + kicks_k for each mode, all (n, m)."""
    n, m = kicks.shape
    # A loop over all samples is slow in Python: this one runs over columns only, with all rows in
    # each step.
    columns = -(-n // ROWS)
    shape = (ROWS, columns, m)
    # Filled up with steps that change nothing, so that all rows are equally long.
    factors, q = (
        np.ones((ROWS * columns, m), dtype=kicks.dtype),
        np.zeros((ROWS * columns, m), dtype=kicks.dtype),
    )
    factors[:n], q[:n] = decay, kicks
    factors, q = factors.reshape(shape), q.reshape(shape)
    # Every row on its own first, all rows at once; then what each carries over into the next one.
    for k in range(1, columns):
        q[:, k] += factors[:, k] * q[:, k - 1]
        factors[:, k] *= factors[:, k - 1]
    carried = start
    for row in range(ROWS):
        q[row] += factors[row] * carried
        carried = q[row, -1]
    return q.reshape(-1, m)[:n]
