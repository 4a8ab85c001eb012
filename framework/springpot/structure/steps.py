"""A linear system in exact steps, and what is largest between its samples.

y' = A y + b a is exact for an acceleration a that is straight within each step: one matrix
exponential serves all steps. Between two samples anything seen of y is followed by the cubic that
has its values and slopes at both (Hermite); around the largest ones the recursion is repeated in
steps so short that this cubic is exact to 1e-4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from springpot.rheology.points import Real

SHORT = 16.0
"""Steps in the shortest period around a largest value.

A cubic errs there by (2 pi / 16)^4 / 384 = 6e-5 of it.
"""
NEAREST = 8
"""Steps of the record that are looked at again for each value, the largest by the cubic first."""


@dataclass(frozen=True, eq=False)
class System:
    """y' = A y + b a in steps of one length.

    Parameters
    ----------
    matrix : ndarray, shape (m, m)
        A in 1/s.
    load : ndarray, shape (m,)
        b.
    step : float
        In s.
    """

    matrix: Real
    load: Real
    step: float

    def in_steps_of(self, step: float) -> System:
        """The same in other steps."""
        return System(self.matrix, self.load, step)

    @cached_property
    def forward(self) -> Real:
        """What a step makes of y by itself (m, m)."""
        return _exponential(self.matrix * self.step)

    @cached_property
    def integrals(self) -> tuple[Real, Real]:
        """Integrals (m, m) of exp(A (h - t)) over the step.

        Of a load of one, and of one that rises to one.
        """
        size = len(self.matrix)
        # One exponential of a block matrix holds both (Van Loan 1978,
        # doi:10.1109/TAC.1978.1101743).
        whole = np.zeros((3 * size, 3 * size))
        whole[:size, :size] = self.matrix * self.step
        whole[:size, size : 2 * size] = np.eye(size) * self.step
        whole[size : 2 * size, 2 * size :] = np.eye(size)
        both = _exponential(whole)[:size]
        return both[:, size : 2 * size], both[:, 2 * size :]

    def pushed(self, start: Real, end: Real) -> Real:
        """What the acceleration adds in steps (s, m) at whose ends it has these values (s,)."""
        first, second = self.integrals
        return np.outer(start, (first - second) @ self.load) + np.outer(end, second @ self.load)

    def run(self, a: Real) -> Real:
        """States (t, m) from rest under the accelerations a (t,)."""
        state, y = np.zeros((len(a), len(self.matrix))), np.zeros(len(self.matrix))
        forward = self.forward
        # What the acceleration adds is known for all steps at once; the rest follows step by step.
        for i, push in enumerate(self.pushed(a[:-1], a[1:]), 1):
            y = forward @ y + push
            state[i] = y
        return state

    def largest(self, state: Real, a: Real, seen: Real) -> Real:
        """Largest size (q,) that each row of `seen` (q, m) times y reaches, between samples too.

        Parameters
        ----------
        state : ndarray, shape (t, m)
            As of `run`.
        a : ndarray, shape (t,)
            The accelerations.
        seen : ndarray, shape (q, m)
            What is looked at.
        """
        whole = self._between(state, a, seen)
        top: Real = whole.max(axis=0)
        fastest = float(np.abs(np.linalg.eigvals(self.matrix).imag).max())
        parts = int(np.ceil(self.step * SHORT * fastest / (2.0 * np.pi)))
        if parts <= 1:
            return top
        # Only about the largest: a smaller one does not become the largest when it is looked at
        # more closely.
        order = np.argsort(whole, axis=0)[-NEAREST:]
        rows = np.unique(order)
        fine = self.in_steps_of(self.step / parts)
        y, start, rise = state[rows], a[rows], a[rows + 1] - a[rows]
        top = np.zeros(len(seen))
        for i in range(parts):
            before, after = start + i / parts * rise, start + (i + 1) / parts * rise
            then = y @ fine.forward.T + fine.pushed(before, after)
            pair = np.stack([y, then]), np.stack([before, after])
            top = np.maximum(top, fine._between(*pair, seen).reshape(-1, len(seen)).max(axis=0))
            y = then
        return top

    def _between(self, state: Real, a: Real, seen: Real) -> Real:
        """Largest size in each step (t - 1, ..., q), from its ends (t, ..., m)."""
        value = state @ seen.T
        slope = self.step * (state @ (seen @ self.matrix).T + a[..., None] * (seen @ self.load))
        return _largest_of_cubic(value[:-1], value[1:], slope[:-1], slope[1:])


def _largest_of_cubic(start: Real, end: Real, slope: Real, last: Real) -> Real:
    """Largest size between 0 and 1 of the cubics with these values and slopes at both ends."""
    square, cube = 3.0 * (end - start) - 2.0 * slope - last, slope + last - 2.0 * (end - start)
    most = np.maximum(np.abs(start), np.abs(end))
    # It turns where slope + 2 square u + 3 cube u^2 is nothing, in the form that loses no digits
    # where cube is small.
    with np.errstate(all="ignore"):
        root = -(square + np.copysign(np.sqrt(square**2 - 3.0 * cube * slope), square))
        for turn in (slope / root, root / (3.0 * cube)):
            # Outside of the step, or where nothing turns, the ends are the largest.
            u = np.where((turn > 0.0) & (turn < 1.0), turn, 0.0)
            most = np.maximum(most, np.abs(start + u * (slope + u * (square + u * cube))))
    return np.asarray(most)


def _exponential(matrix: Real) -> Real:
    from scipy.linalg import expm

    grown: Real = expm(matrix)
    return grown
