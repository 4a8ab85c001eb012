"""Clocks of the material: it ages, or it is not yet as warm as it will be."""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.measurement import TimeTest
from springpot.rheology import (
    PURE,
    AppliesTo,
    Effect,
    Parameter,
    StageLaw,
    on_clock,
    relaxation_time,
)

from .record import WARMING

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


EFFECTS = (
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
