"""An identified damper in a structure: its stiffness, what in it is not linear, what is not known.

What is not known of its parameters is moves along axes that are apart from each other; a positive
parameter moves by its logarithm: known within a factor, it must not go below zero.

Friction, a slider, a stop and a power of the speed are followed for what they are, step by step:
within a step each such force is constant, taken in the middle of the step, that of a slider as it
moves along. Where a force jumps as the motion turns (dry friction), the damper sticks if a force
between the ends of the jump brings it to rest at the end of the step: a jump is no steep slope, and
what sticks does not creep (Moreau 1988, Unilateral contact and dry friction in finite freedom
dynamics, doi:10.1007/978-3-7091-2624-0_1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError
from springpot.identification.prediction import Known
from springpot.measurement.covered import Covered
from springpot.measurement.units import AMPLITUDE_UNITS, STIFFNESS_UNITS, Units
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.model import Model, sorted_out
from springpot.rheology.named import Placed
from springpot.rheology.nodes import FULL
from springpot.rheology.points import HALF_PI, KELVIN, ROOM, Complex, Points, Real

from ..numerics import HALVINGS, MOST_STEPS, NEGLIGIBLE, ROUNDING


def _by_factors(model: Model, theta: Real) -> NDArray[np.bool_]:
    log = np.array([parameter.scale == "log" for parameter in model.parameters], dtype=bool)
    return log & (theta > 0.0)


def sizes_of(model: Model, theta: Real) -> Real:
    """By how much theta (p,) changes with a move of one, to begin with."""
    return np.where(_by_factors(model, theta), theta, 1.0)


def axes_of(model: Model, theta: Real, covariance: Real) -> Real:
    """Moves (p, q) by one standard deviation each, from the covariance (p, p) of theta (p,)."""
    size = sizes_of(model, theta)
    # By eigenvalues: the covariance of a parameter on its bound is zero, and rounding may make it
    # less.
    squares, axes = np.linalg.eigh(covariance / np.outer(size, size))
    return np.asarray(axes * np.sqrt(np.abs(squares)))


def moved(model: Model, theta: Real, move: Real) -> Real:
    """Parameters after a move (p,), within their bounds: beyond, they would be no such model."""
    log = _by_factors(model, theta)
    there = np.where(log, theta * np.exp(np.where(log, move, 0.0)), theta + move)
    return np.clip(there, *model.box)


@dataclass(frozen=True, eq=False)
class Damper:
    """An identified damper.

    Parameters
    ----------
    model : Model
        Of a stiffness.
    theta : ndarray, shape (p,)
        Its parameters, in SI units (N, m, s) unless `units` say otherwise.
    storey : int
        Which one it braces, 1 for the lowest.
    count : float
        How many there are.
    covariance : ndarray, shape (p, p), optional
        Of theta.
    temperature : float, optional
        In degC.
    reference : float
        Temperature in kelvin at which shifts are one.
    units : Units
        Of stiffness and displacement, in which theta is.
    covered : Covered
        What it was measured at.
    cosine : float
        Of the slope against the floor.
    heat_capacity : float, optional
        Of one damper, in J/K.
    scale : tuple of float, optional
        Stiffness in N/m and displacement in m of which theta counts one, where they are not the
        units themselves: of a damper that is larger than what was tested.
    factors : tuple of float
        Least and largest property modification factor of its force.
    tested : Known, optional
        The fit that it is from, with what that had of the rig: its covariance counts then.

    Raises
    ------
    ModelError
        If there is none of them, or they stand upright; or if the model has an effect of the rig or
        of the signals, which belong to no damper. What is not linear and stands beside the material
        - friction, a slider, a stop - is taken as part of the damper.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Model, dashpot
    >>> from springpot.structure import Damper
    >>> damper = Damper(Model("dashpot", dashpot()), np.array([500.0]), count=2.0)
    >>> damper.stiffness(np.array([1j]))[0].round(6)
    array([0.+1000.j])
    """

    model: Model
    theta: Real
    storey: int = 1
    count: float = 1.0
    covariance: Real | None = None
    temperature: float | None = None
    reference: float = ROOM
    units: Units = field(default_factory=lambda: Units("N/m", "m"))
    covered: Covered = field(default_factory=Covered)
    cosine: float = 1.0
    heat_capacity: float | None = None
    scale: tuple[float, float] | None = None
    factors: tuple[float, float] = (1.0, 1.0)
    tested: Known | None = None

    def __post_init__(self) -> None:
        if not self.count > 0.0:
            raise ModelError(f"there are {self.count:g} of a damper: its count is above zero")
        # An upright one feels nothing of a drift, and its force is endless beside it.
        if not NEGLIGIBLE < self.cosine <= 1.0:
            raise ModelError(
                "a damper slopes by less than 90 degrees against the floor, either way"
            )
        for effect in self.linear.effects:
            if effect.layer > Layer.SPECIMEN:
                raise ModelError(
                    f"'{effect.name}' belongs to the rig, not to the damper: leave it out, "
                    f"without = ['{effect.name}']"
                )
            if "amplitude" in effect.needs:
                raise ModelError(
                    f"'{effect.name}' is known by its first harmonic alone, and has no law in time:"
                    f" leave it out, without = ['{effect.name}']"
                )
        # A part in series with one that gives no force is no number, nor is what is too large.
        with np.errstate(all="ignore"):
            stiffness, _ = self.stiffness(np.array([1j]))
            numbers = np.concatenate([stiffness, self.theta**2])
        if not np.all(np.isfinite(numbers)):
            values = self.model.named(self.theta).items()
            given = ", ".join(f"{name} = {value:g}" for name, value in values)
            raise ModelError(
                f"a damper of {self.model.name} with {given} has no stiffness that is a number"
            )
        for effect, _ in self.beside:
            if getattr(effect.element, "flows", False):
                raise ModelError(
                    f"'{effect.name}' flows by a clock of its own, which no step of a structure"
                    f" follows: leave it out, without = ['{effect.name}']"
                )

    @cached_property
    def _placed(self) -> Sequence[Placed]:
        """The effects that are not linear, each with the place of its parameters."""
        return sorted_out(self.model)[1]

    @property
    def beside(self) -> list[tuple[Effect, Real]]:
        """The effects that are not linear, with their parameters."""
        return [(effect, self.theta[own]) for effect, _, own in self._placed]

    @cached_property
    def linear(self) -> Model:
        """The model without them."""
        names = {effect.name for effect, _, _ in self._placed}
        kept = [effect for effect in self.model.effects if effect.name not in names]
        return replace(self.model, effects=tuple(kept))

    @property
    def linear_theta(self) -> Real:
        """Parameters of `linear`."""
        return self.theta[[self.model.names.index(name) for name in self.linear.names]]

    @property
    def size(self) -> float:
        """Stiffness in N/m along the floor of all dampers of this kind together, for a K of one."""
        # Once for the drift that reaches the damper, once for its force that is along the floor.
        return self.count * self.cosine**2 * self.unit

    @property
    def unit(self) -> float:
        """Stiffness in N/m of which theta counts one."""
        if self.scale is not None:
            return self.scale[0]
        return STIFFNESS_UNITS[self.units.stiffness]

    @property
    def length(self) -> float:
        """Displacement in m of which theta counts one."""
        if self.scale is not None:
            return self.scale[1]
        return AMPLITUDE_UNITS[self.units.amplitude]

    def remark(self, omega: Real, of: str) -> str:
        """One line on where it is used outside of what was measured; nothing where it is not.

        Parameters
        ----------
        omega : ndarray, shape (n,)
            At which it is used, in rad/s.
        of : str
            What these belong to, such as ``modes``.
        """
        return self.covered.remark(omega, self._conditions, self.units, of=of)

    def outside(self, omega: Real) -> NDArray[np.bool_]:
        """Whether it was measured at none of these (n,), in rad/s, or not at its temperature."""
        return self.covered.outside(omega, self._conditions)

    def remark_on_stroke(self, stroke: float) -> str:
        """One line where its largest stroke in m lies outside of the measured amplitudes."""
        rate = np.array([max(self.covered.rate[0], np.finfo(float).tiny)])
        used = {"amplitude": np.array([stroke / self.length])}
        return self.covered.remark(rate, used, self.units, of="peak strokes")

    @property
    def _conditions(self) -> dict[str, Real]:
        if self.temperature is None:
            return {}
        return {"temperature": np.array([self.temperature])}

    @property
    def kelvin(self) -> float | None:
        """Its temperature in kelvin."""
        if self.temperature is None:
            return None
        return self.temperature + KELVIN

    def stiffness(self, s: Complex) -> tuple[Complex, Complex]:
        """K and dK/ds in N/m of all dampers of this kind together, at s (n,) in 1/s.

        s may be complex. What is not linear is left out.
        """
        kelvin = None
        if self.kelvin is not None:
            kelvin = np.full(len(s), self.kelvin)
        turned: Any = np.log(s) - HALF_PI
        at = Points(turned, None, kelvin, self.reference)
        response = self.linear.network.respond(self.linear_theta, at, FULL)
        # By ln s: dK/ds is dK/d(ln s) over s.
        return self.size * response.value, self.size * response.by_log_omega / s

    def bound(self, end: int) -> Damper:
        """The same with its force at the least (0) or largest (1) of its factors."""
        scale = self.factors[end] * self.unit, self.length
        return replace(self, scale=scale, factors=(1.0, 1.0))

    @cached_property
    def axes(self) -> Real:
        """Moves (p, q) of its parameters by one standard deviation, as `unknown.axes_of`.

        Of a fit in which there was more than the damper has, the rows of what it has.
        """
        if self.tested is not None:
            axes = axes_of(self.tested.model, self.tested.theta, self.tested.theta_covariance)
            return axes[[self.tested.model.names.index(name) for name in self.model.names]]
        if self.covariance is not None:
            return axes_of(self.model, self.theta, self.covariance)
        return np.zeros((len(self.theta), 0))

    def moved(self, along: Real) -> Damper:
        """The same, moved along its `axes` by so many standard deviations (q,)."""
        if not self.axes.size:
            return self
        return replace(self, theta=moved(self.model, self.theta, self.axes @ along))


CLOSE = 1e-7
"""Relative change of the forces at which they are found.

Far below what the length of a step changes.
"""
CALM = 8
"""Rounds after which only half of a change is taken, and so on.

Near rest a power of the speed may be steep.
"""


class Beside:
    """The forces of one entry of dampers that are not linear.

    Parameters
    ----------
    damper : Damper
        With such effects.
    """

    def __init__(self, damper: Damper) -> None:
        self.along = damper.cosine / damper.length
        # The cosine of the way is in `along` already: here is that of the force.
        self.size = damper.count * damper.cosine * damper.unit * damper.length
        self.laws: list[tuple[Any, list[float]]] = []
        self.sliders: list[tuple[Callable[..., float], list[float]]] = []
        for effect, theta in damper.beside:
            # A slider remembers its force; any other law is told by the motion of the moment.
            slides = getattr(effect.element, "step", None)
            if slides is None:
                self.laws.append((effect.element, theta.tolist()))
            else:
                self.sliders.append((slides, theta.tolist()))
        self.carried = [0.0] * len(self.sliders)
        # Asked on either side of rest: what differs there by more than a slope could is a jump.
        back, on = self._pointwise(0.0, -ROUNDING), self._pointwise(0.0, ROUNDING)
        self.jumps = on - back > NEGLIGIBLE * (
            self._pointwise(0.0, 1.0) - self._pointwise(0.0, -1.0)
        )

    def _pointwise(self, way: float, speed: float) -> float:
        """Force in the damper's own units, of all laws that remember nothing."""
        now, here, fast = np.zeros(1), np.array([way]), np.array([speed])
        force = 0.0
        for element, theta in self.laws:
            value, _ = element.in_time(now, here, fast, *theta)
            force += float(value[0])
        return force

    def _slid(self, way: float) -> list[float]:
        """Forces of the sliders after a way within the step."""
        pairs = zip(self.sliders, self.carried, strict=True)
        return [slides(before, way, *theta) for (slides, theta), before in pairs]

    def ends(
        self, start: float, end: float, start_speed: float, end_speed: float
    ) -> tuple[float, float]:
        """Least and largest force in N along the floor in a step; where nothing jumps they are one.

        Parameters
        ----------
        start, end : float
            Drift in m at both ends of the step.
        start_speed, end_speed : float
            In m/s.
        """
        # In the middle of the step: the error then falls with the square of its length.
        way, speed = 0.5 * self.along * (start + end), 0.5 * self.along * (start_speed + end_speed)
        slid = 0.5 * sum(self.carried) + 0.5 * sum(self._slid(self.along * (end - start)))
        if not self.jumps:
            force = self.size * (self._pointwise(way, speed) + slid)
            return force, force
        back, on = (
            self._pointwise(way, min(speed, -ROUNDING)),
            self._pointwise(way, max(speed, ROUNDING)),
        )
        return self.size * (back + slid), self.size * (on + slid)

    def move(self, way: float) -> None:
        """Let a step be over, in which the drift changed by so much."""
        self.carried = self._slid(self.along * way)


def forces(
    besides: Sequence[Beside],
    start: tuple[Real, Real],
    free: tuple[Real, Real],
    by_force: tuple[Real, Real],
    guess: Real,
) -> Real:
    """The forces (q,) in N of a step, at which motion and laws agree.

    Parameters
    ----------
    besides : sequence of Beside
        The q dampers.
    start, free : tuple of ndarray, shape (q,)
        Drifts and their speeds at the beginning of the step, and at its end without these forces.
    by_force : tuple of ndarray, shape (q, q)
        What each force, constant in the step, changes of both at its end.
    guess : ndarray, shape (q,)
        Such as the forces of the step before.
    """
    (first, first_speed), (last, last_speed) = start, free
    way_by, speed_by = by_force
    force, share = guess, 1.0
    low, high = np.full(len(guess), np.nan), np.full(len(guess), np.nan)
    for turn in range(MOST_STEPS):
        end, end_speed = last + way_by @ force, last_speed + speed_by @ force
        motion = zip(
            besides,
            first.tolist(),
            end.tolist(),
            first_speed.tolist(),
            end_speed.tolist(),
            strict=True,
        )
        ends = np.array([beside.ends(*each) for beside, *each in motion])
        size = np.abs(ends).max()
        # In the first round there is nothing to compare with.
        if turn and np.abs(ends - np.column_stack([low, high])).max() <= CLOSE * size:
            break
        if turn >= CALM:
            share *= 0.9
            ends = share * ends + (1.0 - share) * np.column_stack([low, high])
        low, high = ends.T
        force = _at_rest_if_it_can(last_speed, speed_by, low, high, force)
    return force


def _at_rest_if_it_can(
    free_speed: Real, by_force: Real, low: Real, high: Real, force: Real
) -> Real:
    """Forces (q,) from `low` to `high` that bring each damper to rest, or as near as they can."""
    if np.array_equal(low, high):
        return low.copy()
    ends = list(zip(low.tolist(), high.tolist(), strict=True))
    now, matrix, speeds = force.tolist(), by_force.tolist(), free_speed.tolist()
    # Dampers of neighbouring storeys that stick feel each other by half: each sweep halves what
    # is left.
    for _ in range(HALVINGS):
        change = 0.0
        for i, (row, (least, most)) in enumerate(zip(matrix, ends, strict=True)):
            others = speeds[i] + sum(a * b for a, b in zip(row, now, strict=True)) - row[i] * now[i]
            # One damper after the other, each at rest beside what the others do now (Gauss and
            # Seidel).
            stopping = min(max(-others / row[i], least), most)
            change = max(change, abs(stopping - now[i]))
            now[i] = stopping
        # One damper alone is at rest at once: there is no neighbour that moves it again.
        if len(now) == 1 or change <= CLOSE * max(map(abs, now)):
            break
    return np.array(now)
