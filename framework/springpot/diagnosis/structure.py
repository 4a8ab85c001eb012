"""Is anything left? One test on the residual that needs no list of effects.

Several statistics look for different kinds of structure (slow curves, runs, single points, too much scatter). Each
is turned into a chance by simulated noise that has lost what the parameters follow, and the smallest of these chances
is itself judged against its own distribution in the same simulation: looking in several ways costs no false alarm.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Real

from .bases import orthonormal
from .frame import Frame
from .noise import Averaged
from .sweeps import slow_shapes, spectrum, sweeps_of

DRAWS = 2000
EDGE = (1e-3, 2e-2)
"""Chances about the alarms, which lie between 0.002 and 0.006, that are resolved by more draws."""
MORE = 9
"""So many times as many draws more."""
FEWEST_REPEATS = 8
"""Repeated points below which nothing can be said of how repeats differ."""
NEIGHBOURS = np.exp(-0.5 * (np.arange(1, 7) / 3.0) ** 2)
"""Weights of the first to sixth neighbour in runs: an error that is shared is mostly shared by several points, and a
sum over them sees it where the products of next neighbours alone are too few."""
MOST_LOCAL = 600
"""Narrow shapes looked at; more points than these have slow structure enough."""


@dataclass(frozen=True)
class Structure:
    """Chances that noise alone leaves a residual like this.

    Attributes
    ----------
    p_value : float
        Of the most telling statistic, with the others taken into account.
    parts : dict of str to float
        Of each statistic by itself.
    """

    p_value: float
    parts: dict[str, float]

    @property
    def kind(self) -> str:
        """The most telling statistic."""
        return min(self.parts, key=lambda name: self.parts[name])


def repeats_structure(data: Averaged, rng: np.random.Generator) -> Structure:
    """Test whether repeats differ by chance alone, or drift in time or move together along a sweep.

    Parameters
    ----------
    data : Averaged
        Data with repeats; without them nothing can be said and the chance is one.
    rng : numpy.random.Generator
        For the simulated noise.
    """
    if np.sum(data.scatter.dof) < FEWEST_REPEATS:
        return Structure(1.0, {})
    count = data.scatter.dof + 1.0
    noise = rng.standard_normal((DRAWS, 2, len(data.raw)))
    order = np.argsort(data.group, kind="stable")
    starts = np.searchsorted(data.group[order], np.arange(len(count)))
    mean = np.add.reduceat(noise[..., order], starts, axis=-1) / count
    noise -= mean[:, :, data.group]
    measured = data.deviations()
    sample = np.concatenate([np.stack([measured.real, measured.imag])[None], noise])
    sample /= np.sqrt(np.mean(sample**2, axis=-1, keepdims=True))
    slow = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, len(data.raw)), 3)
    drift = orthonormal(np.asarray(slow, dtype=np.float64))
    statistics = {
        "drift": np.sum((sample @ drift) ** 2, axis=(1, 2)),
        "neighbours": sum(np.sum(_kinship(sample[:, :, sweep.rows]), axis=1) for sweep in sweeps_of(data.raw)),
    }
    return _judged(statistics)


def structure(frame: Frame, rng: np.random.Generator) -> Structure:
    """Test the residual of a fit for structure of any kind.

    Parameters
    ----------
    frame : Frame
        The fit.
    rng : numpy.random.Generator
        For the simulated noise.
    """
    sample = np.concatenate([frame.standard(frame.rest[None, :]), frame.draws(DRAWS, rng)])
    statistics = _statistics(frame, sample)
    found = _judged(statistics)
    if not EDGE[0] < found.p_value < EDGE[1]:
        return found
    # Near the alarms two thousand draws leave the verdict to the seed: twenty thousand do not.
    more = [statistics, *(_statistics(frame, frame.draws(DRAWS, rng)) for _ in range(MORE))]
    return _judged({name: np.concatenate([each[name] for each in more]) for name in statistics})


def _judged(statistics: dict[str, Real]) -> Structure:
    """Chances of the first member of the sample, the smallest judged against its own distribution."""
    chances = {name: _chances(values) for name, values in statistics.items()}
    smallest = np.min(np.array(list(chances.values())), axis=0)
    p_value = float(np.mean(smallest <= smallest[0]))
    return Structure(p_value, {name: float(values[0]) for name, values in chances.items()})


def _chances(values: Real) -> Real:
    """Share of the sample that is at least as large, for every member of it."""
    ordered = np.sort(values)
    return (len(values) - np.searchsorted(ordered, values, side="left")) / len(values)


def _statistics(frame: Frame, sample: Real) -> dict[str, Real]:
    found = {
        "slow": np.sum((sample @ frame.smooth) ** 2, axis=1),
        "shared": np.sum((sample @ frame.shared) ** 2, axis=1),
        "common": np.sum((sample @ _common(frame)) ** 2, axis=1),
        "runs": _runs(frame, sample, _along_frequency(frame)),
        "ripple": _ripple(frame, sample),
        "order": _runs(frame, sample, [np.arange(len(frame.measurement))]),
        "one frequency": np.max(np.abs(sample @ _local(frame)), axis=1, initial=0.0),
        "single points": np.max(np.abs(sample), axis=1),
    }
    if frame.scale_dof == inf:
        found["scatter"] = np.sum(sample * sample, axis=1)
    return found


def _common(frame: Frame) -> Real:
    """Slow shapes that all sweeps share."""
    shapes = slow_shapes(frame.measurement)
    degrees = len(shapes) // max(1, len(sweeps_of(frame.measurement)))
    pooled = np.array([shapes[i::degrees].sum(axis=0) for i in range(degrees)])
    columns = [frame.whiten(factor * frame.model_stiffness * pooled) for factor in (1.0, 1.0j)]
    return frame.beyond(np.concatenate(columns).T)


def _local(frame: Frame) -> Real:
    """Narrow shapes fixed in Hz that all sweeps share: one to three neighbouring frequencies, each part by itself."""
    log_omega = np.log(frame.measurement.omega)
    distinct, which = np.unique(np.round(log_omega, 6), return_inverse=True)
    which, n = which.ravel(), len(log_omega)
    columns = []
    for width in (1, 2, 3):
        starts = np.arange(len(distinct) - width + 1)
        inside = ((which[:, None] >= starts) & (which[:, None] < starts + width)).astype(float)
        empty = np.zeros((n, len(starts)))
        columns += [np.concatenate([inside, empty]), np.concatenate([empty, inside])]
    local = frame.project(np.concatenate(columns, axis=1)[:, :MOST_LOCAL])
    size = np.sqrt(np.sum(local * local, axis=0))
    narrow: Real = local[:, size > 0.1] / size[size > 0.1]
    return narrow


def _ripple(frame: Frame, sample: Real) -> Real:
    """Largest power of a periodic residual along the sweeps, of one period in all of them."""
    return np.asarray(spectrum(frame.measurement, sample).max(axis=1), dtype=np.float64)


def _along_frequency(frame: Frame) -> list[NDArray[np.int64]]:
    return [sweep.rows for sweep in sweeps_of(frame.measurement)]


def _runs(frame: Frame, sample: Real, orders: list[NDArray[np.int64]]) -> Real:
    """How alike neighbours are, K' and K'' apart."""
    n = len(frame.measurement)
    total = np.zeros(len(sample))
    for rows in orders:
        for offset in (0, n):
            total += _kinship(sample[:, rows + offset])
    return total


def _kinship(rows: Real) -> Real:
    """Weighted sum of products of neighbours along the last axis."""
    total: Real = np.zeros(rows.shape[:-1])
    for lag, weight in enumerate(NEIGHBOURS[: rows.shape[-1] - 1], 1):
        total += weight * np.einsum("...i,...i->...", rows[..., lag:], rows[..., :-lag])
    return total
