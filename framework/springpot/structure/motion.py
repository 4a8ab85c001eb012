"""A frame under a record: displacement, force, energy, with the uncertainty of its dampers.

Each damper is its spectrum, a sum of exponentials, so that frame and dampers are one linear system
of first order, y' = A y + b a. For an acceleration a that is straight between its samples its
motion is exact: one matrix exponential serves all steps. So are its largest values, which seldom
fall on a sample: between two of them anything seen of y is followed by the cubic that has its
values and slopes at both (Hermite); around the largest ones the recursion is repeated in steps so
short that this cubic is exact to 1e-4. What is not linear in a damper stands beside that system and
is followed in short steps, see `beside`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from springpot.errors import DataError, ModelError
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from ..numerics import ROUNDING
from .damper import Beside, Damper, forces
from .frame import Frame, Mode, modes_of


class Fineness(NamedTuple):
    """How finely a motion is followed."""

    short: float
    """Steps in the shortest period around a largest value.

    A cubic errs there by (2 pi / 16)^4 / 384 = 6e-5 of it.
    """
    nearest: int
    """Steps of the record that are looked at again for each value, the largest by the cubic
    first.
    """
    tolerance: float
    """Relative error of K for which a damper's spectrum is read: far below what is known of any
    damper.
    """
    beyond: float
    """How far the band of a spectrum reaches beyond the frequencies of frame and record."""
    fine: float
    """Steps in the shortest period of the frame where something is not linear.

    The motion is then within 0.5 % of that of an adaptive integrator, with stops as stiff as the
    storey; the error falls with the square of their number.
    """


STEPS = Fineness(short=16.0, nearest=8, tolerance=1e-5, beyond=30.0, fine=120.0)


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
        wanted = np.ceil(self.step * STEPS.short * fastest / (2.0 * np.pi))
        if wanted <= 1:
            return top
        # Only about the largest: a smaller one does not become the largest when it is looked at
        # more closely.
        order = np.argsort(whole, axis=0)[-STEPS.nearest :]
        rows = np.unique(order)
        if not wanted * len(rows) <= STRUCTURE.steps:
            raise ModelError(
                f"the shortest period of the frame is {2.0 * np.pi / fastest:.3g} s, far below the"
                f" record's steps of {self.step:.3g} s; check masses and stiffnesses"
            )
        parts = int(wanted)
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


class Believed(NamedTuple):
    """What is believed of a structure and its record."""

    steps: int
    """Of a record in short steps, which take some minutes: a minute of shaking and a period of 7
    ms.
    """
    acceleration: float
    """Acceleration of the ground in m/s^2: far above a shock table's."""
    even: float
    """Relative scatter of the steps of a record that is taken for even: of times with four
    digits.
    """
    storeys: int
    """The tallest buildings have half as many; the work grows with their cube."""
    mass: float
    """Of kg of a floor, or N/m of a storey: more than a mountain has."""


STRUCTURE = Believed(steps=1_000_000, acceleration=1e6, even=1e-3, storeys=300, mass=1e15)


@dataclass(frozen=True, eq=False)
class GroundMotion:
    """Acceleration of the ground.

    Parameters
    ----------
    step : float
        Time between samples in s.
    acceleration : ndarray, shape (t,)
        In m/s^2.
    name : str
        Shown in reports.

    Examples
    --------
    >>> from springpot.structure import GroundMotion
    >>> GroundMotion.of([0.0, 0.01, 0.02], [0.0, 1.0, 0.0]).finer(2).acceleration
    array([0. , 0.5, 1. , 0.5, 0. ])
    """

    step: float
    acceleration: Real
    name: str = "record"

    @property
    def time(self) -> Real:
        """Of each sample, in s."""
        return np.arange(len(self.acceleration), dtype=float) * self.step

    def finer(self, parts: int) -> GroundMotion:
        """The same with so many steps for each of its own, straight between its samples."""
        time = self.time
        fine = np.linspace(time[0], time[-1], (len(time) - 1) * parts + 1)
        return GroundMotion(self.step / parts, np.interp(fine, time, self.acceleration), self.name)

    @classmethod
    def of(cls, time: Real, acceleration: Real, name: str = "record") -> GroundMotion:
        """From samples at even times.

        Raises
        ------
        DataError
            If the steps are not even, or a sample is no number or far too large.
        """
        time, acceleration = np.asarray(time, dtype=float), np.asarray(acceleration, dtype=float)
        if len(time) < 2 or time.shape != acceleration.shape:
            raise DataError(
                f"{name}: a record has two samples or more, each with a time and an acceleration"
            )
        if not (np.all(np.isfinite(time)) and np.all(np.isfinite(acceleration))):
            bad = int(np.flatnonzero(~np.isfinite(time + acceleration))[0])
            raise DataError(
                f"{name}: sample {bad + 1} is no number: leave the record whole, or mend it"
            )
        if (strong := np.flatnonzero(np.abs(acceleration) > STRUCTURE.acceleration)).size:
            raise DataError(
                f"{name}: sample {strong[0] + 1} is {acceleration[strong[0]]:g} m/s^2, which no"
                " ground does: mend it, or the unit"
            )
        steps = np.diff(time)
        if not np.all(steps > 0.0):
            back = int(np.flatnonzero(steps <= 0.0)[0])
            raise DataError(
                f"{name}: the time does not rise after sample {back + 1} (t = {time[back]:g} s)"
            )
        mean = float(np.mean(steps))
        if np.abs(steps - mean).max() > STRUCTURE.even * mean:
            worst = int(np.argmax(np.abs(steps - mean)))
            raise DataError(
                f"{name}: the steps are not equal ({steps[worst]:.4g} s after sample {worst + 1},"
                f" {mean:.4g} s on average): sample the record anew at equal steps"
            )
        return cls(mean, acceleration, name)


def artificial(
    rng: np.random.Generator, duration: float = 20.0, step: float = 0.01, peak: float = 3.0
) -> GroundMotion:
    """A ground motion as of an earthquake.

    White noise through the ground's own oscillator, rising and fading.

    Parameters
    ----------
    rng : numpy.random.Generator
        Where the noise comes from.
    duration, step : float
        In s.
    peak : float
        Largest acceleration in m/s^2.

    References
    ----------
    Kanai 1957 and Tajimi 1960 for the filter (firm ground: 15.6 rad/s, damping 0.6); Saragoni &
    Hart 1974, doi:10.1002/eqe.4290020305, for the envelope.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import artificial
    >>> record = artificial(np.random.default_rng(1), duration=10.0)
    >>> len(record.time), round(float(np.abs(record.acceleration).max()), 6)
    (1000, 3.0)
    """
    from scipy.signal import cont2discrete, lfilter

    t = np.arange(0.0, duration, step)
    omega, zeta = 15.6, 0.6
    upper, lower, _ = cont2discrete(
        ([2 * zeta * omega, omega**2], [1.0, 2 * zeta * omega, omega**2]), step
    )
    # What the mass of an oscillator feels whose foot the noise shakes: the soil above the rock.
    shaken = lfilter(upper.ravel(), lower, rng.normal(size=len(t)))
    shaken = (shaken - shaken.mean()) * t**2 * np.exp(-12.0 * t / duration)
    return GroundMotion(step, peak * shaken / np.abs(shaken).max(), "artificial")


@dataclass(frozen=True, eq=False)
class Motion:
    """What a frame does under a record.

    Attributes
    ----------
    frame : Frame
        The frame.
    record : GroundMotion
        The record.
    displacement, velocity : ndarray, shape (t, n)
        Of the floors relative to the ground, in m and m/s.
    force : ndarray, shape (t, d)
        Of the dampers of each entry together, in N, along the floor.
    beside : tuple of ndarray, shape (t, d)
        Of the force the part that is not linear, in N, and the work on it along the floor, in J:
        where it jumps, samples do not tell its work.
    peaks : ndarray, shape (n + d + n,)
        Largest sizes, between samples too, of the drifts, of these forces, and of their sums in
        each storey.
    """

    frame: Frame
    record: GroundMotion
    displacement: Real
    velocity: Real
    force: Real
    beside: tuple[Real, Real]
    peaks: Real

    @property
    def drift(self) -> Real:
        """Of each storey, in m, shape (t, n)."""
        return self.frame.drift_of(self.displacement)

    @property
    def peak_drift(self) -> Real:
        """Largest drift of each storey in m, shape (n,)."""
        return self.peaks[: len(self.frame)]

    @property
    def axial_force(self) -> Real:
        """Force of one damper of each entry along its axis, in N, shape (t, d)."""
        return self.force / self.frame.floor_per_axis

    @property
    def stroke(self) -> Real:
        """Way of each damper along its axis, in m, shape (t, d)."""
        return self.frame.strokes_of(self.drift)

    @property
    def peak_axial_force(self) -> Real:
        """Largest force of one damper of each entry along its axis, in N, shape (d,)."""
        n = len(self.frame)
        return self.peaks[n : len(self.peaks) - n] / self.frame.floor_per_axis

    @property
    def peak_stroke(self) -> Real:
        """Largest way of each damper along its axis, in m, shape (d,)."""
        return self.frame.strokes_of(self.peak_drift)

    @property
    def peak_storey_force(self) -> Real:
        """Largest force along the floor of all dampers of a storey at once, in N, shape (n,)."""
        return self.peaks[len(self.peaks) - len(self.frame) :]

    @cached_property
    def work(self) -> Real:
        """Energy in J that one damper of each entry has taken, against time, shape (t, d).

        At last it is heat, but for what its springs then hold.
        """
        sudden, work = self.beside
        storeys = [damper.storey - 1 for damper in self.frame.dampers]
        rates = self.frame.drift_of(self.velocity)[:, storeys]
        taken = self._told(_integral((self.force - sudden) * rates, self.record.step) + work)
        return np.asarray(taken / np.array([damper.count for damper in self.frame.dampers]))

    @cached_property
    def energy(self) -> dict[str, Real]:
        """Energies in J against time (t,).

        Put in by the ground, taken by the dampers, by the frame's own damping.
        """
        # Relative to the ground its acceleration is a force of inertia, against it.
        power = -(self.velocity @ self.frame.mass) * self.record.acceleration
        # What neither the dampers nor the frame take is in motion or in springs when the record
        # ends.
        own = np.einsum("ti,ij,tj->t", self.velocity, self.frame.viscous, self.velocity)
        counts = np.array([damper.count for damper in self.frame.dampers])
        return {
            "input": self._told(_integral(power, self.record.step)),
            "dampers": self.work @ counts,
            "frame": self._told(_integral(own, self.record.step)),
        }

    def _told(self, whole: Real) -> Real:
        """Energies in J against time (t, ...); none where that is rounding."""
        # Beside what rides along with the ground the work on a frame that is stuck is rounding.
        reached = _integral(np.abs(self.record.acceleration), self.record.step)[-1]
        least = ROUNDING * float(np.sum(self.frame.mass)) * reached**2
        return np.where(np.abs(whole) > least, whole, 0.0)


def _integral(rate: Real, step: float) -> Real:
    """Of a rate (t, ...) against time, by the trapezoidal rule."""
    whole: Real = np.zeros_like(rate)
    whole[1:] = np.cumsum(0.5 * step * (rate[1:] + rate[:-1]), axis=0)
    return whole


def motion_of(frame: Frame, record: GroundMotion) -> Motion:
    """The motion of a frame that was at rest, exact where the acceleration is piecewise linear.

    What is not linear in a damper (friction, a slider, a stop, a power of the speed) is followed
    for what it is.

    Parameters
    ----------
    frame : Frame
        With its dampers.
    record : GroundMotion
        The acceleration of the ground.

    Raises
    ------
    ModelError
        If a damper is no relaxing material, or something in it has no law in time.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import Frame, GroundMotion, motion_of
    >>> frame = Frame([1000.0], [1000.0 * (2 * np.pi) ** 2], damping=0.02)
    >>> pulse = GroundMotion(0.001, np.where(np.arange(2000) < 100, 1.0, 0.0))
    >>> round(float(motion_of(frame, pulse).peak_drift[0]), 3)
    0.015
    """
    matrix, load, parts = _system(frame, record)
    system = System(matrix, load, record.step)
    # A linear system goes in exact steps of the record, as long as they are; a jump of friction
    # needs short ones.
    besides = {i: Beside(damper) for i, damper in enumerate(frame.dampers) if damper.beside}
    n, count = len(frame), len(record.acceleration)
    seen = _seen(frame, parts, len(matrix))
    if besides:
        state, beside, peaks = _stepped(frame, record, system, besides, seen)
    else:
        nothing = np.zeros((count, len(parts)))
        state, beside = system.run(record.acceleration), (nothing, nothing)
        peaks = system.largest(state, record.acceleration, seen)
    force = state @ seen[n : n + len(parts)].T + beside[0]
    return Motion(frame, record, state[:, :n], state[:, n : 2 * n], force, beside, peaks)


def _seen(frame: Frame, parts: Sequence[_Part], size: int) -> Real:
    """Rows (n + d + n, m) that turn a state into drifts, forces of entries and storey forces."""
    n = len(frame)
    drifts = np.hstack([frame.drifts, np.zeros((n, size - n))])
    forces = np.array([part.row_of_force(size) for part in parts]).reshape(len(parts), size)
    return np.vstack([drifts, forces, frame.storeys_of_dampers @ forces])


def _stepped(
    frame: Frame, record: GroundMotion, system: System, besides: dict[int, Beside], seen: Real
) -> tuple[Real, tuple[Real, Real], Real]:
    """States (t, m), forces (t, d) and work of what is not linear, and peaks.

    The forces are constant within each of many short steps. The peaks are those of these steps:
    with so many of them, a sample misses one by 1 - cos(pi / 120) = 3e-4.
    """
    # By the shortest period: the highest mode is the one that a jump of a force sets ringing.
    wanted = np.ceil(record.step * STEPS.fine * frame.natural[0][-1] / (2.0 * np.pi))
    # Also where it is no number, as of a frame that is far too stiff for one.
    if not wanted * len(record.acceleration) <= STRUCTURE.steps:
        period = 2.0 * np.pi / frame.natural[0][-1]
        raise ModelError(
            f"the shortest period of the frame is {period:.3g} s: friction, a slider or a stop in a"
            f" damper takes more than {STRUCTURE.steps} steps of the record; check masses and"
            " stiffnesses, or give a shorter record"
        )
    parts = int(wanted)
    fine = record.finer(parts)
    n, a = len(frame), fine.acceleration
    rows = frame.drifts[[frame.dampers[i].storey - 1 for i in besides]]
    # A damper's force acts against the drift of its storey, on the velocities only.
    pull = np.zeros((len(system.matrix), len(besides)))
    pull[n : 2 * n] = -(rows / frame.mass).T
    short = system.in_steps_of(fine.step)
    forward, pulled = short.forward, short.integrals[0] @ pull
    pushed = short.pushed(a[:-1], a[1:])
    by_force = rows @ pulled[:n], rows @ pulled[n : 2 * n]
    count, size = len(record.acceleration), len(system.matrix)
    state, extra = np.zeros((count, size)), np.zeros((2, count, len(frame.dampers)))
    y, force, members = np.zeros(size), np.zeros(len(rows)), list(besides.values())
    work = np.zeros(len(rows))
    felt, peaks = _felt(frame, list(besides)), np.zeros(len(seen))
    start = rows @ y[:n], rows @ y[n : 2 * n]
    for i, push in enumerate(pushed, 1):
        y = forward @ y + push
        # As if nothing slid: what the forces then add is linear in them, so that they are solved
        # for at once.
        free = rows @ y[:n], rows @ y[n : 2 * n]
        force = forces(members, start, free, by_force, force)
        y = y + pulled @ force
        before, start = start, (rows @ y[:n], rows @ y[n : 2 * n])
        way = start[0] - before[0]
        # Exact, as the force is constant within the step.
        work = work + force * way
        for member, moved in zip(members, way.tolist(), strict=True):
            member.move(moved)
        peaks = np.maximum(peaks, np.abs(seen @ y + felt @ force))
        if i % parts == 0:
            state[i // parts] = y
            extra[:, i // parts, list(besides)] = force, work
    return state, (extra[0], extra[1]), peaks


def _felt(frame: Frame, entries: Sequence[int]) -> Real:
    """What not linear forces of entries (k,) add to what `_seen` sees, shape (n + d + n, k)."""
    own = np.eye(len(frame.dampers))[:, entries]
    return np.vstack([np.zeros((len(frame), len(entries))), own, frame.storeys_of_dampers @ own])


@dataclass(frozen=True, eq=False)
class _Part:
    """A damper in the system.

    Its spring, dashpot and branches, and where the states of these stand.
    """

    row: Real
    spring: float
    dashpot: float
    weights: Real
    rates: Real
    states: slice

    def row_of_force(self, size: int) -> Real:
        """By which its force is seen in a state, shape (size,)."""
        n = len(self.row)
        seen = np.zeros(size)
        # A branch pulls by how far its dashpot lags behind the drift.
        seen[:n] = (self.spring + self.weights.sum()) * self.row
        seen[n : 2 * n] = self.dashpot * self.row
        seen[self.states] = -self.weights
        return seen


def _part(damper: Damper, frame: Frame, band: tuple[float, float], start: int) -> _Part:
    spectrum = damper.linear.spectrum(
        damper.linear_theta,
        band,
        tolerance=STEPS.tolerance,
        temperature=damper.kelvin,
        reference_temperature=damper.reference,
    )
    # The size holds the count and the slope; the model's own parameters stay as they were
    # identified.
    row, factor = frame.drifts[damper.storey - 1], damper.size
    return _Part(
        row=row,
        spring=factor * spectrum.equilibrium,
        dashpot=factor * spectrum.viscosity,
        weights=factor * spectrum.weights,
        rates=spectrum.rates,
        states=slice(start, start + len(spectrum.rates)),
    )


def _system(frame: Frame, record: GroundMotion) -> tuple[Real, Real, list[_Part]]:
    """Matrix and load of y' = A y + b a; y: displacements, velocities, ways of the branches."""
    n = len(frame)
    # A short record leaves the frame swinging: its longest period counts as well.
    longest = max(len(record.acceleration) * record.step, 10.0 / frame.natural[0][0])
    band = (
        1.0 / (STEPS.beyond * longest),
        max(STEPS.beyond * float(frame.natural[0][-1]), np.pi / record.step),
    )
    parts: list[_Part] = []
    start = 2 * n
    for damper in frame.dampers:
        parts.append(_part(damper, frame, band, start))
        start = parts[-1].states.stop
    stiffness, damping = frame.elastic.copy(), frame.viscous.copy()
    # One first-order system for all: frame and dampers are then exact together, without any
    # iteration.
    matrix = np.zeros((start, start))
    inverse = 1.0 / frame.mass
    for part in parts:
        square = np.outer(part.row, part.row)
        stiffness += (part.spring + part.weights.sum()) * square
        damping += part.dashpot * square
        matrix[n : 2 * n, part.states] = np.outer(inverse * part.row, part.weights)
        # The way of a branch follows the drift at the branch's own rate; what it lags behind is its
        # force.
        matrix[part.states, :n] = np.outer(part.rates, part.row)
        matrix[part.states, part.states] = -np.diag(part.rates)
    matrix[:n, n : 2 * n] = np.eye(n)
    matrix[n : 2 * n, :n] = -inverse[:, None] * stiffness
    matrix[n : 2 * n, n : 2 * n] = -inverse[:, None] * damping
    load = np.zeros(start)
    load[n : 2 * n] = -1.0
    return matrix, load, parts


@dataclass(frozen=True, eq=False)
class Simulation:
    """A frame under a record, and how sure that is.

    Attributes
    ----------
    motion : Motion
        With the identified parameters.
    modes : list of Mode
        With these, lowest first; empty where a mode no longer swings.
    drifts : ndarray, shape (draws, n)
        Peak drifts in m with parameters as they may as well be.
    bounds : dict of str to Simulation
        ``lower`` and ``upper``, with all dampers at an end of their factors; see `Frame.bounds`.
    """

    motion: Motion
    modes: list[Mode]
    drifts: Real
    bounds: dict[str, Simulation] = field(default_factory=dict)

    @property
    def level(self) -> float:
        """Share of motions that the band holds; of few draws less than 0.95, of one none."""
        return level_of(len(self.drifts))

    def band(self) -> tuple[Real, Real]:
        """Ends (n,) of the band of the peak drifts in m."""
        return band_of(self.drifts, self.motion.peak_drift)


def level_of(draws: int) -> float:
    """Share that lies within a band of so many draws; of few less than 0.95, of one none."""
    return min(INTERVAL, max(draws - 1, 0) / (draws + 1))


def band_of(drawn: Real, nominal: Real) -> tuple[Real, Real]:
    """Ends (n,) of the band of what was drawn (draws, n); of one draw or none the nominal (n,)."""
    level = level_of(len(drawn))
    if not level:
        return nominal, nominal
    tail = 0.5 * (1.0 - level)
    # Weibull's positions: between the outermost of n draws lie (n - 1)/(n + 1) of all.
    low, high = np.quantile(drawn, [tail, 1.0 - tail], axis=0, method="weibull")
    return low, high


def simulate(
    frame: Frame, record: GroundMotion, rng: np.random.Generator, draws: int = 40
) -> Simulation:
    """Run a frame under a record, and again with dampers drawn from what is known of them.

    Parameters
    ----------
    frame : Frame
        With identified dampers.
    record : GroundMotion
        The acceleration of the ground.
    rng : numpy.random.Generator
        Of the draws.
    draws : int
        How many.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import Frame, artificial, simulate
    >>> rng = np.random.default_rng(1)
    >>> frame = Frame([1000.0], [1000.0 * (2 * np.pi) ** 2], damping=0.05)
    >>> simulate(frame, artificial(rng, duration=5.0), rng).motion.displacement.shape
    (500, 1)
    """
    # Where no damper is uncertain, each draw would be the same motion again.
    if not any(damper.axes.size for damper in frame.dampers):
        draws = 0
    peaks = [motion_of(frame.drawn(rng), record).peak_drift for _ in range(draws)]
    return Simulation(
        motion_of(frame, record),
        modes_of(frame),
        np.array(peaks).reshape(-1, len(frame)),
        {name: simulate(bound, record, rng, 0) for name, bound in frame.bounds.items()},
    )
