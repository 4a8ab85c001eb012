"""Where in the parameters of an effect to look.

Values that the units suggest, for sizes and times of the tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from springpot.measurement.timetest import TimeTest
from springpot.rheology.effect import Effect
from springpot.rheology.parameters import Parameter
from springpot.rheology.stages import StageLaw

from .residuals_of_tests import InTimePart, Part

TIMES = 7
"""Times tried between the shortest and the longest.

Nearer than a decade, for an exponential is a decade wide.
"""
SHARES = (0.03, 0.1, 0.3, 0.6, 0.9)
"""Of the largest displacement or force, where a threshold may lie."""
INSIDE = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Of the range of a parameter that has two ends, such as an order."""
MOST = 40
"""Places tried of one effect; more would cost more than a fit from a poor one."""


@dataclass(frozen=True)
class Scales:
    """Sizes of the tests of a specimen.

    Attributes
    ----------
    stiffness, reach : float
        Typical |K|, and the largest displacement.
    shortest, longest : float
        Times in s that the tests tell about.
    """

    stiffness: float
    reach: float
    shortest: float
    longest: float

    @classmethod
    def of(cls, parts: Sequence[Part]) -> Scales:
        """Those of tests in common units."""
        sizes, reaches, times = [], [], []
        for part in parts:
            if isinstance(part, InTimePart):
                stiffness, reach = _sizes(part.test)
                slow, fast = part.test.seen
            else:
                stiffness = float(np.exp(np.mean(np.log(part.test.magnitude))))
                reach = float(np.max(part.test.conditions.get("amplitude", np.ones(1))))
                slow, fast = float(part.test.omega.min()), float(part.test.omega.max())
            sizes.append(stiffness)
            reaches.append(reach)
            times += [1.0 / fast, 1.0 / slow]
        return cls(float(np.exp(np.mean(np.log(sizes)))), max(reaches), min(times), max(times))

    def typical(self, parameter: Parameter) -> float:
        """The natural size of a parameter here."""
        unit = parameter.unit
        # A power of s that another parameter tells is not known here.
        time = 0.0
        if not isinstance(unit.time, str):
            time = float(unit.time)
        # Times go by factors: their middle is that of the logarithms.
        middle = float(np.sqrt(self.shortest * self.longest))
        size = (
            parameter.typical
            * self.stiffness**unit.stiffness
            * self.reach**unit.amplitude
            * middle**time
        )
        return float(np.clip(size, parameter.lower, parameter.upper))

    def values(self, parameter: Parameter) -> list[float]:
        """Values worth trying."""
        unit, width = parameter.unit, parameter.upper - parameter.lower
        if parameter.scale == "linear" and np.isfinite(width):
            return [parameter.lower + share * width for share in INSIDE]
        sized = (unit.stiffness, unit.amplitude)
        if sized == (0, 0) and unit.time in (1, -1):
            return [
                float(t) ** int(unit.time) for t in np.geomspace(self.shortest, self.longest, TIMES)
            ]
        if sized in ((0, 1), (1, 1)) and unit.time == 0:
            largest = self.reach
            # A threshold of force: what the specimen answers to its largest displacement.
            if unit.stiffness:
                largest = self.reach * self.stiffness
            return [share * largest for share in SHARES]
        return [self.typical(parameter)]


def _sizes(test: TimeTest) -> tuple[float, float]:
    imposed, answer = np.abs(test.loading.value).max(), np.abs(test.response)
    if test.control == "displacement":
        return max(float(np.median(answer) / imposed), 1e-300), float(imposed)
    reach = max(float(answer.max()), 1e-300)
    return max(float(imposed) / reach, 1e-300), reach


def tries_of(effect: Effect, test: TimeTest, scales: Scales) -> list[tuple[float, ...]]:
    """Places in the parameters of an effect of time tests from which to look further."""
    law, free = effect.element, effect.element.parameters
    if isinstance(law, StageLaw) and law.tries is not None:
        return [tuple(map(float, place)) for place in law.tries(test)][:MOST]
    return list(product(*(scales.values(parameter) for parameter in free)))[:MOST]
