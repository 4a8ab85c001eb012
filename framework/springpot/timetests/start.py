"""Where to begin: a test in time as a sum of exponentials, and so as a sweep fitted at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from springpot.errors import SpringpotError
from springpot.identification.native import fit
from springpot.measurement.imposed import Loading
from springpot.measurement.measurement import Measurement
from springpot.measurement.timetest import TimeTest
from springpot.numerics import SMALLEST, evenly, non_negative
from springpot.rheology.effect import ALL
from springpot.rheology.model import Model
from springpot.rheology.motion import acceleration, velocity
from springpot.rheology.points import Complex, Real
from springpot.rheology.terms import Modes, driven

PER_DECADE = 2
"""Exponentials a decade: half a per cent of a springpot, enough for a start."""
FREQUENCIES = 5
"""Frequencies a decade at which the sum is looked at."""
MOST = 400
"""Samples that the sum is fitted to."""


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


def apparent(test: TimeTest, sd: Real) -> Measurement | None:
    """The sweep that a test in time amounts to, between the frequencies that it saw.

    The response is fitted by non-negative exponentials (Prony in relaxation, Kelvin elements in
    creep), whose complex stiffness is known in closed form.
    """
    picked = evenly(len(test), MOST)
    clock = test.time - test.start
    shortest = max(float(np.min(clock[clock > 0.0], initial=np.inf)), 1e-6 * test.duration, 1e-12)
    longest = max(test.duration, 3.0 * shortest)
    decades = np.log10(longest / shortest) + 2.0
    times = np.geomspace(0.3 * shortest, 3.0 * longest, max(3, int(PER_DECADE * decades)))
    answers = answers_of(test.loading, test.control, times, test.time)
    # Without the mass, which is no part of such a sum.
    columns = np.delete(answers, 2, axis=1)[picked] / sd[picked, None]
    # Not negative: so it is a material, and no fit to the noise.
    amounts, _ = non_negative(columns, (test.response / sd)[picked])
    count = max(4, int(FREQUENCIES * np.log10(longest / shortest)))
    omega = np.geomspace(1.0 / longest, 1.0 / shortest, count)
    stiffness = _sum_at(omega, times, amounts, test.control)
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
        else:
            moving += velocity(grid, imposed)[place]
            pushed += acceleration(grid, imposed)[place]
    modes = faded
    # A Kelvin element under a force has moved by what its Maxwell twin has forgotten.
    if control != "displacement":
        modes = np.outer(followed, one.sum(axis=0)) - faded
    answers: Real = np.column_stack([followed, moving, pushed]) @ mix[:3] + modes.real
    return answers


def _sum_at(omega: Real, times: Real, amounts: Real, control: str) -> Complex:
    """K of spring, dashpot and exponentials; of creep the amounts are compliances, in series."""
    s = 1j * omega
    turned = np.outer(s, times)
    if control == "displacement":
        stiffness: Complex = amounts[0] + amounts[1] * s + (turned / (1.0 + turned)) @ amounts[2:]
        return stiffness
    compliance: Complex = amounts[0] + amounts[1] / s + (1.0 / (1.0 + turned)) @ amounts[2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(1.0 / compliance)


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
