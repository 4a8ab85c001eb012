"""A test of a damper as one of its material, and back, through the geometry between them."""

from __future__ import annotations

from typing import TypeVar

from .geometry import Geometry
from .measurement import Measurement
from .timetest import TimeTest

Test = TypeVar("Test", Measurement, TimeTest)


def as_modulus(measurement: Test, geometry: Geometry, unit: str = "Pa") -> Test:
    """Stress over strain of the material, from force over displacement (torque over angle).

    Parameters
    ----------
    measurement : Measurement or TimeTest
        In any unit of stiffness; an amplitude becomes a strain, standard deviations are converted
        too. Of a test in time its record, and what was imposed.
    geometry : Geometry
        Of the specimen or damper.
    unit : str
        Unit of storage and loss.

    Raises
    ------
    DataError
        If the measurement is a modulus already, or the geometry turns and the test did not.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement, Units
    >>> from springpot.measurement import as_modulus, parse_geometry
    >>> damper = Measurement([1.0], [100.0 + 50.0j], units=Units("kN/m", "mm"))
    >>> geometry = parse_geometry("shear-pads area=200cm^2 gap=10mm pads=2")
    >>> as_modulus(damper, geometry, "MPa").stiffness
    array([0.025+0.0125j])
    """
    return measurement.as_modulus(geometry, unit)


def as_stiffness(
    measurement: Test,
    geometry: Geometry,
    unit: str | None = None,
    amplitude: str | None = None,
) -> Test:
    """Force over displacement (torque over angle) of a damper, from its material's modulus.

    The modulus is stress over strain.

    Parameters
    ----------
    measurement : Measurement or TimeTest
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

    Examples
    --------
    >>> from springpot import Measurement, Units
    >>> from springpot.measurement import as_stiffness, parse_geometry
    >>> material = Measurement([1.0], [0.025 + 0.0125j], units=Units("MPa"))
    >>> geometry = parse_geometry("shear-pads area=200cm^2 gap=10mm pads=2")
    >>> as_stiffness(material, geometry, "kN/m").stiffness
    array([100.+50.j])
    """
    return measurement.as_stiffness(geometry, unit, amplitude)


def through(measurement: Test, geometry: Geometry) -> Test:
    """The other side of the geometry.

    The material of a measured damper, or the damper of a measured material.

    Examples
    --------
    >>> from springpot import Measurement, Units
    >>> from springpot.measurement import parse_geometry, through
    >>> damper = Measurement([1.0], [100.0 + 50.0j], units=Units("kN/m", "mm"))
    >>> through(damper, parse_geometry("shear-pads area=200cm^2 gap=10mm")).units.stiffness
    'Pa'
    """
    if measurement.units.is_modulus:
        return measurement.as_stiffness(geometry)
    return measurement.as_modulus(geometry)
