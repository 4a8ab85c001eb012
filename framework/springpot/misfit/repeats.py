"""Whether repeats differ by chance alone, and what sets them apart where they do not."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from springpot.measurement.replicates import Averaged
from springpot.measurement.sweeps import sweeps_of
from springpot.thresholds import REPEATS, VERDICT

from .frame import DRAWS
from .residual_battery import Battery, judged
from .residual_tests import kinship
from .shapes import Drawn, drift_curves, orthonormal

NEIGHBOURS = "neighbours"
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
    if np.sum(data.scatter.dof) < REPEATS.fewest:
        return Battery(1.0, {})
    # Simulated repeats lose the mean of their group, as the measured ones did.
    count = data.scatter.dof + 1.0
    noise = rng.standard_normal((DRAWS, 2, len(data.raw)))
    order = np.argsort(data.group, kind="stable")
    starts = np.searchsorted(data.group[order], np.arange(len(count)))
    mean = np.add.reduceat(noise[..., order], starts, axis=-1) / count
    noise -= mean[:, :, data.group]
    measured = data.deviations()
    sample = np.concatenate([np.stack([measured.real, measured.imag])[None], noise])
    # In units of their own scatter: how large repeats scatter is the noise itself, and only order
    # is evidence.
    sample /= np.sqrt(np.mean(sample**2, axis=-1, keepdims=True))
    drift = orthonormal(drift_curves(len(data.raw)))
    lines = [sweep.rows for sweep in sweeps_of(data.raw)]
    statistics = {
        "drift": np.sum((sample @ drift) ** 2, axis=(1, 2)),
        NEIGHBOURS: sum(np.sum(kinship(sample[:, :, rows]), axis=1) for rows in lines),
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
    count = np.bincount(data.group)
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
