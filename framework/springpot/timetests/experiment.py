"""The next experiment where tests in time do not tell two effects apart."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from springpot.diagnosis.contest import (
    TYPED_IN,
    WAITED_FOR,
    WORKED_FOR,
    Contest,
    most_telling,
    worth_telling_apart,
)
from springpot.diagnosis.experiment import FARTHER, POINTS, STRONGER
from springpot.diagnosis.result import Candidate, NextExperiment
from springpot.errors import ModelError
from springpot.identification.result import Identification
from springpot.measurement.imposed import Loading
from springpot.measurement.measurement import Measurement
from springpot.misfit.error import plain
from springpot.rheology.intime import Traced
from springpot.rheology.points import KELVIN, Real
from springpot.thresholds import EXPERIMENT

from ..numerics import SMALLEST
from .residuals_of_tests import InTimePart, SweepPart, TestPart, reach_of, units_of
from .verdict import TimeCase
from .where import rms

SAMPLES = 200
"""Of a planned record, which moves all the time."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A test that could be made, with the noise that is to be expected of it.

    Attributes
    ----------
    says : str
        What to do.
    part : TestPart
        The test; nothing was measured in it.
    effort : float
        Relative cost, by which the expected separation is divided when tests are compared.
    action : dict of str to list of float
        The new conditions: ``omega`` in rad/s, ``time`` in s, ``factor`` of what is imposed,
        ``faster`` of the whole history, ``release`` in s, ``repeats``.
    """

    says: str
    part: TestPart
    effort: float
    action: dict[str, list[float]] = field(default_factory=dict)


def next_test(case: TimeCase, parts: Sequence[TestPart]) -> NextExperiment | None:
    """The test that would tell the two leading effects of a diagnosis apart.

    None where it is plain which of them it is, or that nothing is missing.
    """
    if case.diagnosis.verdict == "adequate":
        return None
    fits = {each.effect.name: each.fit for each in case.tried if each.fit is not None}
    chances = {
        each.effect: each.probability for each in case.diagnosis.candidates if each.effect in fits
    }
    pair = worth_telling_apart(chances) or _of_one_class(case.diagnosis.candidates, fits)
    if pair is None:
        return None
    first, second = (fits[name] for name in pair)

    def contest(planned: Planned, holds: int) -> AfterTest:
        both = (first, second)
        return AfterTest(both[holds], both[1 - holds], (*parts, planned.part))

    plans = list(planned_tests(parts, first))
    return most_telling(plans, contest, pair, (chances[pair[0]], chances[pair[1]]))


def _of_one_class(candidates: Sequence[Candidate], fits: Collection[str]) -> tuple[str, str] | None:
    """The first two that these tests do not tell apart, however unlike their chances.

    None where something else is believed in.
    """
    believed = [each for each in candidates[:1] if each.probability > EXPERIMENT.rival]
    alike = [name for each in believed for name in each.alike if name in fits]
    return (alike[0], alike[1]) if len(alike) > 1 else None


@dataclass(frozen=True, eq=False)
class AfterTest(Contest):
    """Two fits after a further test: one holds, the rival may change to follow it.

    Attributes
    ----------
    truth, rival : Identification
        The one that holds, and the other.
    parts : sequence of TestPart
        The tests that were made, and the new one.
    """

    truth: Identification
    rival: Identification
    parts: Sequence[TestPart]

    @cached_property
    def _shown(self) -> list[Real]:
        return [_answer(self.truth, part, self.truth.theta).value for part in self.parts]

    def seen(self, theta: Real) -> tuple[Real, Real]:
        """Whitened difference (m,) of truth and rival, and the rival's slopes (p, m)."""
        differences, slopes = [], []
        for part, shown in zip(self.parts, self._shown, strict=True):
            answer = _answer(self.rival, part, theta)
            # Those that a search begins with stand for all samples of a test.
            stand_for = np.sqrt(part.count() / part.count(coarse=True)) / part.scale
            weight = np.where(part.counted, stand_for / part.sd, 0.0)[part.thin]
            with np.errstate(invalid="ignore", over="ignore"):
                differences.append((shown - answer.value) * weight)
                slopes.append(answer.by_theta * weight[:, None])
        return np.concatenate(differences), np.concatenate(slopes).T


def _answer(fit: Identification, part: TestPart, theta: Real) -> Traced:
    try:
        with np.errstate(all="ignore"):
            return part.answer(fit.model, theta, fit.reference, part.thin)
    except ModelError:
        # Where a parameter has grown without limit there is no such model: it follows nothing.
        nothing = np.full(len(part.thin), np.nan)
        return Traced(nothing, np.zeros((len(nothing), len(theta))))


def planned_tests(parts: Sequence[TestPart], fit: Identification) -> Iterator[Planned]:
    """What could be measured next of a specimen, the cheap things first.

    Parameters
    ----------
    parts : sequence of TestPart
        The tests that were made.
    fit : Identification
        A model that follows them, which says how large K is.
    """
    # Of many tests of one kind the first stands for all.
    first = next((part for part in parts if isinstance(part, InTimePart)), None)
    if first is not None:
        # The mean of four is half as noisy.
        quieter = replace(first, noise=0.5 * first.sd)
        again = f"repeat {first.test.name} four times"
        yield Planned(again, quieter, WORKED_FOR, {"repeats": [4.0]})
        yield from _changed(first)
    yield from _sweeps(parts, fit)


def _changed(part: InTimePart) -> Iterator[Planned]:
    """The same kind of test, longer, sooner, larger, smaller, faster, slower or let go."""
    test = part.test
    moved = "step" if test.after_step else "motion"
    for factor, word in ((STRONGER, "three times"), (1.0 / STRONGER, "a third of")):
        says = f"impose {word} the {moved} of {test.name}"
        larger = _with(part, test.time, test.loading.scaled(factor))
        yield Planned(says, larger, TYPED_IN, {"factor": [factor]})
    if test.after_step:
        yield from _of_step(part)
        return
    for factor, word in ((FARTHER, "ten times as fast"), (1.0 / FARTHER, "ten times as slowly")):
        loading = Loading(test.loading.time / factor, test.loading.value)
        faster = _with(part, test.time / factor, loading)
        yield Planned(
            f"run the {moved} of {test.name} {word}", faster, TYPED_IN, {"faster": [factor]}
        )


def _of_step(part: InTimePart) -> Iterator[Planned]:
    test = part.test
    clock = test.time - test.start
    first, last = float(np.min(clock[clock > 0.0])), float(clock[-1])
    later = test.start + np.geomspace(last, FARTHER * last, POINTS)
    says = f"go on with {test.name} to {plain(FARTHER * last)} s: {POINTS} samples"
    yield Planned(says, _with(part, later, test.loading), WAITED_FOR, {"time": later.tolist()})
    sooner = test.start + np.geomspace(first / FARTHER, first, POINTS)
    says = f"read {test.name} sooner, from {plain(first / FARTHER)} s on: {POINTS} samples"
    yield Planned(says, _with(part, sooner, test.loading), WAITED_FOR, {"time": sooner.tolist()})
    end = float(test.time[-1])
    loading, back = test.loading, float(test.loading.value[0])
    let_go = Loading(
        np.concatenate([loading.time[loading.time < end], [end, end]]),
        np.concatenate([loading.value[loading.time < end], [loading.value[-1], back]]),
    )
    times = end + np.geomspace(first, last, POINTS)
    says = f"let {test.name} go at {plain(end)} s and record as long again: {POINTS} samples"
    yield Planned(says, _with(part, times, let_go), WAITED_FOR, {"release": [end]})


def _with(part: InTimePart, time: Real, loading: Loading) -> InTimePart:
    """A planned test beside one that was made, as noisy as its middle sample."""
    rows = np.unique(np.linspace(0, len(time) - 1, min(len(time), SAMPLES)).astype(int))
    test = replace(
        part.test,
        time=time[rows],
        response=np.zeros(len(rows)),
        loading=loading,
        warmth=None,
        measured=False,
    )
    return InTimePart(test, noise=np.full(len(rows), float(np.median(part.sd))))


def _sweeps(parts: Sequence[TestPart], fit: Identification) -> Iterator[Planned]:
    """Frequencies beyond those of the sweeps, or a sweep where there is none."""
    known = [part.test for part in parts if isinstance(part, SweepPart)]
    if known:
        low, high = (known[0].omega.min(), known[0].omega.max())
        bands = [(FARTHER, "extend the sweep upwards"), (1.0 / FARTHER, "extend it downwards")]
    else:
        seen = [part.resolved for part in parts]
        low, high = min(each[0] for each in seen), max(each[1] for each in seen)
        bands = [(1.0, "measure a sweep of the same specimen")]
    for factor, word in bands:
        omega = np.geomspace(low, high, POINTS) * factor
        hertz = omega / (2.0 * np.pi)
        says = f"{word}: {POINTS} points from {plain(hertz[0])} to {plain(hertz[-1])} Hz"
        part = _sweep(parts, fit, omega)
        yield Planned(says, part, WAITED_FOR, {"omega": omega.tolist()})


def _sweep(parts: Sequence[TestPart], fit: Identification, omega: Real) -> SweepPart:
    """A sweep under the conditions of the tests, as noisy for its size as they are."""
    amplitude = np.full(len(omega), reach_of(parts))
    conditions: Mapping[str, Real] = {"amplitude": amplitude}
    for name in fit.model.own.values():
        # Of specimens with parameters of their own the first stands for all.
        conditions = {**conditions, name: np.full(len(omega), parts[0].test.conditions[name][0])}
    if any("temperature" in part.conditions for part in parts):
        conditions = {**conditions, "temperature": np.full(len(omega), fit.reference - KELVIN)}
    units = units_of([part.test for part in parts])
    plan = Measurement(
        omega, np.ones(len(omega), dtype=np.complex128), conditions=conditions, units=units
    )
    size = np.abs(fit.model.stiffness(fit.theta, replace(plan, reference=fit.reference).points))
    share = float(np.median([rms(part.sd) / max(rms(part.measured), SMALLEST) for part in parts]))
    return SweepPart(plan).with_sd(share * np.tile(size, 2))
