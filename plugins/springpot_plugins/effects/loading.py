"""What was imposed is not what reached the specimen.

A step that took time, play in a joint, a bearing that holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from springpot.measurement import Loading, TimeTest
from springpot.measurement.steady_start import rise_is_presumed
from springpot.rheology import (
    AMPLITUDE,
    FORCE,
    PURE,
    AppliesTo,
    Dimension,
    Effect,
    Parameter,
    Real,
    StageLaw,
    on_loading,
    relaxation_time,
)
from springpot.rheology.points import STEADY

ELEMENTARY = "elementary"
FEWEST = 21
"""Samples of an imposed history from which play in it is looked for."""
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Shares of the way up to which a specimen may hang loose, where the search begins."""


LEAST_LEFT = 1e-3
"""Share of the life of a specimen that the last knot of its load leaves."""
KNOTS = 257
"""Of a load that grows until then: straight lines between them are within 2e-4 of it."""
GROWTHS = (1.0, 4.0, 16.0)
"""Exponents at the largest strain at which stiffening is sought: tissue comes to ten and more."""


def ramped(loading: Loading, tau: Any) -> tuple[Loading, tuple[Loading]]:
    """Each step as a ramp of tau seconds; the derivative by tau is a ramp down and a jump back.

    A ramp that was said, and not recorded, takes tau seconds more.
    """
    # Only jumps become ramps: what was recorded in between is followed as it was.
    when, sizes = loading.jumps
    if len(when) == 0:
        return lengthened(loading, tau)
    smooth = loading.smooth
    corners = [when, when + tau]
    if smooth is not None:
        corners.append(smooth.time)
    time = np.unique(np.concatenate(corners))
    share = np.clip((time[:, None] - when) / tau, 0.0, 1.0)
    rest: Real | float = 0.0
    if smooth is not None:
        rest = np.interp(time, smooth.time, smooth.value)
    bent = Loading(time, rest + share @ sizes)
    ends = np.stack([when, when + tau, when + tau], axis=1).ravel()
    back = np.stack([0.0 * sizes, -sizes / tau, 0.0 * sizes], axis=1).ravel()
    order = np.argsort(ends, kind="stable")
    if len(when) == 1:
        # Ramps of several steps may overlap, those of one do not.
        return bent, (Loading(ends[order], back[order]),)
    return bent, (_summed(when, -sizes / tau, tau),)


def _up(loading: Loading) -> tuple[float, float, Real, int]:
    """When an even rise began and how long it took, its values at both ends, and its last knot."""
    rates = (loading.value[1:] - loading.value[0]) / (loading.time[1:] - loading.time[0])
    uneven = np.flatnonzero(~np.isclose(rates, rates[0], atol=0.0))
    last = int(uneven[0]) if len(uneven) else len(rates)
    begin = float(loading.time[0])
    return begin, float(loading.time[last]) - begin, loading.value[[0, last]], last


def lengthened(loading: Loading, more: Any) -> tuple[Loading, tuple[Loading]]:
    """A ramp up that took some time more than was said, up to what was held from then on."""
    begin, long, ends, _ = _up(loading)
    over = begin + long + more
    later = loading.time > over
    slow = Loading(
        np.concatenate([[begin, over], loading.time[later]]),
        np.concatenate([ends, loading.value[later]]),
    )
    depth = -(ends[1] - ends[0]) / (long + more)
    return slow, (Loading(np.array([begin, over, over]), np.array([0.0, depth, 0.0])),)


def sooner(loading: Loading, share: Any) -> tuple[Loading, tuple[Loading]]:
    """A ramp up that was over sooner, by a share of its time."""
    begin, long, ends, last = _up(loading)
    over = begin + (1.0 - share) * long
    quick = Loading(
        np.concatenate([[begin, over], loading.time[last:]]),
        np.concatenate([ends, loading.value[last:]]),
    )
    # Until it is over it is the higher the sooner that is: a ramp up that jumps back.
    height = (ends[1] - ends[0]) / (1.0 - share)
    return quick, (Loading(np.array([begin, over, over]), np.array([0.0, height, 0.0])),)


def _summed(when: Real, depths: Real, tau: float) -> Loading:
    """The sum of ramps from nothing to `depths` in tau seconds that then jump back, one a step."""
    time = np.repeat(np.unique(np.concatenate([when, when + tau])), 2)
    since = (time[:, None] - when) / tau
    after = np.arange(len(time)) % 2 == 1
    # At its own end a ramp is all there just before, and nothing just after.
    ends = np.isclose(since, 1.0, rtol=0.0, atol=1e-12)
    there = np.where(ends, ~after[:, None], (since > 0.0) & (since < 1.0))
    return Loading(time, (np.where(there, since, 0.0)) @ depths)


def held_back(loading: Loading, reach: Any) -> tuple[Loading, tuple[Loading]]:
    """What follows a value at a distance of at most `reach`, as the far end of a joint's play."""
    x, behind, slope = loading.value, np.empty(len(loading.value)), np.zeros(len(loading.value))
    moves = np.sign(np.diff(x))
    turns = np.flatnonzero((moves[1:] != moves[:-1]) & (moves[1:] != 0.0)) + 1
    behind[0] = held = x[0]
    ends = [*turns, len(x) - 1]
    # Between two turns the load moves one way, so that no sample has to wait for the one before it.
    for first, last, (when, furthest) in zip(
        [0, *turns], ends, _turned(loading, ends), strict=True
    ):
        run = slice(first + 1, last + 1)
        way = 1.0
        if x[last] < x[first]:
            way = -1.0
        pulled = way * x[run] - reach > way * held
        behind[run] = np.where(pulled, x[run] - way * reach, held)
        slope[run] = np.where(pulled, -way, slope[first])
        # It may turn between two samples, and pulls until it does.
        held = way * max(way * held, way * furthest - reach)
        if when < loading.time[last]:
            behind[last] = held
    return replace(loading, value=behind), (Loading(loading.time, slope),)


def _turned(loading: Loading, turns: Sequence[int]) -> list[tuple[float, float]]:
    """When a load turned about each of these samples, and at which value."""
    at, x = np.array(turns), loading.value
    if len(loading.jumps[0]) or loading.motion is None:
        return list(zip(loading.time[at].tolist(), x[at].tolist(), strict=True))
    ends = np.clip(at + np.array([[-1], [1]]), 0, len(x) - 1)
    near = np.linspace(loading.time[ends[0]], loading.time[ends[1]], 9)
    motion = loading.motion.at(near.ravel())
    first, last = np.searchsorted(motion.time, near[[0, -1]])[..., None]
    about = np.minimum(first + np.arange(np.max(last - first) + 1), last)
    way = np.sign(x[at] - x[at - 1])[:, None]
    most = np.argmax(way * motion.value[about], axis=1)[:, None]
    furthest = np.take_along_axis(about, most, axis=1)[:, 0]
    return list(zip(motion.time[furthest].tolist(), motion.value[furthest].tolist(), strict=True))


def stiffened(loading: Loading, rate: Any) -> tuple[Loading, tuple[Loading]]:
    """The elastic strain of a specimen whose stiffness grows as exp(rate times the strain)."""
    x, size = loading.value, np.abs(loading.value)
    with np.errstate(over="ignore", invalid="ignore"):
        felt, slope = x, 0.5 * x * size
        if rate != 0.0:
            felt = np.sign(x) * np.expm1(rate * size) / rate
            slope = (x * np.exp(rate * size) - felt) / rate
    return replace(loading, value=felt), (Loading(loading.time, slope),)


def slackened(loading: Loading, place: Any) -> tuple[Loading, tuple[Loading]]:
    """What stretches a specimen that hangs loose up to a place, to whichever side it goes."""
    x = loading.value
    taut = np.abs(x) > place
    stretched = np.where(taut, x - place * np.sign(x), 0.0)
    slope = Loading(loading.time, np.where(taut, -np.sign(x), 0.0))
    return replace(loading, value=stretched), (slope,)


def weakened(loading: Loading, rupture: Any, exponent: Any) -> tuple[Loading, tuple[Loading, ...]]:
    """The stress of what is still sound while a step of load is held, up to near its rupture.

    dD/dt = C / (1 - D)^n leaves 1 - D = (1 - t / rupture)^exponent, exponent = 1 / (n + 1).
    """
    when, sizes = loading.jumps
    left = np.geomspace(1.0, LEAST_LEFT, KNOTS)
    time = when[0] + rupture * np.concatenate([[0.0], 1.0 - left])
    grown = sizes[0] * np.concatenate([[0.0], left**-exponent])
    by_rupture = -exponent * grown[1:] * (1.0 - left) / left / rupture
    by_exponent = -grown[1:] * np.log(left)
    slopes = (Loading(time[1:], slope) for slope in (by_rupture, by_exponent))
    return Loading(time, grown), tuple(slopes)


def _held(test: TimeTest) -> bool:
    """Whether the load is one step from nothing that is held."""
    return len(test.loading.jumps[0]) == 1 and test.loading.smooth is None


def _rises(test: TimeTest) -> list[tuple[float]]:
    """Rises in s from which to look further: most steps were over before the first sample."""
    clock = test.time - test.start
    first, last = float(np.min(clock[clock > 0.0])), float(np.max(clock))
    return [(float(rise),) for rise in np.geomspace(0.1 * first, last, 9)]


def _ruptures(test: TimeTest) -> list[tuple[float, float]]:
    """Times and exponents from which to look further."""
    last = float(test.time[-1] - test.start)
    return [(beyond * last, exponent) for beyond in (1.05, 1.5) for exponent in (0.1, 0.4)]


def _sooner(_: TimeTest) -> list[tuple[float]]:
    return [(share,) for share in (0.5, 0.99)]


def _said(test: TimeTest) -> bool:
    """Whether a step is taken to have risen evenly, as was said or presumed, not as recorded."""
    loading = test.loading
    if test.kind not in ("relaxation", "creep") or loading.sampled or len(loading.time) < 2:
        return False
    return bool(loading.value[0] == 0.0 and loading.time[0] < loading.time[1])


def _risen(test: TimeTest) -> bool:
    """The same, or a record has nothing of the rise but what was there before and after."""
    loading = test.loading
    if _said(test) or _stepped(test) or not loading.sampled or len(loading.time) < FEWEST:
        return _said(test)
    first, second, third = loading.value[:3]
    return bool(first == 0.0 and abs(third - second) <= STEADY * abs(second) > 0.0)


def _stepped(test: TimeTest) -> bool:
    return len(test.loading.jumps[0]) > 0


def _seen_held(test: TimeTest) -> bool:
    """Whether a transducer saw it held at the first sample, until which it is presumed to rise.

    What stands still to the last digit is the target, which does not tell when it was reached.
    """
    if not rise_is_presumed(test.loading, test.kind, test.time[0]):
        return False
    return "motion" in test.provenance or bool(np.ptp(test.loading.value[1:]) > 0.0)


def _stepped_or_said(test: TimeTest) -> bool:
    return _stepped(test) or (_said(test) and not _seen_held(test))


def _returns(test: TimeTest) -> bool:
    """Whether the load turns back: while it only rises, one that is held back is a smaller one."""
    moves = np.sign(np.diff(test.loading.value))
    return bool(np.any(moves > 0.0) and np.any(moves < 0.0))


def _rough(test: TimeTest) -> bool:
    return not _stepped(test) and len(test.loading.time) >= FEWEST and _returns(test)


def _followed(test: TimeTest) -> bool:
    """Whether the load passes through many values, not only that of a step."""
    return not _stepped(test) and len(test.time) >= FEWEST


def _growths(test: TimeTest) -> tuple[tuple[float], ...]:
    largest = float(np.abs(test.loading.value).max())
    return tuple((growth / largest,) for growth in GROWTHS)


def _loose(test: TimeTest) -> tuple[tuple[float], ...]:
    size = np.abs(test.loading.value)
    return tuple((float(size.min() + share * np.ptp(size)),) for share in SHARES)


EFFECTS = (
    Effect(
        "finite-ramp",
        on_loading,
        StageLaw(ramped, (relaxation_time("rise"),), _rises),
        "the step was no step: it took some time, in a straight line, or more than was said",
        citation="Boltzmann's superposition; Zapas and Phillips 1971, doi:10.6028/jres.075A.005",
        applies_to=AppliesTo(suits=_stepped_or_said),
        signature="early, up to some ten times the rise: a relaxation begins lower, a creep later",
        aliases=("slow-step",),
    ),
    Effect(
        "sudden-step",
        on_loading,
        StageLaw(
            sooner,
            (Parameter("share", "e", PURE, 0.0, 1.0 - LEAST_LEFT, "linear", 0.9),),
            _sooner,
        ),
        "the step was over sooner than was said, or than the first sample, until which it was taken"
        " to have risen: '?ramp=0[s]' behind the file makes it a step",
        citation="Boltzmann's superposition; Zapas and Phillips 1971, doi:10.6028/jres.075A.005",
        applies_to=AppliesTo(suits=_risen),
        signature="early, up to some ten times the first sample: a relaxation begins lower, a creep"
        " higher",
        aliases=("quick-step",),
    ),
    Effect(
        "backlash-in-time",
        on_loading,
        StageLaw(held_back, (Parameter("b", "b", AMPLITUDE, typical=0.3),)),
        "a joint with play of b on either side: after each turn the specimen rests until the play"
        " is taken up",
        citation="Visintin, Differential Models of Hysteresis, 1994",
        applies_to=AppliesTo(("displacement",), _rough),
        signature="flat pieces after each turn of the motion, and a smaller loop",
        aliases=("play-in-time",),
    ),
    Effect(
        "bearing-friction",
        on_loading,
        StageLaw(held_back, (Parameter("F", "F", FORCE, typical=0.1),)),
        "the bearing holds up to a force F: what was imposed reaches the specimen less that",
        citation="Coulomb's friction; the specimen follows its load without overshoot",
        applies_to=AppliesTo(("force",), _returns),
        signature="after the load is taken off, the specimen comes back less, and stops early",
    ),
    Effect(
        "creep-damage",
        on_loading,
        StageLaw(
            weakened,
            (
                relaxation_time("rupture", "t_r"),
                Parameter("exponent", "p", PURE, 0.0, 1.0, "linear", 0.25),
            ),
            _ruptures,
        ),
        "the specimen cracks under the load it carries: what is still sound bears ever more, until"
        " it breaks at the time t_r",
        citation="Kachanov 1958; Rabotnov, Creep Problems in Structural Members, 1969",
        applies_to=AppliesTo(("force",), _held),
        signature="a creep that slows down at first, and late grows ever faster",
        aliases=("tertiary-creep",),
        absent_at=np.inf,
    ),
    Effect(
        "strain-stiffening",
        on_loading,
        StageLaw(
            stiffened,
            (Parameter("B", "B", Dimension(amplitude=-1), 0.0, scale="linear", typical=0.5),),
            _growths,
        ),
        "the specimen stiffens as it is stretched: what relaxes is an exponential of the strain, as"
        " of tissue",
        citation="Fung, Biomechanics, 1993: quasi-linear viscoelasticity",
        applies_to=AppliesTo(("displacement",), _followed),
        signature="a toe, then ever steeper; the same relaxation at any strain",
        aliases=("quasi-linear",),
    ),
    Effect(
        "slack",
        on_loading,
        StageLaw(slackened, (Parameter("place", "x_0", AMPLITUDE, typical=0.3),), _loose),
        "the specimen hangs loose at first, or has free play: it feels the motion only beyond a"
        " place",
        citation=ELEMENTARY,
        applies_to=AppliesTo(("displacement",), _followed),
        signature="nothing up to a place, to either side, then the response as from there",
        aliases=("free-play",),
        prior=0.5,
    ),
)
