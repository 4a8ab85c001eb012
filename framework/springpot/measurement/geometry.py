"""The geometry of a specimen or damper: how force and displacement become stress and strain.

With stress = a force and strain = b displacement the stiffness is K = (b / a) G: a damper and the
fluid in it are one model, K = G A / h for shear pads. Where the stress varies within the specimen,
stress and strain are those at the place that the geometry names; G does not depend on that choice.
Lengths in metres, angles in radians. The factors and units serve both ways: from stiffnesses of a
damper to moduli of its material, and back.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from difflib import get_close_matches
from math import cosh, inf, isfinite, log, pi, tanh
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from springpot.errors import DataError, OptionError, OutputError
from springpot.lazy import draw
from springpot.rheology.points import Complex, Real
from springpot.writing import LISTED, Html, joined, table, tag

from .units import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    STRAIN_UNITS,
    TORSION_UNITS,
    Units,
    known_unit,
    normal_unit,
    one_modulus,
)

if TYPE_CHECKING:
    from .rows import Rows

_TERMS = 200
"""Terms of the series for torsion.

They fall at least with the inverse square, and exponentially where it counts.
"""


@dataclass(frozen=True)
class Geometry(ABC):
    """A geometry; all sizes are positive and in SI units.

    Attributes
    ----------
    name : str
        What users type.
    turns : bool
        Whether it takes torque and angle rather than force and displacement.
    source : str
        Where the formulas are from.
    modulus : str
        Letter of the modulus that it gives: G where it shears.

    Examples
    --------
    >>> from springpot.measurement import parse_geometry
    >>> parse_geometry("parallel-plates diameter=25mm gap=1mm").strain_factor
    12.5
    """

    name: ClassVar[str]
    turns: ClassVar[bool] = False
    source: ClassVar[str]
    modulus: ClassVar[str] = "G"

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            # A yes or no is a number to Python too, and no is not positive.
            if not (isinstance(value, bool) or (isfinite(value) and value > 0)):
                raise OptionError(f"{self.name}: {field.name} must be positive, got {value:g}")

    @property
    @abstractmethod
    def stress_factor(self) -> float:
        """Stress for a force of 1 N (1/m^2), or for a torque of 1 N m (1/m^3)."""

    @property
    @abstractmethod
    def strain_factor(self) -> float:
        """Strain for a displacement of 1 m (1/m), or for an angle of 1 rad (1)."""

    @property
    def shape(self) -> float:
        """K / G in m, or in m^3 per radian where it turns."""
        return self.strain_factor / self.stress_factor


@dataclass(frozen=True)
class ShearPads(Geometry):
    """Plane pads in simple shear, as in a sandwich damper: K = n A G / h.

    Parameters
    ----------
    area : float
        Sheared area of one pad, m^2.
    gap : float
        Thickness h of one pad, m.
    pads : float
        Number n of pads that share the force.
    """

    name = "shear-pads"
    source = (
        "Soong, Dargush: Passive Energy Dissipation Systems in Structural Engineering (1997), ch. 3"
    )
    area: float
    gap: float
    pads: float = 1

    @property
    def stress_factor(self) -> float:
        """1 / (n A)."""
        return 1.0 / (self.pads * self.area)

    @property
    def strain_factor(self) -> float:
        """1 / h."""
        return 1.0 / self.gap


@dataclass(frozen=True)
class BondedBlock(Geometry):
    """A block bonded to plates that press or pull it: K = E (1 + 2 S^2) A / h.

    S = A / (p h), of a free edge all around p, is the shape factor: what the plates hold cannot
    spread. Of a material that keeps its volume, at small strains; square, round or moderately
    rectangular; stress and strain are those of a block that is free to spread.

    Parameters
    ----------
    area : float
        Bonded area of one plate, m^2.
    perimeter : float
        Of that area, that of a hole included, m.
    gap : float
        Thickness h between the plates, m.
    """

    name = "bonded-block"
    source = "Gent, Lindley: Proc. IMechE 173 (1959) 111, doi:10.1243/PIME_PROC_1959_173_022_02"
    modulus = "E"
    area: float
    perimeter: float
    gap: float

    @property
    def shape_factor(self) -> float:
        """Of a bonded area over the area that is free to bulge."""
        return self.area / (self.perimeter * self.gap)

    @property
    def stress_factor(self) -> float:
        """1 / (A (1 + 2 S^2)): what a block that is free to spread bears of the force."""
        return 1.0 / (self.area * (1.0 + 2.0 * self.shape_factor**2))

    @property
    def strain_factor(self) -> float:
        """1 / h."""
        return 1.0 / self.gap


@dataclass(frozen=True)
class AnnularDashpot(Geometry):
    """A piston moving along the axis of a tube, the material in the annulus.

    Stress and strain at the piston.

    With a = ln(R_o / R_i), an open tube is pure shear, K = 2 pi L G / a. In a closed one the piston
    pushes what it displaces back through the annulus, K = 2 pi L G / (a - tanh a), which exceeds
    the former by 3 / a^2 for a narrow gap. Inertia of the material and the ends of the piston are
    left out.

    Parameters
    ----------
    inner_radius, outer_radius : float
        Of the piston and of the tube, m.
    length : float
        Of the piston, m.
    closed : bool
        Whether the displaced material flows back through the annulus.
    """

    name = "annular-dashpot"
    source = (
        "Bird, Stewart, Lightfoot: Transport Phenomena (2002), 2.4; Lohrenz, Swift, Kurata: AIChE"
        " J. 6 (1960) 547"
    )
    inner_radius: float
    outer_radius: float
    length: float
    closed: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.inner_radius < self.outer_radius:
            raise OptionError(f"{self.name}: inner_radius must be smaller than outer_radius")

    @property
    def _resistance(self) -> tuple[float, float]:
        """The denominator of K, and the share of the force that shears the piston's wall."""
        a = log(self.outer_radius / self.inner_radius)
        if not self.closed:
            return a, 1.0
        return _less_tanh(a), tanh(a)

    @property
    def stress_factor(self) -> float:
        """1 / (2 pi R_i L), times tanh a where closed.

        The rest of the force is pressure on the piston's ends.
        """
        return self._resistance[1] / (2.0 * pi * self.inner_radius * self.length)

    @property
    def strain_factor(self) -> float:
        """1 / (R_i a), or tanh a / (R_i (a - tanh a)) where closed."""
        # The ratio of both factors is K: each gets the same share, which then cancels.
        below, share = self._resistance
        return share / (self.inner_radius * below)


def _less_tanh(a: float) -> float:
    """The difference a - tanh a without cancellation."""
    if a >= 0.02:
        return a - tanh(a)
    # Below, the difference loses as many digits as the series leaves out, and soon more.
    return a**3 / 3.0 * (1.0 - 0.4 * a**2 + 17.0 / 105.0 * a**4)


@dataclass(frozen=True)
class ParallelPlates(Geometry):
    """Two discs, one of which turns: K = pi R^4 G / (2 h) per radian; stress and strain at the rim.

    Parameters
    ----------
    radius, gap : float
        In m.
    """

    name = "parallel-plates"
    turns = True
    source = "Macosko: Rheology (1994), ch. 5.5"
    radius: float
    gap: float

    @property
    def stress_factor(self) -> float:
        """2 / (pi R^3), for a stress that grows with the radius as in linear oscillation."""
        return 2.0 / (pi * self.radius**3)

    @property
    def strain_factor(self) -> float:
        """R / h."""
        return self.radius / self.gap


@dataclass(frozen=True)
class ConePlate(Geometry):
    """A flat cone on a plate: K = 2 pi R^3 G / (3 beta) per radian.

    The strain is the same everywhere.

    Parameters
    ----------
    radius : float
        In m.
    angle : float
        Between cone and plate, rad; the formula is for a few degrees.
    """

    name = "cone-plate"
    turns = True
    source = "Macosko: Rheology (1994), ch. 5.4"
    radius: float
    angle: float

    @property
    def stress_factor(self) -> float:
        """3 / (2 pi R^3)."""
        return 3.0 / (2.0 * pi * self.radius**3)

    @property
    def strain_factor(self) -> float:
        """1 / beta."""
        return 1.0 / self.angle


@dataclass(frozen=True)
class TorsionBar(Geometry):
    """A rectangular bar, twisted (Saint-Venant, free to warp).

    Stress and strain at the middle of its broad side.

    Parameters
    ----------
    length : float
        Between the clamps, m.
    width, thickness : float
        Of its cross-section, m, in any order.
    """

    name = "torsion-bar"
    turns = True
    source = "Timoshenko, Goodier: Theory of Elasticity (1970), art. 109"
    length: float
    width: float
    thickness: float

    @property
    def _section(self) -> tuple[float, float]:
        """Torsion constant in m^4, and the largest shear for unit twist per length in m."""
        # Whichever side is called the width: the formulas hold for the longer over the shorter.
        b, ratio = min(self.width, self.thickness), max(self.width, self.thickness)
        ratio /= b
        # Saint-Venant's series: even terms vanish, as the section is symmetric.
        odd = range(1, _TERMS, 2)
        bent = sum(tanh(n * pi * ratio / 2.0) / n**5 for n in odd)
        flattened = sum(1.0 / (n**2 * _cosh(n * pi * ratio / 2.0)) for n in odd)
        constant = ratio / 3.0 - 64.0 / pi**5 * bent
        steep = 1.0 - 8.0 / pi**2 * flattened
        return constant * b**4, steep * b

    @property
    def stress_factor(self) -> float:
        """Largest shear over the torsion constant."""
        constant, steep = self._section
        return steep / constant

    @property
    def strain_factor(self) -> float:
        """Largest shear for unit twist per length, over the length."""
        return self._section[1] / self.length


def _cosh(x: float) -> float:
    # Beyond that it is more than a number holds, and Python raises.
    if x >= 700.0:
        return inf
    return cosh(x)


@dataclass(frozen=True)
class Constants(Geometry):
    """A geometry of a rotational rheometer, by the two constants that its maker gives.

    Parameters
    ----------
    stress : float
        Stress for a torque of 1 N m, 1/m^3 (Pa/(N m)).
    strain : float
        Strain for an angle of 1 rad.
    """

    name = "constants"
    turns = True
    source = "the header of an instrument's file"
    stress: float
    strain: float

    @property
    def stress_factor(self) -> float:
        """As given."""
        return self.stress

    @property
    def strain_factor(self) -> float:
        """As given."""
        return self.strain


GEOMETRIES: dict[str, type[Geometry]] = {
    kind.name: kind
    for kind in (
        ShearPads,
        BondedBlock,
        AnnularDashpot,
        ParallelPlates,
        ConePlate,
        TorsionBar,
        Constants,
    )
}


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


AREA_UNITS = {f"{unit}^2": size**2 for unit, size in LENGTH_UNITS.items()}
_ITEM = re.compile(r"([\w-]+)\s*=\s*([^=]*?)(?=[\s,;]+[\w-]+\s*=|[\s,;]*$)")
_VALUE = re.compile(r"^([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*\[?\s*(.*?)\s*\]?$")
_TABLES: dict[str, Mapping[str, float]] = {
    "area": AREA_UNITS,
    "angle": ANGLE_UNITS,
    "pads": {"-": 1.0},
    "stress": {"Pa/N m": 1.0, "Pa/(N m)": 1.0, "1/m^3": 1.0},
    "strain": {"1/rad": 1.0, "-": 1.0},
}
"""Units of sizes that are no lengths."""
_WORDS = {"yes": True, "true": True, "no": False, "false": False}
EXAMPLE = "shear-pads area=200cm^2 gap=10mm"


def words_of(geometry: Geometry) -> str:
    """A geometry as a user writes it, in SI units."""
    sizes = [f"{f.name}={_size(f.name, getattr(geometry, f.name))}" for f in fields(geometry)]
    return " ".join([geometry.name, *sizes])


def _size(name: str, value: float) -> str:
    if isinstance(value, bool):
        return {True: "yes", False: "no"}[value]
    unit = {"area": "m^2", "angle": "rad", "pads": "", "stress": "1/m^3", "strain": "1/rad"}.get(
        name, "m"
    )
    # A number of pads has no unit, and is no measured size that needs all its digits.
    if not unit:
        return f"{value:g}"
    return f"{value!r} {unit}"


def parse_geometry(text: str) -> Geometry:
    """The geometry that a text such as ``shear-pads area=200cm^2 gap=10mm`` names.

    Lengths may be given as diameters where a radius is meant: ``parallel-plates diameter=40mm
    gap=1mm``.

    Raises
    ------
    OptionError
        If the geometry, a size or a unit is unknown, or one is missing.

    Examples
    --------
    >>> from springpot.measurement import parse_geometry
    >>> parse_geometry("shear-pads area=200cm^2 gap=10mm").shape
    2.0
    """
    name, _, rest = " ".join(text.replace(":", " ", 1).split()).partition(" ")
    if name not in GEOMETRIES:
        near = get_close_matches(name, GEOMETRIES, n=1)
        hint = f"known are {', '.join(GEOMETRIES)}"
        if near:
            hint = f"did you mean {near[0]}?"
        raise OptionError(f"geometry '{name:.40}': {hint}; write for instance '{EXAMPLE}'")
    kind = GEOMETRIES[name]
    wanted = {field.name: field for field in fields(kind)}
    given: dict[str, float] = {}
    for key, value in _ITEM.findall(rest):
        key = key.replace("-", "_")
        # Catalogues give diameters, formulas take radii.
        size = key.replace("diameter", "radius")
        if size not in wanted:
            raise OptionError(
                f"geometry {name}: there is no '{key:.40}'; it has {', '.join(wanted)}"
            )
        if size in given:
            raise OptionError(f"geometry {name}: '{key}' is given twice")
        given[size] = _read(name, size, value)
        # It was given as a diameter.
        if size != key:
            given[size] *= 0.5
    missing = [
        key for key, field in wanted.items() if key not in given and field.default is MISSING
    ]
    # What is left when all items are taken out is no NAME=VALUE.
    unread = _ITEM.sub("", rest).strip()
    if missing or unread.strip(" ,;"):
        what = f"cannot read '{unread:.40}'"
        if missing:
            what = f"{' and '.join(missing)} missing"
        raise OptionError(f"geometry {name}: {what}; write for instance '{_example(kind)}'")
    return kind(**given)


def _read(name: str, size: str, value: str) -> float:
    if size == "closed":
        if value.lower() not in _WORDS:
            raise OptionError(f"geometry {name}: closed is yes or no, not '{value:.20}'")
        return _WORDS[value.lower()]
    match = _VALUE.match(value.strip())
    table = dict(_TABLES.get(size, LENGTH_UNITS))
    if match is None:
        raise OptionError(f"geometry {name}: {size} is no number with a unit: '{value:.30}'")
    # No unit is guessed: 10 for a gap may be mm or m, and the modulus a thousand times off.
    if not match[2] and "-" not in table:
        raise OptionError(
            f"geometry {name}: {size}={match[1]} has no unit; write"
            f" {size}={match[1]}{list(table)[1]}"
        )
    try:
        return float(match[1]) * table[known_unit(normal_unit(match[2]), table, size)]
    except DataError as error:
        raise OptionError(f"geometry {name}: {error}") from None


def _example(kind: type[Geometry]) -> str:
    units = {
        "area": "200cm^2",
        "angle": "2deg",
        "pads": "2",
        "closed": "no",
        "stress": "79577Pa/(N m)",
        "strain": "20",
    }
    return " ".join(
        [kind.name, *(f"{field.name}={units.get(field.name, '10mm')}" for field in fields(kind))]
    )


def html_of(data: Rows) -> Html:
    """The first rows in their units, and the curve where pictures can be drawn."""
    unit = data.units.stiffness
    headers = [data.units.clock_head, f"{data.units.storage} [{unit}]"]
    headers += [f"{data.units.loss} [{unit}]"]
    headers += [f"{name} [{data.units.of_condition(name)}]" for name in data.conditions]
    columns = [
        data.units.on_clock(data.frequency),
        data.storage,
        data.loss,
        *data.conditions.values(),
    ]
    rows = [[f"{column[i]:.4g}" for column in columns] for i in range(min(LISTED, len(data)))]
    more = len(data) - len(rows)
    beside = tag("p", f"and {more} more rows") if more > 0 else joined(())
    return tag("div", tag("p", tag("b", data.name)), table(headers, rows), beside, _curve(data))


def _curve(data: Rows) -> Html:
    try:
        figure = draw(data)
    except OutputError:  # without matplotlib the table is all there is
        return joined(())
    picture: bytes = figure._repr_png_()  # type: ignore[union-attr]
    return tag(
        "img",
        src=f"data:image/png;base64,{b64encode(picture).decode()}",
        width="640",
        alt=data.name,
    )
