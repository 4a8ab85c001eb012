"""The law by which a material's times follow the temperature, as solvers have it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.rheology.model import Model
from springpot.rheology.nodes import VALUE, Shift
from springpot.rheology.points import GAS_CONSTANT, KELVIN, Points, Real

from ..numerics import ALIKE, DECADE

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
    warm = [placed for placed in model.placed() if "temperature" in placed.effect.needs]
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
