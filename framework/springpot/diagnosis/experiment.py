"""The next experiment: which of several feasible ones tells two explanations apart best.

`actions` lists what could be measured next: frequencies, amplitudes, temperatures and specimens
that a rig may have to spare. The two explanations are evaluated where the new points would lie, and
one is allowed to follow the other with all its parameters. Measurements are ranked with linear
slopes; those that would be named are fitted in earnest, since a rival far from its old parameters
can follow much better than its slopes tell. Where nothing is to be told apart, the `experiment_on`
functions say what would tell of single points, of a confounded condition or of what is unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from springpot.errors import SpringpotError
from springpot.identification.leastsquares import levenberg_marquardt, one_by_one
from springpot.identification.native import FittedModel
from springpot.measurement.independence import distinct_log_omega, moved_along, spread_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import sweeps_of
from springpot.measurement.units import Units
from springpot.misfit.error import plain
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.misfit.residuals_of_tests import SweepPart, TestPart
from springpot.rheology.intime import Traced
from springpot.rheology.model import Model
from springpot.rheology.nodes import Node
from springpot.rheology.parameters import INERTANCE, Coordinates
from springpot.rheology.points import KELVIN, Points, Real, complex_form, real_form
from springpot.thresholds import EXPERIMENT
from springpot.writing import NAMED

from ..numerics import ALIKE, PRINTED, SMALLEST, orthonormal, projected_out
from .grown import COLUMN, Untold
from .result import NextExperiment

TYPED_IN, WAITED_FOR, WORKED_FOR = 1.0, 1.5, 2.0
"""Effort of an amplitude, which is a number.

Of frequencies, a temperature or an empty rig, which take a while; of a
specimen that must be made, or of several repeats."""
ENOUGH = 3.0
"""Times the separation that settles the matter beyond which more is worth nothing."""
EVALUATIONS = 40
"""Evaluations of a fit of one explanation to the other."""
TRIED = 3
"""Actions that are fitted in earnest at most."""
MOST_TOLD = 1000.0
"""Standard deviations that are told at most.

So far from the data a model is a guess, and nobody doubts that it is
enough."""

Pair = tuple[float, float]
"""Of the first and of the second explanation."""


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
        The new conditions: ``omega`` in rad/s, ``temperature`` in degC, ``amplitude``, ``repeats``,
        of a specimen of another size ``specimen`` (its factor, zero without one) and ``mass`` in
        kg; of a test in time ``time`` in s, ``factor`` of what is imposed, ``faster`` of the whole
        history, ``release`` in s.
    """

    says: str
    part: TestPart
    effort: float
    action: dict[str, list[float]]


@dataclass(frozen=True, eq=False)
class Contest:
    """Two explanations after a measurement: one holds, the rival may change to follow it.

    Attributes
    ----------
    truth, rival : Refit or Identification
        The one that holds, and the other.
    parts : sequence of TestPart
        The tests that were made, and the new one.
    """

    truth: FittedModel
    rival: FittedModel
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

    @property
    def linear(self) -> float:
        """Standard deviations between the two where the rival follows as its slopes tell."""
        residual, slopes = self.seen(self.rival.theta)
        # A parameter without a slope here follows nothing; one without a value would spoil the
        # whole basis.
        usable = np.all(np.isfinite(slopes), axis=1) & (np.sum(slopes**2, axis=1) > 0)
        # A rival that overflows under the new conditions has no slopes to go by: it is worth no
        # trial.
        if not np.all(np.isfinite(residual)):
            return 0.0
        absorbed = orthonormal(slopes[usable].T)
        left = projected_out(residual, absorbed)
        return float(np.sqrt(left @ left))

    def fitted(self) -> float:
        """The same where the rival is fitted to old and new points together."""
        # What is no number to begin with promises nothing.
        if not np.all(np.isfinite(self.seen(self.rival.theta)[0])):
            return 0.0
        theta = self.rival.theta
        at = Coordinates.of(self.rival.model.parameters, 0.0, np.ones(1))
        # From where the rival is: so far away a parameter is as good as nothing, or as endless.
        size = np.where(at.log, np.maximum(theta, SMALLEST), 1.0)
        at = replace(at, size=size[None], pairs=())

        def seen(u: Real) -> tuple[Real, Real]:
            moved = at.theta(u, size)
            residual, slopes = self.seen(moved)
            return residual, -at.carry(np.nan_to_num(slopes), moved, size)

        # What changes no digit that is printed is not gone after.
        nearest = levenberg_marquardt(
            one_by_one(seen),
            at.u(theta.copy(), size)[None],
            *at.bounds,
            iterations=EVALUATIONS,
            flat=PRINTED,
        )
        return float(np.sqrt(nearest.cost[0]))


def _answer(fit: FittedModel, part: TestPart, theta: Real) -> Traced:
    try:
        with np.errstate(all="ignore"):
            return part.answer(fit.model, theta, fit.reference, part.thin)
    except SpringpotError:
        # Where a parameter has grown without limit there is no such model: it follows nothing.
        nothing = np.full(len(part.thin), np.nan)
        return Traced(nothing, np.zeros((len(nothing), len(theta))))


def most_telling(
    plans: Callable[[FittedModel], Iterable[Planned]],
    fits: tuple[FittedModel, FittedModel],
    parts: Sequence[TestPart],
    names: tuple[str, str],
    chances: Pair,
) -> NextExperiment:
    """The measurement that should best separate two explanations for its effort.

    Parameters
    ----------
    plans : callable
        From the one that holds to what can be done.
    fits : tuple of Refit or Identification
        The two explanations.
    parts : sequence of TestPart
        The tests that were made.
    names : tuple of str
        The effects that set them apart.
    chances : tuple of float
        Their probabilities: who holds decides what a measurement can show, as a larger model
        follows a smaller one.
    """
    # Of these two only: what a third would be is not what the measurement is asked.
    shares = (chances[0] / sum(chances), chances[1] / sum(chances))

    # Either may be right, and the one that is not may change all its parameters to follow.
    def worth(sigmas: Pair, planned: Planned) -> float:
        return _expected(shares, (_enough(sigmas[0]), _enough(sigmas[1]))) / planned.effort

    # Slopes first, as a fit for each action would take far longer; but a promise is made from a fit
    # only.
    first, second = fits
    contests = {
        one: (
            Contest(first, second, (*parts, one.part)),
            Contest(second, first, (*parts, other.part)),
        )
        for one, other in zip(plans(first), plans(second), strict=True)
    }
    feasible = {each: (one.linear, other.linear) for each, (one, other) in contests.items()}
    tried = sorted(feasible, key=lambda action: -worth(feasible[action], action))[:TRIED]
    reached = {each: (contests[each][0].fitted(), contests[each][1].fitted()) for each in tried}
    # By the better of the two ways: a larger model follows a smaller one wherever one measures.
    telling = [action for action in tried if max(reached[action]) >= EXPERIMENT.telling]
    if not telling:
        best = max(tried, key=lambda action: max(reached[action]))
        expected = separation(shares, reached[best])
        return NextExperiment(_no_use(best.says, names, expected), names, expected)
    best = max(telling, key=lambda action: worth(reached[action], action))
    expected = separation(shares, reached[best])
    return NextExperiment(
        f"{best.says}: {promise(names, shares, reached[best])}", names, expected, best.action
    )


def _no_use(says: str, names: tuple[str, str], sigma: float) -> str:
    """Where one explanation follows the other everywhere, nothing is to be bought by measuring."""
    size = "less than 0.1"
    if sigma > 0.1:
        size = plain(sigma, 2)
    return (
        f"no feasible measurement tells {names[0]} from {names[1]}: even the best ({says})"
        f" would separate them by {size} sigma"
    )


def _expected(shares: Pair, sigmas: Pair) -> float:
    return shares[0] * sigmas[0] + shares[1] * sigmas[1]


def _enough(sigma: float) -> float:
    """More than enough separation is worth no more."""
    return min(sigma, ENOUGH * EXPERIMENT.settled)


def separation(shares: Pair, sigmas: Pair) -> float:
    """The standard deviations that are promised.

    At least so many, or where it depends on who is right, the mean.
    """
    if _either_way(sigmas):
        return min(sigmas)
    return _expected(shares, sigmas)


def _either_way(sigmas: Pair) -> bool:
    """Whether the measurement tells the two apart whoever is right."""
    # Beyond what settles the matter a difference of the two is of no matter; below, up to two-fold
    # is about the same.
    return min(sigmas) >= EXPERIMENT.settled or 2.0 * min(sigmas) >= max(sigmas)


def promise(names: tuple[str, str], shares: Pair, sigmas: Pair) -> str:
    """What the measurement will show if the first or the second of two explanations holds."""
    less, more = sorted(range(2), key=lambda i: sigmas[i])
    apart = _sigmas(separation(shares, sigmas))
    if _either_way(sigmas):
        return f"it separates {names[0]} from {names[1]} by {apart}"
    verb = "speaks against"
    if sigmas[more] >= EXPERIMENT.settled:
        verb = "rules out"
    return (
        f"if {names[more]} is right it {verb} {names[less]} by {_sigmas(sigmas[more])}; "
        f"if not, {names[more]} stays possible; {apart} are to be expected"
    )


def _sigmas(number: float) -> str:
    """Standard deviations in words."""
    if number > MOST_TOLD:
        return f"more than {MOST_TOLD:.0f} sigma"
    return f"{plain(number, 2)} sigma"


def openness(chances: Mapping[str, float]) -> float:
    """Odds of the second likeliest answer against the likeliest."""
    most = sorted(chances.values())[-2:]
    if len(most) < 2 or most[1] <= 0.0:
        return 0.0
    return most[0] / most[1]


def worth_telling_apart(chances: Mapping[str, float]) -> list[tuple[str, str]]:
    """The likeliest with each of its rivals, where it is open which holds and both are believed in.

    Two each, not all rivals: a measurement that separates two can be promised in one sentence.
    """
    names = sorted(chances, key=lambda name: -chances[name])
    return [(names[0], name) for name in names[1:] if chances[name] >= EXPERIMENT.rival]


def first_telling(
    pairs: Iterable[tuple[str, str]],
    fits: Mapping[str, FittedModel],
    chances: Mapping[str, float],
    parts: Sequence[TestPart],
    plans: Callable[[FittedModel], Iterable[Planned]],
) -> NextExperiment | None:
    """The measurement for the first of these pairs of effects that any tells apart.

    Where none does, what the first pair promises; None without pairs.

    Parameters
    ----------
    pairs : iterable of (str, str)
        Effects, those first that are asked for first.
    fits, chances : mapping
        With each of them the fit, and how likely it is.
    parts, plans
        As for `most_telling`.
    """
    promised = None
    for pair in pairs:
        first, second = pair
        both = fits[first], fits[second]
        found = most_telling(plans, both, parts, pair, (chances[first], chances[second]))
        if found.action:
            return found
        promised = promised or found
    return promised


class ActionReach(NamedTuple):
    """What an action may ask of a rig."""

    farther: float
    """Factor by which the frequencies are extended: a decade is what a rig has to spare, if
    anything.
    """
    stronger: float
    """Factor by which amplitudes go beyond what was measured.

    Nonlinear effects go with a power of it, and show there.
    """
    points: int
    """Points of a new sweep."""
    denser: int
    """How many times as many frequencies, or repeats, an action takes as there were."""
    most: int
    """Points of a denser sweep at most."""
    kelvins: tuple[float, float]
    """Kelvin by which the range of temperatures is widened at least and at most."""
    coldest: float
    """Temperature in degC that liquid nitrogen reaches in a test chamber."""
    beside: tuple[float, float, float]
    """Factors of a frequency at which a point was bad.

    So near that no material changes, and off the line of a hum.
    """


ACTION = ActionReach(
    farther=10.0,
    stronger=3.0,
    points=20,
    denser=4,
    most=400,
    kelvins=(20.0, 40.0),
    coldest=-180.0,
    beside=(0.97, 1.0, 1.03),
)


@dataclass(frozen=True, eq=False)
class Action:
    """A measurement that could be made.

    Attributes
    ----------
    says : str
        What to do.
    points : Points
        Where the new points would lie.
    effort : float
        Relative cost, by which the expected separation is divided when actions are compared.
    scale : float
        Factor by which the specimen is larger; zero where it is taken out.
    repeats : int
        How often every new point is measured.
    mass : float
        Known mass in place of the specimen, in units of stiffness times s^2.
    action : dict of str to list of float
        The new conditions, see `Planned`.
    """

    says: str
    points: Points
    effort: float = 1.0
    scale: float = 1.0
    repeats: int = 1
    mass: float = 0.0
    action: dict[str, list[float]] = field(default_factory=dict)


def actions(measurement: Measurement) -> Iterator[Action]:
    """What could be measured next, the cheap things first."""
    again = "repeat the same measurement four times"
    # Always feasible; its effort lets any other win that tells as much.
    yield Action(
        again, measurement.points, WORKED_FOR, repeats=ACTION.denser, action={"repeats": [4.0]}
    )
    yield from _frequencies(measurement)
    yield from _amplitudes(measurement)
    yield from _temperatures(measurement)
    yield from _specimens(measurement)


def _sweep(says: str, measurement: Measurement, omega: Real, effort: float) -> Action:
    """A sweep of frequencies under the middle conditions of the data."""
    at = measurement.points
    middle = [
        None if c is None else np.full(len(omega), np.median(c))
        for c in (at.amplitude, at.temperature)
    ]
    # A model may have factors by any column: at its middle there is a level, or two to lie between.
    columns = {name: np.full(len(omega), np.median(column)) for name, column in at.columns.items()}
    points = Points(np.log(omega), middle[0], middle[1], at.reference_temperature, columns)
    return Action(says, points, effort, action={"omega": omega.tolist()})


def _usual(measurement: Measurement) -> Real:
    """Frequencies over the range of the data, in rad/s."""
    return np.geomspace(measurement.omega.min(), measurement.omega.max(), ACTION.points)


def _frequencies(measurement: Measurement) -> Iterator[Action]:
    omega, clock, distinct = (
        _usual(measurement),
        measurement.units,
        len(distinct_log_omega(measurement)),
    )
    hertz = omega / (2.0 * np.pi)
    if distinct == 1:
        new = np.geomspace(1.0 / ACTION.farther, ACTION.farther, ACTION.points) * omega[0]
        band = _range(1.0 / ACTION.farther * hertz[0], ACTION.farther * hertz[0], clock)
        yield _sweep(
            f"measure a sweep of frequencies: {ACTION.points} points {band}",
            measurement,
            new,
            WAITED_FOR,
        )
        return
    for factor, word in ((ACTION.farther, "up"), (1.0 / ACTION.farther, "down")):
        band = _range(hertz[0] * factor, hertz[-1] * factor, clock)
        says = f"extend the frequencies {word}wards: {ACTION.points} points {band}"
        yield _sweep(says, measurement, omega * factor, WAITED_FOR)
    count = min(ACTION.denser * distinct, ACTION.most)
    # Of so many points already, no denser sweep is on offer.
    if count <= distinct:
        return
    dense = np.geomspace(omega[0], omega[-1], count)
    says = (
        f"measure the same frequencies more densely: {count} points"
        f" {_range(hertz[0], hertz[-1], clock)}"
    )
    yield _sweep(says, measurement, dense, TYPED_IN + count / (ACTION.denser * ACTION.points))


def _amplitudes(measurement: Measurement) -> Iterator[Action]:
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is None:
        return
    unit = ""
    if measurement.units.amplitude != "-":
        unit = f" {measurement.units.amplitude}"
    for new in (ACTION.stronger * float(amplitude.max()), float(amplitude.min()) / ACTION.stronger):
        says = f"measure {ACTION.points} points at the amplitude {new:.3g}{unit}"
        swept = _sweep(says, measurement, _usual(measurement), TYPED_IN)
        points = replace(swept.points, amplitude=np.full(ACTION.points, new))
        yield replace(swept, points=points, action=swept.action | {"amplitude": [new]})


def _temperatures(measurement: Measurement) -> Iterator[Action]:
    temperature = measurement.conditions.get("temperature")
    if temperature is None:
        return
    step = float(np.clip(0.5 * np.ptp(temperature), *ACTION.kelvins))
    for new in (
        float(temperature.max()) + step,
        max(float(temperature.min()) - step, ACTION.coldest),
    ):
        swept = _sweep(
            f"measure {ACTION.points} points at {new:.3g} degC",
            measurement,
            _usual(measurement),
            WAITED_FOR,
        )
        points = replace(swept.points, temperature=np.full(ACTION.points, new + KELVIN))
        yield replace(swept, points=points, action=swept.action | {"temperature": [new]})


def _specimens(measurement: Measurement) -> Iterator[Action]:
    omega = _usual(measurement)
    says = f"measure a specimen of twice the area, in the same rig, at {ACTION.points} points"
    larger = _sweep(says, measurement, omega, WORKED_FOR)
    yield replace(larger, scale=2.0, action=larger.action | {"specimen": [2.0]})
    without = _sweep(
        f"measure the rig without a specimen, at {ACTION.points} points",
        measurement,
        omega,
        WAITED_FOR,
    )
    without = replace(without, scale=0.0, action=without.action | {"specimen": [0.0]})
    yield without
    factor, unit = measurement.units.of(INERTANCE)
    if unit != "kg":  # a mass cannot take the place of a modulus or of a torsional stiffness
        return
    # Heavy enough to be as stiff as the specimen at the highest frequency.
    mass = float(np.median(measurement.magnitude)) / float(omega[-1]) ** 2
    about = f"a known mass of about {factor * mass:.2g} kg"
    says = f"measure {about} in place of the specimen, at {ACTION.points} points"
    yield replace(without, says=says, mass=mass, action=without.action | {"mass": [factor * mass]})


def _range(low: float, high: float, units: Units) -> str:
    """Frequencies in Hz, as the data tell them."""
    return f"from {plain(units.on_clock(low))} to {plain(units.on_clock(high))} {units.clock}"


@dataclass(frozen=True, eq=False)
class PlannedSweep(SweepPart):
    """A sweep that could be made in the rig of one that was; nothing was measured in it.

    Parameters
    ----------
    action : Action
        Where its points lie, and what stands in the rig.
    """

    action: Action = field(kw_only=True)

    @property
    def points(self) -> Points:
        """Those of the action."""
        return self.action.points

    @property
    def measured(self) -> Real:
        """Nothing."""
        return np.zeros(2 * len(self.points.log_omega))

    def network_of(self, own: Model) -> Node:
        """With a specimen that may be larger, absent or a known mass."""
        if self.action.scale == 1.0:
            return own.network
        # No specimen is one of hardly any size, as a network cannot be empty.
        return own.resized(max(self.action.scale, ALIKE), self.action.mass)


def planned_sweep(action: Action, made: SweepPart, fit: FittedModel) -> PlannedSweep:
    """The sweep of an action, relative to a fit's |K| as noisy as the median of one that was made.

    Parameters
    ----------
    action : Action
        What would be measured.
    made : SweepPart
        What was measured, with its noise.
    fit : Refit or Identification
        A model that follows it.
    """
    plan = PlannedSweep(made.test, action=action)
    size, new = (np.abs(complex_form(_answer(fit, part, fit.theta).value)) for part in (made, plan))
    if action.scale == 0.0:
        # Without a specimen the force is small, and its noise is not.
        new = np.maximum(new, float(np.median(size)))
    # At worst the noise is a force of fixed size, and the more so at a smaller amplitude.
    usual, there, share = made.points.amplitude, action.points.amplitude, 1.0
    if usual is not None and there is not None:
        share = max(share, float(np.median(usual) / np.median(there)))
    # The mean of so many repeats is quieter by the root of their number.
    share /= float(np.sqrt(action.repeats))
    levels = [np.median(sd / size) for sd in made.sd.reshape(2, -1)]
    new = share * np.maximum(new, SMALLEST)
    return plan.with_sd(np.concatenate([level * new for level in levels]))


def planned_sweeps(made: SweepPart, fit: FittedModel) -> Iterator[Planned]:
    """What could be measured next in the rig of a sweep, as noisy as a fit has it."""
    for each in actions(made.test):
        yield Planned(each.says, planned_sweep(each, made, fit), each.effort, each.action)


def next_experiment(
    base: Refit,
    pairs: Iterable[tuple[str, str]],
    fits: Mapping[str, FittedModel],
    chances: Mapping[str, float],
) -> NextExperiment | None:
    """The action that should best separate two explanations of a sweep; see `first_telling`.

    Parameters
    ----------
    base : Refit
        Any fit to the sweep, which knows its noise.
    pairs, fits, chances
        As for `first_telling`.
    """
    made = SweepPart(base.fit.measurement, noise=real_form(base.noise.sd))
    return first_telling(pairs, fits, chances, (made,), partial(planned_sweeps, made))


def experiment_on_confounded(measurement: Measurement, names: Sequence[str]) -> NextExperiment:
    """What to measure where a condition moved with the frequency.

    The same frequencies with the condition held.

    Parameters
    ----------
    measurement : Measurement
        The data in which it moved.
    names : sequence of str
        Effects of that condition which would explain the data.
    """
    moved, *_ = sorted(moved_along(measurement))
    middle = float(np.median(measurement.conditions[moved]))
    omega = np.exp(distinct_log_omega(measurement))[: ACTION.most]
    says = (
        f"measure the same frequencies at one {moved}, and again at another: only then can an"
        f" effect of it ({', '.join(names[:NAMED])}) be told from one of the frequency"
    )
    return NextExperiment(says, (), None, {"omega": omega.tolist(), moved: [middle]})


def experiment_on_points(outliers: Sequence[Outlier]) -> NextExperiment:
    """What to measure where nothing but single points is wrong.

    Parameters
    ----------
    outliers : sequence of Outlier
        The points that were set aside.
    """
    places = " and ".join(outlier.at for outlier in outliers[:NAMED])
    says = (
        f"measure again at {places}, and close beside: a bad point does not come back, an"
        " interference or a resonance does"
    )
    omega = [
        2.0 * np.pi * outlier.frequency * factor for outlier in outliers for factor in ACTION.beside
    ]
    return NextExperiment(says, (), None, {"omega": omega})


def experiment_on_untold(untold: Untold, measurement: Measurement) -> NextExperiment:
    """What tells an effect from those of an amplitude that no column tells.

    Parameters
    ----------
    untold : Untold
        The effect, and the others.
    measurement : Measurement
        The data.
    """
    says = (
        f"measure the same points at another {COLUMN} too, and write both in a column {COLUMN}:"
        f" {untold.effect} stays as it is, {' or '.join(untold.others)} changes with it"
    )
    return NextExperiment(says, (), None, {"omega": measurement.omega[: ACTION.most].tolist()})


def experiment_on_unknown(measurement: Measurement) -> NextExperiment:
    """What to measure where something is missing that no effect explains.

    Whether it is there again, and with what.

    Parameters
    ----------
    measurement : Measurement
        The data as measured, with their repeats.
    """
    longest = max(sweeps_of(measurement), key=lambda sweep: len(sweep.rows))
    # As they stand in the file, which is the order in which they were measured.
    omega = measurement.omega[np.sort(longest.rows)][: ACTION.most]
    again: dict[str, list[float]] = {"omega": omega[::-1].tolist()}
    # The cheapest question first: nothing else is worth asking of what is gone the next time.
    if measurement.repeat is None:
        says = (
            "measure the same points again in the opposite order: what comes back is the specimen's"
            " or the rig's, what does not is drift or ageing"
        )
        return NextExperiment(says, (), None, again)
    amplitude = spread_of(measurement, "amplitude")
    if amplitude is not None and not amplitude.varied:
        half = 0.5 * float(np.median(measurement.conditions["amplitude"]))
        says = (
            "measure the same points at half the amplitude:"
            " what then changes is no linear material's"
        )
        return NextExperiment(says, (), None, {"omega": omega.tolist(), "amplitude": [half]})
    says = (
        "measure something known in place of the specimen, such as a steel spring or a standard"
        " fluid: what it shows too is the rig's"
    )
    return NextExperiment(says, (), None)
