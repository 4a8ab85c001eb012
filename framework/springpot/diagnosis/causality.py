"""Whether a residual is causal: whether its K' and K'' belong together as Kramers and Kronig say.

Two random curves are weighed against each other by their evidence. Both are sums of bumps along the frequency, of one
width and one size that the data choose, inside the band and beside it. In the causal curve each bump of K' brings its
own K'', as a weak resonance does; in the other K' and K'' have the same bumps but go their own ways. So nothing is
asked of the data but whether the two parts belong together (compare the Bayesian test of Liu et al. 2020,
doi:10.1149/1945-7111/ab631a).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Complex, Real

from .bases import orthonormal
from .frame import Frame

Rows: TypeAlias = NDArray[np.int64]
WIDTHS = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0)
"""Widths of the bumps in steps of the measured frequencies."""
SIZES = np.geomspace(1e-2, 1e2, 17)
"""Sizes of the bumps in sizes of the residual."""
BEYOND = 5.0
"""Range of ln omega beyond the data in which bumps may lie."""
MOST_BESIDE = 25
"""Bumps beyond each end of the data at most."""
MOST = 60
"""Steps along the frequency at most."""


def causal_evidence(frame: Frame, x: Real, groups: Sequence[Rows]) -> float:
    """Log-evidence for causality against independent K' and K''; near zero where the data cannot tell.

    Parameters
    ----------
    frame : Frame
        The fit whose residual is judged.
    x : ndarray, shape (n,)
        Ln omega along which it is a curve, reduced by temperature or not.
    groups : sequence of ndarray of int
        Rows that share one curve, such as sweeps.
    """
    n, step = len(x), step_of(frame)
    off = frame.measurement.stiffness - frame.model_stiffness
    size = float(np.sqrt(np.mean(np.abs(off / frame.model_stiffness) ** 2)))
    best: dict[str, Real] = {}
    for width in WIDTHS:
        total: dict[str, Real] = {}
        for rows in groups:
            both = np.concatenate([rows, rows + n])
            absorbed = orthonormal(frame.absorbed[both])
            values = frame.residual[both]
            values = values - absorbed @ (absorbed.T @ values)
            for name, columns in _curves(frame, x, rows, width * step):
                columns = columns - absorbed @ (absorbed.T @ columns)
                total[name] = total.get(name, 0.0) + _evidence(columns, values, size * SIZES)
        for name, evidence in total.items():
            best[name] = np.append(best.get(name, []), np.max(evidence))
    top = {name: float(np.max(values)) for name, values in best.items()}
    return top.pop("causal") - max(top.values())


def step_of(frame: Frame) -> float:
    """Distance of neighbouring measured frequencies in ln omega, within reason."""
    distinct = np.unique(np.round(np.log(frame.measurement.omega), 6))
    if len(distinct) < 2:
        return 1.0
    return float(max(np.median(np.diff(distinct)), np.ptp(distinct) / MOST))


def _curves(frame: Frame, x: Real, rows: Rows, width: float) -> Iterator[tuple[str, Real]]:
    """Columns (2m, q) of the causal curve and of those whose parts are independent, whitened."""
    stiffness = frame.model_stiffness[rows]
    shapes = np.array(list(_shapes(x[rows], stiffness, width)))
    weights = frame.weights[rows]

    def whitened(change: Complex) -> Real:
        return np.concatenate([change.real * weights.real, change.imag * weights.imag], axis=1).T

    real, imaginary = whitened(shapes.real * stiffness), whitened(1j * shapes.imag * stiffness)
    yield "causal", real + imaginary
    yield "apart", np.concatenate([real, imaginary], axis=1)
    yield "storage", real
    yield "loss", imaginary


def _shapes(x: Real, stiffness: Complex, width: float) -> Iterator[Complex]:
    """Causal relative changes of K: resonances in and beside the band, and what those far away leave in it."""
    beside = min(BEYOND, MOST_BESIDE * width)
    for pole in np.arange(x.min() - beside, x.max() + beside + width, width):
        at = 1j * np.exp(np.clip(x - pole, -300.0, 300.0))
        yield 2.0 * width * at / (1.0 + 2.0 * width * at + at**2)
    s = 1j * np.exp(x - np.mean(x))
    for far in (np.ones_like(s), s, 1.0 / stiffness, s / stiffness, s**2 / stiffness, stiffness, stiffness / s):
        yield far / np.max(np.abs(far))


def _evidence(columns: Real, values: Real, sizes: Real) -> Real:
    """Log-evidence of a sum of columns with normal coefficients of each size, over that of noise alone."""
    power, directions = np.linalg.eigh(columns.T @ columns)
    kept = power > 1e-10 * max(float(power[-1]), 1e-300)
    power = power[kept]
    along = (directions[:, kept].T @ (columns.T @ values)) ** 2 / power
    gain = power * sizes[:, None] ** 2
    return np.asarray(0.5 * np.sum(gain / (1.0 + gain) * along - np.log1p(gain), axis=1), dtype=np.float64)
