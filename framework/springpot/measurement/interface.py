"""A measurement of a damper as one of its material, and back, through the geometry between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError

from .geometry import Geometry
from .geometry_text import said
from .measurement import Measurement
from .units import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    STRAIN_UNITS,
    TORSION_UNITS,
    Units,
    known_unit,
)


def as_modulus(measurement: Measurement, geometry: Geometry, unit: str = "Pa") -> Measurement:
    """Stress over strain of the material, from force over displacement (torque over angle).

    Parameters
    ----------
    measurement : Measurement
        In any unit of stiffness; an amplitude becomes a strain, standard deviations are converted too.
    geometry : Geometry
        Of the specimen or damper.
    unit : str
        Unit of storage and loss.

    Raises
    ------
    DataError
        If the measurement is a modulus already, or the geometry turns and the test did not.
    """
    units, table, reach = measurement.units, *_kinds(geometry)
    if units.stiffness not in table:
        raise _misfit(measurement, geometry, table)
    unit = known_unit(unit, PRESSURE_UNITS, "a modulus")
    factor = _factor(geometry, units.stiffness, table, unit)
    scale = 1.0
    if "amplitude" in measurement.conditions:
        if units.amplitude not in reach:
            there = f"{geometry.name} needs an amplitude in {_some(reach)}, not in {_shown(units.amplitude)}"
            raise DataError(f"{measurement.name}: {there}")
        scale = geometry.strain_factor * reach[units.amplitude]
    return _scaled(measurement, geometry, (factor, scale), Units(unit, "-", units.clock), np.divide)


def as_stiffness(
    measurement: Measurement, geometry: Geometry, unit: str | None = None, amplitude: str | None = None
) -> Measurement:
    """Force over displacement (torque over angle) of a damper, from stress over strain of its material.

    Parameters
    ----------
    measurement : Measurement
        In any unit of pressure; a strain amplitude becomes a displacement (an angle).
    geometry : Geometry
        Of the specimen or damper.
    unit : str, optional
        Unit of storage and loss; ``N/m`` or ``N m/rad`` by default.
    amplitude : str, optional
        Unit of the amplitude; ``m`` or ``rad`` by default.

    Raises
    ------
    DataError
        If the measurement is no modulus.
    """
    table, reach = _kinds(geometry)
    units = measurement.units
    if units.stiffness not in PRESSURE_UNITS:
        raise _misfit(measurement, geometry, PRESSURE_UNITS)
    unit = known_unit(unit or ("N m/rad" if geometry.turns else "N/m"), table, "a stiffness")
    amplitude = known_unit(amplitude or ("rad" if geometry.turns else "m"), reach, "an amplitude")
    factor = _factor(geometry, unit, table, units.stiffness)
    scale = 1.0
    if "amplitude" in measurement.conditions:
        if units.amplitude not in STRAIN_UNITS:
            raise DataError(f"{measurement.name}: a modulus needs a strain as amplitude, not [{units.amplitude}]")
        scale = geometry.strain_factor * reach[amplitude] / STRAIN_UNITS[units.amplitude]
    return _scaled(measurement, geometry, (factor, scale), Units(unit, amplitude, units.clock), np.multiply)


def through(measurement: Measurement, geometry: Geometry) -> Measurement:
    """The other side of the geometry: the material of a measured damper, or the damper of a measured material."""
    return (as_stiffness if measurement.units.is_modulus else as_modulus)(measurement, geometry)


def _kinds(geometry: Geometry) -> tuple[dict[str, float], dict[str, float]]:
    return (TORSION_UNITS, ANGLE_UNITS) if geometry.turns else (STIFFNESS_UNITS, LENGTH_UNITS)


def _factor(geometry: Geometry, stiffness: str, table: dict[str, float], modulus: str) -> float:
    """K / G in these units; both ways use this very number, so that a round trip errs by one rounding at most."""
    return geometry.shape * PRESSURE_UNITS[modulus] / table[stiffness]


def _scaled(
    measurement: Measurement, geometry: Geometry, factors: tuple[float, float], units: Units, by: np.ufunc
) -> Measurement:
    """The measurement with K multiplied or divided by the first factor; the amplitude goes the other way."""
    other = np.divide if by is np.multiply else np.multiply
    conditions = dict(measurement.conditions)
    if "amplitude" in conditions:
        conditions["amplitude"] = other(conditions["amplitude"], factors[1])
    return replace(
        measurement,
        stiffness=_both(measurement.stiffness, factors[0], by),
        sd=None if measurement.sd is None else _both(measurement.sd, factors[0], by),
        conditions=conditions,
        units=units,
        provenance={**measurement.provenance, "geometry": said(geometry)},
    )


def _both(values: NDArray[np.complex128], factor: float, by: np.ufunc) -> NDArray[np.complex128]:
    """Real and imaginary parts each times or over a real factor, with one rounding."""
    parts = np.ascontiguousarray(values).view(float)
    result: NDArray[np.complex128] = by(parts, factor).view(np.complex128)
    return result


def _misfit(measurement: Measurement, geometry: Geometry, table: Mapping[str, float]) -> DataError:
    what = "torque and angle" if geometry.turns else "force and displacement"
    return DataError(
        f"{measurement.name}: {geometry.name} relates {what} to stress and strain; storage and loss are in "
        f"{measurement.units.stiffness}, where {_some(table)} would serve"
    )


def _some(table: Mapping[str, float]) -> str:
    return ", ".join(list(table)[:3]) + ", ..."


def _shown(unit: str) -> str:
    return "a plain number" if unit == "-" else unit
