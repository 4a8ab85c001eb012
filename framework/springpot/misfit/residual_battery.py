"""Is anything left? One battery of tests on the residual of a fit, which needs no list of effects.

Each test looks for another kind of structure (slow curves, neighbours that are alike, ripples,
single points, too much scatter). Its statistic becomes a chance by simulated noise that has lost
what the parameters follow, and the smallest of these chances is itself judged against its own
distribution in the same simulation: looking in several ways costs no false alarm. `diagnose` and
`compare` ask this battery and no other.

Whether repeats differ by chance alone, and what sets them apart where they do not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from springpot.measurement.mixed_tests import sweeps_of
from springpot.measurement.replicates import Averaged
from springpot.plain_data import jsonable, number
from springpot.rheology.points import Real
from springpot.thresholds import REPEATS, VERDICT

from .frame import (
    DRAWN,
    DRAWS,
    FURTHER,
    Drawn,
    NoiseFrame,
    drift_curves,
    near_an_alarm,
    orthonormal,
)
from .outliers import outlying
from .residual_tests import TESTS, kinship, points_in_words


@dataclass(frozen=True)
class Finding:
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

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return dict(jsonable(vars(self)))

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Finding:
        """What `to_dict` gave."""
        statistic, chance = number(row["statistic"]), number(row["p_value"])
        return cls(row["test"], statistic, chance, row["found"], row["says"])


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
    if np.sum(data.scatter.dof) < REPEATS.enough:
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
