"""What was imposed in a test in time.

Straight between its knots, and how that is read off a record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import ceil, comb, log, sqrt
from typing import NamedTuple

import numpy as np

from springpot.distributions import normal_sf
from springpot.errors import DataError
from springpot.rheology.motion import FEWEST_AT_CORNER, SHARP, Between
from springpot.rheology.points import STEADY, Real

from ..numerics import DEVIATIONS, NORMAL, SMALLEST, rms
from ..thresholds import SIGNALS
from .instrument import is_even, rounding_step
from .steady import SHORTEST

NEARLY_ALL = 0.9
"""Share of the samples at which what is imposed is held or gone: its ramps take the rest."""
SHORT = 0.05
"""Share of the record that a rise may take for the test to be called relaxation or creep."""
ORDER = 8
"""Of the differences that tell the noise: of a sine of twelve samples a hundredth is left."""


class Unfelt(NamedTuple):
    """What was taken off a motion that was read with noise, as no specimen felt it.

    Attributes
    ----------
    noise : float
        Standard deviation of the noise, as large as it is where it is slow; zero of none.
    numbers : float
        Of so many the course is: that part of the noise it has kept.
    """

    noise: float = 0.0
    numbers: float = 0.0


@dataclass(frozen=True, eq=False)
class Loading:
    """What was imposed.

    Straight between its knots, at rest at the first value before, held at the last one after.

    Parameters
    ----------
    time : ndarray, shape (k,)
        In s; two knots at one time are a step.
    value : ndarray, shape (k,)
        Displacement or force.
    sampled : bool
        Whether the knots are samples of something that may be smooth between them; see `Between`.
    before : int
        Knots before the first sample: how it had gone on until then, or one where it rose from
        nothing.
    unfelt : Unfelt
        The noise that was taken off, where the course is a smooth one.

    Raises
    ------
    DataError
        If the time runs backwards, or something is no number.

    Examples
    --------
    >>> from springpot.measurement import Loading
    >>> Loading([0.0, 0.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0]).jumps
    (array([0.]), array([1.]))
    """

    time: Real
    value: Real
    sampled: bool = False
    before: int = 0
    unfelt: Unfelt = field(default_factory=Unfelt)

    def __post_init__(self) -> None:
        for name in ("time", "value"):
            object.__setattr__(
                self, name, np.atleast_1d(np.asarray(getattr(self, name), dtype=float))
            )
        if self.time.shape != self.value.shape or self.time.ndim != 1 or not len(self.time):
            raise DataError("a loading is two lists of the same length, times and values")
        if not (np.all(np.isfinite(self.time)) and np.all(np.isfinite(self.value))):
            raise DataError("a loading has a time or a value that is no number")
        if np.any(np.diff(self.time) < 0.0):
            back = int(np.flatnonzero(np.diff(self.time) < 0.0)[0])
            raise DataError(f"the time of the loading runs backwards after {self.time[back]:g} s")

    @classmethod
    def step(cls, size: float = 1.0, rise: float = 0.0) -> Loading:
        """A step at t = 0 that takes `rise` seconds.

        Examples
        --------
        >>> Loading.step(2.0, rise=0.5).time
        array([0. , 0.5])
        """
        if not rise >= 0.0:
            raise DataError(f"the rise of a step takes 0 s or more, not {rise:g} s")
        return cls(np.array([0.0, rise]), np.array([0.0, size]))

    @cached_property
    def jumps(self) -> tuple[Real, Real]:
        """Times and sizes of the steps that take no time."""
        # Steps are kept apart: their answer is the relaxation function itself, which no rate of
        # change would give.
        at = np.flatnonzero((np.diff(self.time) == 0.0) & (np.diff(self.value) != 0.0))
        return self.time[at], np.diff(self.value)[at]

    @property
    def smooth(self) -> Loading | None:
        """The rest without its jumps, at rising times; None where nothing else moves."""
        rest = self._without_jumps
        # One that kept itself would wait for the garbage collector, with all that it has worked
        # out: gigabytes, where a diagnosis has a thousand of a long record.
        kept = self if rest is None else rest
        return kept if kept._moves else None

    @property
    def goes_one_way(self) -> bool:
        """Whether it never comes back, so that it passes each of its values once."""
        back = min(np.ptp(np.maximum.accumulate(each) - each) for each in (self.value, -self.value))
        return bool(back <= STEADY * np.abs(self.value).max())

    @cached_property
    def _moves(self) -> bool:
        return bool(np.ptp(self.value) > 0.0 or self.value[0] != 0.0)

    @cached_property
    def _without_jumps(self) -> Loading | None:
        if not len(self.jumps[0]):
            return None
        # What has jumped so far is taken off, so that what is left has no steps and one value at
        # each time.
        passed = np.cumsum(np.where(np.diff(self.time) == 0.0, np.diff(self.value), 0.0))
        first = np.concatenate([[True], np.diff(self.time) > 0.0])
        value = self.value - np.concatenate([[0.0], passed])
        return replace(self, time=self.time[first], value=value[first])

    @property
    def is_cycled(self) -> bool:
        """Whether it has cycles before the first sample, of which nobody knows how many."""
        return self.before > 1

    @property
    def recorded(self) -> Loading:
        """What was recorded of it."""
        now = slice(self.before, None)
        return replace(self, time=self.time[now], value=self.value[now], before=0)

    def scaled(self, factor: float) -> Loading:
        """The same in another unit."""
        unfelt = self.unfelt._replace(noise=self.unfelt.noise * abs(factor))
        return replace(self, value=self.value * factor, unfelt=unfelt)

    @cached_property
    def motion(self) -> Between | None:
        """The course between the samples; None where it is straight."""
        if not self.sampled or len(self.time) < 2:
            return None
        return Between.of(self.time, self.value)

    @cached_property
    def steps_between(self) -> list[tuple[float, float, float]]:
        """Times of two samples between which it stepped, held before and after, and by how much.

        Examples
        --------
        >>> Loading(np.arange(8.0), np.arange(8.0) < 4.0, sampled=True).steps_between
        [(3.0, 4.0, -1.0)]
        """
        known = self.recorded if self.is_cycled else self
        if len(known.value) < SHORTEST:
            return []
        change, most = np.diff(known.value), STEADY * float(np.abs(known.value).max())
        size = np.where(np.diff(known.time) > 0.0, np.abs(change), 0.0)
        padded, steps = np.pad(size, 2), np.zeros(len(size), dtype=bool)
        # Fewer samples on the way than two corners need tell as little of when these were.
        for length in range(1, FEWEST_AT_CORNER - 1):
            runs = np.lib.stride_tricks.sliding_window_view(padded, length + 4)
            beside = np.max(runs[:, [0, 1, -2, -1]], axis=1)
            large = np.min(runs[:, 2:-2], axis=1) > np.maximum(SHARP * beside, most)
            for i in range(length):
                steps[i : i + len(large)] |= large
        # One rise to what is held from the first sample on was said, or presumed.
        if not steps[1:].any():
            return []
        at = np.flatnonzero(steps)
        ends = known.time[at].tolist(), known.time[at + 1].tolist(), change[at].tolist()
        return list(zip(*ends, strict=True))

    def unsure(self, judged: bool) -> Real:
        """Times when nobody knows what is felt: at a jump by a spring, at a turn by a dashpot.

        Where it is to be `judged`, its first sample too if it was at rest before and moves from
        there on; of a plan that of what moves is told. Of a smooth course without its noise the
        ends too, which are told from one side.
        """
        times, _ = self.jumps
        if self.unfelt.noise:
            few = ceil(len(self.time) / self.unfelt.numbers)
            times = np.union1d(times, self.time[[*range(few), *range(-few, 0)]])
        if self.smooth is None or self.smooth.motion is None:
            return times
        motion = self.smooth.motion
        if judged and not self.before and motion.leaving[0] != 0.0:
            times = np.union1d(times, self.time[:1])
        return np.union1d(times, motion.unsure)

    @property
    def turning(self) -> Real:
        """Times of the samples at which it turns: dry friction holds there with any force."""
        if self.smooth is None or self.smooth.motion is None:
            return np.zeros(0)
        return self.smooth.motion.turning


def controlled(clock: Real, moved: Real, pulled: Real) -> tuple[str, dict[str, str]]:
    """The channel that is held or released for nearly all of the record, or stands still.

    Of two that move, the force where it has no noise and the displacement has, and a note on that;
    else the displacement.

    A force that was held and taken away does not stand still in the end, nor does what recovers
    from it.
    """
    # Asked first: a channel at its level is plain, while an unrest has to be weighed against the
    # other's.
    displacement_held, force_held = _at_levels(moved), _at_levels(pulled)
    if max(displacement_held, force_held) < NEARLY_ALL:
        displacement_held, force_held = (
            share_held(levels(value)[1], len(value)) for value in (moved, pulled)
        )
    force_unrest = _late_unrest(pulled)
    if max(displacement_held, force_held) >= NEARLY_ALL:
        force_imposed = force_held > displacement_held
    elif is_command(clock, pulled, moved):
        said = (
            "the force has no noise and the displacement has: the force is taken to have been"
            " imposed; '?control=displacement' behind the file says otherwise"
        )
        return "force", {"note control": said}
    else:
        force_imposed = force_unrest <= STEADY and force_unrest < _late_unrest(moved)
    if force_imposed:
        return "force", {}
    return "displacement", {}


def is_command(clock: Real, value: Real, other: Real) -> bool:
    """Whether a channel (n,) has no noise, but for digits finer than the noise of the other.

    Such a one was no transducer's: it was imposed. Nor can a model be asked for it: what it answers
    to noise of the other one bends it.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.imposed import is_command
    >>> t = np.arange(200) / 20.0
    >>> noisy = np.sin(t) + 0.01 * np.random.default_rng(1).normal(size=200)
    >>> is_command(t, np.sin(t), noisy), is_command(t, noisy, np.sin(t))
    (True, False)
    """
    # One that mostly stands is told by its levels.
    stands = not np.median(np.abs(np.diff(value))) > 0.0
    if stands or len(clock) < 5 * ORDER or not is_even(clock):
        return False
    # Short lines have corners in most high differences, and in few of the second order.
    noise, digit = imposed_noise(other, ORDER // 4), rms(rounding_step(value))
    if imposed_noise(value, ORDER // 4) <= digit:
        # What answers to lines is none, be it by its noise or by itself.
        return noise > rms(rounding_step(other)) and digit * rms(other) < noise * rms(value)
    noise, most = imposed_noise(other), _hidden_noise(other)
    own, digit = imposed_noise(value), _hidden_noise(value)
    return noise > most and own <= digit and max(own, digit) * rms(other) < noise * rms(value)


def noise_of_transducer(value: Real) -> float:
    """The noise of a channel (n,) that was evenly sampled; nothing of what is smooth, or digits.

    Examples
    --------
    >>> noise_of_transducer(np.sin(0.3 * np.arange(100)))
    0.0
    """
    noise = imposed_noise(value)
    return noise if noise > _hidden_noise(value) else 0.0


def _hidden_noise(value: Real) -> float:
    """What differences leave at most of a channel (n,) without noise but that of its digits."""
    return max(noise_of_smooth(value), rms(rounding_step(value)))


def noise_of_smooth(value: Real) -> float:
    """What differences leave at most of a smooth channel (n,) without any noise."""
    # Of a sine of three samples two thirds of what half the order leaves; of noise as much.
    return 0.5 * imposed_noise(value, ORDER // 2)


def imposed_noise(value: Real, order: int = ORDER) -> float:
    """Standard deviation of white noise in a channel (n,) that was evenly sampled.

    By the median of its differences of the eighth order, which corners do not move; 0 where there
    are too few samples for one.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.imposed import imposed_noise
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=2000)
    >>> round(imposed_noise(np.sin(0.1 * np.arange(2000)) + noise), 3)
    0.01
    """
    if len(value) <= order:
        return 0.0
    # Of white noise of variance one such a difference has the variance 2n over n.
    own = sqrt(comb(2 * order, order))
    return NORMAL * float(np.median(np.abs(np.diff(value, order)))) / own


def _late_unrest(value: Real) -> float:
    """How much a channel moves after a first quarter of its samples, which brought it there."""
    late = value[len(value) // 4 :]
    # A channel that is zero throughout is at rest, not undefined.
    return float(np.ptp(late) / max(np.abs(value).max(), SMALLEST))


def share_held(parts: Sequence[slice], count: int) -> float:
    """Share of `count` samples that are in parts that are held."""
    return float(sum(part.stop - part.start for part in parts)) / count


def levels(value: Real) -> tuple[Real, list[slice]]:
    """A channel (n,) without white noise where it is held between two steps, and where that is.

    A step is a change beyond the largest one of noise, and beyond what may be called held.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.imposed import levels
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=40)
    >>> level, parts = levels(np.repeat([1.0, 2.0], 20) + noise)
    >>> level[[0, 39]].round(1), parts
    (array([1., 2.]), [slice(0, 20, None), slice(20, 40, None)])
    """
    level, parts, count = value.copy(), list[slice](), len(value)
    if count < SHORTEST:
        return level, parts
    change = np.abs(np.diff(value))
    # Differences of noise have twice its variance, and the largest of so many is as far off.
    largest, most = NORMAL * float(np.median(change)) * 2.0 * sqrt(log(count)), np.abs(value).max()
    # What swings by as much from sample to sample is held nowhere.
    if largest >= 0.5 * most:
        return level, parts
    steps = np.flatnonzero(change > max(largest, STEADY * float(most))) + 1
    for first, last in pairwise([0, *steps.tolist(), count]):
        part = slice(first, last)
        left = value[part] - float(np.mean(value[part]))
        # Noise is told from a course by twice as many samples as a level without any.
        exact = last - first >= SHORTEST and np.ptp(value[part]) == 0.0
        if exact or (last - first >= 2 * SHORTEST and is_white(left)):
            level[part] -= left
            parts.append(part)
    return level, parts


def is_white(left: Real) -> bool:
    """Whether neighbours are not alike, beyond chance (von Neumann 1941)."""
    count = len(left)
    unrest = float(np.mean(np.diff(left) ** 2)) / max(2.0 * float(np.var(left)), SMALLEST)
    off = (unrest - 1.0) / np.sqrt((count - 2.0) / (count**2 - 1.0))
    return bool(normal_sf(-off) >= SIGNALS.ruled_out)


def _at_levels(value: Real) -> float:
    """Share of the samples that are at the level that was held, or at nothing."""
    size = np.abs(value)
    largest = float(size.max())
    # The level that was held, told from ramps and from the time before and after by the median of
    # the upper half.
    raised = size > 0.5 * largest
    if largest == 0.0 or not raised.any():
        return 0.0
    level = float(np.median(size[raised]))
    return float(np.mean((np.abs(size - level) <= STEADY * largest) | (size <= STEADY * largest)))


def from_rest(clock: Real, imposed: Real, rise: float | None) -> Loading:
    """The record as a loading.

    What is there already at a first sample after t = 0 began at t = 0 from nothing.

    With a rise it led from there to what the record holds afterwards; a rise of nothing is a step.
    """
    if rise is not None:
        later = clock > rise
        # Where the record ends within the rise, its last value is the best there is for where the
        # rise led.
        reached = imposed[-1:]
        if later.any():
            reached = imposed[later][:1]
        start, size = np.array([0.0, rise]), np.concatenate([[0.0], reached])
        return Loading(
            np.concatenate([start, clock[later]]), np.concatenate([size, imposed[later]])
        )
    largest = np.abs(imposed).max()
    held = largest > 0.0 and np.ptp(imposed) <= STEADY * largest
    if held and (clock[0] == 0.0 or is_late(clock)):
        # Held from the first sample on: it was stepped to just then.
        return Loading(np.concatenate([clock[:1], clock]), np.concatenate([[0.0], imposed]))
    if held and clock[0] > 0.0:
        return Loading(np.concatenate([[0.0], clock]), np.concatenate([[0.0], imposed]))
    return Loading(clock, imposed, sampled=True)


def is_late(clock: Real) -> bool:
    """Whether a record begins after more time than it takes: its clock may have begun elsewhere."""
    return bool(clock[0] > clock[-1] - clock[0])


def leads_to_nothing(clock: Real, value: Real) -> bool:
    """Whether a channel (n,) whose first sample is after t = 0 comes from nothing at t = 0.

    By the parabola through its first samples, within its error or half of the first one: what was
    held there before is off by all of that. Not from further than these samples reach.

    Examples
    --------
    >>> t = np.arange(1.0, 41.0)
    >>> leads_to_nothing(t, 0.5 * t), leads_to_nothing(t, 0.5 * (t + 2.0))
    (True, False)
    """
    at = clock[:SHORTEST]
    if len(at) < SHORTEST or not 0.0 < at[0] <= at[-1] - at[0] or value[0] == 0.0:
        return False
    to_nothing = np.linalg.pinv(np.vander(at, 3))[-1]
    error = imposed_noise(value) * float(np.linalg.norm(to_nothing))
    most = max(DEVIATIONS * error, 0.5 * abs(value[0]))
    return bool(abs(to_nothing @ value[:SHORTEST]) <= most)


def since_nothing(loading: Loading, read: Real) -> Loading:
    """A sampled loading that rises from nothing at t = 0.

    Where what was `read` (n,) says so, or where it is there already soon after.

    Examples
    --------
    >>> t = np.arange(1.0, 41.0)
    >>> since_nothing(Loading(t, 0.5 * t, sampled=True), 0.5 * t).time[:2]
    array([0., 1.])
    """
    first, largest = loading.time[0], float(np.abs(read).max())
    soon = 0.0 < first < SHORT * loading.time[-1] and abs(float(read[0])) > STEADY * largest
    if loading.before or not (loading.sampled and (soon or leads_to_nothing(loading.time, read))):
        return loading
    time, value = (np.concatenate([[0.0], each]) for each in (loading.time, loading.value))
    return replace(loading, time=time, value=value, before=1)


def is_released(clock: Real, value: Real, largest: float) -> bool:
    """Whether a load went up once, came back to nothing and stays there, never to the other side.

    A record that swings goes there, and one that is pulled and let go ends where it is at nothing.
    """
    # With the load counted upwards, compression and tension are one case.
    up = value * np.sign(value[np.argmax(np.abs(value))])
    # Half the largest value is crossed once on the way up and once on the way down.
    changes = int(np.count_nonzero(np.diff((up > 0.5 * largest).astype(int))))
    held = np.flatnonzero(up > STEADY * largest)
    rest = clock[-1] - clock[held[-1]] if len(held) else 0.0
    stays = rest > SHORT * (clock[-1] - clock[0])
    return bool(stays and changes <= 2 and up.min() >= -STEADY * largest)
