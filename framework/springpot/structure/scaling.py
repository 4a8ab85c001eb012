"""From what was tested to the damper in the building: by the geometry of both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from springpot.errors import ModelError
from springpot.measurement.geometry import EXAMPLE, Geometry, to_modulus, to_stiffness
from springpot.measurement.units import STIFFNESS_UNITS, Units
from springpot.rheology.points import Real


@dataclass(frozen=True)
class _Tested:
    """What a geometry converts, named as the message shall name it."""

    name: str
    units: Units
    conditions: Mapping[str, Real] = field(default_factory=dict)


def scale_of(
    name: str, units: Units, geometry: Geometry, specimen: Geometry | None = None
) -> tuple[float, float]:
    """Stiffness in N/m and displacement in m of a damper for one of each of what was tested.

    Parameters
    ----------
    name : str
        Of the damper, for messages.
    units : Units
        Of what was tested.
    geometry : Geometry
        Of the damper.
    specimen : Geometry, optional
        Of what was tested, where that was a stiffness and no modulus.

    Raises
    ------
    SpringpotError
        If these do not fit each other, in one line.

    Examples
    --------
    >>> from springpot.measurement import parse_geometry
    >>> from springpot.measurement.units import Units
    >>> from springpot.structure.scaling import scale_of
    >>> pads = parse_geometry("shear-pads area=0.02m^2 gap=10mm")
    >>> scale_of("damper 1", Units("kPa", "-"), pads)
    (2000.0, 0.01)
    """
    if units.stiffness in STIFFNESS_UNITS and specimen is None:
        raise ModelError(
            f"{name}: what was tested is a stiffness in {units.stiffness}: give its own geometry"
            f" too, specimen = '{EXAMPLE}'"
        )
    factor, reach = 1.0, 1.0
    if specimen is not None:
        there = to_modulus(_Tested(name, units), specimen, "Pa")
        factor, reach, units = there.factor, there.reach, there.units
    here = to_stiffness(_Tested(name, units), geometry, "N/m", "m")
    return here.factor / factor, reach / here.reach
