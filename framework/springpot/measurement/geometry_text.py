"""Geometries as text: ``shear-pads area=200cm^2 gap=10mm``.

A measurement in a notebook: its first rows and its curve.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import MISSING, fields
from difflib import get_close_matches

from springpot.drawing import draw
from springpot.errors import DataError, OptionError, OutputError
from springpot.markup import Html, joined, table, tag

from ..format_numbers import LISTED
from .geometry import GEOMETRIES, Geometry
from .rows import Rows
from .units import ANGLE_UNITS, LENGTH_UNITS, known_unit, normal_unit

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
    units = {"temperature": "degC", "amplitude": data.units.amplitude}
    clock = {"Hz": "frequency [Hz]", "rad/s": "omega [rad/s]"}[data.units.clock]
    headers = [clock, f"{data.units.storage} [{unit}]", f"{data.units.loss} [{unit}]"]
    headers += [f"{name} [{units.get(name, '-')}]" for name in data.conditions]
    columns = [
        data.units.on_clock(data.frequency),
        data.storage,
        data.loss,
        *data.conditions.values(),
    ]
    rows = [[f"{column[i]:.4g}" for column in columns] for i in range(min(LISTED, len(data)))]
    more = len(data) - len(rows)
    beside = joined(())
    if more > 0:
        beside = tag("p", f"and {more} more rows")
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
