"""From stiffnesses of a damper to moduli of its material and back.

The factors and units that a geometry gives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from springpot.errors import DataError
from springpot.rheology.points import Complex, Real

from .geometry import Geometry
from .units import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    STRAIN_UNITS,
    TORSION_UNITS,
    Units,
    known_unit,
    one_modulus,
)


class Converted(Protocol):
    """A test of any kind, of which a geometry makes another."""

    @property
    def name(self) -> str:
        """Shown in messages."""

    @property
    def units(self) -> Units:
        """Of stiffness and displacement."""

    @property
    def conditions(self) -> Mapping[str, Real]:
        """Columns of numbers, an amplitude among them or not."""


@dataclass(frozen=True)
class Conversion:
    """How columns of one side of a geometry become those of the other.

    Attributes
    ----------
    geometry : Geometry
        Of the specimen or damper.
    factor : float
        By which the stiffness is multiplied or divided.
    reach : float
        The same for the amplitude, which goes the other way.
    by : ufunc
        `numpy.multiply` or `numpy.divide`, for the stiffness.
    units : Units
        Of the other side.
    """

    geometry: Geometry
    factor: float
    reach: float
    by: np.ufunc
    units: Units

    def stiffness(self, values: Complex) -> Complex:
        """Real and imaginary parts (n,) each times or over a real factor, with one rounding."""
        # NumPy divides complex numbers by complex ones, which rounds more than once.
        parts = np.ascontiguousarray(values).view(float)
        result: Complex = self.by(parts, self.factor).view(np.complex128)
        return result

    def amplitude(self, values: Real) -> Real:
        """Amplitudes (n,) of the other side."""
        # A modulus is the greater the smaller its strain: amplitudes go the other way.
        if self.by is np.multiply:
            return np.asarray(np.divide(values, self.reach))
        return np.asarray(np.multiply(values, self.reach))


def to_modulus(measured: Converted, geometry: Geometry, unit: str) -> Conversion:
    """From force over displacement to stress over strain.

    See `springpot.measurement.as_modulus`.
    """
    # Torque over angle and force over displacement take other geometries: the pair is checked
    # before any number.
    units, table, reach = measured.units, *_kinds(geometry)
    if units.stiffness not in table:
        raise _misfit(measured, geometry, table)
    unit = known_unit(unit, PRESSURE_UNITS, "a modulus")
    factor = _factor(geometry, units.stiffness, table, unit)
    scale = geometry.strain_factor * reach.get(units.amplitude, 1.0)
    if "amplitude" in measured.conditions and units.amplitude not in reach:
        there = (
            f"{geometry.name} needs an amplitude in {_some(reach)}, not in"
            f" {_shown(units.amplitude)}"
        )
        raise DataError(f"{measured.name}: {there}")
    return Conversion(
        geometry, factor, scale, np.divide, Units(unit, "-", units.clock, geometry.modulus)
    )


def to_stiffness(
    measured: Converted, geometry: Geometry, unit: str | None, amplitude: str | None
) -> Conversion:
    """From stress over strain to force over displacement.

    See `springpot.measurement.as_stiffness`.
    """
    table, reach = _kinds(geometry)
    units = measured.units
    if units.stiffness not in PRESSURE_UNITS:
        raise _misfit(measured, geometry, PRESSURE_UNITS)
    one_modulus([(measured.name, units), (geometry.name, replace(units, letter=geometry.modulus))])
    usual, usual_amplitude = "N/m", "m"
    if geometry.turns:
        usual, usual_amplitude = "N m/rad", "rad"
    unit = known_unit(unit or usual, table, "a stiffness")
    amplitude = known_unit(amplitude or usual_amplitude, reach, "an amplitude")
    factor = _factor(geometry, unit, table, units.stiffness)
    if "amplitude" in measured.conditions and units.amplitude not in STRAIN_UNITS:
        raise DataError(
            f"{measured.name}: a modulus needs a strain as amplitude, not [{units.amplitude}]"
        )
    strain = STRAIN_UNITS.get(units.amplitude, 1.0)
    scale = geometry.strain_factor * reach[amplitude] / strain
    return Conversion(geometry, factor, scale, np.multiply, Units(unit, amplitude, units.clock))


def _kinds(geometry: Geometry) -> tuple[dict[str, float], dict[str, float]]:
    """Units of stiffness and of amplitude that a test of this geometry has."""
    if geometry.turns:
        return TORSION_UNITS, ANGLE_UNITS
    return STIFFNESS_UNITS, LENGTH_UNITS


def _factor(geometry: Geometry, stiffness: str, table: dict[str, float], modulus: str) -> float:
    """K / G in these units.

    Both ways use this very number, so that a round trip errs by one rounding at most.
    """
    return geometry.shape * PRESSURE_UNITS[modulus] / table[stiffness]


def _misfit(measured: Converted, geometry: Geometry, table: Mapping[str, float]) -> DataError:
    what = "force and displacement"
    if geometry.turns:
        what = "torque and angle"
    return DataError(
        f"{measured.name}: {geometry.name} relates {what} to stress and strain; storage and loss"
        f" are in {measured.units.stiffness}, where {_some(table)} would serve"
    )


def _some(table: Mapping[str, float]) -> str:
    return ", ".join(list(table)[:3]) + ", ..."


def _shown(unit: str) -> str:
    if unit == "-":
        return "a plain number"
    return unit
