"""A structure as a user describes it in TOML, and the records that shake it.

Those of the ground's acceleration are CSV, PEER's AT2, or drawn ones.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from glob import glob
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from springpot.errors import DataError, ModelError, OptionError, SpringpotError
from springpot.files import text_in, toml_in
from springpot.identification.prediction import Known, require_known
from springpot.loading import fitted, stated
from springpot.measurement.geometry import (
    EXAMPLE,
    Geometry,
    parse_geometry,
    to_modulus,
    to_stiffness,
)
from springpot.measurement.units import STIFFNESS_UNITS, Units
from springpot.rheology.points import KELVIN, Real

from .damper import Damper
from .frame import Frame
from .motion import STRUCTURE, GroundMotion, artificial

ACCELERATIONS = {
    "m/s^2": 1.0,
    "m/s2": 1.0,
    "g": 9.80665,
    "cm/s^2": 0.01,
    "gal": 0.01,
    "mm/s^2": 1e-3,
}
ENDINGS = (".csv", ".txt", ".at2")
"""Of the files in a folder that are records."""
HEADER = 4
"""Lines before the numbers of an AT2 file: who, which, what, and how many at which step."""
_COUNT_AND_STEP = (
    re.compile(r"NPTS\s*=\s*(\d+)\D.*?DT\s*=\s*([\d.]+(?:E[-+]?\d+)?)", re.I),
    # As PEER wrote until 2010.
    re.compile(r"^\s*(\d+)\s+([\d.]+(?:E[-+]?\d+)?)\s+NPTS\s*,\s*DT", re.I),
)


def records_meant(specs: Iterable[str]) -> list[str]:
    """The records that a user means: of a folder all that are in it, of a pattern those it fits.

    Raises
    ------
    DataError
        If a folder or pattern has none.
    """
    meant: list[str] = []
    for spec in specs:
        found = [spec]
        if Path(spec).is_dir():
            inside = sorted(Path(spec).iterdir())
            found = [str(path) for path in inside if path.suffix.lower() in ENDINGS]
        elif re.search(r"[*?\[]", spec) and not Path(spec).exists():
            found = sorted(glob(spec))
        if not found:
            raise DataError(f"{spec}: there is no record there; one is a file {', '.join(ENDINGS)}")
        meant += found
    return meant


def read_record(spec: str, rng: np.random.Generator) -> GroundMotion:
    """The record that a user names.

    A CSV file, one of PEER (.AT2), or ``artificial``, or ``artificial:3.0`` with its peak in m/s^2.

    The first has columns ``time [s]`` and ``acceleration [m/s^2]`` (or ``[g]``, ``[cm/s^2]``), at
    equal steps. The second has four lines, of which the last says NPTS and DT, and numbers in g.

    Raises
    ------
    DataError
        If there is none, or it cannot be used, in one line.
    """
    if spec == "artificial" or spec.startswith("artificial:"):
        return _drawn(spec, rng)
    path = Path(spec)
    lines = text_in(path).splitlines()
    time, acceleration = (_of_peer if _is_peer(path, lines) else _of_table)(path, lines)
    try:
        return GroundMotion.of(time, acceleration, path.stem)
    except SpringpotError as error:
        # The name of the record is the path, which stands before it already.
        raise DataError(f"{path}: {str(error).removeprefix(f'{path.stem}: ')}") from None


def _drawn(spec: str, rng: np.random.Generator) -> GroundMotion:
    _, _, peak = spec.partition(":")
    try:
        largest = float(peak or 3.0)
    except ValueError:
        largest = float("nan")
    # One that is no number, or beyond any earthquake, is told alike.
    if not 0.0 < largest < STRUCTURE.acceleration:
        raise DataError(f"'{spec:.60}': write artificial:3.0 with the peak in m/s^2")
    return artificial(rng, peak=largest)


def _is_peer(path: Path, lines: list[str]) -> bool:
    """Whether a file is one of PEER: by its ending, or by what its fourth line says."""
    if path.suffix.lower() == ".at2":
        return True
    return len(lines) >= HEADER and _count_and_step(lines[HEADER - 1]) is not None


def _count_and_step(line: str) -> tuple[int, float] | None:
    for pattern in _COUNT_AND_STEP:
        if match := pattern.search(line):
            try:
                return int(match[1]), float(match[2])
            except ValueError:
                return None
    return None


def _of_peer(path: Path, lines: list[str]) -> tuple[Real, Real]:
    """Times and accelerations (t,) of an AT2 file."""
    told = _count_and_step(lines[HEADER - 1]) if len(lines) >= HEADER else None
    if told is None:
        raise DataError(f"{path}, line {HEADER}: no NPTS= and DT=, as a record of PEER has there")
    # Velocities and displacements (VT2, DT2) have the same header.
    if not re.search(r"\bG\b", lines[HEADER - 2], re.I) or "ACCEL" not in lines[HEADER - 2].upper():
        raise DataError(
            f"{path}, line {HEADER - 1}: '{lines[HEADER - 2].strip():.60}' is no acceleration in"
            " units of g: give the .AT2 file of the record"
        )
    count, step = told
    values: list[float] = []
    for number, line in enumerate(lines[HEADER:], HEADER + 1):
        try:
            values += map(float, line.split())
        except ValueError as error:
            raise DataError(f"{path}, line {number}: {error}") from None
    if len(values) != count:
        raise DataError(
            f"{path}, line {HEADER}: NPTS says {count} numbers, and there are {len(values)}: the"
            " file is not whole"
        )
    return np.arange(count, dtype=float) * step, ACCELERATIONS["g"] * np.array(values)


def _of_table(path: Path, lines: list[str]) -> tuple[Real, Real]:
    """Times and accelerations (t,) of a CSV file."""
    rows = [
        (number, line)
        for number, line in enumerate(lines, 1)
        if line.strip() and not line.startswith("#")
    ]
    factor = _acceleration_unit(rows[0][1] if rows else "", path)
    samples = []
    for number, row in rows[1:]:
        try:
            # What stands in further columns is not asked about.
            samples.append([float(cell) for cell in row.split(",")[:2]])
        except ValueError as error:
            raise DataError(f"{path}, line {number}: {error}") from None
        if len(samples[-1]) != 2:
            raise DataError(
                f"{path}, line {number}: a record has two columns, time [s] and acceleration"
                " [m/s^2]"
            )
    values = np.array(samples, dtype=float).reshape(len(samples), 2)
    return values[:, 0], factor * values[:, 1]


def _acceleration_unit(header: str, path: Path) -> float:
    titles = [title.strip().lower() for title in header.split(",")[:2]]
    if len(titles) != 2 or titles[0] != "time [s]" or not titles[1].startswith("acceleration ["):
        raise DataError(
            f"{path}: write 'time [s],acceleration [m/s^2]' in the first line, with the unit it has"
        )
    unit = titles[1].removeprefix("acceleration [").rstrip("]")
    if unit not in ACCELERATIONS:
        raise DataError(
            f"{path}: unknown unit [{unit}] of an acceleration: known are"
            f" {', '.join(ACCELERATIONS)}"
        )
    return ACCELERATIONS[unit]


Fits = dict[tuple[Path, str], Known]
FRAME_KEYS = {"mass", "stiffness", "damping", "storeys"}
DAMPER_KEYS = {
    "fit",
    "model",
    "parameters",
    "unit",
    "storey",
    "at",
    "count",
    "slope",
    "temperature",
    "without",
    "heat_capacity",
    "geometry",
    "specimen",
    "factors",
}


def read_structure(path: str | Path) -> Frame:
    """The frame that a TOML file describes.

    Parameters
    ----------
    path : str or Path
        With ``[structure]`` (``mass`` in kg and ``stiffness`` in N/m, a number or one for each
        storey, ``damping``, ``storeys``) and for each kind of damper ``[[damper]]``: ``fit``, the
        JSON of an identification, or ``model`` with ``parameters`` and ``unit``; ``storey``,
        ``count``, ``slope`` in degrees, ``temperature`` in degC, ``heat_capacity`` of one in J/K,
        ``without``, effects of the rig to leave out; ``at``, which specimen of a fit in which each
        has parameters of its own, ``{ file = "S2" }``; ``geometry`` where a modulus was fitted, or
        with that of the tested ``specimen`` where a stiffness was; and ``factors``, the least and
        the largest of its property modification.

    Raises
    ------
    SpringpotError
        If it cannot be read, or something in it is unknown, missing or does not fit, in one line.
    """
    path = Path(path)
    whole = toml_in(path)
    frame = whole.get("structure")
    if not isinstance(frame, dict):
        raise DataError(f"{path}: there is no [structure] with mass, stiffness and damping")
    _only(frame, FRAME_KEYS, path, "[structure]")
    entries = whole.get("damper", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise DataError(f"{path}: each damper is a [[damper]]")
    try:
        storeys = _count(frame.get("storeys", 1), "storeys", STRUCTURE.storeys)
        mass = _column(frame, "mass", storeys, path)
        stiffness = _column(frame, "stiffness", storeys, path)
        fits: Fits = {}
        dampers = tuple(_damper(entry, path, i, fits) for i, entry in enumerate(entries, 1))
        return Frame(mass, stiffness, _number(frame.get("damping", 0.0), "damping"), dampers)
    except (DataError, ModelError, OptionError) as error:
        # Which of the dampers it is they say themselves; the file once.
        if str(path) in str(error):
            raise
        raise type(error)(f"{path}: {error}") from None


def _only(given: Mapping[str, Any], known: set[str], path: Path, where: str) -> None:
    if unknown := sorted(set(given) - known):
        raise DataError(
            f"{path}: {where} has no '{unknown[0]}'; it knows {', '.join(sorted(known))}"
        )


def _column(frame: Mapping[str, Any], name: str, storeys: int, path: Path) -> Real:
    if name not in frame:
        raise DataError(f"{path}: [structure] has no {name}")
    value = frame[name]
    # One number stands for all storeys.
    if not isinstance(value, list):
        value = [value] * storeys
    return np.array(
        [
            _number(each, name, 1.0 / STRUCTURE.mass, STRUCTURE.mass)
            for each in value[: STRUCTURE.storeys + 1]
        ]
    )


def _damper(entry: Mapping[str, Any], path: Path, number: int, fits: Fits) -> Damper:
    where = f"damper {number}"
    _only(entry, DAMPER_KEYS, path, where)
    # Both would leave it open which of them counts.
    if ("fit" in entry) == ("model" in entry):
        raise DataError(
            f"{path}: {where} has a fit = 'FIT.json', or a model with parameters and unit"
        )
    if "fit" in entry and (own := {"parameters", "unit"} & entry.keys()):
        raise DataError(
            f"{path}: {where} has a fit, which has parameters and a unit of its own: leave out"
            f" {' and '.join(sorted(own))}"
        )
    whole = _known(entry, path, where, fits)
    known = whole.without(_without(entry, where))
    scale = _scale(entry, known, where)
    # Against the floor: an upright damper would feel no drift.
    slope = _number(entry.get("slope", 0.0), f"{where}: slope", -90.0, 90.0)
    temperature = None
    if "temperature" in entry:
        temperature = _number(entry["temperature"], f"{where}: temperature", -KELVIN)
        # As in a prediction: one that nothing depends on would be passed over without a word.
        try:
            require_known(known.model, known.covered, "temperature", np.array([temperature]))
        except ModelError as error:
            raise ModelError(f"{where}: {error}") from None
    if "temperature" in known.model.needs and temperature is None:
        raise DataError(f"{path}: {where}: {known.model.name} needs its temperature in degC")
    covariance, tested = None, None
    # Parameters that were stated, not fitted, have no uncertainty to carry on.
    if np.any(known.theta_covariance != 0.0):
        covariance, tested = known.theta_covariance, whole
    return Damper(
        known.model,
        known.theta,
        _count(entry.get("storey", 1), f"{where}: storey", STRUCTURE.storeys),
        _number(entry.get("count", 1), f"{where}: count", 0.0),
        covariance,
        temperature,
        known.reference,
        known.units,
        known.covered,
        float(np.cos(np.radians(slope))),
        _capacity(entry, where),
        scale,
        _factors(entry, where),
        tested,
    )


def _scale(entry: Mapping[str, Any], known: Known, where: str) -> tuple[float, float] | None:
    """By which a damper exceeds what was tested, where its geometry says so."""
    geometries = {
        name: parse_geometry(str(entry[name])) for name in ("geometry", "specimen") if name in entry
    }
    if "geometry" in geometries:
        return scale_of(where, known.units, **geometries)
    if geometries:
        raise DataError(f"{where}: a specimen's geometry is for that of the damper: give both")
    if known.units.stiffness not in STIFFNESS_UNITS:
        raise ModelError(
            f"{where}: a damper has a stiffness, and {known.model.name} is in"
            f" {known.units.stiffness}: give its geometry = '{EXAMPLE}'"
        )
    return None


def _factors(entry: Mapping[str, Any], where: str) -> tuple[float, float]:
    """Property modification factors, the least first."""
    given = entry.get("factors", [1.0, 1.0])
    if not isinstance(given, list) or len(given) != 2:
        raise DataError(f"{where}: factors are the least and the largest, [0.8, 1.2]")
    least, most = (_number(each, f"{where}: factors", 0.0) for each in given)
    if least > most:
        raise DataError(f"{where}: factors are the least and the largest, [{most:g}, {least:g}]")
    return least, most


def _capacity(entry: Mapping[str, Any], where: str) -> float | None:
    if "heat_capacity" not in entry:
        return None
    return _number(entry["heat_capacity"], f"{where}: heat_capacity", 0.0)


def _known(entry: Mapping[str, Any], path: Path, where: str, fits: Fits) -> Known:
    """The model of a damper, from a file of a fit or with parameters that are stated."""
    if "fit" in entry:
        # A path is meant from the description, wherever the command is run.
        source = path.parent / str(entry["fit"])
        at = entry.get("at", {})
        # Once for all dampers of it: what is not known of one is not known of the others alike.
        if (source, repr(at)) not in fits:
            known = fitted(source)
            if not isinstance(at, dict) or (at and not known.model.own):
                raise DataError(f'{where}: at says which specimen of several, {{ file = "S2" }}')
            try:
                fits[source, repr(at)] = known.at_level(at)
            except DataError as error:
                raise DataError(f"{where}, at = {{ ... }}: {error}") from None
        return fits[source, repr(at)]
    values = _flat(entry.get("parameters", {}), where)
    return stated(str(entry["model"]), values, str(entry.get("unit", "")), f"{where} of {path}")


def _without(entry: Mapping[str, Any], where: str) -> list[str]:
    """Names of the effects that a damper is taken without."""
    without = entry.get("without", [])
    # A single name need not stand in a list.
    if isinstance(without, str):
        without = [without]
    if not isinstance(without, list):
        raise DataError(f"{where}: without is a list of names of effects")
    return [str(name) for name in without]


def _flat(parameters: object, where: str) -> dict[str, float]:
    """Parameters by name; TOML reads ``inertia.m = 0.6`` without quotes as a table of its own."""
    if not isinstance(parameters, dict):
        raise DataError(f"{where}: parameters are names with numbers, {{ k = 4e5, alpha = 0.5 }}")
    values: dict[str, float] = {}
    for name, value in parameters.items():
        if isinstance(value, dict):
            values |= {
                f"{name}.{own}": _number(each, f"{where}: {name}.{own}")
                for own, each in value.items()
            }
        else:
            values[name] = _number(value, f"{where}: {name}")
    return values


def _number(value: object, what: str, above: float = -inf, below: float = inf) -> float:
    """A finite number between two ends, neither of which it may be.

    Raises
    ------
    DataError
        If it is none; TOML gives what was written, a word or a list too where a number belongs.
    """
    wanted = "a finite number"
    if above > -inf:
        wanted += f" above {above:g}"
    if below < inf:
        wanted += f" and below {below:g}"
    # True is a number to Python, and to nobody else.
    if isinstance(value, int | float) and not isinstance(value, bool):
        # A whole number may have more digits than a float holds.
        with suppress(OverflowError):
            if isfinite(value) and above < value < below:
                return float(value)
    raise DataError(f"{what}: {value!r:.40} is no number that it can be; give {wanted}")


def _count(value: object, what: str, most: int) -> int:
    """A whole number from one on.

    Raises
    ------
    DataError
        If it is none, or too large.
    """
    if isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= most:
        return value
    raise DataError(
        f"{what}: {value!r:.40} is no number that it can be; give a whole one from 1 to {most}"
    )


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
    >>> from springpot.structure.reading import scale_of
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
