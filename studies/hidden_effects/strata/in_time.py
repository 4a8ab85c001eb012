"""Force histories by integration in time, reduced to harmonics.

Nothing here knows a describing function.

The displacement is x = X cos(turn) with turn = omega t. All rows (frequencies times amplitudes)
march together with the classical Runge-Kutta method until the last turn, whose force gives the
harmonics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hidden_effects.bases import Complex, Real
from hidden_effects.scaling import NotVisible

STEPS = 400
"""Steps a turn: 1e-5 of the force even with a resonance at thirty times the motion's frequency."""
TURNS = 4
HALVES = 8
"""Half turns in which offsets are taken out before that."""
UNSTEADY = 2e-4
"""Largest change over the last turn, relative to the largest value: a fifth of the smallest noise.
"""
State = Real
Rate = Callable[[State, float], State]


@dataclass(frozen=True)
class Motion:
    """The prescribed displacement of all rows.

    Angular frequency [rad/s] and amplitude, each of shape (n,).
    """

    omega: Real
    top: Real

    def at(self, turn: float) -> tuple[Real, Real, Real]:
        """Displacement, velocity and acceleration."""
        x = self.top * np.cos(turn)
        return x, -self.top * self.omega * np.sin(turn), -(self.omega**2) * x


@dataclass(frozen=True)
class Solid:
    """A spring ``ke`` beside a spring ``k`` with a dashpot of relaxation time ``tau``."""

    ke: float
    k: float
    tau: float

    def pull(self, q: Real, x: Real) -> Real:
        """Force at displacement x with the force q in the branch."""
        return self.ke * x + q

    def branch_rate(self, q: Real, v: Real) -> Real:
        """Time derivative of the force in the branch at velocity v."""
        return self.k * v - q / self.tau

    def steady(self, motion: Motion) -> Real:
        """Force in the branch at turn 0, as if the motion had always been there."""
        s = 1j * motion.omega * self.tau
        return self.k * motion.top * (s / (1.0 + s)).real


def clock() -> Real:
    """The turns at which the last cycle is kept."""
    return 2.0 * np.pi * np.arange(STEPS) / STEPS


def harmonic(force: Real, order: int) -> Complex:
    """Complex amplitude of one harmonic of a cycle (STEPS, n): force = Re sum F_n exp(i n turn)."""
    return 2.0 * np.mean(force * np.exp(-1j * order * clock())[:, None], axis=0)


def march(rate: Rate, start: State, omega: Real, count: int = TURNS) -> Real:
    """States (STEPS, m, n) over the last of ``count`` turns.

    ``rate(state (m, n), turn)`` is per second.

    Everything here is odd, so that in the steady state half a turn changes the sign. Half the
    difference of two states half a turn apart is therefore free of the offsets that would take many
    turns to die; it is the next start.

    Raises
    ------
    NotVisible
        If the last turn does not close, or the integration does not stay finite.
    """
    state, h = start, 2.0 * np.pi / STEPS
    kept = np.empty((STEPS, *start.shape))

    def per_turn(y: State, turn: float) -> State:
        return rate(y, turn) / omega

    with np.errstate(all="ignore"):
        for _ in range(HALVES):
            begin = state
            for i in range(STEPS // 2):
                state = _step(per_turn, state, i * h, h)
            state = 0.5 * (begin - state)
        for i in range(count * STEPS):
            kept[i % STEPS] = state
            state = _step(per_turn, state, i * h, h)
        open_by = np.abs(state - kept[0]) / np.max(np.abs(kept), axis=0)
    if not np.all(open_by < UNSTEADY):
        raise NotVisible
    return kept


def _step(rate: Rate, y: State, turn: float, h: float) -> State:
    a = rate(y, turn)
    b = rate(y + 0.5 * h * a, turn + 0.5 * h)
    c = rate(y + 0.5 * h * b, turn + 0.5 * h)
    return y + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(y + h * c, turn + h))


# --- what specimen and rig are made of; each returns the force of the last turn (STEPS, n)
def solid_force(solid: Solid, motion: Motion) -> Real:
    """The specimen alone."""
    branch = march(
        lambda y, turn: solid.branch_rate(y, motion.at(turn)[1]),
        solid.steady(motion)[None],
        motion.omega,
    )
    return np.array(
        [solid.pull(q[0], motion.at(turn)[0]) for q, turn in zip(branch, clock(), strict=True)]
    )


def instant_force(element: Callable[[Real, Real, Real], Real], motion: Motion) -> Real:
    """An element without memory: its force from displacement, velocity and acceleration."""
    return np.array([element(*motion.at(turn)) for turn in clock()])


def sliders_force(stiffness: float, limits: Real, motion: Motion) -> Real:
    """Springs of equal stiffness, each behind a slider that gives way at its own displacement."""
    x = motion.at(0.0)[0]
    held = np.zeros((limits.size, x.size))
    force = np.empty((STEPS, x.size))
    for i in range(2 * STEPS):
        force[i % STEPS] = stiffness * held.mean(axis=0)
        new = motion.at(2.0 * np.pi * (i + 1) / STEPS)[0]
        held = np.clip(held + (new - x), -limits[:, None], limits[:, None])
        x = new
    return force


def bouc_wen_force(
    stiffness: float, limit: float, sharpness: float, share: float, motion: Motion
) -> Real:
    """Bouc-Wen: z' = v (1 - |z / limit|^n (share sign(v z) + 1 - share)), force = stiffness z."""

    def rate(y: State, turn: float) -> State:
        v = motion.at(turn)[1]
        return v * (1.0 - np.abs(y / limit) ** sharpness * (share * np.sign(v * y) + 1.0 - share))

    z = march(rate, 0.0 * motion.top[None], motion.omega)
    return stiffness * z[:, 0]


def load_cell_force(force: Real, motion: Motion, resonance: float, zeta: float) -> Real:
    """What a load cell shows that is itself a mass on a spring.

    y'' + 2 zeta w y' + w^2 y = w^2 force.
    """
    closed = np.vstack([force, force[:1]])

    def pulled(turn: float) -> Real:
        place = (turn % (2.0 * np.pi)) / (2.0 * np.pi) * STEPS
        i = min(int(place), STEPS - 1)
        return closed[i] + (place - i) * (closed[i + 1] - closed[i])

    def rate(y: State, turn: float) -> State:
        return np.array(
            [y[1], resonance**2 * (pulled(turn) - y[0]) - 2.0 * zeta * resonance * y[1]]
        )

    slope = (closed[1] - closed[-2]) / (4.0 * np.pi / STEPS) * motion.omega
    return march(rate, np.array([force[0], slope]), motion.omega, 30)[:, 0]


def mount_force(solid: Solid, motion: Motion, stiffness: float, cubic: float) -> Real:
    """The specimen behind a mount whose spring hardens.

    Mount force = stiffness w + cubic w^3, w = x - u.
    """

    def rate(y: State, turn: float) -> State:
        u, q = y
        x, v, _ = motion.at(turn)
        slope = stiffness + 3.0 * cubic * (x - u) ** 2
        moved = (slope * v + q / solid.tau) / (slope + solid.ke + solid.k)
        return np.array([moved, solid.branch_rate(q, moved)])

    states = march(rate, np.array([motion.top, solid.steady(motion)]), motion.omega)
    return states[:, 1] + solid.ke * states[:, 0]


def slip_force(solid: Solid, motion: Motion, fluidity: float, exponent: float) -> Real:
    """The specimen that slips at the wall with a speed of fluidity |F|^exponent sign(F)."""

    def rate(y: State, turn: float) -> State:
        u, q = y
        pull = solid.pull(q, u)
        moved = motion.at(turn)[1] - fluidity * np.abs(pull) ** exponent * np.sign(pull)
        return np.array([moved, solid.branch_rate(q, moved)])

    states = march(rate, np.array([motion.top, solid.steady(motion)]), motion.omega)
    return states[:, 1] + solid.ke * states[:, 0]
