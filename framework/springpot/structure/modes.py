"""Steady state and modes of a frame with dampers, exactly: no dashpot stands for a springpot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.errors import ModelError
from springpot.rheology.points import Complex, Real

from .frame import Frame

ITERATIONS = 60
"""Newton steps before a mode counts as not found."""
CLOSE = 1e-12
"""Relative change of an eigenvalue at which it is found."""


@dataclass(frozen=True, eq=False)
class Mode:
    """A free vibration x = Re(shape exp(s t)).

    Attributes
    ----------
    s : complex
        In 1/s.
    shape : ndarray of complex, shape (n,)
        The largest floor moves by one.
    """

    s: complex
    shape: Complex

    @property
    def frequency(self) -> float:
        """|s| / 2 pi, in Hz."""
        return abs(self.s) / (2.0 * np.pi)

    @property
    def damping(self) -> float:
        """Share of critical damping, -Re s / |s|."""
        return -self.s.real / abs(self.s)


def modes_of(frame: Frame) -> list[Mode]:
    """All modes, lowest first, of the eigenvalue problem (s^2 M + s C + K + K_d(s)) shape = 0.

    Each is followed from that of the bare frame by Newton's method on shape and s together, while
    the dampers come in step by step.

    Raises
    ------
    ModelError
        If a mode is not found: the dampers damp it beyond critical.

    References
    ----------
    Ruhe 1973, doi:10.1137/0710059; Lewandowski & Wielentejczyk 2020,
    doi:10.1007/s00419-019-01602-4.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import Frame, modes_of
    >>> mode = modes_of(Frame([1000.0], [1000.0 * (2 * np.pi) ** 2], damping=0.05))[0]
    >>> round(mode.frequency, 3), round(mode.damping, 3)
    (1.0, 0.05)
    """
    # The bare frame has n modes for certain: followed from there, none is missed and none comes
    # twice.
    omega, shapes = frame.natural
    return [
        _followed(frame, 1j * omega[i], shapes[:, i].astype(complex)) for i in range(len(frame))
    ]


def _followed(frame: Frame, s: complex, shape: Complex) -> Mode:
    # The dampers come in by steps, as Newton's method finds the mode only near where it begins.
    for share in (0.0, 0.1, 0.3, 0.6, 1.0):
        s, shape = _newton(frame, s, shape / shape[np.argmax(np.abs(shape))], share)
    # On the real axis it creeps back without swinging: that is no mode with a frequency.
    if s.imag <= 0.0:
        raise ModelError("a mode is damped beyond critical: it no longer swings")
    return Mode(complex(s), shape / shape[np.argmax(np.abs(shape))])


def _newton(frame: Frame, s: complex, shape: Complex, share: float) -> tuple[complex, Complex]:
    """The eigenvalue near s, with that share of damping and dampers."""
    n, border = len(shape), shape.conj()
    # Without its own damping too: that comes in with the dampers.
    bare = Frame(frame.mass, frame.stiffness)
    for _ in range(ITERATIONS):
        # K_d(s) of a springpot is no polynomial: it is taken at s itself, with its exact slope.
        at = np.array([s])
        whole, plain = frame.dynamic(at), bare.dynamic(at)
        value = (1.0 - share) * plain[0][0] + share * whole[0][0]
        slope = (1.0 - share) * plain[1][0] + share * whole[1][0]
        # Bordered: the shape keeps its size while both move.
        system = np.block([[value, (slope @ shape)[:, None]], [border[None, :], np.zeros((1, 1))]])
        right = np.append(-value @ shape, 0.0)
        step = np.linalg.solve(system, right)
        shape, s = shape + step[:n], s + complex(step[n])
        if abs(step[n]) <= CLOSE * abs(s):
            return s, shape
    raise ModelError(
        "a mode of the frame was not found: its dampers are far stiffer than its storeys"
    )


@dataclass(frozen=True, eq=False)
class Steady:
    """A frame that the ground shakes with one amplitude at each of some frequencies.

    Attributes
    ----------
    frame : Frame
        The frame.
    omega : ndarray, shape (w,)
        In rad/s.
    displacement : ndarray of complex, shape (w, n)
        Amplitudes of the floors relative to the ground, in m.
    """

    frame: Frame
    omega: Real
    displacement: Complex

    @property
    def drift(self) -> Complex:
        """Amplitudes (w, n) of the storeys in m."""
        return self.frame.drift_of(self.displacement)

    @property
    def force(self) -> Complex:
        """Amplitudes (w, d) of the force of each entry's dampers along the floor, in N."""
        return self._stiffness * self._way

    @property
    def axial_force(self) -> Complex:
        """Amplitudes (w, d) of the force of one damper of each entry along its axis, in N."""
        return np.asarray(self.force / self.frame.floor_per_axis)

    @property
    def stroke(self) -> Complex:
        """Amplitudes (w, d) of the way of each damper along its axis, in m."""
        return self.frame.strokes_of(self.drift)

    @property
    def storey_force(self) -> Complex:
        """Amplitudes (w, n) of the force along the floor of all dampers of a storey, in N."""
        return np.asarray(self.force @ self.frame.storeys_of_dampers.T)

    @property
    def energy(self) -> Real:
        """Energy (w, d) in J that each entry of dampers takes in a cycle, pi K'' X^2."""
        taken: Real = np.pi * self._stiffness.imag * np.abs(self._way) ** 2
        return taken

    @property
    def _stiffness(self) -> Complex:
        s = np.asarray(1j * self.omega, dtype=np.complex128)
        of_each = [damper.stiffness(s)[0] for damper in self.frame.dampers]
        return np.array(of_each, dtype=complex).reshape(len(of_each), len(self.omega)).T

    @property
    def _way(self) -> Complex:
        return self.drift[:, [damper.storey - 1 for damper in self.frame.dampers]]


def steady_of(frame: Frame, omega: Real, acceleration: float = 1.0) -> Steady:
    """The steady state of a frame; see `steady_state`.

    Raises
    ------
    ModelError
        If a damper is not linear: then it depends on the amplitude, and no sinusoid stays one.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Model, dashpot
    >>> from springpot.structure import Damper, Frame, steady_of
    >>> damper = Damper(Model("dashpot", dashpot()), np.array([500.0]))
    >>> frame = Frame([1000.0], [1000.0 * (2 * np.pi) ** 2], dampers=(damper,))
    >>> steady_of(frame, np.array([2 * np.pi])).energy.round(2)
    array([[1000.]])
    """
    for damper in frame.dampers:
        for effect, _ in damper.beside:
            raise ModelError(
                f"'{effect.name}' has no steady state at any amplitude: give a record, or leave"
                " it out"
            )
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    return Steady(frame, omega, steady_state(frame, omega, acceleration))


def steady_state(frame: Frame, omega: Real, acceleration: float = 1.0) -> Complex:
    """Amplitudes of the floors relative to the ground, whose acceleration has that amplitude.

    Parameters
    ----------
    frame : Frame
        The frame.
    omega : ndarray, shape (w,)
        Angular frequencies in rad/s.
    acceleration : float
        In m/s^2.

    Returns
    -------
    ndarray of complex, shape (w, n)
        In m.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import Frame, steady_state
    >>> frame = Frame([1000.0], [1000.0 * (2 * np.pi) ** 2], damping=0.05)
    >>> np.abs(steady_state(frame, np.array([2 * np.pi]))).round(3)
    array([[0.253]])
    """
    value, _ = frame.dynamic(1j * np.atleast_1d(np.asarray(omega, dtype=float)))
    # Seen from the ground each floor is pushed by its own inertia.
    load = -frame.mass * acceleration * np.ones((len(value), 1))
    return np.asarray(np.linalg.solve(value, load[:, :, None])[:, :, 0])
