"""Single samples of a record that stray from their neighbours, as a spike of the electronics does.

A model is not asked: fourth differences see neither what is smooth nor what the specimen does
slowly, and a sample that is off by itself leaves its own pattern in the five that hold it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import NORMAL, SMALLEST
from ..thresholds import OUTLIERS
from .timenoise import FEWEST, ORDER, clock_of, fourth_differences, noise_of
from .timetest import TimeTest

AROUND = 15
"""Samples on either side whose median tells how large the noise is there."""
TOLD = 5
"""Samples that are named at most."""


@lru_cache(maxsize=256)
def strays(test: TimeTest) -> NDArray[np.int64]:
    """Indices of the samples of a response that stray from their neighbours, each by itself.

    Beyond what noise does once in `OUTLIERS.rare`; none where more than `OUTLIERS.most` do, as that
    is how the signal is. What was imposed at the same instant must not bend there: a mass at a
    corner of the motion feels a real blow.

    Parameters
    ----------
    test : TimeTest
        The test.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.strays import strays
    >>> t = np.geomspace(0.1, 100.0, 60)
    >>> signal = t**-0.3 * (1.0 + 0.01 * np.random.default_rng(1).normal(size=60))
    >>> strays(TimeTest.of_relaxation(t, signal + 0.2 * (np.arange(60) == 30)))
    array([30])
    """
    none = np.zeros(0, dtype=np.int64)
    if not test.measured or len(test) < FEWEST + ORDER:
        return none
    clock = clock_of(test)
    differences, factors = _over_noise(test)
    off = _off(differences, factors)
    imposed = np.interp(test.time, test.loading.time, test.loading.value)
    bends = _beyond(_off(*fourth_differences(clock, imposed)))
    for at in np.searchsorted(test.time, test.loading.jumps[0]):
        bends[max(at - ORDER, 0) : at + ORDER] = True
    found = np.flatnonzero(_beyond(off) & ~bends).tolist()
    alone = [i for i in found if _by_itself(i, clock, differences, factors)]
    if len(alone) > OUTLIERS.most * len(test):
        return none
    return np.array(alone, dtype=np.int64)


def said_of_strays(test: TimeTest) -> str:
    """Which samples stray and by how much, in words; nothing where none do."""
    rows = strays(test)
    if len(rows) == 0:
        return ""
    most = float(np.abs(_off(*_over_noise(test))[rows]).max())
    named = ", ".join(f"{t:.4g}" for t in test.time[rows[:TOLD]]) + (
        ", ..." if len(rows) > TOLD else ""
    )
    if len(rows) == 1:
        return f"{test.name}: the sample at {named} s is off by {most:.2g} x the noise: left out"
    return (
        f"{test.name}: {len(rows)} samples are each off by up to {most:.2g} x the noise: left out"
        f" at {named} s"
    )


def _over_noise(test: TimeTest) -> tuple[Real, Real]:
    """Fourth differences of a response over its noise, with their factors."""
    return fourth_differences(clock_of(test), test.response / noise_of(test).sd)


def _off(differences: Real, factors: Real) -> Real:
    """By how much each sample (n,) is off, by the five differences that hold it.

    At the ends, which fewer of them hold, nothing is said.
    """
    count = len(differences) + ORDER
    inside, places = np.arange(ORDER, count - ORDER), np.arange(ORDER + 1)
    # Sample i stands at place k of the five that begin at i - k.
    first = inside[:, None] - places
    pattern, seen = factors[first, places], differences[first]
    off = np.zeros(count)
    off[inside] = np.sum(pattern * seen, axis=1) / np.sum(pattern**2, axis=1)
    return off


def _beyond(off: Real) -> NDArray[np.bool_]:
    """Which of these numbers (n,) are larger than the largest of so many of noise.

    Of the noise around them, where that is larger than elsewhere.
    """
    from scipy.ndimage import median_filter
    from scipy.special import ndtri

    sizes = np.abs(off[ORDER : len(off) - ORDER])
    # Of the side that is noisier: where the noise grows at once there are no strays beyond.
    medians = np.pad(median_filter(sizes, AROUND, mode="nearest"), AROUND // 2, mode="edge")
    around = np.maximum(medians[: len(sizes)], medians[-len(sizes) :])
    around = np.maximum(around, np.median(sizes))
    most = -float(ndtri(0.5 * OUTLIERS.rare / len(off)))
    beyond = sizes > most * np.maximum(NORMAL * around, SMALLEST)
    return np.pad(beyond, ORDER)


def _by_itself(i: int, clock: Real, differences: Real, factors: Real) -> bool:
    """Whether a sample is off, and not the signal broken beside it: a corner, or a jump.

    Two corners at neighbouring samples are a corner between them, or a jump. What is off by itself
    leaves less than they do, though it has one number and they have two.
    """
    first = np.arange(i - ORDER, i + 1)
    held = first[:, None] + np.arange(ORDER + 1)

    def left(signals: Real) -> float:
        patterns = np.einsum("wj,swj->ws", factors[first], signals[:, held])
        size = np.linalg.lstsq(patterns, differences[first], rcond=None)[0]
        return float(np.sum((differences[first] - patterns @ size) ** 2))

    corners = np.maximum(clock - clock[i - 1 : i + 2, None], 0.0)
    one = (np.arange(len(clock)) == i).astype(float)
    return left(one[None]) < min(left(corners[:2]), left(corners[1:]))
