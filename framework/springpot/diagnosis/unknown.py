"""What might be missing that no effect of the library explains: patterns in general, and faults of a measuring chain.

Each kind is a linear family of changes of K. A pattern with few shapes that explains all (a gain that creeps) is more
credible than an effect of the library that explains most.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from springpot.measurement import CONDITIONS
from springpot.rheology import Complex, Real

from .frame import Frame

CREEP = 3
"""Degree of the polynomials by which a gain or a phase may change over the measurement."""
FEWEST_LEVELS = 3
"""Levels of a condition from which a gain of its own at each is no other name for a trend."""
POINTS_OF_EACH = 4
"""Points of each level at least, so that the levels do not follow the noise."""
MOST_STEPS = 200
"""Places at which a step is sought at most, evenly over the measured frequencies."""


@dataclass(frozen=True, eq=False)
class Unknown:
    """One kind of structure without a name in the library.

    Attributes
    ----------
    says : str
        What it would be; empty for structure in general.
    drop : float
        Drop of the whitened residual sum of squares.
    shapes : int
        How many shapes follow the residual.
    places : int
        At how many places the shape was tried.
    """

    says: str
    drop: float
    shapes: int
    places: int = 1


def unknowns(frame: Frame) -> Iterator[Unknown]:
    """Kinds of structure that may be left by a fit, each with what it would explain.

    Parameters
    ----------
    frame : Frame
        The fit.
    """
    for basis in (frame.smooth, frame.structured):
        yield Unknown("", _explained(frame, basis), int(basis.shape[1]))
    log_omega = np.log(frame.measurement.omega)
    order = np.arange(len(frame.measurement), dtype=float)
    for along, words in ((log_omega, "along frequency"), (order, "from row to row")):
        if np.ptp(along) > 0:
            curves = _creep(along)
            yield _family(frame, curves, f"a gain that changes slowly {words}")
            yield _family(frame, np.multiply(1j, curves), f"a phase that changes slowly {words}")
    for name in CONDITIONS:
        curves = _own_levels(frame, name)
        if len(curves):
            yield _family(frame, curves, f"a gain of its own at each {name}")
            yield _family(frame, np.multiply(1j, curves), f"a phase of its own at each {name}")
    yield from _step(frame, log_omega)


def _family(frame: Frame, curves: Real | Complex, says: str) -> Unknown:
    basis = frame.beyond(frame.whiten(frame.model_stiffness * curves).T)
    return Unknown(says, _explained(frame, basis), int(basis.shape[1]))


def _own_levels(frame: Frame, name: str) -> Real:
    """Shapes (m, n) that are one at one level of a condition and zero elsewhere, for all but the first of them.

    None where there are fewer than three levels, or so few points at each that they could follow anything.
    """
    column = frame.measurement.conditions.get(name)
    if column is None:
        return np.zeros((0, len(frame.measurement)))
    level = frame.measurement.levels(name)
    count = int(level.max()) + 1
    if count < FEWEST_LEVELS or len(level) < POINTS_OF_EACH * count:
        return np.zeros((0, len(level)))
    shapes: Real = (level == np.arange(1, count)[:, None]).astype(np.float64)
    return shapes


def _creep(along: Real) -> Real:
    """Polynomials without their constant, shape (CREEP, n)."""
    x = 2.0 * (along - along.min()) / np.ptp(along) - 1.0
    curves: Real = np.polynomial.legendre.legvander(x, CREEP).T[1:]
    return curves


def _step(frame: Frame, log_omega: Real) -> Iterator[Unknown]:
    """A gain that differs between two ranges of frequency."""
    levels = np.unique(np.round(log_omega, 6))
    if len(levels) < 4:
        return
    between = 0.5 * (levels[1:-2] + levels[2:-1])
    between = between[np.linspace(0, len(between) - 1, min(len(between), MOST_STEPS)).round().astype(int)]
    columns = frame.whiten(frame.model_stiffness * (log_omega > between[:, None])).T
    left = frame.project(columns)
    size = np.linalg.norm(left, axis=0)
    seen = size > 1e-3 * np.linalg.norm(columns, axis=0)
    drops = np.where(seen, (frame.rest @ left) ** 2 / np.where(seen, size, 1.0) ** 2, 0.0)
    best = int(np.argmax(drops))
    hertz = float(np.exp(between[best])) / (2.0 * np.pi)
    yield Unknown(f"a gain that steps at {hertz:.3g} Hz", float(drops[best]), 1, len(between))


def _explained(frame: Frame, basis: Real) -> float:
    return float(np.sum((basis.T @ frame.rest) ** 2))
