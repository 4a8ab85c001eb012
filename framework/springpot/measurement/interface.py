"""A measurement of a damper as one of its material, and back, through the geometry between them."""

from __future__ import annotations

from .geometry import Geometry
from .measurement import Measurement


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
    return measurement.as_modulus(geometry, unit)


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
    return measurement.as_stiffness(geometry, unit, amplitude)


def through(measurement: Measurement, geometry: Geometry) -> Measurement:
    """The other side of the geometry: the material of a measured damper, or the damper of a measured material."""
    if measurement.units.is_modulus:
        return measurement.as_stiffness(geometry)
    return measurement.as_modulus(geometry)
