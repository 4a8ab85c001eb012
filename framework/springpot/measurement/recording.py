"""What a test in time records of a model, with exact derivatives by the parameters.

`predicted` is the answer of the specimen to the loading; `recorded` adds what the test itself did,
stage after stage: loading, clock and record. Where the temperature moves, shifts follow it in
reduced time, sample by sample.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.errors import ModelError
from springpot.rheology.effect import Effect, acting, on_clock, on_loading, on_response
from springpot.rheology.intime import Traced
from springpot.rheology.model import InTime, Model, sorted_out
from springpot.rheology.motion import velocity
from springpot.rheology.named import NamedNetwork, Placed
from springpot.rheology.nodes import Composing, Node
from springpot.rheology.points import KELVIN, ROOM, Real

from ..numerics import DIFFERENCE, NEGLIGIBLE, ROUNDING, SMALLEST
from .imposed import Loading
from .timenoise import without_scatter
from .timetest import TimeTest


def warming(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None,
    at: Real | None,
    tolerance: float,
    loading: Loading | None = None,
) -> Traced:
    """The response of a model to the loading of a test whose temperature moved.

    `loading` is what reached the specimen, where that is another. The other parameters and the
    returns are those of `predicted`; the temperature is straight between samples and held before
    and after them, and the reference is its mean by default.

    Raises
    ------
    ModelError
        If something else than a shift feels the temperature.
    """
    assert test.warmth is not None
    assert test.kelvin is not None
    if at is None:
        at = test.time
    if loading is None:
        loading = test.loading
    if reference is None:
        reference = test.kelvin
    # All samples take part, whichever are asked for: between them the temperature may turn.
    asked, motion = np.union1d(test.time, at), loading.motion
    if motion is not None:
        motion = motion.at(asked)
        grid, imposed = motion.time, motion.value
    else:
        # A history in reduced time is one value at each time: a step becomes a very short ramp.
        loading = _gradual(loading, test.time)
        grid = np.union1d(loading.time, asked)
        imposed = np.interp(grid, loading.time, loading.value)
    kelvin = np.interp(grid, test.time, test.warmth) + KELVIN
    inside = model.in_time(
        theta, temperature=kelvin, reference_temperature=reference, tolerance=tolerance
    )
    if test.control == "displacement":
        answer = inside.respond(grid, imposed, motion)
    else:
        answer = inside.respond_force(grid, imposed, motion)
    rows = np.searchsorted(grid, at)
    return Traced(answer.value[rows], answer.by_theta[rows])


def _gradual(loading: Loading, samples: Real) -> Loading:
    """The loading with ramps in place of its steps."""
    time = loading.time.copy()
    for i in np.flatnonzero(np.diff(time) == 0.0):
        later = np.concatenate([samples[samples > time[i]], time[time > time[i]]])
        wait = 1.0
        if len(later):
            wait = float(later.min()) - time[i]
        time[i + 1] += NEGLIGIBLE * wait
    return Loading(time, loading.value)


def predicted(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None = None,
    at: Real | None = None,
    tolerance: float = NEGLIGIBLE,
) -> Traced:
    """The response of a model to the loading of a test.

    Parameters
    ----------
    model : Model
        Any model whose parts have a meaning in time; for effects of the test itself see `recorded`.
    theta : ndarray, shape (p,)
        Its parameters, in the units of the test.
    test : TimeTest
        What is imposed, on which side, at which temperature.
    reference : float, optional
        Temperature in kelvin at which shifts are one; that of the test by default.
    at : ndarray, shape (m,), optional
        Rising times in s; those of the test by default.
    tolerance : float
        Relative error of K.

    Returns
    -------
    Traced
        Response (m,) and its derivatives (m, p).

    Raises
    ------
    ModelError
        If an effect of the model has no law in time, or not for a step that takes no time.

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.timetests import predicted
    >>> model = springpot.parse_model("maxwell")
    >>> test = springpot.TimeTest.of_relaxation([1.0, 4.0], [1.0, 1.0], "kPa")
    >>> predicted(model, model.theta(k=2.0, c=8.0), test).value.round(3)
    array([1.558, 0.736])
    """
    if test.warmth is not None and "temperature" in model.needs:
        return warming(model, theta, test, reference, at, tolerance)
    if at is None:
        at = test.time
    inside = specimen(model, theta, test, reference, tolerance)
    return answer(inside, test.loading, at, test.control)


def specimen(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None,
    tolerance: float = NEGLIGIBLE,
) -> InTime:
    """A model with its parameters at the temperature of a test."""
    if reference is None:
        reference = test.kelvin
    # A model that no temperature moves takes any reference.
    if reference is None:
        reference = ROOM
    return model.in_time(
        theta, temperature=test.kelvin, reference_temperature=reference, tolerance=tolerance
    )


def answer(inside: InTime, loading: Loading, t: Real, control: str) -> Traced:
    """The response to a loading at the times t, with jumps and all."""
    value, by_theta = np.zeros(len(t)), np.zeros((len(t), len(inside.theta)))
    when, sizes = loading.jumps
    if len(when):
        since = t[:, None] - when
        after = since >= 0.0
        # A jump has no rate of change: its answer is the creep or the relaxation function itself.
        step_answer = inside.creep
        if control == "displacement":
            step_answer = inside.relaxation
        # All jumps at once: the spectrum of the material is read once.
        one = step_answer(since[after])
        rows, which = np.nonzero(after)
        np.add.at(value, rows, sizes[which] * one.value)
        np.add.at(by_theta, rows, sizes[which, None] * one.by_theta)
    smooth = loading.smooth
    if smooth is not None:
        rest = _to_smooth(inside, smooth, t, control)
        value, by_theta = value + rest.value, by_theta + rest.by_theta
    return Traced(value, by_theta)


def _to_smooth(inside: InTime, loading: Loading, t: Real, control: str) -> Traced:
    """The response to a loading without jumps at the times t, which need not be its knots."""
    motion = loading.motion
    if motion is not None:
        motion = motion.at(t)
        grid, imposed = motion.time, motion.value
    else:
        grid = np.union1d(loading.time, t)
        if len(grid) < 2:
            # A history has two samples at the least.
            grid = np.append(grid, grid[-1] + 1.0)
        imposed = np.interp(grid, loading.time, loading.value)
    if control == "displacement":
        whole = inside.respond(grid, imposed, motion)
    else:
        whole = inside.respond_force(grid, imposed, motion)
    place = np.searchsorted(grid, t)
    return Traced(whole.value[place], whole.by_theta[place])


def recorded(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None = None,
    at: Real | None = None,
    tolerance: float = NEGLIGIBLE,
) -> Traced:
    """What a test records of a model and of what the test itself did; see `predicted`.

    Parameters
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its parameters, in the units of the test.
    test, reference, at, tolerance
        As in `predicted`.

    Returns
    -------
    Traced
        What is recorded (m,), and its derivatives (m, p): exact, but where a model that is not
        linear feels a changed loading. Effects that this test cannot have change nothing in it.

    Raises
    ------
    ModelError
        As in `predicted`; also if something does not go by the clock of its material, such as a
        mass, or if an effect is to turn that clock while a moving temperature does.

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.timetests import recorded
    >>> model = springpot.parse_model("maxwell + force-drift")
    >>> test = springpot.TimeTest.of_relaxation([1.0, 4.0], [1.0, 1.0], "kPa")
    >>> recorded(model, np.array([2.0, 8.0, 0.1]), test).value.round(3)
    array([1.658, 1.136])
    """
    t = at
    if t is None:
        t = test.time
    there, places = model.had_by(test)
    traced = _recorded(there, theta[places], test, reference, t, tolerance)
    return spread(traced, places, len(theta))


def spread(traced: Traced, places: Sequence[int], count: int) -> Traced:
    """The same by all parameters: those that a test knows nothing of change nothing in it."""
    if len(places) == count:
        return traced
    by_theta = np.zeros((len(traced.value), count))
    by_theta[:, places] = traced.by_theta
    return Traced(traced.value, by_theta)


def _recorded(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None,
    t: Real,
    tolerance: float,
) -> Traced:
    """The same of a model all of whose effects the test has."""
    mine, eased = at_work(model, test)
    if not mine:
        return predicted(model, theta, test, reference, t, tolerance)
    if test.warmth is not None and "temperature" in model.needs:
        traced = _while_it_warms(model, mine, theta, test, reference, t, tolerance)
    else:
        inside = replace(specimen(model, theta, test, reference, tolerance), eased=eased)
        traced = _answered(inside, mine, theta, test, t)
    return shown(mine, theta, Record.of(test, t), *traced)


def _while_it_warms(
    model: Model,
    mine: Sequence[Placed],
    theta: Real,
    test: TimeTest,
    reference: float | None,
    t: Real,
    tolerance: float,
) -> Traced:
    """What the specimen answers while its temperature moves.

    As `_answered`, without effects of the clock.

    Which of two effects turns the clock first, the temperature or the other, no test of one course
    can tell.
    """
    for effect, _, _ in at_stage(mine, on_clock):
        raise ModelError(
            f"{test.name}: '{effect.name}' turns the material's clock, which the moving temperature"
            " turns already: leave it out, or name one temperature for the test"
        )
    loading, slopes = reached(mine, theta, test, t)

    def respond(imposed: Loading) -> Traced:
        return warming(model, theta, test, reference, t, tolerance, imposed)

    traced = respond(loading)
    linear = not slopes or specimen(model, theta, test, reference, tolerance).linear
    for index, slope in zip(indices(at_loading(mine)), slopes, strict=True):
        traced.by_theta[:, index] = _by_loading(
            lambda imposed: respond(imposed).value, linear, loading, slope
        )
    return traced


def shown(
    mine: Sequence[Placed],
    theta: Real,
    record: Record,
    value: Real,
    by_theta: Real,
) -> Traced:
    """What is recorded of a response (n,) whose derivatives (n, p) are known."""
    for effect, _, own in at_stage(mine, on_response):
        value, columns, by_response = acting(effect.element, theta[own], record, value)
        if by_response.ndim == 1:
            by_theta = by_theta * by_response[:, None]
        else:
            by_theta = by_response @ by_theta
        for i, column in zip(own, columns, strict=True):
            by_theta[:, i] = column
    return Traced(value, by_theta)


def at_work(model: NamedNetwork, test: TimeTest) -> tuple[list[Placed], bool]:
    """What the test itself did, and what is taken off an imposed force; whether anything is.

    Where a specimen goes under a force that does not act on its material alone is an equation at
    each instant; but where it went was measured, and there a force beside the material is known.
    """
    mine = [each for each in model.placed if each.effect.of_test]
    if not is_eased(test):
        return mine, False
    beside = sorted_out(model)[1]
    return [*mine, *beside], bool(beside)


def is_eased(test: TimeTest) -> bool:
    """Whether it tells at each instant where an imposed force led, and how it came there."""
    loading = test.loading
    known = test.measured and test.warmth is None and not loading.is_cycled
    return known and test.control == "force" and not len(loading.jumps[0])


def at_loading(mine: Sequence[Placed]) -> list[Placed]:
    """The effects that change what reaches the material: a force beside it does, too."""
    return [
        each for each in mine if each.effect.composition == on_loading or not each.effect.of_test
    ]


def at_stage(mine: Sequence[Placed], stage: Composing) -> list[Placed]:
    """The effects of one stage."""
    return [each for each in mine if each.effect.composition == stage]


def indices(effects: Sequence[Placed]) -> list[int]:
    """Where the parameters of effects stand in theta."""
    return [i for each in effects for i in each.own]


def _answered(
    inside: InTime, mine: Sequence[Placed], theta: Real, test: TimeTest, t: Real
) -> Traced:
    """What the specimen answers, and its derivatives by all but the stage of the response."""
    loading, slopes = reached(mine, theta, test, t)
    clock = Clock(at_stage(mine, on_clock), theta, test.start)
    turned, here = loading, t
    # A clock that nothing turns is left out: it would only add a knot to the loading for each
    # sample.
    if clock.effects:
        turned, here = clock.turned(loading, t), clock.at(t)
        slopes = [clock.turned(slope, t) for slope in slopes]
    traced = answer(inside, turned, here, test.control)
    for index, slope in zip(indices(at_loading(mine)), slopes, strict=True):
        column = _by_loading(
            lambda imposed: answer(inside, imposed, here, test.control).value,
            inside.linear,
            turned,
            slope,
        )
        # At the very corner of a ramp the slope of a springpot's answer is endless; no other sample
        # is touched.
        traced.by_theta[:, index] = np.where(np.isfinite(column), column, 0.0)
    if clock.effects:
        columns = _by_clock(inside, loading, clock, t, test.control)
        traced.by_theta[:, indices(at_stage(mine, on_clock))] = columns
    return traced


def reached(
    mine: Sequence[Placed], theta: Real, test: TimeTest, t: Real
) -> tuple[Loading, list[Loading]]:
    """What reached the specimen, and its derivative by each parameter at that stage."""
    effects = at_loading(mine)
    if not effects:
        return test.loading, []
    loading = dense(test.loading, t)
    slopes: list[Loading] = []
    for effect, _, place in effects:
        values = theta[place]
        before = loading
        if not effect.of_test:
            loading, own = _eased(before, effect, values, test)
            slopes += own
            continue
        loading, own = acting(effect.element, values, before)
        # What an inner effect changed goes on through the outer one: by a difference, for few laws
        # are linear.
        slopes = [_carried(effect.element, values, before, slope) for slope in slopes]
        slopes += own
    return loading, slopes


def _eased(
    loading: Loading, effect: Effect, values: Real, test: TimeTest
) -> tuple[Loading, list[Loading]]:
    """What a force beside the material leaves of the imposed one, and its derivatives."""
    t = loading.time
    # Not as it was measured: a force that feels a sample's own error would answer it, and near a
    # turn of the force by as much, so that nothing would be left of the noise.
    place = without_scatter(test)
    moved = np.interp(t, test.time, place)
    # Before the first sample it came there from rest, as the force did.
    if t[0] < test.time[0] and loading.value[0] == 0.0:
        moved = np.interp(t, [t[0], *test.time], [0.0, *place])
    force, slopes = effect.element.in_time(t, moved, velocity(t, moved), *values)  # type: ignore[attr-defined]
    own = [
        Loading(t, -np.broadcast_to(slope, t.shape), sampled=loading.sampled) for slope in slopes
    ]
    return replace(loading, value=loading.value - force), own


def _carried(law: Node, values: Real, before: Loading, slope: Loading) -> Loading:
    width, moved = _either_way(before, slope)
    more, less = (acting(law, values, each)[0] for each in moved)
    return Loading(more.time, (more.value - less.value) / width)


def _either_way(loading: Loading, slope: Loading) -> tuple[float, list[Loading]]:
    """A loading with a little more and a little less of its change, and how much apart they are."""
    # Relative to the load itself: a step of any fixed size would be rounding in one unit and a leap
    # in another. Where nothing is left of the load, as behind a slack that takes all of it, to the
    # change.
    change_of_all = max(float(np.abs(slope.value).max()), SMALLEST)
    size = DIFFERENCE * (float(np.abs(loading.value).max()) or change_of_all) / change_of_all
    times = np.union1d(loading.time, slope.time)
    there, change = (np.interp(times, each.time, each.value) for each in (loading, slope))
    return 2.0 * size, [Loading(times, there + sign * size * change) for sign in (1.0, -1.0)]


def dense(loading: Loading, t: Real) -> Loading:
    """The same loading with a knot at each of the times t.

    So that a law may bend it between its own knots.
    """
    smooth = loading.smooth
    if smooth is None:
        # Of steps alone: between its knots there is nothing that a law could bend.
        return loading
    times = np.union1d(smooth.time, t)
    if smooth.motion is None:
        return with_jumps(times, np.interp(times, smooth.time, smooth.value), *loading.jumps)
    whole = smooth.motion.at(t)
    value = whole.value[np.searchsorted(whole.time, times)]
    return replace(with_jumps(times, value, *loading.jumps), sampled=True)


def with_jumps(time: Real, value: Real, when: Real, sizes: Real) -> Loading:
    """A loading of a smooth part and of jumps."""
    if not len(when):
        return Loading(time, value)
    knots = np.union1d(time, when)
    followed = np.interp(knots, time, value)
    before = followed + (knots[:, None] > when).astype(float) @ sizes
    after = followed + (knots[:, None] >= when).astype(float) @ sizes
    jumping = np.isin(knots, when)
    # Stable, so that what was before a jump stays before it.
    order = np.argsort(np.concatenate([knots, knots[jumping]]), kind="stable")
    return Loading(
        np.concatenate([knots, knots[jumping]])[order],
        np.concatenate([before, after[jumping]])[order],
    )


def _by_loading(
    respond: Callable[[Loading], Real], linear: bool, loading: Loading, slope: Loading
) -> Real:
    """How the response changes with the loading.

    That to the change itself, as long as all is linear.
    """
    if linear:
        return respond(slope)
    width, moved = _either_way(loading, slope)
    more, less = map(respond, moved)
    return np.asarray((more - less) / width)


class Clock:
    """Time by the material's clock, which effects may have turned."""

    def __init__(self, effects: Sequence[Placed], theta: Real, start: float) -> None:
        self.effects, self.theta, self.start = list(effects), theta, start

    def at(self, t: Real) -> Real:
        """Time (n,) by that clock at the times t."""
        return self.with_slopes(t)[0]

    def with_slopes(self, t: Real) -> tuple[Real, Real]:
        """The same, and its derivatives (n, q) by the effects' parameters.

        Before the load moved it is the wall's.
        """
        since = t - self.start
        after = since > 0.0
        here, slopes = np.maximum(since, 0.0), np.zeros((len(t), 0))
        for effect, _, place in self.effects:
            values = self.theta[place]
            turned, own = acting(effect.element, values, here)
            columns = [np.broadcast_to(column, t.shape) for column in own]
            # An inner clock's slopes run at the pace of the outer one.
            if slopes.shape[1]:
                slopes = slopes * _pace(effect.element, values, here)[:, None]
            slopes = np.column_stack([slopes, *columns])
            here = turned
        if not np.all(np.isfinite(here)):
            raise ModelError(f"{self.effects[-1].effect.name}: a clock that stands still or leaps")
        return self.start + np.where(after, here, since), np.where(after[:, None], slopes, 0.0)

    def turned(self, loading: Loading, t: Real) -> Loading:
        """A loading by that clock."""
        knots = dense(loading, t)
        return replace(knots, time=self.at(knots.time))


def _pace(law: Node, values: Real, here: Real) -> Real:
    """How fast an outer clock runs, by the inner one."""
    step = DIFFERENCE * np.maximum(here, DIFFERENCE)
    more, less = (acting(law, values, here + sign * step)[0] for sign in (1.0, -1.0))
    pace: Real = (more - less) / (2.0 * step)
    return pace


def _by_clock(inside: InTime, loading: Loading, clock: Clock, t: Real, control: str) -> Real:
    """Derivatives (n, q) of the response by the parameters of the clock."""
    # Jumps and the rest apart: the answer to a jump has its derivative in closed form, the rest a
    # complex step.
    here, moves = clock.with_slopes(t)
    derivatives = np.zeros(moves.shape)
    # A clock that is turned brings the answer to a jump sooner, by its rate there.
    for when, size in zip(*loading.jumps, strict=True):
        there, moved = clock.with_slopes(np.array([when]))
        since = here - there
        after = since > 0.0
        rate = inside.step_rate(since[after], control)
        derivatives[after] += size * rate[:, None] * (moves[after] - moved)
    smooth = loading.smooth
    if smooth is not None and len(np.union1d(smooth.time, t)) > 1:
        grid = np.union1d(smooth.time, t)
        turned, own = clock.with_slopes(grid)
        imposed = np.interp(grid, smooth.time, smooth.value)
        # The end of a ramp beside a sample, nearer than a clock can tell, is one instant.
        apart = np.concatenate([[True], np.diff(turned) > ROUNDING * np.ptp(turned)])
        whole = inside.by_clock(turned[apart], imposed[apart], control, own[apart])
        derivatives += whole[(np.cumsum(apart) - 1)[np.searchsorted(grid, t)]]
    return derivatives


@dataclass(frozen=True, eq=False)
class Record:
    """What a law is told about a test, at each of its samples.

    Attributes
    ----------
    time : ndarray, shape (n,)
        In s since the load first moved; nothing happens before, when it is negative.
    imposed, rate : ndarray, shape (n,)
        What was imposed, and its change per second; steps that take no time have none.
    largest : float
        Largest size of what was imposed.
    cycles : ndarray, shape (n,)
        The way that was gone until each sample, in cycles: the whole span there and back each.
    control : {"displacement", "force"}
        Which of the two that was.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import TimeTest
    >>> from springpot.measurement import Record
    >>> test = TimeTest.of_relaxation([0.5, 1.0], [3.0, 2.0])
    >>> Record.of(test, test.time).imposed
    array([1., 1.])
    """

    time: Real
    imposed: Real
    rate: Real
    largest: float
    cycles: Real
    control: str

    @classmethod
    def of(cls, test: TimeTest, at: Real | None = None) -> Record:
        """That of a test, at its own samples or at the times `at` (n,)."""
        t = test.time
        if at is not None:
            t = at
        imposed, rate = followed(test.loading, t)
        largest = float(np.abs(test.loading.value).max())
        # By the knots of the loading, so that it does not matter how many samples are looked at.
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(test.loading.value)))])
        # Of a load on one side a cycle goes there and back once, not twice.
        span = float(np.ptp(test.loading.value)) or largest
        # Those before the record have been; it counts its own.
        way -= way[test.loading.before]
        cycles = np.interp(t, test.loading.time, way) / (2.0 * span)
        return cls(t - test.start, imposed, rate, largest, cycles, test.control)


def followed(loading: Loading, t: Real) -> tuple[Real, Real]:
    """What a loading is at the times t (n,), and how fast it changes there.

    A step is over at its own instant.
    """
    times, sizes = loading.jumps
    # Steps are added by hand, as interpolation knows no two values at one time.
    value = (t[:, None] >= times).astype(float) @ sizes
    smooth = loading.smooth
    if smooth is None:
        return value, np.zeros(len(t))
    if len(smooth.time) < 2:
        return value + smooth.value[0], np.zeros(len(t))
    return value + np.interp(t, smooth.time, smooth.value), _rate(smooth, t)


def _rate(smooth: Loading, t: Real) -> Real:
    """Change per second between samples.

    At a knot the mean of both sides, and nothing beyond the ends.
    """
    slope = np.diff(smooth.value) / np.diff(smooth.time)
    # Before the first knot and after the last one everything rests.
    after = np.concatenate([[0.0], slope, [0.0]])
    left = after[np.searchsorted(smooth.time, t, side="left")]
    right = after[np.searchsorted(smooth.time, t, side="right")]
    rate: Real = 0.5 * (left + right)
    return rate
