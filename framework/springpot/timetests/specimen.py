"""What the tests of one specimen have in common, and what one of them has by itself.

Effects of all, of the sweeps or of one; where in the parameters of an effect to look.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from springpot.errors import DataError
from springpot.identification.leastsquares import REACH
from springpot.identification.space import require_columns, require_effects
from springpot.measurement.conversion import FILE, file_of, refuse_copies
from springpot.measurement.measurement import Measurement, points_at
from springpot.measurement.opening import Test, sweep_of
from springpot.measurement.timetest import TimeTest
from springpot.misfit.residuals_of_tests import (
    Residual,
    TestPart,
    part_of,
    reach_of,
    typical_stiffness,
)
from springpot.rheology.effect import ALL, SWEEPS, Effect, Layer, StageLaw
from springpot.rheology.model import Model
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import KELVIN, ROOM, Real

RIGS = (ALL, SWEEPS)


def at_rig(effect: Effect, tests: Sequence[Test]) -> Effect:
    """An effect as tests of one specimen can have it.

    What a measuring chain does to its signals is a fault of one rig. Where sweeps stand beside
    tests in time it is that of the sweeps: a step has no phase that a delay could turn.
    """
    if effect.layer is not Layer.SIGNAL or not _is_rig(effect):
        return effect
    if any(isinstance(test, Measurement) for test in tests):
        return effect.at(SWEEPS)
    return effect.at(ALL)


def at_tests(effect: Effect, tests: Sequence[Test]) -> list[Effect]:
    """The forms in which tests of a specimen have an effect.

    All of them, all sweeps, or one test alone.
    """
    if effect.applies_to.one:
        # One test by itself has nothing to be told from.
        names = dict.fromkeys(test.name for test in tests if isinstance(test, TimeTest))
        return [effect.of_one(name) for name in names if len(tests) > 1]
    if len(tests) == 1 and not effect.applies_to.alone(tests[0]):
        return []
    there = at_rig(effect, tests)
    if isinstance(effect.element, StageLaw):
        # What was done in one test, such as a slow step, was not done in the others.
        shown = dict.fromkeys(test.name for test in tests if there.applies_to(test))
        return [there, *(there.of_one(name) for name in shown if len(shown) > 1)]
    if not _is_rig(there) or len(tests) == 1:
        return [there]
    forms, sweeps = [there], [test for test in tests if isinstance(test, Measurement)]
    if there.in_time and sweeps:
        forms.append(there.at(SWEEPS))
    # One rig alone may have it; one sweep is all sweeps.
    apart = [test for test in tests if there.applies_to(test) and [test] != sweeps]
    if getattr(effect.element, "kind", "") == "gain":
        # That of one test in time is told of its record: twice, each would halve the other's odds.
        apart = [test for test in apart if isinstance(test, Measurement)]
    return forms + [there.of_one(name) for name in dict.fromkeys(test.name for test in apart)]


def at_rigs(model: Model, tests: Sequence[Test]) -> Model:
    """A model of tests of one specimen, each of its effects where `at_rig` puts it.

    With a parameter for each level of the tests, where levels have their own.
    """
    model = _with_effects(model, [at_rig(effect, tests) for effect in model.effects])
    if not model.own:
        return model
    columns = [
        {name: np.unique(test.conditions[name]) for name in model.own.values()} for test in tests
    ]
    every = {name: np.concatenate([each[name] for each in columns]) for name in columns[0]}
    size = len(next(iter(every.values())))
    return model.bound_to(points_at(np.zeros(size), every, reference_of(tests)))


def words_of(model: Model, tests: Sequence[Test]) -> dict[str, list[str]]:
    """What levels that are numbered are called, in their order: those of files by their names."""
    if FILE not in model.own.values():
        return {}
    return {FILE: list(dict.fromkeys(file_of(test.name) for test in tests))}


def as_had_by(model: Model, tests: Sequence[Test]) -> Model:
    """A model as these tests can have it.

    Of a sweep alone with a parameter for each level of a column, else with each effect at its rig.
    """
    sweep = sweep_of(tests)
    if sweep is not None:
        return model.bound_to(sweep.points)
    return at_rigs(model, tests)


def answered(model: Model, theta: Real, tests: Sequence[Test]) -> tuple[Test, ...]:
    """The tests of a specimen as a model says them, without noise.

    Parameters
    ----------
    model : Model
        As `as_had_by` gives it.
    theta : ndarray, shape (p,)
        Its parameters.
    tests : sequence of Test
        What was imposed, and when it is read.

    Raises
    ------
    DataError
        If one is of a further kind, whose numbers are no answer to a loading.
    """
    sweep, reference = sweep_of(tests), reference_of(tests)
    if sweep is not None:
        return (replace(sweep, stiffness=model.stiffness(theta, sweep.points)),)
    return tuple(_answered(model, theta, test, reference) for test in tests)


def _answered(model: Model, theta: Real, test: Test, reference: float) -> Test:
    part = part_of(test)
    value = part.answer(model, theta, reference, np.arange(len(part.measured))).value
    if isinstance(test, Measurement):
        return replace(test, stiffness=value[: len(test)] + 1j * value[len(test) :])
    if isinstance(test, TimeTest):
        return replace(test, response=value)
    raise DataError(f"{test.name}: a test of the kind '{test.kind}' cannot be computed")


def rig_of_sweeps(model: Model, tests: Sequence[Test]) -> Model | None:
    """The model where sweeps were made on a rig of their own; None where that changes nothing."""
    if not any(isinstance(test, Measurement) for test in tests):
        return None
    apart = [each.at(SWEEPS) if _is_rig(each) else each for each in model.effects]
    if tuple(apart) == model.effects:
        return None
    return _with_effects(model, apart)


def _is_rig(effect: Effect) -> bool:
    """Whether an effect joins the specimen from outside, and nobody said of which tests."""
    return Layer.SPECIMEN < effect.layer < Layer.TEST and effect.applies_to in RIGS


def _with_effects(model: Model, effects: Sequence[Effect]) -> Model:
    """The model with other effects; itself where they are its own."""
    if tuple(effects) == model.effects:
        return model
    return replace(model, effects=tuple(effects))


def reference_of(tests: Sequence[Test]) -> float:
    """Temperature in kelvin at which shifts are one.

    The measured one nearest to the median of all tests.
    """
    known = []
    for test in tests:
        if isinstance(test, TimeTest):
            if test.temperature is not None:
                known.append(test.temperature + KELVIN)
        elif "temperature" in test.conditions:
            known.append(test.reference_temperature)
    if not known:
        return ROOM
    return float(np.sort(known)[(len(known) - 1) // 2])


def residual_of(
    parts: Sequence[TestPart], model: Model, theta: Real, reference: float, coarse: bool = False
) -> Residual:
    """The residuals of all tests of a specimen one after the other; see `TestPart.residual`."""
    each = [part.residual(model, theta, reference, coarse) for part in parts]
    return Residual(*map(np.concatenate, zip(*each, strict=True)))


def require_its_conditions(model: Model, test: Test) -> None:
    """Check that a test has each condition that a model needs.

    Raises
    ------
    SpringpotError
        If one lacks.
    """
    if isinstance(test, Measurement):
        require_columns(model.had_by(test)[0], test)
    elif "temperature" in model.needs and test.temperature is None:
        raise DataError(
            f"{test.name}: {model.name} needs a temperature: open it as"
            f" '{test.provenance.get('file', test.name)}?temperature=25[degC]'"
        )


def require_tests(model: Model, tests: Sequence[Test]) -> None:
    """Check that a model has what it needs of every test.

    Raises
    ------
    SpringpotError
        If a condition lacks, there are fewer numbers than parameters, or two tests hold the same.
    """
    require_effects(model, tests)
    refuse_copies(tests)
    for test in tests:
        require_its_conditions(model, test)
    numbers = sum(part_of(test).count() for test in tests)
    if numbers < len(model.parameters):
        raise DataError(
            f"{tests[0].name}: {model.name} has {len(model.parameters)} parameters but there are"
            f" only {numbers} samples; choose a simpler model"
        )


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
    def of(cls, parts: Sequence[TestPart]) -> Scales:
        """Those of tests in common units."""
        slow, fast = zip(*(part.test.seen for part in parts), strict=True)
        return cls(typical_stiffness(parts), reach_of(parts), 1.0 / max(fast), 1.0 / min(slow))

    def typical(self, parameter: Parameter) -> float:
        """The natural size of a parameter here."""
        # Times go by factors: their middle is that of the logarithms.
        middle = float(np.sqrt(self.shortest * self.longest))
        # A power of s that another parameter tells is not known here.
        size = parameter.unit.size(self.stiffness, middle, self.reach, 0.0)
        return float(np.clip(parameter.typical * size, parameter.lower, parameter.upper))

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


def tries_of(effect: Effect, test: TimeTest, scales: Scales) -> list[tuple[float, ...]]:
    """Places in the parameters of an effect of time tests from which to look further."""
    law, free = effect.element, effect.element.parameters
    if isinstance(law, StageLaw) and law.tries is not None:
        return [tuple(map(float, place)) for place in law.tries(test)][:MOST]
    return list(product(*(scales.values(parameter) for parameter in free)))[:MOST]


def stepped(model: Model, theta: Real, step: Real) -> Real:
    """Parameters (p,) of a model after a linear step (p,), within their bounds."""
    moved = []
    for parameter, value, change in zip(model.parameters, theta, step, strict=True):
        # What has one sign moves by a factor: a long step cannot take it through nothing.
        if parameter.scale == "log" and value > 0.0:
            moved.append(value * float(np.exp(np.clip(change / value, -REACH, REACH))))
        else:
            moved.append(float(np.clip(value + change, parameter.lower, parameter.upper)))
    return np.array(moved)
