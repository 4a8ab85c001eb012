"""Whether a record begins in the middle of a motion that had gone on before.

A cyclic test is mostly recorded once it runs. What its specimen remembers of the cycles before is
in the first ones recorded, and a model that begins at rest misses it. A steady motion is known
without the noise of its transducer, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise, product

import numpy as np

from springpot.distributions import f_sf
from springpot.rheology.points import STEADY, Real

from ..numerics import DEVIATIONS, NEGLIGIBLE, SMALLEST, rms, vertex
from ..thresholds import SIGNALS
from .imposed import (
    NEARLY_ALL,
    Loading,
    imposed_noise,
    is_late,
    is_white,
    levels,
    share_held,
)
from .instrument import is_even, rounding_step
from .steady import SHORTEST

PERIODS_AFTER = 2
"""Periods that are recorded beside those which are laid over one another at least."""
REPEATS = 0.01
"""By how much what was imposed may differ from cycle to cycle, over its own root mean square."""
PERIODIC = 0.2
"""The same by which a period is found, which need not be a whole number of samples."""
OF_PERIOD = (0.125, 0.5, 1.0)
"""Parts of a period, from the first sample on, in which the response may still be settling."""
MANY = 10
"""Times the cycles recorded, that a motion had gone on for before them."""


def gone_on(loading: Loading, response: Real) -> Loading:
    """The loading with cycles before the first sample, where the response repeats from there on.

    They grow from nothing, so that they leave no memory of their own beginning. Where the
    specimen forgets within the noise, they change nothing.

    Parameters
    ----------
    loading : Loading
        As it was recorded, evenly in time.
    response : ndarray, shape (n,)
        Of the same samples.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(400) / 100.0
    >>> moved = Loading(t, np.sin(2.0 * np.pi * t), sampled=True)
    >>> steady, noise = np.sin(2.0 * np.pi * t + 0.3), np.random.default_rng(1).normal(size=400)
    >>> gone_on(moved, steady + 0.01 * noise).before
    400
    >>> gone_on(moved, steady + np.exp(-t) + 0.01 * noise).before
    0
    """
    samples = len(loading.time)
    periods, lag = cycles_of(loading, samples)
    if not lag or not _repeats(response[lag:] - response[:-lag], lag // periods):
        return loading
    # What lags answers already where its load passes nothing; at rest it does not.
    size = NEGLIGIBLE * float(np.abs(response).max())
    quiet_yet = abs(float(response[0])) <= max(DEVIATIONS * imposed_noise(response), size)
    if quiet_yet and abs(float(loading.value[0])) <= STEADY * float(np.abs(loading.value).max()):
        return loading
    # What flows on has no place that it had always been at, and what never moves was not measured.
    if abs(float(np.mean(response[lag:] - response[:-lag]))) >= REPEATS * float(np.std(response)):
        return loading
    # As many cycles as were recorded.
    return _after_cycles(loading, lag, samples // lag)


def lasting(loading: Loading) -> Loading:
    """A loading that has cycles before its first sample, with many more of them.

    What hangs on how many there were, no such record tells.
    """
    recorded = loading.recorded
    _, lag = cycles_of(loading, len(recorded.time))
    return _after_cycles(recorded, lag, MANY * loading.before // lag)


def _after_cycles(loading: Loading, lag: int, count: int) -> Loading:
    """A loading after so many cycles like its first, which grow from nothing."""
    middle = float(np.mean(loading.value[:lag]))
    grown = np.minimum(2.0 * np.arange(count * lag) / (count * lag), 1.0)
    earlier = middle + np.sin(0.5 * np.pi * grown) ** 2 * (
        np.tile(loading.value[:lag], count) - middle
    )
    step = float(np.mean(np.diff(loading.time)))
    before = loading.time[0] - step * np.arange(count * lag, 0, -1)
    return replace(
        loading,
        time=np.concatenate([before, loading.time]),
        value=np.concatenate([earlier, loading.value]),
        before=count * lag,
    )


def stepped_to(loading: Loading, control: str, response: Real) -> Loading:
    """The loading with a step at its first sample, where the response to what is held then is new.

    A specimen that had been held there before has come to rest; one that creeps or relaxes from the
    first sample on was loaded just then (von Neumann 1941, doi:10.1214/aoms/1177731677), and does
    so ever more slowly. A swing that is recorded from its end on is slow there, and is not held.

    Parameters
    ----------
    loading : Loading
        As it was recorded.
    control : {"displacement", "force"}
        What was imposed.
    response : ndarray, shape (n,)
        Of the same samples.

    Examples
    --------
    >>> t = np.arange(40.0)
    >>> held, noise = Loading(t, 1.0 * (t < 20.0), sampled=True), 0.01 * np.cos(7.0 * t)
    >>> stepped_to(held, "force", 1.0 + 0.1 * t + noise).jumps
    (array([0.]), array([1.]))
    >>> stepped_to(held, "force", 1.0 + noise) is held
    True
    """
    first, size = loading.value[0], float(np.abs(loading.value).max())
    moved = np.abs(loading.value - first) > STEADY * size
    held = int(np.argmax(moved))
    begun = loading.time[0] == 0.0 or is_late(loading.time)
    if not begun or abs(first) <= STEADY * size or held < SHORTEST:
        return loading
    early, late = loading.value[: held // 2], loading.value[held // 2 : held]
    # The halves of what turns there lie half of the way out apart, and half of that is motion
    # already. By medians, for a ramp may end what is held.
    if abs(float(np.median(late) - np.median(early))) > 0.25 * STEADY * size:
        return loading
    # What is held creeps on under a force, and relaxes under a displacement.
    onwards = np.sign(first) if control == "force" else -np.sign(first)
    if not _comes_to_rest(onwards * response[:held]):
        return loading
    step = np.concatenate([loading.time[:1], loading.time])
    return replace(loading, time=step, value=np.concatenate([[0.0], loading.value]))


def _comes_to_rest(answer: Real) -> bool:
    """Whether samples rise beyond their noise, and rise no faster in the end than at first."""
    from scipy.special import ndtr

    count, noise = len(answer), float(np.mean(np.diff(answer) ** 2)) / 2.0
    unrest = noise / max(float(np.var(answer)), SMALLEST)
    chance = float(ndtr((unrest - 1.0) / np.sqrt((count - 2.0) / (count**2 - 1.0))))
    begins, then, later, ends = (float(np.mean(part)) for part in np.array_split(answer, 4))
    # Of the four means, each of a quarter of the samples.
    faster = ((ends - later) - (then - begins)) / max(np.sqrt(16.0 * noise / count), SMALLEST)
    rises = chance < SIGNALS.ruled_out and later + ends > begins + then
    return bool(rises and ndtr(-faster) >= SIGNALS.ruled_out)


def rise_is_presumed(loading: Loading, kind: str, first: float) -> bool:
    """Whether a load is held from its first sample on, and nothing tells how it came there."""
    if kind not in ("relaxation", "creep") or loading.sampled or len(loading.time) < 2:
        return False
    return bool(loading.value[0] == 0.0 and loading.time[0] < loading.time[1] == first)


def said_of_start(name: str, loading: Loading, kind: str, time: Real) -> str:
    """What a test is taken to have done before its record (n,); nothing of most."""
    first = float(time[0])
    if is_late(time) and first in loading.jumps[0]:
        return f"{name} is held from its first sample at {first:.4g} s on: stepped to then"
    if is_late(time) and kind in ("relaxation", "creep"):
        return (
            f"{name} is read {first - loading.time[0]:.4g} s after its step and later: if its clock"
            " began elsewhere, count the time from the step"
        )
    if rise_is_presumed(loading, kind, first):
        return (
            f"{name} is held from its first sample at {first:.3g} s on: taken to have"
            " risen evenly until then, which '?ramp=0[s]' behind the file turns to a step"
        )
    if not loading.is_cycled:
        return ""
    return f"{name} repeats from its first cycle on: taken to have gone on before the record"


@lru_cache(maxsize=256)
def cycles_of(loading: Loading, samples: int) -> tuple[int, int]:
    """Periods of what was imposed, and their samples; see `period_of`.

    None where it was not recorded evenly, or with other samples than so many.
    """
    recorded = loading.recorded
    few = samples <= (PERIODS_AFTER + 1) * SHORTEST
    if few or samples != len(recorded.time) or not is_even(recorded.time):
        return 0, 0
    return period_of(recorded.value)


def period_of(value: Real) -> tuple[int, int]:
    """So many periods as lie best over the next ones, and their samples; zero for none.

    Parameters
    ----------
    value : ndarray, shape (n,)
        What was imposed, evenly sampled.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.steady_start import period_of
    >>> period_of(np.sin(2.0 * np.pi * np.arange(200) / 12.5))
    (1, 25)
    """
    n, size = len(value), value - np.mean(value)
    whole = np.fft.rfft(size, 2 * n)
    alike = np.fft.irfft(whole * np.conj(whole))[:n]
    squares = np.concatenate([[0.0], np.cumsum(size**2)])
    lags = np.arange(n)
    apart = squares[n - lags] + squares[n] - squares[lags] - 2.0 * alike
    apart /= np.maximum((n - lags) * max(squares[n] / n, SMALLEST), SMALLEST)
    near = np.flatnonzero(apart[SHORTEST:] < PERIODIC**2) + SHORTEST
    # What is smooth is near itself at first: a period is where it comes back.
    left = np.flatnonzero(apart[SHORTEST:] > PERIODIC**2) + SHORTEST
    near = near[near > left[0]] if len(left) else near[:0]
    if not len(near):
        return 0, 0
    # Lags that follow one another are of one place where it comes back.
    first = near[: np.argmax(np.append(np.diff(near), 2) > 1) + 1]
    shortest = int(first[np.argmin(apart[first])])
    tried = near[near <= n - PERIODS_AFTER * shortest]
    if not len(tried):
        return 0, 0
    # It need not be a whole number of samples: by a parabola.
    period = shortest + float(vertex(*apart[shortest - 1 : shortest + 2]))
    # The fewest that lie as well as any: more of them leave less of a record to compare.
    least = float(np.min(apart[tried]))
    best = int(tried[np.argmax(apart[tried] <= 2.0 * least + NEGLIGIBLE**2)])
    if apart[best] > REPEATS**2:
        return 0, 0
    # Where a period is too few samples to be found, all that is sure is what lies over the next.
    count = round(best / period)
    return (count if abs(best / period - count) < PERIODIC else 1), best


def _repeats(change: Real, period: int) -> bool:
    """Whether a response changes from its first cycle to a later one no more than later ones do."""
    rest = change[period:]
    usual = float(np.mean(rest**2)) if len(rest) else 0.0
    # Of what never differs, as a command does not, any difference is one.
    if usual == 0.0:
        return not change.any()
    for part in OF_PERIOD:
        first = change[: max(int(part * period), 2)]
        ratio = float(np.mean(first**2)) / usual
        # Of three parts each has a third of the chance.
        if f_sf(ratio, len(first), len(rest)) < SIGNALS.ruled_out / len(OF_PERIOD):
            return False
    return True


def quiet(loading: Loading, response: Real) -> tuple[Loading, dict[str, str]]:
    """A motion that is a few harmonics and white noise without that noise, and what is told of it.

    The specimen never felt it, and a model answers to it, a mass by its second derivative: a fit to
    what was read is too soft (errors in variables: Fuller 1987, Measurement Error Models, chapter
    1). What the response goes with was felt, and stays; so does what is no noise, as of a motion
    that grows.

    Parameters
    ----------
    loading : Loading
        As it was recorded, evenly in time.
    response : ndarray, shape (n,)
        Of the same samples.

    Examples
    --------
    >>> t, noise = np.arange(400) / 100.0, np.random.default_rng(1).normal(size=(2, 400))
    >>> moved = np.sin(2.0 * np.pi * t)
    >>> read = Loading(t, moved + 0.003 * noise[0], sampled=True)
    >>> still, _ = quiet(read, 2.0 * moved + 0.01 * noise[1])
    >>> float(np.abs(still.value - moved).max().round(2))
    0.0
    >>> quiet(read, 2.0 * read.value + 0.001 * noise[1])[0] is read
    True
    """
    value, count = loading.value, len(loading.value)
    periods, lag = cycles_of(loading, count) if loading.sampled else (0, 0)
    if not lag:
        return loading, {}
    turn = _refined(value, 2.0 * np.pi * periods / lag)
    # Of a period there are four samples a turn of the highest harmonic at least.
    for harmonics in range(1, min(lag // (4 * periods), SHORTEST) + 1):
        columns = _columns(count, turn, harmonics)
        basis = np.linalg.qr(columns)[0]
        smooth = basis @ (basis.T @ value)
        left = value - smooth
        if is_white(left):
            break
    else:
        return loading, {}
    noise = float(np.std(left))
    if noise <= max(rms(rounding_step(value)), NEGLIGIBLE * rms(smooth)):
        return loading, {}
    answer = basis @ (basis.T @ response)
    stiffness = float(np.std(answer)) / max(float(np.std(smooth)), SMALLEST)
    # What stays uncertain of the motion has to be less than what the response itself leaves open.
    unsure = stiffness * noise * np.sqrt(columns.shape[1] / count)
    if unsure > rms(response - answer) or goes_with(response - answer, left, stiffness):
        return loading, {}
    return replace(loading, value=smooth), taken_off("steady", left, smooth)


def taken_off(how: str, left: Real, course: Real, noise: str = "white noise") -> dict[str, str]:
    """The note on the noise (n,) that was taken off a course (n,)."""
    share = 100.0 * float(np.std(left)) / rms(course)
    return {"motion": f"{how}, with {share:.2g} % of {noise} that nothing answers to: taken off"}


def still(clock: Real, imposed: Real, response: Real) -> tuple[Real, dict[str, str]]:
    """What was held at levels (n,), without white noise that nothing answers to, and a note on it.

    As `quiet` does of what swings: a play or a bearing's friction would swallow that noise.

    Examples
    --------
    >>> t, noise = np.arange(400) / 100.0, np.random.default_rng(1).normal(size=(2, 400))
    >>> read = 1.0 + 0.01 * noise[0]
    >>> held, _ = still(t, read, 2.0 - np.exp(-t) + 0.01 * noise[1])
    >>> float(np.ptp(held)), float(held[0].round(2))
    (0.0, 1.0)
    >>> still(t, read, 2.0 * read - np.exp(-t))[0] is read
    True
    """
    level, parts = levels(imposed)
    return without_noise(clock, imposed, response, level, parts, "held")


def without_noise(
    clock: Real, imposed: Real, response: Real, course: Real, parts: Sequence[slice], how: str
) -> tuple[Real, dict[str, str]]:
    """A course (n,) for what was imposed, if nothing answers to what that has beside it."""
    left = imposed - course
    # What swings by half of the whole from sample to sample is held nowhere, and no line.
    told = rms(rounding_step(imposed)) < rms(left) < 0.5 * rms(course)
    if told and share_held(parts, len(course)) >= NEARLY_ALL:
        rest = np.zeros(len(course))
        for part in parts:
            rest[part] = _beside_creep(response[part])
        if not goes_with(rest, left, rms(response) / rms(course)):
            return _bridged(clock, imposed, course, parts), taken_off(how, left, course)
    return imposed, {}


def _bridged(clock: Real, value: Real, course: Real, parts: Sequence[slice]) -> Real:
    """A course (n,) of lines with those too short to be told by themselves between them.

    Where one neighbour goes on until the other begins, or a line of their own, leaves no more of
    the few samples there than the noise that the long ones told.
    """
    noise = float(np.mean(np.concatenate([(value - course)[part] for part in parts]) ** 2))
    course, nowhere = course.copy(), slice(0, 0)
    for one, other in pairwise([nowhere, *parts, slice(len(value), len(value))]):
        gap, count = slice(one.stop, other.start), other.start - one.stop
        known = [_onwards(clock[part], course[part], clock[gap]) for part in (one, other)]
        ways = [np.where(np.arange(count) < k, *known) for k in range(count + 1)]
        # The long ones may reach a little further than they were told to.
        for first, last in product(range(3), range(count - 2, count + 1)):
            if last - first > 2:
                own, t = slice(first, last), clock[gap][first:last]
                way, line = np.where(np.arange(count) < last, *known), np.vander(t, 2)
                way[own] = line @ np.linalg.lstsq(line, value[gap][own], rcond=None)[0]
                ways.append(way)
        left = [float(np.sum((value[gap] - way) ** 2)) for way in ways]
        best = int(np.nanargmin(left))
        ratio = left[best] / max(noise * count, SMALLEST)
        if f_sf(ratio, max(count, 1), len(value)) >= SIGNALS.ruled_out:
            course[gap] = ways[best]
    return course


def _onwards(clock: Real, line: Real, t: Real) -> Real:
    """What a straight line (n,) comes to at other times (m,); of none no numbers."""
    if not len(clock):
        return np.full(len(t), np.nan)
    rate = (line[-1] - line[0]) / (clock[-1] - clock[0])
    return np.asarray(line[0] + rate * (t - clock[0]))


def _beside_creep(answer: Real) -> Real:
    """What an answer to a step (n,) has beside polynomials of the time and of its logarithm."""
    place, degree = np.arange(len(answer)), min(SHORTEST, len(answer) // SHORTEST)
    clocks = [2.0 * clock / clock[-1] - 1.0 for clock in (place, np.log1p(place))]
    columns = [np.polynomial.legendre.legvander(clock, degree)[:, 1:] for clock in clocks]
    basis = np.linalg.qr(np.column_stack([np.ones(len(answer)), *columns]))[0]
    return answer - basis @ (basis.T @ answer)


def _columns(count: int, turn: float, harmonics: int) -> Real:
    """A level, a drift and the harmonics of a motion that goes by `turn` a sample, (n, p)."""
    place = np.arange(count) - 0.5 * (count - 1)
    angles = np.outer(turn * place, np.arange(1, harmonics + 1))
    return np.column_stack([np.ones(count), place / count, np.cos(angles), np.sin(angles)])


def _refined(value: Real, turn: float) -> float:
    """The angle a sample by which the first harmonic of a motion (n,) fits best (Gauss-Newton)."""
    count = len(value)
    place = np.arange(count) - 0.5 * (count - 1)
    for _ in range(SHORTEST):
        columns = _columns(count, turn, 1)
        along, across = np.linalg.lstsq(columns, value, rcond=None)[0][2:]
        slope = place * (across * columns[:, 2] - along * columns[:, 3])
        step = np.linalg.lstsq(np.column_stack([columns, slope]), value, rcond=None)[0][-1]
        turn += float(step)
    return turn


def goes_with(rest: Real, left: Real, stiffness: float) -> bool:
    """Whether a response without its harmonics goes with what a motion has beside its own.

    Beyond chance, and by half of what the specimen's stiffness would answer to it at least.
    """
    basis = np.linalg.qr(np.column_stack([left[:-2], left[1:-1], left[2:]]))[0]
    own = rest[1:-1]
    followed = float(np.sum((basis.T @ own) ** 2))
    if followed < (0.5 * stiffness) ** 2 * float(left @ left):
        return False
    spare = len(own) - 3
    ratio = followed / 3.0 / max((float(own @ own) - followed) / spare, SMALLEST)
    return bool(f_sf(ratio, 3, spare) < SIGNALS.ruled_out)
