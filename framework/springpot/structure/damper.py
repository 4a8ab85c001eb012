"""An identified damper in a structure: its stiffness, its size, and what is not known of it."""

from __future__ import annotations

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

from ..numerics import NEGLIGIBLE
from .unknown import axes_of, moved


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
            values = zip(self.model.names, self.theta.tolist(), strict=True)
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
    def _placed(self) -> list[Placed]:
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
