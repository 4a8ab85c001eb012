"""What a test records of a model that has effects of time tests.

Loading, clock and record, stage after stage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.imposed import Loading
from springpot.measurement.timed import Timed
from springpot.measurement.timeeffect import Record, Stage, TimeEffect
from springpot.measurement.timetest import TimeTest
from springpot.rheology.history import InTime
from springpot.rheology.intime import Traced
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .response import TOLERANCE, answer, predicted, specimen
from .warming import warming

STEP = 1e-6
"""Relative step of the one derivative that is a difference.

Of what is not linear, by a changed loading.
"""


def recorded(
    model: Model | Timed,
    theta: Real,
    test: TimeTest,
    reference: float | None = None,
    at: Real | None = None,
    tolerance: float = TOLERANCE,
) -> Traced:
    """What a test records of a model, with or without effects of time tests; see `predicted`.

    Parameters
    ----------
    model : Model or Timed
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
    >>> from springpot.measurement import Timed
    >>> from springpot.timetests import recorded
    >>> drift = springpot.plugins().find("time effect", "force-drift")
    >>> model = Timed(springpot.parse_model("maxwell"), (drift,))
    >>> test = springpot.TimeTest.of_relaxation([1.0, 4.0], [1.0, 1.0], "kPa")
    >>> recorded(model, np.array([2.0, 8.0, 0.1]), test).value.round(3)
    array([1.658, 1.136])
    """
    if not isinstance(model, Timed):
        return predicted(model, theta, test, reference, at, tolerance)
    t = at
    if t is None:
        t = test.time
    own, placed = model.parts(theta)
    mine = [(effect, place) for effect, place in placed if effect.is_for(test)]
    if test.warmth is not None and "temperature" in model.needs:
        traced = _while_it_warms(model, own, mine, theta, test, reference, t, tolerance)
    else:
        inside = specimen(model.material, own, test, reference, tolerance)
        traced = _answered(inside, mine, theta, test, t)
    # Effects that this test cannot have change nothing in it: their columns stay nothing.
    by_theta = np.zeros((len(t), len(theta)))
    by_theta[:, : len(own)] = traced.by_theta[:, : len(own)]
    for k, index in enumerate(indices(mine, Stage.LOADING) + indices(mine, Stage.CLOCK)):
        by_theta[:, index] = traced.by_theta[:, len(own) + k]
    return shown(mine, theta, Record.of(test, t), traced.value, by_theta)


def _while_it_warms(
    model: Timed,
    own: Real,
    mine: Sequence[tuple[TimeEffect, slice]],
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
    for effect, _ in at_stage(mine, Stage.CLOCK):
        raise ModelError(
            f"{test.name}: '{effect.name}' turns the material's clock, which the moving temperature"
            " turns already: leave it out, or name one temperature for the test"
        )
    loading, slopes = reached(mine, theta, test, t)

    def respond(imposed: Loading) -> Traced:
        return warming(model.material, own, test, reference, t, tolerance, imposed)

    traced = respond(loading)
    linear = not slopes or specimen(model.material, own, test, reference, tolerance).linear
    columns = [
        _by_loading(lambda imposed: respond(imposed).value, linear, loading, slope)
        for slope in slopes
    ]
    return Traced(traced.value, np.column_stack([traced.by_theta, *columns]))


def shown(
    mine: Sequence[tuple[TimeEffect, slice]],
    theta: Real,
    record: Record,
    value: Real,
    by_theta: Real,
) -> Traced:
    """What is recorded of a response (n,) whose derivatives (n, p) are known."""
    for effect, place in at_stage(mine, Stage.RESPONSE):
        output = effect.law(record, value, *theta[place])
        value, by_theta = output.value, by_theta * output.by_response[:, None]
        # A law may give one number for all samples.
        columns = [np.broadcast_to(column, value.shape) for column in output.by_parameters]
        by_theta[:, place] = np.column_stack(columns)
    return Traced(value, by_theta)


def at_stage(
    mine: Sequence[tuple[TimeEffect, slice]], stage: Stage
) -> list[tuple[TimeEffect, slice]]:
    """The effects of one stage, with the places of their parameters."""
    return [(effect, place) for effect, place in mine if effect.stage is stage]


def indices(mine: Sequence[tuple[TimeEffect, slice]], stage: Stage) -> list[int]:
    """Where the parameters of the effects of one stage stand in theta."""
    numbers: list[int] = []
    for _, place in at_stage(mine, stage):
        numbers += range(place.start, place.stop)
    return numbers


def _answered(
    inside: InTime, mine: Sequence[tuple[TimeEffect, slice]], theta: Real, test: TimeTest, t: Real
) -> Traced:
    """What the specimen answers.

    Derivatives by its own parameters, then by those of loading and of clock.
    """
    loading, slopes = reached(mine, theta, test, t)
    clock = Clock(at_stage(mine, Stage.CLOCK), theta, test.start)
    turned, here = loading, t
    # A clock that nothing turns is left out: it would only add a knot to the loading for each
    # sample.
    if clock.effects:
        turned, here = clock.turned(loading, t), clock.at(t)
        slopes = [clock.turned(slope, t) for slope in slopes]
    traced = answer(inside, turned, here, test.control)
    columns = [traced.by_theta]
    for slope in slopes:
        column = _by_loading(
            lambda imposed: answer(inside, imposed, here, test.control).value,
            inside.linear,
            turned,
            slope,
        )
        # At the very corner of a ramp the slope of a springpot's answer is endless; no other sample
        # is touched.
        columns.append(np.where(np.isfinite(column), column, 0.0)[:, None])
    if clock.effects:
        columns.append(_by_clock(inside, loading, clock, t, test.control))
    return Traced(traced.value, np.column_stack(columns))


def reached(
    mine: Sequence[tuple[TimeEffect, slice]], theta: Real, test: TimeTest, t: Real
) -> tuple[Loading, list[Loading]]:
    """What reached the specimen, and its derivative by each parameter at that stage."""
    effects = at_stage(mine, Stage.LOADING)
    if not effects:
        return test.loading, []
    loading = dense(test.loading, t)
    slopes: list[Loading] = []
    for effect, place in effects:
        values = theta[place]
        before = loading
        loading, own = effect.law(before, *values)
        # What an inner effect changed goes on through the outer one: by a difference, for few laws
        # are linear.
        slopes = [_carried(effect, values, before, slope) for slope in slopes]
        slopes += list(own)
    return loading, slopes


def _carried(effect: TimeEffect, values: Real, before: Loading, slope: Loading) -> Loading:
    # Relative to the load itself: a step of any fixed size would be rounding in one unit and a leap
    # in another.
    size = STEP * np.abs(before.value).max() / max(float(np.abs(slope.value).max()), 1e-300)
    times = np.union1d(before.time, slope.time)
    ends = []
    for sign in (1.0, -1.0):
        moved = np.interp(times, before.time, before.value) + sign * size * np.interp(
            times, slope.time, slope.value
        )
        ends.append(effect.law(Loading(times, moved), *values)[0])
    return Loading(ends[0].time, (ends[0].value - ends[1].value) / (2.0 * size))


def dense(loading: Loading, t: Real) -> Loading:
    """The same loading with a knot at each of the times t.

    So that a law may bend it between its own knots.
    """
    smooth = loading.smooth
    if smooth is None:
        # Of steps alone: between its knots there is nothing that a law could bend.
        return loading
    times = np.union1d(smooth.time, t)
    return with_jumps(times, np.interp(times, smooth.time, smooth.value), *loading.jumps)


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
    size = STEP * np.abs(loading.value).max() / max(float(np.abs(slope.value).max()), 1e-300)
    times = np.union1d(loading.time, slope.time)
    there, change = (np.interp(times, each.time, each.value) for each in (loading, slope))
    more, less = (respond(Loading(times, there + sign * size * change)) for sign in (1.0, -1.0))
    rate: Real = (more - less) / (2.0 * size)
    return rate


class Clock:
    """Time by the material's clock, which effects may have turned."""

    def __init__(
        self, effects: Sequence[tuple[TimeEffect, slice]], theta: Real, start: float
    ) -> None:
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
        for effect, place in self.effects:
            turned, own = effect.law(here, *self.theta[place])
            columns = np.column_stack([np.broadcast_to(column, t.shape) for column in own])
            # An inner clock's slopes run at the pace of the outer one.
            if slopes.shape[1]:
                slopes = slopes * _pace(effect, here, self.theta[place])[:, None]
            slopes = np.column_stack([slopes, columns])
            here = turned
        return self.start + np.where(after, here, since), np.where(after[:, None], slopes, 0.0)

    def turned(self, loading: Loading, t: Real) -> Loading:
        """A loading by that clock."""
        knots = dense(loading, t)
        return replace(knots, time=self.at(knots.time))


def _pace(effect: TimeEffect, here: Real, values: Real) -> Real:
    """How fast an outer clock runs, by the inner one."""
    step = STEP * np.maximum(here, STEP)
    more, less = (effect.law(here + sign * step, *values)[0] for sign in (1.0, -1.0))
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
        whole = inside.by_clock(turned, np.interp(grid, smooth.time, smooth.value), control, own)
        derivatives += whole[np.searchsorted(grid, t)]
    return derivatives
