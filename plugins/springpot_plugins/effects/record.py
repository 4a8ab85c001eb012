"""The record is not the response, and the clock of the material is not ours.

Its zero is off or drifts, the fixture grows, the amplifier saturates, it tires; the material ages,
or it is not yet as warm as it will be.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.measurement import Record, TimeTest
from springpot.measurement.timenoise import strays
from springpot.rheology import (
    AMPLITUDE,
    FORCE,
    PURE,
    SECOND,
    Answered,
    AppliesTo,
    Dimension,
    Effect,
    Parameter,
    Real,
    StageLaw,
    on_clock,
    on_response,
    relaxation_time,
)

NEAR_TOP, SEVERAL = 0.95, 5
"""Share of the largest response, and samples above it, from which it is no single peak.

A limit would hold more.
"""
SHARES = (0.98, 0.95, 0.9, 0.8, 0.7, 0.5)
"""Shares of the largest response at which a limit is sought."""


def drifted(record: Record, response: Any, rate: Any) -> Answered:
    """The response and `rate` times the time since the load moved."""
    return Answered(response + rate * record.time, (record.time,), np.ones_like(response))


def offset(record: Record, response: Any, size: Any) -> Answered:
    """The response and a constant."""
    return Answered(response + size, (np.ones_like(response),), np.ones_like(response))


def scaled(record: Record, response: Any, gain: Any) -> Answered:
    """The response, larger by a share of itself."""
    return Answered((1.0 + gain) * response, (response,), np.full_like(response, 1.0 + gain))


def grown(record: Record, response: Any, size: Any, tau: Any) -> Answered:
    """The response and a fixture that grows by `size` while it comes to its temperature."""
    time = np.maximum(record.time, 0.0)
    left = np.exp(-time / tau)
    by_tau = -size * left * time / tau**2
    return Answered(response + size * (1.0 - left), (1.0 - left, by_tau), np.ones_like(response))


def faded(record: Record, response: Any, size: Any, tau: Any) -> Answered:
    """The response and what is left of an earlier one, which fades."""
    time = np.maximum(record.time, 0.0)
    left = np.exp(-time / tau)
    return Answered(
        response + size * left, (left, size * left * time / tau**2), np.ones_like(response)
    )


def clipped(record: Record, response: Any, limit: Any) -> Answered:
    """The response within a limit on either side."""
    # Where the limit cuts, the record follows it alone, and the specimen no more.
    inside = np.abs(response) < limit
    return Answered(
        np.clip(response, -limit, limit),
        (np.where(inside, 0.0, np.sign(response)),),
        inside.astype(float),
    )


def tired(record: Record, response: Any, damage: Any) -> Answered:
    """The response of a specimen that loses a share of its stiffness with every cycle."""
    way = record.cycles
    if record.control == "displacement":
        # Less stiff, it answers an imposed displacement with less force, an imposed force with more
        # displacement.
        way = -record.cycles
    left = np.exp(damage * way)
    return Answered(response * left, (response * left * way,), left)


def _sizes(test: TimeTest) -> Real:
    """Of the response, without single samples that stray beyond any limit."""
    return np.asarray(np.abs(np.delete(test.response, strays(test))))


def _limits(test: TimeTest) -> tuple[tuple[float], ...]:
    largest = float(_sizes(test).max())
    # A limit above all samples changes nothing and has no slope: the search could not come back
    # from there.
    return tuple((share * largest,) for share in SHARES)


def _cyclic(test: TimeTest) -> bool:
    """Whether there are two cycles or more."""
    return bool(Record.of(test).cycles[-1] >= 2.0)


def _repeated(test: TimeTest) -> bool:
    """Whether a specimen that was moved was moved again, or mostly held, stepped or pulled.

    What is stiffer or softer in the first loading leaves another force behind when it comes back,
    as what warms meanwhile does; only the next loading, of half a cycle, tells them apart, or a
    hold, in which time goes on and the way does not.
    """
    record = Record.of(test)
    held = not np.median(np.abs(np.diff(record.imposed))) > 0.0
    return test.kind != "history" or held or bool(record.cycles[-1] >= 1.5)


def _begun(test: TimeTest) -> bool:
    """Whether the first sample finds it in motion, or not where it rests."""
    moved = test.loading.value
    if test.kind != "history" or test.loading.before or len(test.loading.jumps[0]):
        return False
    first, usual = abs(float(moved[1] - moved[0])), float(np.median(np.abs(np.diff(moved))))
    return first > AT_ONCE * usual or abs(float(moved[0])) > AT_ONCE * float(np.abs(moved).max())


def _beside_a_spring(test: TimeTest) -> bool:
    """Whether the load came back, or its rise was recorded over several samples.

    A constant beside what a step alone leaves would be a spring of another size, as long as no
    other test tells the spring.
    """
    if test.kind not in ("relaxation", "creep"):
        came_back = test.kind == "history" and bool(Record.of(test).cycles[-1] >= 1.0)
        # At a steady rate a spring's force grows, and a constant does not.
        return came_back or test.kind in ("recovery", "startup")
    size = np.abs(test.loading.value)
    below = np.count_nonzero(size < NEAR_TOP * size.max())
    return test.loading.sampled and bool(below >= SEVERAL)


def _level(test: TimeTest) -> bool:
    """Whether the largest responses are alike: several samples lie near the largest."""
    size = _sizes(test)
    return test.kind in ("history", "recovery", "startup") and bool(
        np.count_nonzero(size > NEAR_TOP * size.max()) >= SEVERAL
    )


QUICKEST = 1.0
"""Seconds within which no fixture comes to its temperature.

Steel of 0.1 mm in a strong draught takes
rho c d / h = 7800 * 500 * 1e-4 / 100 = 4 s. What is there sooner was there before, or is the start
of the rig.
"""
WARMING = Parameter("tau", "τ", SECOND, QUICKEST)

AT_ONCE = 0.1
"""Share of the usual step, or of the largest value, from which a first sample is no rest."""

FORCE_RATE = Dimension(stiffness=1, amplitude=1, time=-1)
AMPLITUDE_RATE = Dimension(amplitude=1, time=-1)
ELEMENTARY = "elementary"

EFFECTS = (
    Effect(
        "test-gain",
        on_response,
        StageLaw(scaled, (Parameter("g", "g", PURE, -0.99, scale="linear", typical=0.5),)),
        "this test is too large against the others of the specimen: a calibration, an area or a gap"
        " is wrong",
        citation=ELEMENTARY,
        apparatus=True,
        applies_to=AppliesTo(one=True),
        signature="the whole record by one factor; a test by itself cannot show it, as its material"
        " takes it over",
    ),
    Effect(
        "force-offset",
        on_response,
        StageLaw(offset, (Parameter("size", "F", FORCE, -np.inf, scale="linear"),)),
        "the force has a constant part: a preload, a gas charge, a weight, or the zero of the"
        " transducer",
        citation=ELEMENTARY,
        applies_to=AppliesTo(("displacement",), alone=_beside_a_spring),
        signature="the whole loop stands higher or lower, the same from the first sample to the"
        " last",
    ),
    Effect(
        "displacement-offset",
        on_response,
        StageLaw(offset, (Parameter("size", "u", AMPLITUDE, -np.inf, scale="linear"),)),
        "the displacement has a constant part: it is not counted from where the force vanishes",
        citation=ELEMENTARY,
        applies_to=AppliesTo(("force",), alone=_beside_a_spring),
        signature="the whole loop stands further on or back, the same from the first sample to the"
        " last",
    ),
    Effect(
        "force-drift",
        on_response,
        StageLaw(drifted, (Parameter("rate", "r", FORCE_RATE, -np.inf, scale="linear"),)),
        "the zero of the force transducer drifts at a steady rate",
        citation=ELEMENTARY,
        apparatus=True,
        applies_to=AppliesTo(("displacement",)),
        signature="a straight line in linear time, from the first sample to the last, whatever the"
        " load does",
    ),
    Effect(
        "displacement-drift",
        on_response,
        StageLaw(drifted, (Parameter("rate", "r", AMPLITUDE_RATE, -np.inf, scale="linear"),)),
        "the zero of the displacement transducer drifts at a steady rate",
        citation=ELEMENTARY,
        apparatus=True,
        applies_to=AppliesTo(("force",)),
        signature="a straight line in linear time, from the first sample to the last; in creep it"
        " looks like flow",
    ),
    Effect(
        "thermal-force",
        on_response,
        StageLaw(grown, (Parameter("size", "F", FORCE, -np.inf, scale="linear"), WARMING)),
        "fixture and specimen grow while they come to their temperature, and press on the"
        " transducer",
        citation="Newton's law of cooling; free thermal strain",
        apparatus=True,
        applies_to=AppliesTo(("displacement",), alone=_repeated),
        signature="a force that comes up within some tau and stays, whatever the load does",
        prior=0.5,
    ),
    Effect(
        "earlier-motion",
        on_response,
        StageLaw(
            faded,
            (
                Parameter("size", "F", FORCE, -np.inf, scale="linear"),
                relaxation_time("fading", "t_f"),
            ),
        ),
        "the specimen still remembers how it moved before the record began, and forgets it",
        citation="Boltzmann's superposition, of a history of which nothing is known",
        apparatus=True,
        applies_to=AppliesTo(("displacement",), _begun),
        signature="a force that is off at the first samples and fades within some tau",
    ),
    Effect(
        "earlier-load",
        on_response,
        StageLaw(
            faded,
            (
                Parameter("size", "u", AMPLITUDE, -np.inf, scale="linear"),
                relaxation_time("fading", "t_f"),
            ),
        ),
        "the specimen still creeps back from how it was loaded before the record began",
        citation="Boltzmann's superposition, of a history of which nothing is known",
        apparatus=True,
        applies_to=AppliesTo(("force",), _begun),
        signature="a displacement that is off at the first samples and fades within some tau",
    ),
    Effect(
        "thermal-growth",
        on_response,
        StageLaw(grown, (Parameter("size", "u", AMPLITUDE, -np.inf, scale="linear"), WARMING)),
        "fixture and specimen grow while they come to their temperature, and the transducer takes"
        " it for creep",
        citation="Newton's law of cooling; free thermal strain",
        apparatus=True,
        applies_to=AppliesTo(("force",), alone=_repeated),
        signature="a displacement that comes up within some tau and stays; it does not recover with"
        " the load",
        prior=0.5,
    ),
    Effect(
        "force-clipping",
        on_response,
        StageLaw(clipped, (Parameter("limit", "L", FORCE),), _limits),
        "the force channel saturates: it shows no more than a limit on either side",
        citation=ELEMENTARY,
        apparatus=True,
        applies_to=AppliesTo(("displacement",), _level),
        signature="flat tops of the force, where the loop is highest",
        absent_at=np.inf,
    ),
    Effect(
        "displacement-clipping",
        on_response,
        StageLaw(clipped, (Parameter("limit", "L", AMPLITUDE),), _limits),
        "the displacement channel saturates: it shows no more than a limit on either side",
        citation=ELEMENTARY,
        apparatus=True,
        applies_to=AppliesTo(("force",), _level),
        signature="flat tops of the displacement, where the loop is widest",
        absent_at=np.inf,
    ),
    Effect(
        "damage",
        on_response,
        StageLaw(tired, (Parameter("d", "d", PURE, -2.0, 2.0, "linear", 0.1),)),
        "the specimen loses the share d of its stiffness with every cycle it goes through",
        citation="Lemaitre and Desmorat, Engineering Damage Mechanics, 2005",
        applies_to=AppliesTo(suits=_cyclic),
        signature="loops that lean over from cycle to cycle, all alike in shape",
        aliases=("cyclic-softening",),
    ),
)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
"""Gauss's rule: integrates exp(-s exp(-u)) over one time constant to rounding for |s| up to 10."""


def aged(time: Any, mu: Any, waited: Any) -> Any:
    """Effective time, the integral of (t_w / (t_w + u))^mu du, and derivatives by mu and t_w."""
    long = np.log1p(time / waited)
    rest = 1.0 - mu
    # (exp(rest L) - 1) / rest and its derivative by rest, which have limits where rest is nothing.
    # There the next term of the series is below 1e-8, and the closed form a difference of nearly
    # equal terms.
    near = np.abs(rest * long) < 1e-4
    safe = np.where(near, 1.0, rest)
    grown = np.where(near, long * (1.0 + rest * long / 2.0), np.expm1(safe * long) / safe)
    closed = (long * np.exp(safe * long) - np.expm1(safe * long) / safe) / safe
    by_rest = np.where(near, long**2 * (0.5 + rest * long / 3.0), closed)
    by_waited = grown - np.exp(rest * long) * time / (waited + time)
    return waited * grown, (-waited * by_rest, by_waited)


def warming(time: Any, s: Any, tau: Any) -> Any:
    """Integral of exp(-s exp(-u / tau)) du and its derivatives.

    ln a_T = s exp(-t / tau) fades with the transient.

    In v = exp(-u / tau) it is tau times the integral of exp(-s v) / v dv, which is u itself and,
    without its pole, an entire function of s.
    """
    v = np.exp(-time / tau)
    x, share = 0.5 * (1.0 + NODES), 0.5 * WEIGHTS
    # From v to 1 by Gauss's rule on the smooth part, (exp(-s v) - 1) / v.
    at = v[..., None] + (1.0 - v)[..., None] * x
    smooth = np.expm1(-s * at) / at
    part = (1.0 - v) * (smooth @ share)
    by_s = -(1.0 - v) * (np.exp(-s * at) @ share)
    value = time + tau * part
    # d/dtau: of the factor, and of the lower end v.
    by_tau = part - np.expm1(-s * v) * time / tau
    return value, (tau * by_s, by_tau)


def at_another_pace(time: Any, s: Any) -> Any:
    """Time over the shift factor, ln a_T = s, and its derivative."""
    quick = time * np.exp(-s)
    return quick, (-quick,)


def _waits(test: TimeTest) -> list[tuple[float, float]]:
    """Exponents and waiting times from which to look further."""
    times = np.geomspace(3.0 / test.seen[1], 1.0 / test.seen[0], 5)
    return [(mu, float(waited)) for mu in (0.3, 0.8) for waited in times]


def _transients(test: TimeTest) -> list[tuple[float, float]]:
    """Sizes and times from which to look further."""
    times = np.geomspace(3.0 / test.seen[1], 0.3 / test.seen[0], 5)
    times = np.unique(np.maximum(times, WARMING.lower))
    return [(s, float(tau)) for s in (-3.0, -0.5, 0.5, 3.0) for tau in times]


def _paces(_: TimeTest) -> list[tuple[float]]:
    return [(s,) for s in (-3.0, -1.0, -0.3, 0.3, 1.0, 3.0)]


def _long(test: TimeTest) -> bool:
    """Whether there are two decades of time, or the clock is but a factor."""
    return test.seen[1] / test.seen[0] > 100.0


CLOCKS = (
    Effect(
        "ageing",
        on_clock,
        StageLaw(
            aged,
            (Parameter("mu", "μ", PURE, 0.0, 1.2, "linear", 0.5), relaxation_time("waited")),
            _waits,
        ),
        "the specimen ages during the test: its times grow as the power mu of the time since it was"
        " quenched",
        citation="Struik, Physical Aging in Amorphous Polymers and Other Materials, 1978",
        applies_to=AppliesTo(suits=_long),
        signature="nothing early; from the waiting time on the response lags more and more behind"
        " that of a ready specimen",
        aliases=("physical-ageing",),
    ),
    Effect(
        "thermal-transient",
        on_clock,
        StageLaw(
            warming,
            (Parameter("s", "s", PURE, -12.0, 12.0, "linear", 1.0), WARMING),
            _transients,
        ),
        "the specimen comes to its temperature while it is tested: ln a_T = s exp(-t / tau)",
        citation="reduced time, Morland and Lee 1960, doi:10.1122/1.548856",
        apparatus=True,
        applies_to=AppliesTo(suits=_long),
        signature="early the response is that of another temperature, from some tau on that of the"
        " set one",
    ),
    Effect(
        "test-shift",
        on_clock,
        StageLaw(
            at_another_pace,
            (Parameter("s", "s", PURE, -12.0, 12.0, "linear", 1.0),),
            _paces,
        ),
        "this test was made at another temperature or age than the others of the specimen: all its"
        " times by one factor, ln a_T = s",
        citation="reduced time, Morland and Lee 1960, doi:10.1122/1.548856",
        apparatus=True,
        applies_to=AppliesTo(one=True),
        signature="the whole response sooner or later by one factor; a test by itself cannot show"
        " it, as its material takes it over",
        aliases=("another-temperature",),
    ),
)
