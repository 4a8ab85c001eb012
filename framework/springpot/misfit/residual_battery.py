"""Is anything left? One battery of tests on the residual of a fit, which needs no list of effects.

Each test looks for another kind of structure (slow curves, neighbours that are alike, ripples,
single points, too much scatter). Its statistic becomes a chance by simulated noise that has lost
what the parameters follow, and the smallest of these chances is itself judged against its own
distribution in the same simulation: looking in several ways costs no false alarm. `diagnose` and
`compare` ask this battery and no other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from springpot.plain_data import jsonable, number
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from .frame import DRAWN, DRAWS, FURTHER, Frame, near_an_alarm
from .outliers import outlying
from .residual_tests import TESTS, points_in_words
from .shapes import Drawn


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
    frame : Frame, optional
        The fit; without it there are no sentences.
    points : tuple of int
        Rows that stand out by themselves, by the rule of `outliers`.
    """

    p_value: float
    parts: dict[str, float]
    frame: Frame | None = None
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


def battery(frame: Frame, rng: np.random.Generator) -> Battery:
    """Test the residual of a fit for structure of any kind.

    Parameters
    ----------
    frame : Frame
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


def _statistics(frame: Frame, sample: Drawn) -> dict[str, Real]:
    values = {test.name: test.statistic(frame, sample) for test in TESTS}
    return {name: value for name, value in values.items() if value is not None}


def judged(statistics: dict[str, Real], frame: Frame | None = None) -> Battery:
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
