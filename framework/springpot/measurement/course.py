"""What was imposed along straight lines, as ramps are, or smoothly, without its noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from math import comb, log, sqrt

import numpy as np

from springpot.distributions import LIKENESS, f_sf, prewhitened
from springpot.rheology.points import Real

from ..numerics import (
    DEVIATIONS,
    DIFFERENCE,
    ENOUGH,
    NEGLIGIBLE,
    SMALLEST,
    evenly,
    projected_out,
    rms,
)
from ..thresholds import SIGNALS
from .imposed import (
    NEARLY_ALL,
    ORDER,
    Loading,
    Unfelt,
    controlled,
    from_rest,
    imposed_noise,
    is_white,
    noise_of_smooth,
    since_nothing,
)
from .instrument import is_even, rounding_step
from .steady import SHORTEST
from .steady_start import goes_with, gone_on, quiet, stepped_to, still, taken_off, without_noise

FEWEST = 2 * SHORTEST
"""Samples at a level, at least, by which their noise is told from a course."""
BENDS, CLOSE, PARTS = 4, 0.02, 4
"""Differences of a course that are as good as noise: those that a mass feels are two less. How near
the likeliest memory and the logarithm of a weight are sought. Parts of a long record that tell how
far its knots are apart: to seek that in all of it would take longer than to read it.
"""


def control_of(clock: Real, moved: Real, pulled: Real) -> tuple[str, dict[str, str]]:
    """The channel (n,) that was imposed, and a note where that is less than plain.

    As `controlled` says, but of two that are noisy the force where it goes along fewer straight
    lines than the displacement does: what answers to a line is none.

    Examples
    --------
    >>> t, noise = np.arange(400) / 100.0, 0.01 * np.random.default_rng(1).normal(size=(2, 400))
    >>> control_of(t, t - 1.0 + np.exp(-t) + noise[0], t + noise[1])[0]
    'force'
    >>> control_of(t, t + noise[0], 1.0 - np.exp(-t) + noise[1])[0]
    'displacement'
    """
    control, notes = controlled(clock, moved, pulled)
    if control == "force" or len(clock) < SHORTEST or not (_is_noisy(moved) and _is_noisy(pulled)):
        return control, notes
    course, parts = lines(clock, pulled)
    # A search of a long record takes a tenth of a second: the second one only where it matters.
    if not parts or 0 < len(lines(clock, moved)[1]) <= len(parts):
        return control, notes
    # As large a bend as the displacement has there would have been hidden in the force's noise.
    bent = [_beside_line(clock[part], moved[part])[1] for part in parts]
    if rms(np.concatenate(bent)) * rms(pulled) <= rms(pulled - course) * rms(moved):
        return control, notes
    said = (
        "the force goes along straight lines and the displacement does not: the force is taken to"
        " have been imposed; '?control=displacement' behind the file says otherwise"
    )
    return "force", {"note control": said}


def _is_noisy(value: Real) -> bool:
    return imposed_noise(value) > rms(rounding_step(value))


def as_imposed(
    clock: Real, imposed: Real, rise: float | None, control: str, response: Real
) -> tuple[Loading, dict[str, str]]:
    """The loading that a recorded channel (n,) was, and a note on noise that it was not."""
    read = imposed
    imposed, said = still(clock, read, response)
    loading, noise = quiet(from_rest(clock, imposed, rise), response)
    if not noise:
        loading, noise = straightened(loading, response)
    if not noise:
        loading, noise = smoothed(loading, response)
    if loading.sampled:
        loading = stepped_to(gone_on(loading, response), control, response)
    return since_nothing(loading, read), said | noise


def straightened(loading: Loading, response: Real) -> tuple[Loading, dict[str, str]]:
    """A motion along straight lines without white noise that nothing answers to, and a note on it.

    As `quiet` does of what swings: a play would swallow that noise, and dry friction turn with it.

    Parameters
    ----------
    loading : Loading
        As it was recorded.
    response : ndarray, shape (n,)
        Of the same samples.

    Examples
    --------
    >>> t, noise = np.arange(400) / 100.0, np.random.default_rng(1).normal(size=(2, 400))
    >>> read = Loading(t, t + 0.01 * noise[0], sampled=True)
    >>> ramp, _ = straightened(read, 2.0 * t + 0.01 * noise[1])
    >>> float(np.abs(ramp.value - t).max().round(2))
    0.0
    """
    value = loading.value
    if not loading.sampled or len(value) < SHORTEST or not _is_noisy(value):
        return loading, {}
    course, parts = lines(loading.time, value)
    if not _stands_out(value, course, 2.0 * len(parts)):
        return loading, {}
    course, said = without_noise(
        loading.time, value, response, course, parts, "along straight lines"
    )
    if not said:
        return loading, {}
    return replace(loading, value=course), said


def _stands_out(value: Real, course: Real, numbers: float) -> bool:
    """Whether a course of so many numbers tells more of a channel (n,) than its mean does.

    Of few samples all is noise, and so is all of what does not move.
    """
    told, left = course - value.mean(), value - course
    spare = len(value) - numbers
    if not numbers or spare < 1:
        return False
    ratio = float(told @ told) / (numbers - 1) / max(float(left @ left) / spare, SMALLEST)
    return bool(f_sf(ratio, numbers - 1, spare) < SIGNALS.ruled_out)


def lines(clock: Real, value: Real) -> tuple[Real, list[slice]]:
    """A channel (n,) without white noise where it goes along straight lines, and where that is.

    Examples
    --------
    >>> t, noise = np.arange(80.0), 0.1 * np.random.default_rng(1).normal(size=80)
    >>> lines(t, np.minimum(t, 40.0) + noise)[1]
    [slice(0, 41, None), slice(41, 80, None)]
    >>> lines(t, 10.0 * np.sin(0.2 * t) + 0.01 * noise)[1]
    []
    """
    rows = evenly(len(value), ENOUGH)
    parts = _parts(clock[rows], value[rows])
    if len(rows) < len(value):
        parts = _of_all(
            clock, value, [slice(rows[part.start], rows[part.stop - 1] + 1) for part in parts]
        )
    course = value.copy()
    for part in parts:
        course[part] -= _beside_line(clock[part], value[part])[1]
    return course, parts


def _parts(clock: Real, value: Real) -> list[slice]:
    """Where a channel (n,) goes along straight lines; nowhere if for too little of it."""
    count, found = len(value), list[slice]()
    if count >= SHORTEST and _bend(clock, value) is not None:
        return [slice(0, count)]
    spare = (1.0 - NEARLY_ALL) * count
    for part in _likeliest(clock, value):
        if part.stop - part.start >= SHORTEST:
            if _bend(clock[part], value[part]) is None:
                return []
            found.append(part)
            continue
        spare -= part.stop - part.start
        if spare < 0.0:
            return []
    found = _joined(clock, value, found)
    bends = sum(_bend(clock[part], value[part]) or 0.0 for part in found)
    # Of many short lines each may hide a bend that all of them together show.
    if f_sf(bends / (2.0 * len(found)), 2 * len(found), count) < SIGNALS.ruled_out:
        return []
    return [] if _is_curve(clock, value, found) else found


def _is_curve(clock: Real, value: Real, parts: list[slice]) -> bool:
    """Whether a smooth curve of as many numbers follows a channel (n,) better than its lines do."""
    rows = np.concatenate([np.arange(part.start, part.stop) for part in parts])
    left = np.concatenate([_beside_line(clock[part], value[part])[1] for part in parts])
    place = (2.0 * clock[rows] - clock[0] - clock[-1]) / (clock[-1] - clock[0])
    # A slope and a level each, and where one ends and the next begins.
    curve = np.linalg.qr(np.polynomial.legendre.legvander(place, 3 * len(parts) - 2))[0]
    beside = value[rows] - curve @ (curve.T @ value[rows])
    return len(parts) > 1 and bool(beside @ beside < left @ left)


def _of_all(clock: Real, value: Real, parts: list[slice]) -> list[slice]:
    """The same lines of all samples (n,), told by some of them; none if one is bent after all."""
    told = [slice(part.start, part.stop) for part in parts]
    for i, other in enumerate(parts[1:]):
        # What is too short to be told lies between them.
        if parts[i].stop < other.start:
            continue
        both = slice(told[i].start, other.stop)
        at = both.start + _best_split(clock[both], value[both])
        told[i], told[i + 1] = slice(both.start, at), slice(at, other.stop)
    straight = all(_bend(clock[part], value[part]) is not None for part in told)
    return told if straight else []


def _beside_line(clock: Real, value: Real) -> tuple[Real, Real]:
    """What two more powers find in a channel (n,) beside its line, and what is left of that."""
    place = (2.0 * clock - clock[0] - clock[-1]) / (clock[-1] - clock[0])
    basis = np.linalg.qr(np.polynomial.legendre.legvander(place, 3))[0]
    weights = basis.T @ value
    return weights[2:], value - basis[:, :2] @ weights[:2]


def _bend(clock: Real, value: Real) -> float | None:
    """Power of two bends over that of the noise; None where it is no line and white noise."""
    bends, left = _beside_line(clock, value)
    spare = len(left) - 4
    noise = max((float(left @ left) - float(bends @ bends)) / spare, SMALLEST)
    power = float(bends @ bends) / noise
    if f_sf(power / 2.0, 2, spare) < SIGNALS.ruled_out or not is_white(left):
        return None
    return power


def _likeliest(clock: Real, value: Real) -> list[slice]:
    """The lines, one behind the other, of which a channel (n,) is likeliest.

    All cuts at once: of a triangle no two lines alone tell where one of its corners is. Each line
    costs its slope, its level and its end (Killick, Fearnhead & Eckley 2012,
    doi:10.1080/01621459.2012.737745).
    """
    # Corners are in few differences of the second order, and a course in none of the eighth.
    noise = min(imposed_noise(value, ORDER // 4), imposed_noise(value))
    count = len(value)
    price = 3.0 * np.log(count) * noise**2
    t, x = clock - clock.mean(), value - value.mean()
    sums = np.cumsum(np.pad([np.ones(count), t, x, t * t, t * x, x * x], ((0, 0), (1, 0))), axis=1)
    best, before = np.full(count + 1, -price), np.zeros(count + 1, dtype=np.intp)
    open_from = np.zeros(1, dtype=np.intp)
    for end in range(1, count + 1):
        n, of_t, of_x, of_tt, of_tx, of_xx = sums[:, [end]] - sums[:, open_from]
        along = np.maximum(of_tt - of_t**2 / n, SMALLEST)
        left = of_xx - of_x**2 / n - (of_tx - of_t * of_x / n) ** 2 / along
        cost = best[open_from] + np.maximum(left, 0.0)
        k = int(np.argmin(cost))
        best[end], before[end] = cost[k] + price, open_from[k]
        # What is dearer than a cut here, with what lies behind it, stays so.
        open_from = np.append(open_from[cost <= best[end]], end)
    ends = [count]
    while ends[-1]:
        ends.append(int(before[ends[-1]]))
    return [slice(*pair) for pair in pairwise(ends[::-1])]


def _best_split(clock: Real, value: Real) -> int:
    """Where two lines leave least of a channel (n,)."""
    left = _left_by_lines(clock, value)
    right = _left_by_lines(clock[::-1], value[::-1])[::-1]
    return 2 + int(np.argmin(left[1:-2] + right[2:-1]))


def _left_by_lines(clock: Real, value: Real) -> Real:
    """Squares that a line leaves of the first 1, 2, ... samples of a channel (n,)."""
    t, x = clock - clock.mean(), value - value.mean()
    count = np.arange(1.0, len(t) + 1.0)
    of_t, of_x = np.cumsum(t), np.cumsum(x)
    across = np.cumsum(t * x) - of_t * of_x / count
    along = np.maximum(np.cumsum(t**2) - of_t**2 / count, SMALLEST)
    return np.asarray(np.cumsum(x**2) - of_x**2 / count - across**2 / along)


def _joined(clock: Real, value: Real, parts: list[slice]) -> list[slice]:
    """Lines of which no two neighbours are one."""
    joined: list[slice] = []
    for part in parts:
        while joined and joined[-1].stop == part.start:
            both = slice(joined[-1].start, part.stop)
            if _bend(clock[both], value[both]) is None:
                break
            joined.pop()
            part = both
        joined.append(part)
    return joined


def smoothed(loading: Loading, response: Real) -> tuple[Loading, dict[str, str]]:
    """A motion that is smooth without noise that nothing answers to, and a note on it.

    White noise, or such as remembers the sample before.

    What is left is its expectation, given what was read: a fit to that is not bent by the noise, as
    one to what was read is (regression calibration: Carroll, Ruppert, Stefanski and Crainiceanu
    2006, Measurement Error in Nonlinear Models, chapter 4).

    Parameters
    ----------
    loading : Loading
        As it was recorded.
    response : ndarray, shape (n,)
        Of the same samples.

    Examples
    --------
    >>> t, noise = np.arange(400) / 100.0, np.random.default_rng(1).normal(size=(2, 400))
    >>> moved = np.sin(t**2)
    >>> read = Loading(t, moved + 0.01 * noise[0], sampled=True)
    >>> course, _ = smoothed(read, 2.0 * moved + 0.02 * noise[1])
    >>> float(np.std(course.value - moved).round(3))
    0.002
    """
    value = loading.value
    few = len(value) < SHORTEST * BENDS
    if few or not loading.sampled or loading.before or not is_even(loading.time):
        return loading, {}
    # Digits are noise as well.
    if imposed_noise(value) <= max(noise_of_smooth(value), NEGLIGIBLE * rms(value)):
        return loading, {}
    spline = _found(value)
    course, answer = spline.course(value), spline.course(response)
    if not (is_white(spline.left(value)) and _stands_out(value, course, spline.freedom)):
        return loading, {}
    left, rest = value - course, response - answer
    stiffness = float(np.std(answer)) / max(float(np.std(course)), SMALLEST)
    if goes_with(rest, left, stiffness):
        return loading, {}
    # Of noise with a memory that much more is where it is slow.
    slow = float(np.std(left)) * sqrt((1.0 + spline.memory) / (1.0 - spline.memory))
    noise = "noise with a memory" if spline.memory else "white noise"
    unfelt = Unfelt(slow, spline.freedom)
    return replace(loading, value=course, unfelt=unfelt), taken_off("smooth", left, course, noise)


def answer_to_unfelt(loading: Loading, clock: Real, response: Real) -> Real:
    """Variance (n,) of what is answered to the error of a smooth course, by its cosine transform.

    The course has that part of the noise which so many numbers follow. That is answered to as the
    response (m,) at some of its samples goes with place, speed and acceleration, also where the
    course itself is gone.
    """
    (noise, numbers), loading = loading.unfelt, loading.recorded
    course, inside = loading.value, loading.time[1:-1]
    turns = np.pi * np.arange(len(course)) / len(course)
    inner = course[1:-1]
    speed, push = 0.5 * (course[2:] - course[:-2]), course[2:] - 2.0 * inner + course[:-2]
    columns = np.column_stack([np.ones_like(inner), inner, speed, push])
    known, answered = columns[np.isin(inside, clock)], response[np.isin(clock, inside)]
    (_, spring, dashpot, mass), unsure = _regressed(known, answered)
    if mass < -DEVIATIONS * unsure:
        # What relaxes stiffens with the frequency, up to where the course moves and no further.
        _, spring, dashpot = _regressed(known[:, :3], answered)[0]
        mass, turns = 0.0, np.minimum(turns, float(np.std(push) / np.std(speed)))
    squares = (spring - mass * (2.0 - 2.0 * np.cos(turns))) ** 2 + (dashpot * np.sin(turns)) ** 2
    return np.asarray((noise * _passed(len(course), numbers)) ** 2 * squares, dtype=np.float64)


def _regressed(columns: Real, value: Real) -> tuple[Real, float]:
    """Amounts of columns (n, p) in values (n,), and the standard deviation of the last of them."""
    found = np.asarray(np.linalg.lstsq(columns, value, rcond=None)[0], dtype=np.float64)
    alone = projected_out(columns[:, -1], np.linalg.qr(columns[:, :-1])[0])
    spread = rms(value - columns @ found)
    return found, spread / max(float(np.linalg.norm(alone)), SMALLEST)


def followed(loading: Loading, noise: Real) -> Real:
    """What a course has of noise (n,) in the motion: all of what was not taken off.

    Examples
    --------
    >>> t, noise = np.arange(400.0), np.random.default_rng(1).normal(size=400)
    >>> float(np.std(followed(Loading(t, noise, unfelt=Unfelt(1.0, 40.0)), noise)).round(1))
    0.2
    """
    from scipy.fft import dct, idct

    if not loading.unfelt.noise:
        return noise
    passed = _passed(len(noise), loading.unfelt.numbers)
    return np.asarray(idct(passed * dct(noise, norm="ortho"), norm="ortho"))


def _passed(count: int, numbers: float) -> Real:
    """Share (n,) of a cosine transform that a spline of so many numbers follows."""
    return np.asarray(1.0 / (1.0 + (np.arange(count) / numbers) ** (2 * BENDS)))


@dataclass(frozen=True, eq=False)
class Spline:
    """A penalised spline of samples that are evenly apart.

    Its coefficients' differences are white noise, of the variance that samples have over `weight`
    (Eilers and Marx 1996, doi:10.1214/ss/1038425655).

    Parameters
    ----------
    count, apart : int
        Samples, and how many of them two knots are apart.
    weight : float
        Of the squares of the differences of its coefficients.
    memory : float
        Correlation of the noise of neighbouring samples.
    """

    count: int
    apart: int
    weight: float
    memory: float = 0.0

    @cached_property
    def _factor(self) -> Real:
        from scipy.linalg import cholesky_banded

        values, differences = _bands(self.count, self.apart, self.memory)
        return np.asarray(cholesky_banded(values + self.weight * differences, lower=True))

    def coefficients(self, value: Real) -> Real:
        """Those (p,) of values (n,)."""
        from scipy.linalg import cho_solve_banded

        here, beside = _weights(self.count, self.memory)
        told = here * value
        told[1:] += beside * value[:-1]
        told[:-1] += beside * value[1:]
        parts = _by_interval(told, self.apart) @ _shares(self.apart)
        sums = np.zeros(self._factor.shape[1])
        for k, part in enumerate(parts.T):
            sums[k : k + len(part)] += part
        return np.asarray(cho_solve_banded((self._factor, True), sums))

    def course(self, value: Real) -> Real:
        """The spline at the samples (n,), of values there."""
        return self._at_samples(self.coefficients(value))

    def _at_samples(self, coefficients: Real) -> Real:
        near = np.lib.stride_tricks.sliding_window_view(coefficients, 2 * BENDS)
        return np.asarray((near @ _shares(self.apart).T).ravel()[: self.count])

    def left(self, value: Real) -> Real:
        """What it leaves of values (n,) there, without what that remembers."""
        return np.asarray(prewhitened(value - self.course(value), self.memory))

    def improbability(self, value: Real) -> float:
        """Minus twice the logarithm of the likelihood of values (n,), but for a constant.

        Free of the polynomials that are not penalised (Patterson and Thompson 1971).
        """
        found, spare = self.coefficients(value), self.count - BENDS
        new = prewhitened(value - self._at_samples(found), self.memory)
        squares = float(new @ new) + self.weight * float(np.sum(np.diff(found, BENDS) ** 2))
        size = spare * log(max(squares, SMALLEST) / spare)
        size += 2.0 * float(np.sum(np.log(self._factor[0])))
        size += (self.count - 1) * log(1.0 - self.memory**2)
        return size - (len(found) - BENDS) * log(self.weight)

    @property
    def freedom(self) -> float:
        """Numbers that it is worth: the trace of what makes it of the values."""
        more = replace(self, weight=self.weight * (1.0 + DIFFERENCE))
        rise = 2.0 * float(np.sum(np.log(more._factor[0] / self._factor[0])))
        return float(self._factor.shape[1] - rise / DIFFERENCE)


@lru_cache(maxsize=8)
def _shares(apart: int) -> Real:
    """B-splines (apart, 2 BENDS) at the samples of each interval of knots."""
    from scipy.interpolate import BSpline

    count = 2 * BENDS
    knots = np.arange(1.0 - count, count + 1.0)
    return np.asarray(BSpline.design_matrix(np.arange(apart) / apart, knots, count - 1).todense())


def _by_interval(value: Real, apart: int) -> Real:
    """Values (n,) of which each row holds those of one interval; none beyond the last."""
    return np.pad(value, (0, -len(value) % apart)).reshape(-1, apart)


def _weights(count: int, memory: float) -> tuple[Real, float]:
    """Of the square of each of so many samples, and of the product of neighbours."""
    new = 1.0 / (1.0 - memory**2)
    here = np.full(count, (1.0 + memory**2) * new)
    here[[0, -1]] = new
    return here, -memory * new


@lru_cache(maxsize=1)
def _bands(count: int, apart: int, memory: float) -> Real:
    """Of squares of the values, and of the differences of coefficients, (2, 2 BENDS + 1, p)."""
    here, beside = _weights(count, memory)
    weights = [_by_interval(here, apart), _by_interval(np.full(count - 1, beside), apart)]
    intervals, order = len(weights[0]), 2 * BENDS
    # The next sample of the last one of an interval is in the next.
    now = np.pad(_shares(apart), ((0, 0), (0, 1)))
    after = np.roll(now, -1, axis=0)
    after[-1] = np.roll(now[0], 1)
    bands = np.zeros((2, order + 1, intervals + order))
    for i in range(order + 1):
        for k in range(order + 1 - i):
            squares = weights[0] @ (now[:, i] * now[:, i + k])
            products = weights[1] @ (now[:, i] * after[:, i + k] + after[:, i] * now[:, i + k])
            bands[0, k, i : i + intervals] += squares
            bands[0, k, i : i + len(products)] += products
    bands = bands[..., : intervals + order - 1]
    factors = [(-1.0) ** i * comb(BENDS, i) for i in range(BENDS + 1)]
    for i, one in enumerate(factors):
        for k, other in enumerate(factors[i:]):
            bands[1, k, i : bands.shape[-1] - BENDS + i] += one * other
    return bands


def likeliest(value: Real, memory: float = 0.0) -> Spline:
    """The spline of evenly sampled values (n,) by its likelihood, beside noise with a memory.

    Its knots are as far apart as the likeliest one follows anything.

    Examples
    --------
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=400)
    >>> round(likeliest(np.sin(np.arange(400) / 10.0) + noise).freedom)
    52
    """
    apart, far = 1, 2
    while far > 1:
        found = _weighed(value, apart, memory)
        # A weight goes with the distance of two knots to the power of what is penalised.
        far = int(found.weight ** (0.5 / BENDS))
        if BENDS * far * apart >= len(value):
            break
        apart *= far
    return found


def _found(value: Real) -> Spline:
    """The likeliest spline beside white noise, or beside such as has a memory if that is not white.

    Of a long record its parts tell how far knots are apart, and the memory.
    """
    if len(value) <= PARTS * ENOUGH:
        return _beside_any_noise(value)
    places = np.linspace(0, len(value) - ENOUGH, PARTS).astype(int).tolist()
    found = [_beside_any_noise(value[place : place + ENOUGH]) for place in places]
    memory = float(np.median([each.memory for each in found]))
    return _weighed(value, min(each.apart for each in found), memory)


def _beside_any_noise(value: Real) -> Spline:
    spline = likeliest(value)
    return spline if is_white(spline.left(value)) else likeliest(value, _memory_of(value))


def _weighed(value: Real, apart: int, memory: float) -> Spline:
    """The likeliest spline with knots so many samples apart."""
    from scipy.optimize import minimize_scalar

    best = minimize_scalar(
        lambda size: Spline(len(value), apart, np.exp(size), memory).improbability(value),
        bounds=(log(NEGLIGIBLE), -log(NEGLIGIBLE)),
        method="bounded",
        options={"xatol": CLOSE},
    )
    return Spline(len(value), apart, float(np.exp(best.x)), memory)


def _memory_of(value: Real) -> float:
    """The likeliest memory of the noise of a smooth channel (n,); of a long one, of its middle."""
    from scipy.optimize import minimize_scalar

    first = max(len(value) - ENOUGH, 0) // 2
    some = value[first : first + ENOUGH]
    best = minimize_scalar(
        lambda memory: _weighed(some, 1, memory).improbability(some),
        bounds=(0.0, LIKENESS),
        method="bounded",
        options={"xatol": CLOSE},
    )
    return float(best.x)
