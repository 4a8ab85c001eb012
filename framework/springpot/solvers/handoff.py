"""What an identified model hands to a solver: its series, and the law that shifts its times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.units import MODULUS_WORDS
from springpot.rheology.model import Model
from springpot.rheology.nodes import VALUE, Shift
from springpot.rheology.points import GAS_CONSTANT, KELVIN, Points, Real

from ..numerics import ALIKE, DECADE
from .prony import Solid, solid_of, young_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from springpot.rheology.points import Complex, Real

    from .prony import Prony


@dataclass(frozen=True, eq=False)
class Handoff:
    """A model as a Prony series, with all that its first lines must say.

    Attributes
    ----------
    prony : Prony
        The series, in the unit of `unit`.
    model : str
        Its expression.
    parameters : dict of str to str
        Each with its value and unit, as printed.
    unit : str
        Of the stiffness or modulus, such as ``kN/m`` or ``MPa``; empty if nobody said.
    is_modulus : bool
        Whether stress over strain is meant, rather than force over displacement.
    poisson : float, optional
        Poisson's ratio, for formats that describe a solid.
    name : str
        What the material or damper shall be called.
    exact : callable, optional
        From angular frequencies in rad/s to the model's own complex K, for formats that hold K
        itself.
    letter : {"", "G", "E", "K"}
        Which modulus it is: shear, Young's or bulk; empty for a stiffness, or if nobody said.
    bulk : {"constant", "relaxing"}, optional
        What the bulk modulus of a solid does; see `solid_of`.
    covered : tuple of float, optional
        Angular frequencies in rad/s between which the model was measured, where it was.
    remarks : tuple of str
        What was measured and what lies outside, in lines for the heading.
    shift : ShiftLaw, optional
        By which the times of the series follow the temperature.
    beside : dict of str to dict
        What is not linear and stands beside the series, where the format asks for it: by the name
        of its effect its parameters, in `unit` and the length that belongs to it.
    number : int
        Of the material among several in one file, from one.
    """

    prony: Prony
    model: str
    parameters: dict[str, str]
    unit: str
    is_modulus: bool
    poisson: float | None = None
    name: str = "springpot"
    exact: Callable[[Real], Complex] | None = None
    letter: str = ""
    bulk: str | None = None
    covered: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()
    shift: ShiftLaw | None = None
    beside: dict[str, dict[str, float]] = field(default_factory=dict)
    number: int = 1

    @cached_property
    def solid(self) -> Solid:
        """The shear and bulk modulus, for formats that describe a solid.

        Raises
        ------
        ModelError
            If it is not known which modulus this is, or Poisson's ratio is not.
        """
        if not self.letter:
            raise ModelError(
                f"{self.model} in {self.unit} is a shear, Young's or bulk modulus, which the data"
                " do not say: give --modulus shear, young or bulk"
            )
        # At 0.5 the bulk modulus is without end, and below -1 the shear modulus is negative.
        if self.poisson is None or not -1.0 < self.poisson < 0.5:
            raise ModelError(
                "a solid needs Poisson's ratio, above -1 and below 0.5: give --poisson 0.49"
            )
        return solid_of(self.prony, self.letter, self.poisson, self.bulk)

    def as_modulus(self, letter: str) -> Handoff:
        """The same as the series of a shear (``G``) or Young's modulus (``E``).

        A stiffness as it is.

        Raises
        ------
        ModelError
            As of `solid`.
        """
        if not self.is_modulus or self.letter == letter:
            return self
        if self.beside:
            raise ModelError(
                f"'{next(iter(self.beside))}' of {self.model} is told in another modulus than that"
                " which the format takes: no law of elasticity turns a slider's stress into it"
            )
        series = self.solid.shear
        if letter == "E":
            series = young_of(self.solid)
        remarks = (*self.remarks, self.solid.says)
        # The model itself is of the measured modulus: what reads it would take it for the other.
        return replace(self, prony=series, letter=letter, exact=None, remarks=remarks)

    @cached_property
    def outside(self) -> NDArray[np.bool_]:
        """Whether each term (m,) has its rate outside of what was measured."""
        rates = 1.0 / self.prony.times
        low, high = self.covered or (0.0, np.inf)
        return np.asarray((rates < low) | (rates > high))

    def stiffness(self, omega: Real) -> Complex:
        """K (n,) at omega (n,) in rad/s.

        That of the model itself where it is known, else that of the series.
        """
        if self.exact is None:
            return self.prony.stiffness(omega)
        return self.exact(omega)

    def heading(self) -> list[str]:
        """What it is, in lines of plain text.

        Model, parameters, band, error, unit, long-term and instantaneous.
        """
        prony = self.prony
        low, high = (omega / (2.0 * np.pi) for omega in prony.band)
        # A solver has no units: what the numbers are in must be read from the file's first lines.
        unit = self.unit or "unit of the parameters"
        what = "stiffness"
        if self.is_modulus:
            what = MODULUS_WORDS[self.letter]
        values = ", ".join(f"{name} = {value}" for name, value in self.parameters.items())
        dashpot = ""
        if prony.viscosity:
            dashpot = f", beside a dashpot of {prony.viscosity:.9g} [{unit} s]"
        return [
            f"springpot: {self.model}: {values}",
            (
                f"Prony series of {len(prony.times)} terms for {low:.6g} to {high:.6g} Hz, "
                f"within {100 * prony.error:.3g} % of |K| of the model"
            ),
            (
                f"{what} in {unit}, times in s; long-term {prony.equilibrium:.9g}, instantaneous"
                f" {prony.instantaneous:.9g}{dashpot}"
            ),
            *self.remarks,
            *([] if self.shift is None else [self.shift.says]),
        ]


ABOUT = np.array([-8.0, -5.0, 4.0, 9.0, 15.0])
"""Kelvin from the reference at which a law is recognised by its shape."""


@dataclass(frozen=True)
class ShiftLaw:
    """All times follow one factor a_T, which is one at the reference.

    Attributes
    ----------
    reference : float
        In degC.
    kind : {"wlf", "arrhenius"}
        log10 a_T = -C1 (T - Tr) / (C2 + T - Tr), or ln a_T = (E / R) (1/T - 1/Tr).
    constants : tuple of float
        C1 and C2 in kelvin, or E in J/mol.
    """

    reference: float
    kind: str
    constants: tuple[float, ...]

    def log_factor(self, celsius: Real) -> Real:
        """Ln a_T at these temperatures (n,) in degC."""
        above = np.asarray(celsius, dtype=float) - self.reference
        if self.kind == "wlf":
            c1, c2 = self.constants
            return np.asarray(-DECADE * c1 * above / (c2 + above))
        energy = self.constants[0] / (1e3 * GAS_CONSTANT)
        inverse = 1.0 / (self.reference + above + KELVIN) - 1.0 / (self.reference + KELVIN)
        return np.asarray(energy * inverse)

    @property
    def says(self) -> str:
        """The law in one line."""
        at = f"Tr = {self.reference:.6g} degC"
        if self.kind == "wlf":
            c1, c2 = self.constants
            return (
                f"times follow log10 a_T = -C1 (T - Tr) / (C2 + T - Tr), C1 = {c1:.9g}, C2 ="
                f" {c2:.9g} K, {at}"
            )
        return f"times follow ln a_T = E/R (1/T - 1/Tr), E = {self.constants[0]:.9g} J/mol, {at}"

    def to_dict(self) -> dict[str, object]:
        """As plain data."""
        return {
            "law": self.kind,
            "reference_degC": self.reference,
            "constants": list(self.constants),
        }


def shift_law_of(model: Model, theta: Real, reference: float) -> ShiftLaw | None:
    """The law of a model with its parameters (p,), reference in kelvin.

    Told by its shape, whatever effect or formula it is from. None where temperature does more than
    to shift times, or by another law.
    """
    warm = [placed for placed in model.placed if "temperature" in placed.effect.needs]
    if not warm or any(placed.effect.composition.kind is not Shift for placed in warm):
        return None
    kelvin = reference + ABOUT
    at = Points(np.zeros(len(kelvin)), None, kelvin, reference)
    factor = sum(
        (placed.effect.element.respond(theta[placed.own], at, VALUE).value.real for placed in warm),
        np.zeros(len(kelvin)),
    )
    # A law that does nothing has no constants.
    if not np.all(factor != 0.0):
        return None
    energies = 1e3 * GAS_CONSTANT * factor / (1.0 / kelvin - 1.0 / reference)
    if np.ptp(energies) <= ALIKE * np.abs(energies).max():
        return ShiftLaw(reference - KELVIN, "arrhenius", (float(energies.mean()),))
    # (T - Tr) / ln a is a straight line of T - Tr.
    slope, start = np.polyfit(ABOUT, ABOUT / factor, 1)
    if np.ptp(ABOUT / factor - start - slope * ABOUT) <= ALIKE * np.abs(ABOUT / factor).max():
        c1, c2 = -1.0 / (DECADE * slope), start / slope
        return ShiftLaw(reference - KELVIN, "wlf", (float(c1), float(c2)))
    return None
