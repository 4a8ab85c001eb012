"""Columns that stand in each other's place, and channels that count the other way.

Of a linear passive material K = K_e + i omega c + integral of H(r) i omega / (i omega + r) d ln r
with H >= 0 (the Kramers-Kronig relations and positive work in one), so that a course of storage has
its own course of loss. Columns that no such material could have, but one could if they were
exchanged, were named the wrong way round. A specimen that gives work away, or pulls when pushed,
has a channel of the wrong sign.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from shlex import split
from typing import TypeVar

import numpy as np

from springpot.distributions import autocorrelation_time
from springpot.numerics import BEYOND, COARSE, PER_DECADE, evenly, non_negative
from springpot.rheology.points import STEADY, Complex, Real, real_form
from springpot.thresholds import SIGNALS

from .measurement import Measurement
from .mixed_tests import sweeps_of
from .timetest import TimeTest

Turned = TypeVar("Turned")
EXCHANGED = "note exchange"
"""Key of the note in a measurement's provenance."""
FEWEST_POINTS = 5
"""With fewer points nearly any pair of curves is that of some material."""
LEAST_RANGE = 5.0
"""Ratio of highest and lowest frequency.

Over less, both curves are straight lines and tell little of each other.
"""
MOST_DECADES = 20.0
"""Of frequencies and of |K|.

No instrument and no master curve has more, and a spectrum over hundreds of decades
would take seconds at each opening."""
MOST_ROWS = 10_000
"""Larger tables are written by programs, which mix up no columns, and finding their sweeps would
take time.
"""
BACK = 0.1
"""Share by which a test goes back under a load that is held, from which a note says so."""
FAR = 0.1
"""Relative rms from which no material is near.

Measured sweeps that were named rightly lie at 0.001 to 0.2, exchanged
at 0.3 to 0.8, those of a springpot of order 1/2, whose two parts are alike, at 0.1."""
NEAR = 0.2
"""Share of that misfit which the exchanged columns may have left.

A mass or a delay takes a sweep far from every
material too, but exchanging its columns brings it no nearer (0.8 to 3 times of the misfit in all
data at hand).
"""


def exchange_note(measurement: Measurement) -> dict[str, str]:
    """A note where storage and loss look exchanged; empty otherwise.

    Parameters
    ----------
    measurement : Measurement
        The data; the sweep with the most points is looked at.
    """
    if len(measurement) > MOST_ROWS:
        return {}
    sweep = max(sweeps_of(measurement), key=lambda each: len(each.rows))
    rows = sweep.rows[evenly(len(sweep.rows), COARSE)]
    omega, stiffness = measurement.omega[rows], measurement.stiffness[rows]
    if len(np.unique(omega)) < FEWEST_POINTS or omega.max() < LEAST_RANGE * omega.min():
        return {}
    if max(decades(omega), decades(np.abs(stiffness))) > MOST_DECADES:
        return {}
    # Of what is left neither is near the end of what a number can be.
    omega, stiffness = omega / omega.max(), stiffness / np.abs(stiffness).max()
    # By an absolute bound first: sound data, which nearly all are, need no second fit.
    as_named = material_misfit(omega, stiffness)
    if as_named < FAR:
        return {}
    exchanged = material_misfit(omega, stiffness.imag + 1j * stiffness.real)
    if exchanged > NEAR * as_named:
        return {}
    return {
        EXCHANGED: (
            f"no material has such storage and loss ({100 * as_named:.0f} % off), but one has them"
            f" the other way round ({100 * exchanged:.1f} %): if the columns are exchanged, open"
            " 'FILE?storage=loss,loss=storage'"
        )
    }


def decades(positive: Real) -> float:
    """Powers of ten between the least and the largest of some positive numbers."""
    return float(np.log10(positive.max()) - np.log10(positive.min()))


def material_misfit(omega: Real, stiffness: Complex) -> float:
    """Relative rms distance of a sweep from the nearest linear passive material.

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Angular frequency in rad/s.
    stiffness : ndarray of complex, shape (n,)
        Complex stiffness or modulus; none zero.

    Returns
    -------
    float
        Root mean square of |K - K_material| / |K|.

    Examples
    --------
    >>> import numpy as np
    >>> omega = np.logspace(-1, 1, 9)
    >>> maxwell = 1j * omega / (1 + 1j * omega)
    >>> bool(material_misfit(omega, maxwell) < 0.01)
    True
    >>> bool(material_misfit(omega, maxwell.conj()) > 0.3)
    True
    """
    low, high = np.log10([omega.min() / BEYOND, omega.max() * BEYOND])
    rates = np.logspace(low, high, int(PER_DECADE * (high - low)) + 1)
    modes = 1j * omega[:, None] / (1j * omega[:, None] + rates)
    # Beside the spectrum a spring and a dashpot, its limits at infinitely low and high rates.
    basis = np.column_stack([np.ones_like(omega), 1j * omega / omega.max(), modes])
    # Relative at each point: a sweep over decades would else be judged at its stiff end alone.
    weighted = basis / np.abs(stiffness)[:, None]
    target = stiffness / np.abs(stiffness)
    _, left = non_negative(real_form(weighted), real_form(target))
    return float(np.sqrt(left / len(omega)))


SIGN = "note sign"
"""Where the doubt is kept among what is told of a test."""


def said_of_sign(provenance: Mapping[str, str]) -> list[str]:
    """What was noted of the sign when data were opened, as a list of one or none."""
    return [said for key, said in provenance.items() if key == SIGN]


def turned(provenance: Mapping[str, str]) -> str:
    """The data the right way round, where a channel counts the other way or two are exchanged.

    Empty for others.
    """
    said = provenance.get(SIGN) or provenance.get(EXCHANGED, "")
    return "".join(split(said.partition(", open ")[2]))


def wrong_way(provenance: Mapping[str, str]) -> str:
    """What of such data is the wrong way round: ``force``, ``phase`` or ``storage and loss``."""
    if SIGN not in provenance:
        return "storage and loss"
    return "phase" if "as if the phase" in provenance[SIGN] else "force"


def turned_over(test: Turned) -> Turned:
    """The same test, what it answers counting the other way; one of frequencies stays."""
    if not isinstance(test, TimeTest):
        return test
    told = {key: said for key, said in test.provenance.items() if key != SIGN}
    return replace(test, response=-test.response, provenance=told)


def sign_note(test: TimeTest, hint: str) -> dict[str, str]:
    """What to tell of a test in which force and displacement count in opposite directions.

    Nothing of another.

    Parameters
    ----------
    test : TimeTest
        Of any kind.
    hint : str
        What to say behind the file's name to turn one channel, such as ``force=-N``.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.mixed_up import sign_note
    >>> t = np.linspace(0.0, 1.0, 200)
    >>> test = TimeTest.of_history(t, np.sin(20 * t), -3.0 * np.sin(20 * t + 0.4), "mm", "N")
    >>> sign_note(test, "force=-N")["note sign"][:45]
    'the specimen gives work away, as if the force'
    """
    moved = np.interp(test.time, test.loading.time, test.loading.value)
    pulled = test.response
    if test.control == "force":
        moved, pulled = pulled, moved
    if test.kind == "history":
        turned, why = _gives_work(test.time, moved, pulled), "the specimen gives work away"
    else:
        # No cycle, over which work is counted: a push is answered by a push until it is taken
        # back. By how much, as what has relaxed to nothing is noise of either sign.
        size = np.abs(moved if test.control == "displacement" else pulled)
        until = 1 + int(np.flatnonzero(size >= (1.0 - STEADY) * size.max())[-1])
        turned = bool(np.sum((moved * pulled)[:until]) < 0.0)
        why = "force and displacement are opposed"
    if not turned:
        return {}
    turn = f"if one channel counts the other way, open 'FILE?{hint}'"
    return {SIGN: f"{why}, as if the force had the wrong sign: {turn}"}


def history_note(test: TimeTest) -> dict[str, str]:
    """A note where a test goes back though its load is held, as after a load that nobody tells of.

    The creep of any passive material only grows, and its relaxation only falls (Bernstein).

    Parameters
    ----------
    test : TimeTest
        Of any kind.
    """
    if not test.after_step:
        return {}
    size = test.response * np.sign(test.loading.value[np.argmax(np.abs(test.loading.value))])
    few = max(1, len(size) // 10)
    first, last = float(np.mean(size[:few])), float(np.mean(size[-few:]))
    if not first > 0.0:
        return {}
    moved, held, went, back = "stress", "strain", "grows", last / first - 1.0
    if test.control == "force":
        moved, held, went, back = "strain", "stress", "falls", 1.0 - last / first
    if back < BACK:
        return {}
    return {
        "note history": f"the {moved} {went} by {100.0 * back:.0f} % while the {held} is held,"
        " as after a load that the file does not tell of, or where the specimen changes: no"
        " material does that by itself; give the record from its rest on"
    }


def _gives_work(time: Real, moved: Real, pulled: Real) -> bool:
    """Whether the force surely goes against the velocity, and not surely with the displacement.

    Above a resonance the storage is negative, and with a late channel the loss; with the wrong sign
    no part is left.
    """
    if np.any(np.diff(time) <= 0.0):
        return False
    columns = np.stack([np.ones_like(moved), moved, np.gradient(moved, time)], axis=1)
    size = np.abs(columns).max(axis=0)
    if not np.all(size > 0.0):
        return False
    amounts, _, rank, _ = np.linalg.lstsq(columns / size, pulled, rcond=None)
    if rank < columns.shape[1]:
        return False
    rest = pulled - (columns / size) @ amounts
    # What is left of a record is alike from sample to sample: it holds fewer than it seems.
    power = float(np.mean(rest**2)) * autocorrelation_time(rest)
    inverse = np.linalg.inv((columns / size).T @ (columns / size))
    sd = np.sqrt(np.diag(inverse) * power)
    stiffness, damping = amounts[1:] / np.maximum(sd[1:], np.finfo(float).tiny)
    return bool(damping < -SIGNALS.negative and stiffness < SIGNALS.negative)
