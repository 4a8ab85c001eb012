"""A test as a sum of exponentials with weights >= 0, a convex problem with one solution.

After a step of displacement, and under any history of it, the force is linear in the weights of
relaxation; under a force the displacement is linear in those of retardation, J_g + t/eta + sum of
L_j (1 - exp(-t/tau_j)). Either tells the other: the poles of K are the zeros of 1/K, one between
each two of its own poles (N. W. Tschoegl, 1989, doi:10.1007/978-3-642-73602-5).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt
from typing import TypeAlias

import numpy as np

from springpot.errors import SpringpotError
from springpot.measurement.imposed import Loading, noise_of_transducer
from springpot.measurement.instrument import is_even
from springpot.measurement.measurement import Measurement
from springpot.measurement.replicates import thinned
from springpot.measurement.timetest import TimeTest
from springpot.numerics import DECADE, ENOUGH, PER_DECADE, SMALLEST, evenly, non_negative
from springpot.rheology.effect import ALL, Effect, Layer
from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.motion import acceleration, velocity
from springpot.rheology.points import Complex, Real, real_form
from springpot.rheology.rational import Rational
from springpot.rheology.spectrum import REFUSED
from springpot.rheology.terms import Modes, driven

from .material import CLOSER, REFINEMENTS, SpectrumSearch, is_material
from .material_fit import KEPT
from .native import fit
from .problem import relative_objective

SLOWER, FASTER = 1.0, 0.5
"""Decades beyond the times of the tests.

What relaxes more slowly is a spring there, and of what is gone before the
first sample, but for a few per cent, any amount could have been."""
SPACINGS = tuple(CLOSER**k for k in range(1, REFINEMENTS + 1))
"""Spacings, over that of the first lattice, at which lines are looked for about those that carry.
"""
APART = 0.2
"""Least distance of lines in ln tau.

The exact response tells those apart that differ by more than a twentieth.
"""


def shown_by(rates: Real, omega: Real) -> Complex:
    """What spring, dashpot and lines of these rates are at angular frequencies (2 + m, n)."""
    return Continuum(tuple(rates.tolist())).basis(np.log(omega), False)[0]


@dataclass(frozen=True, eq=False)
class ConvexSpectrum:
    """K = K_e + c s + sum of weight s / (s + rate), none of them negative."""

    equilibrium: float
    viscosity: float
    rates: Real
    weights: Real

    @classmethod
    def of(cls, amounts: Real, rates: Real) -> ConvexSpectrum:
        """By amounts (2 + m,) of spring, dashpot and lines of these rates (m,) in 1/s."""
        return cls(float(amounts[0]), float(amounts[1]), rates, np.asarray(amounts[2:]))

    @property
    def amounts(self) -> Real:
        """K_e, c and the weights (2 + m,)."""
        return np.concatenate([[self.equilibrium, self.viscosity], self.weights])

    def stiffness(self, omega: Real) -> Complex:
        """K (n,) at angular frequencies in rad/s."""
        return np.asarray(self.amounts @ shown_by(self.rates, omega))

    def among(self, others: Real) -> tuple[Real, Real]:
        """Rates (m,) of these lines and of others apart from them, and all weights (2 + m,)."""
        far = [rate for rate in others if np.all(np.abs(np.log(self.rates / rate)) > APART)]
        rates = np.concatenate([self.rates, far])
        weights = np.concatenate([self.weights, np.zeros(len(far))])
        order = np.argsort(rates)
        return rates[order], np.concatenate([[self.equilibrium, self.viscosity], weights[order]])

    def beside(self, others: Sequence[ConvexSpectrum]) -> ConvexSpectrum:
        """The same with lines of no weight where others have theirs."""
        found = self
        for other in others:
            rates, weights = found.among(other.rates)
            found = replace(found, rates=rates, weights=weights[2:])
        return found


Columns: TypeAlias = Callable[[Real], tuple[Real, Real]]
"""Of times (m,) what spring, dashpot and exponentials do to a test (n, 2 + m), and the test (n,).

In standard deviations.
"""


def nearest_lines(columns: Columns, seen: tuple[float, float]) -> ConvexSpectrum:
    """The sum of exponentials with weights >= 0 that is nearest to a test.

    Parameters
    ----------
    columns : callable
        What each of them does to the test.
    seen : tuple of float
        Angular frequencies in rad/s between which it tells something.
    """
    low, high = seen
    step = DECADE / PER_DECADE
    ends = -np.log(high * 10.0**FASTER), -np.log(low * 10.0**-SLOWER)

    def amounts_at(logs: Real) -> Real:
        return non_negative(*columns(np.exp(logs)))[0]

    logs = np.arange(ends[0], ends[1] + step, step)
    amounts = amounts_at(logs)
    for share in SPACINGS:
        carrying = logs[amounts[2:] > 0.0]
        near = carrying[:, None] + share * step * np.arange(-4.0, 5.0)
        logs = np.unique(np.round(near.ravel() / (share * step))) * share * step
        logs = logs[(logs > ends[0] - share * step) & (logs < ends[1] + share * step)]
        amounts = amounts_at(logs)
    logs = _apart(logs[amounts[2:] > 0.0], amounts[2:][amounts[2:] > 0.0])
    amounts = amounts_at(logs)
    kept = amounts > 0.0
    kept[:2] = True
    return ConvexSpectrum.of(amounts[kept], np.exp(-logs[kept[2:]]))


def lines_of_record(test: TimeTest, sd: Real) -> ConvexSpectrum:
    """Of relaxation, by the response over its noise (n,); of retardation these are turned."""
    found = shown_lines(test, sd)
    return relaxation_of(found) if test.control == "force" else found


def shown_lines(test: TimeTest, sd: Real) -> ConvexSpectrum:
    """Of relaxation under a displacement and of retardation under a force."""
    rows = evenly(len(test), ENOUGH)
    rows = rows[~np.isin(test.time[rows], test.loading.jumps[0])]

    def columns(times: Real) -> tuple[Real, Real]:
        shown = answers_of(test.loading, test.control, times, test.time[rows])
        # Without the mass, which is no part of such a sum.
        return np.delete(shown, 2, axis=1) / sd[rows, None], test.response[rows] / sd[rows]

    return nearest_lines(columns, test.seen)


def unknowns_of(test: TimeTest, sd: Real) -> Real:
    """By how much a response with noise (n,) hangs on what nobody knows of its load, (n, k).

    In standard deviations of that: when each step between two samples happened, and the noise of
    the first sample, at which a model takes the load to have been held before.
    """
    steps, first = test.loading.steps_between, _noise_of_first(test)
    if not steps and not first:
        return np.zeros((len(test), 0))
    lines = shown_lines(test, sd)
    columns = [_instants(test, lines, *step) for step in steps]
    if first:
        faded = np.exp(-np.outer(test.time - test.time[0], lines.rates)) @ lines.weights
        columns.append(first * faded[:, None])
    return np.hstack(columns)


def _noise_of_first(test: TimeTest) -> float:
    """Of what was imposed, where it was recorded from there on, and not put upon a fluid."""
    loading = test.loading
    sampled = loading.sampled and not loading.before and not len(loading.jumps[0])
    if not sampled or test.control == "force" or not is_even(loading.time):
        return 0.0
    return noise_of_transducer(loading.value)


def _instants(
    test: TimeTest, lines: ConvexSpectrum, before: float, after: float, size: float
) -> Real:
    """The same of one step, (n, 3).

    That may have been any instant between two samples, and the loading is straight there, its
    mean. What the lines answer to the step at either sample and in the middle tells how far off
    that is: in proportion to the instant and to its square, each in standard deviations of an even
    chance. Just after it what else there may be is as large as the bend.
    """
    mix = np.concatenate([lines.amounts[:2], [0.0], lines.weights])[:, None]
    step, times = Loading.step(size), 1.0 / lines.rates
    soon, middle, late = (
        answers_of(replace(step, time=step.time + at), test.control, times, test.time, mix)
        for at in (before, 0.5 * (before + after), after)
    )
    bent, just_then = late - 2.0 * middle + soon, (test.time == after)[:, None]
    moved = np.hstack([(late - soon) / sqrt(12.0), bent / sqrt(45.0), bent * just_then])
    return np.where(test.time[:, None] > before, moved, 0.0)


def lines_of_sweep(sweep: Measurement, sd: Real) -> ConvexSpectrum:
    """By K' and then K'' over their noise (2 n,)."""

    def columns(times: Real) -> tuple[Real, Real]:
        shown = real_form(shown_by(1.0 / times, sweep.omega).T)
        return shown / sd[:, None], real_form(sweep.stiffness) / sd

    return nearest_lines(columns, sweep.seen)


def relaxation_of(retardation: ConvexSpectrum) -> ConvexSpectrum:
    """The relaxation of a retardation J = J_g + t / eta + sum of weight (1 - exp(-rate t)).

    Parameters
    ----------
    retardation : ConvexSpectrum
        J_g in 1/Pa, 1/eta in 1/(Pa s), rates in 1/s and weights in 1/Pa.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.identification.convex import ConvexSpectrum, relaxation_of
    >>> found = relaxation_of(ConvexSpectrum(0.5, 0.0, np.array([0.5]), np.array([0.5])))
    >>> found.equilibrium, found.viscosity, found.rates.round(6), found.weights.round(6)
    (1.0, 0.0, array([1.]), array([1.]))
    """
    kept = retardation.weights > 0.0
    rates, weights = retardation.rates[kept], retardation.weights[kept]
    # In p = 1/s it is a sum of the same kind, and its inverse the relaxation.
    made = Rational.known((retardation.equilibrium, retardation.viscosity), 1.0 / rates, weights)
    # Of what goes against its force nothing is followed, and nothing relaxes.
    if made.is_nothing:
        return retardation
    relaxing = made.inverse()
    equilibrium, viscosity, _ = relaxing.ends.tolist()
    rates, weights, *_ = relaxing.lines
    return ConvexSpectrum(equilibrium, viscosity, rates[::-1], weights[::-1])


def _apart(logs: Real, amounts: Real) -> Real:
    """Places of lines, those that stand too near to one another as one in their middle."""
    placed: list[float] = []
    held: list[float] = []
    for log, amount in zip(logs, amounts, strict=True):
        if placed and log - placed[-1] < APART:
            placed[-1] = (held[-1] * placed[-1] + amount * log) / (held[-1] + amount)
            held[-1] += amount
        else:
            placed.append(float(log))
            held.append(float(amount))
    return np.array(placed)


def lattice(bands: Sequence[tuple[float, float]], per_decade: int) -> Real:
    """Rates (m,) in 1/s of the lines that tests of these bands tell of, so many a decade."""
    low, high = min(each[0] for each in bands), max(each[1] for each in bands)
    decades = np.log10(high / low) + SLOWER + FASTER
    return np.geomspace(low * 10.0**-SLOWER, high * 10.0**FASTER, int(per_decade * decades) + 2)


FREQUENCIES = 5
"""Frequencies a decade at which a test in time is looked at as a sweep."""


def start_of(
    model: Model, made: Sequence[Measurement | None], sweeps: Sequence[Measurement]
) -> list[Real]:
    """Parameters near those that fit tests in time, from sweeps that say about the same.

    Parameters
    ----------
    model : Model
        What is to be fitted.
    made : sequence of Measurement or None
        The sweeps that tests in time amount to, in the same units; see `apparent`.
    sweeps : sequence of Measurement
        Tests at frequencies, in these units too.

    Returns
    -------
    list of ndarray, shape (p,)
        Starts, best first; none where no sweep can be made.
    """
    # A start is of the specimen, whichever test an effect is of.
    model = replace(model, effects=tuple(each.at(ALL) for each in model.effects))
    together = [each for each in made if each is not None] + [_bare(sweep) for sweep in sweeps]
    if not together:
        return []
    try:
        return [fit(model, _stacked(together)).theta]
    except SpringpotError:
        # A model with a condition that a sweep made of time lacks begins at its typical values
        # instead.
        return []


def apparent(test: TimeTest, lines: ConvexSpectrum) -> Measurement | None:
    """The sweep that a test in time amounts to by its lines, where it saw something."""
    low, high = test.seen
    omega = np.geomspace(low, high, max(4, int(FREQUENCIES * np.log10(high / low))))
    stiffness = lines.stiffness(omega)
    # A compliance of nothing has no stiffness.
    good = np.isfinite(stiffness) & (np.abs(stiffness) > 0.0)
    if np.count_nonzero(good) < 2:
        return None
    moved = test.response
    if test.control == "displacement":
        moved = test.loading.value
    amplitude = max(float(np.abs(moved).max()), SMALLEST)
    conditions = {"amplitude": np.full(int(good.sum()), amplitude)}
    if test.temperature is not None:
        conditions["temperature"] = np.full(int(good.sum()), test.temperature)
    return Measurement(
        omega[good], stiffness[good], conditions=conditions, units=test.units, name=test.name
    )


def answers_of(
    loading: Loading, control: str, times: Real, t: Real, mix: Real | None = None
) -> Real:
    """The unit responses (n, 3 + m) of spring, dashpot, mass and an exponential of each time.

    Under a force they are compliances, and a mass has no part in them. With a `mix` (3 + m, c) of
    amounts the answer is that of the c mixtures (n, c), which takes less time than each alone.
    """
    if mix is None:
        mix = np.eye(3 + len(times))
    # The first three amounts are those of spring, dashpot and mass.
    one = mix[3:]
    faded: Modes = np.zeros((len(t), mix.shape[1]))
    followed, moving, pushed = np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t))
    for when, size in zip(*loading.jumps, strict=True):
        since = np.maximum(t - when, 0.0)
        after = t >= when
        faded += (size * after[:, None] * np.exp(-since[:, None] / times)) @ one
        followed += size * after
        # A dashpot under a force moves on and on; a step of displacement meets it at one instant
        # only.
        moving += size * since * (control == "force")
    if loading.smooth is not None:
        smooth = loading.smooth
        motion = smooth.motion
        if motion is not None:
            motion = motion.at(t)
            grid, imposed, changes = motion.time, motion.value, motion.changes
        else:
            grid = np.union1d(smooth.time, t)
            imposed = np.interp(grid, smooth.time, smooth.value)
            changes = np.diff(imposed, prepend=imposed[0])
        steps, place = np.diff(grid, prepend=grid[0]), np.searchsorted(grid, t)
        faded = faded + driven(1.0 / times, steps, changes, one, np.zeros_like(one))[place]
        followed += imposed[place]
        if control == "force":
            mean = 0.5 * (imposed[1:] + imposed[:-1])
            moving += np.concatenate([[0.0], np.cumsum(mean * steps[1:])])[place]
        elif motion is not None:
            moving += motion.speed[place]
            pushed += motion.push[place]
        # Of what is straight between its samples they take differences: for whom nobody asks.
        elif mix[1:3].any():
            moving += velocity(grid, imposed)[place]
            pushed += acceleration(grid, imposed)[place]
    modes = faded
    # A Kelvin element under a force has moved by what its Maxwell twin has forgotten.
    if control != "displacement":
        modes = np.outer(followed, one.sum(axis=0)) - faded
    answers: Real = np.column_stack([followed, moving, pushed]) @ mix[:3] + modes.real
    return answers


def _bare(sweep: Measurement) -> Measurement:
    """The columns that all of them may have."""
    kept = {
        name: column
        for name, column in sweep.conditions.items()
        if name in ("amplitude", "temperature")
    }
    return Measurement(
        sweep.omega, sweep.stiffness, conditions=kept, units=sweep.units, name=sweep.name
    )


def _stacked(sweeps: Sequence[Measurement]) -> Measurement:
    common = set.intersection(*(set(sweep.conditions) for sweep in sweeps))
    return Measurement(
        np.concatenate([sweep.omega for sweep in sweeps]),
        np.concatenate([sweep.stiffness for sweep in sweeps]),
        conditions={
            name: np.concatenate([sweep.conditions[name] for sweep in sweeps]) for name in common
        },
        units=sweeps[0].units,
        name=sweeps[0].name,
    )


OMEGA = np.geomspace(1e-3, 1e3, 61)
"""Frequencies in rad/s, about the time of one second that an element is given."""
RATES = np.geomspace(1e-7, 1e7, 57)
"""Four lines a decade, and four decades beyond: a springpot between is followed to 0.1 %."""


def within_material(model: Model, effect: Effect) -> bool:
    """Whether an effect is a part of any material.

    So that beside a free spectrum it can explain nothing.

    Around a material whose times are shifted, what gives way in the mounting is not shifted with
    it, and shows.

    Parameters
    ----------
    model : Model
        The material with other effects; of any other model nothing is a part of the material.
    effect : Effect
        That may be missing.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import within_material
    >>> model, registry = springpot.parse_model("material"), springpot.plugins()
    >>> [within_material(model, registry.effect(name)) for name in ("parallel-spring", "inertia")]
    [True, False]
    """
    shifted = any(own.plane == "shift" for own in model.effects)
    return (
        is_material(model)
        and not (shifted and effect.layer > Layer.MATERIAL)
        and is_passive(effect)
    )


@lru_cache(maxsize=256)
def is_passive(effect: Effect) -> bool:
    """Whether it adds a spring, dashpot, springpot or mode: what a sum of relaxations follows.

    Parameters
    ----------
    effect : Effect
        That may be missing.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import is_passive
    >>> effects = [springpot.plugins().effect(name) for name in ("series-springpot", "time-delay")]
    >>> [is_passive(effect) for effect in effects]
    [True, False]
    """
    if effect.plane not in ("stiffness", "compliance") or effect.needs:
        return False
    return is_relaxing(Model(effect.name, effect.element))


def is_relaxing(model: Model) -> bool:
    """Whether a sum of relaxations follows a model: springs, dashpots, springpots and modes.

    Parameters
    ----------
    model : Model
        Any.
    """
    if model.needs or any(not is_passive(effect) for effect in model.effects):
        return False
    # Inside its range no parameter decides whether an element is passive: any value will do.
    bounds = np.array([(parameter.lower, parameter.upper) for parameter in model.parameters])
    theta = np.where(np.isfinite(bounds[:, 1]), bounds.mean(axis=1), 1.0)
    stiffness = model.stiffness(theta, OMEGA)
    s = 1j * OMEGA[:, None]
    columns = (
        np.concatenate([np.ones_like(s), s, s / (s + RATES)], axis=1) / np.abs(stiffness)[:, None]
    )
    target = stiffness / np.abs(stiffness)
    _, left = non_negative(real_form(columns), real_form(target))
    return left < REFUSED**2 * len(OMEGA)


def least_error(model: Model, measurement: Measurement, known: Sequence[Real]) -> float:
    """The least relative error, as printed, of any linear passive material with a model's effects.

    Parameters
    ----------
    model : Model
        Its material is a `Continuum`.
    measurement : Measurement
        The rows over which the error is taken.
    known : sequence of ndarray, shape (q,)
        Parameters of the effects from which the search begins; of no effect one that is empty.
    """
    # Of many rows some show where the lines are, and all of them what these leave.
    few = thinned(measurement)
    search = SpectrumSearch.of(model, few, relative_objective())
    trials = sorted((search.solve(search.u_of(own)) for own in known), key=lambda trial: trial.cost)
    # No line is spared for the degrees of freedom: they are no part of an error.
    ends = [search.refined(search.descend(trial)[0]) for trial in trials[:KEPT]]
    best = min(ends, key=lambda trial: trial.cost)
    if few is not measurement:
        whole = SpectrumSearch.of(model, measurement, relative_objective())
        best = whole.solve(best.u, best.log_rates)
    return float(np.sqrt(best.cost / len(measurement)))
