"""A shear frame of a few storeys, or an oscillator, with identified dampers between its floors.

Steady state and modes of a frame with dampers, exactly: no dashpot stands for a springpot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError
from springpot.rheology.points import Complex, Real

from ..numerics import MOST_STEPS, ROUNDING
from .damper import Damper

Number = TypeVar("Number", np.float64, np.complex128)


@dataclass(frozen=True, eq=False)
class Frame:
    """A shear frame; one storey is an oscillator.

    Parameters
    ----------
    mass : ndarray, shape (n,)
        Of each floor in kg, the lowest first.
    stiffness : ndarray, shape (n,)
        Of each storey in N/m.
    damping : float
        Ratio of the frame's own damping, in proportion to its stiffness, in its first mode.
    dampers : tuple of Damper
        Between floors.

    Raises
    ------
    ModelError
        If masses, stiffnesses or storeys do not fit each other.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import Frame
    >>> (Frame([1000.0, 1000.0], [4e5, 4e5]).natural[0] / (2 * np.pi)).round(2)
    array([1.97, 5.15])
    """

    mass: Real
    stiffness: Real
    damping: float = 0.0
    dampers: tuple[Damper, ...] = ()

    def __post_init__(self) -> None:
        for name in ("mass", "stiffness"):
            object.__setattr__(
                self, name, np.atleast_1d(np.asarray(getattr(self, name), dtype=float))
            )
        if self.mass.shape != self.stiffness.shape:
            raise ModelError(
                f"{len(self.mass)} floors have a mass and {len(self.stiffness)} storeys a stiffness"
            )
        if not (np.all(self.mass > 0.0) and np.all(self.stiffness > 0.0)):
            raise ModelError("masses and stiffnesses of a frame are above zero")
        if not 0.0 <= self.damping < 1.0:
            raise ModelError(
                f"the damping of a frame is a ratio from 0 to below 1, not {self.damping:g}"
            )
        for damper in self.dampers:
            if not 1 <= damper.storey <= len(self.mass):
                raise ModelError(
                    f"a damper braces storey {damper.storey} of a frame of {len(self.mass)}"
                )

    def __len__(self) -> int:
        return len(self.mass)

    @cached_property
    def drifts(self) -> Real:
        """Matrix (n, n) from displacements of floors to drifts of storeys."""
        n = len(self)
        return np.eye(n) - np.eye(n, k=-1)

    def drift_of(self, floors: NDArray[Number]) -> NDArray[Number]:
        """Drifts of the storeys (t, n) from displacements of the floors, rates from velocities."""
        return np.asarray(floors @ self.drifts.T)

    @cached_property
    def elastic(self) -> Real:
        """Stiffness matrix (n, n) of the bare frame."""
        return self.drifts.T @ (self.stiffness[:, None] * self.drifts)

    @cached_property
    def natural(self) -> tuple[Real, Real]:
        """Angular frequencies (n,) in rad/s and shapes (n, n) of the bare frame, lowest first."""
        from scipy.linalg import eigh

        squared, shapes = eigh(self.elastic, np.diag(self.mass))
        return np.sqrt(squared), shapes

    @cached_property
    def viscous(self) -> Real:
        """Damping matrix (n, n) of the bare frame."""
        matrix: Real = 2.0 * self.damping / self.natural[0][0] * self.elastic
        return matrix

    @cached_property
    def floor_per_axis(self) -> Real:
        """Force of an entry's dampers along the floor over that of one along its axis, (d,)."""
        return np.array([damper.count * damper.cosine for damper in self.dampers])

    def strokes_of(self, drift: NDArray[Number]) -> NDArray[Number]:
        """Ways (..., d) along the axes of the dampers, from the drifts (..., n) of the storeys."""
        cosines = np.array([damper.cosine for damper in self.dampers])
        return np.asarray(drift[..., [damper.storey - 1 for damper in self.dampers]] * cosines)

    @cached_property
    def storeys_of_dampers(self) -> Real:
        """Ones where an entry of dampers braces a storey, shape (n, d).

        The sum of their forces in each.
        """
        braced = np.zeros((len(self), len(self.dampers)))
        for i, damper in enumerate(self.dampers):
            braced[damper.storey - 1, i] = 1.0
        return braced

    @property
    def bounds(self) -> dict[str, Frame]:
        """The same with all dampers at their least, and at their largest factor.

        Nothing where none has any.
        """
        if all(damper.factors == (1.0, 1.0) for damper in self.dampers):
            return {}
        return {
            name: replace(self, dampers=tuple(damper.bound(end) for damper in self.dampers))
            for end, name in enumerate(("lower", "upper"))
        }

    def drawn(self, rng: np.random.Generator) -> Frame:
        """The same with dampers as they may as well be; those of one fit move together."""
        along: dict[int, Real] = {}
        dampers = []
        for damper in self.dampers:
            source = id(damper.tested or damper)
            if source not in along:
                along[source] = rng.standard_normal((damper.axes.shape[1],))
            dampers.append(damper.moved(along[source]))
        return replace(self, dampers=tuple(dampers))

    def dynamic(self, s: Complex) -> tuple[Complex, Complex]:
        """Dynamic stiffness (w, n, n) at s (w,) in 1/s, and its derivative by s."""
        s = np.asarray(s, dtype=complex)
        one, mass = s[:, None, None], np.diag(self.mass)
        value: Complex = one**2 * mass + one * self.viscous + self.elastic
        slope: Complex = 2.0 * one * mass + self.viscous
        for damper in self.dampers:
            # A damper feels the drift of its storey and pushes both floors apart: the same row
            # twice.
            row = self.drifts[damper.storey - 1]
            square = np.outer(row, row)
            k, by_s = damper.stiffness(s)
            value = value + k[:, None, None] * square
            slope = slope + by_s[:, None, None] * square
        return value, slope


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
    for _ in range(MOST_STEPS):
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
        if abs(step[n]) <= ROUNDING * abs(s):
            return s, shape
    raise ModelError(
        "a mode of the frame was not found: its dampers are far stiffer than its storeys"
    )


@dataclass(frozen=True, eq=False)
class SteadyState:
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


def steady_of(frame: Frame, omega: Real) -> SteadyState:
    """The steady state of a frame, of one unit of acceleration; see `steady_state`.

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
                f"'{effect.name}' has no steady state that grows as the ground's amplitude does,"
                " since it is not linear: give a record, or leave it out"
            )
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    return SteadyState(frame, omega, steady_state(frame, omega))


def steady_state(frame: Frame, omega: Real) -> Complex:
    """Amplitudes of the floors relative to the ground, accelerated by 1 m/s^2.

    Parameters
    ----------
    frame : Frame
        The frame.
    omega : ndarray, shape (w,)
        Angular frequencies in rad/s.

    Returns
    -------
    ndarray of complex, shape (w, n)
        In m.

    Raises
    ------
    ModelError
        Where nothing damps the frame at a frequency of its own.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.structure import Frame, steady_state
    >>> frame = Frame([1000.0], [1000.0 * (2 * np.pi) ** 2], damping=0.05)
    >>> np.abs(steady_state(frame, np.array([2 * np.pi]))).round(3)
    array([[0.253]])
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    value, _ = frame.dynamic(np.asarray(1j * omega, dtype=np.complex128))
    left = np.linalg.svd(value, compute_uv=False)[:, -1]
    endless = left <= ROUNDING * np.linalg.norm(frame.elastic, 2)
    if endless.any():
        raise ModelError(
            f"at {omega[endless][0] / (2.0 * np.pi):.4g} Hz nothing damps the frame, which swings"
            " ever higher there: give it a damping, or another frequency"
        )
    # Seen from the ground each floor is pushed by its own inertia.
    load = -frame.mass * np.ones((len(value), 1))
    return np.asarray(np.linalg.solve(value, load[:, :, None])[:, :, 0])
