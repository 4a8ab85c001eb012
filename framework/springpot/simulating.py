"""A structure as a user describes it in TOML, and the record that shakes it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from springpot.errors import DataError, ModelError, SpringpotError
from springpot.identified import fitted, lesser, stated
from springpot.measurement import AMPLITUDE_UNITS, STIFFNESS_UNITS
from springpot.rheology import Real
from springpot.structure import Damper, Frame, Record, artificial

LARGEST = 1_000_000
"""Bytes of a description: it has some hundred."""
LONGEST = 100_000_000
"""Bytes of a record."""
ACCELERATIONS = {"m/s^2": 1.0, "m/s2": 1.0, "g": 9.80665, "cm/s^2": 0.01, "gal": 0.01, "mm/s^2": 1e-3}
FRAME_KEYS = {"mass", "stiffness", "damping", "storeys"}
DAMPER_KEYS = {"fit", "model", "parameters", "unit", "storey", "count", "slope", "temperature", "without"}


def read_structure(path: str | Path) -> Frame:
    """The frame that a TOML file describes.

    Parameters
    ----------
    path : str or Path
        With ``[structure]`` (``mass`` in kg and ``stiffness`` in N/m, a number or one for each storey, ``damping``,
        ``storeys``) and for each kind of damper ``[[damper]]``: ``fit``, the JSON of an identification, or ``model``
        with ``parameters`` and ``unit``; ``storey``, ``count``, ``slope`` in degrees, ``temperature`` in degC, and
        ``without``, effects of the rig to leave out.

    Raises
    ------
    SpringpotError
        If it cannot be read, or something in it is unknown, missing or does not fit, in one line.
    """
    path = Path(path)
    whole = _toml(path)
    frame = whole.get("structure")
    if not isinstance(frame, dict):
        raise DataError(f"{path}: there is no [structure] with mass, stiffness and damping")
    _only(frame, FRAME_KEYS, path, "[structure]")
    entries = whole.get("damper", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise DataError(f"{path}: each damper is a [[damper]]")
    try:
        storeys = int(frame.get("storeys", 1))
        mass = _column(frame, "mass", storeys, path)
        stiffness = _column(frame, "stiffness", storeys, path)
        dampers = tuple(_damper(entry, path, i) for i, entry in enumerate(entries, 1))
        return Frame(mass, stiffness, float(frame.get("damping", 0.0)), dampers)
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None
    # TOML gives what was written, a word or a list too where a number belongs.
    except (TypeError, ValueError) as error:
        raise DataError(f"{path}: something is no number: {error}") from None


def _toml(path: Path) -> dict[str, Any]:
    try:
        # Before it is read: a wrong file may be larger than the memory.
        if path.stat().st_size > LARGEST:
            raise DataError(f"{path} is too large for the description of a structure")
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from None
    # Nested brackets are read by recursion.
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path} is no TOML: {error}") from None


def _only(given: Mapping[str, Any], known: set[str], path: Path, where: str) -> None:
    if unknown := sorted(set(given) - known):
        raise DataError(f"{path}: {where} has no '{unknown[0]}'; it knows {', '.join(sorted(known))}")


def _column(frame: Mapping[str, Any], name: str, storeys: int, path: Path) -> Real:
    if name not in frame:
        raise DataError(f"{path}: [structure] has no {name}")
    value = np.atleast_1d(np.asarray(frame[name], dtype=float))
    # One number stands for all storeys.
    if len(value) == 1:
        return np.full(storeys, value[0])
    return value


def _damper(entry: Mapping[str, Any], path: Path, number: int) -> Damper:
    where = f"damper {number}"
    _only(entry, DAMPER_KEYS, path, where)
    # Both would leave it open which of them counts.
    if ("fit" in entry) == ("model" in entry):
        raise DataError(f"{path}: {where} has a fit = 'FIT.json', or a model with parameters and unit")
    if "fit" in entry:
        # A path is meant from the description, wherever the command is run.
        known = fitted(path.parent / str(entry["fit"]))
    else:
        values = _flat(dict(entry.get("parameters", {})))
        known = stated(str(entry["model"]), values, str(entry.get("unit", "")), f"{where} of {path}")
    without = entry.get("without", [])
    # A single name need not stand in a list.
    if isinstance(without, str):
        without = [without]
    known = lesser(known, map(str, without))
    if known.units.stiffness not in STIFFNESS_UNITS:
        raise ModelError(
            f"a damper has a stiffness, and {known.model.name} is in {known.units.stiffness}: "
            "identify it with the --geometry of the damper"
        )
    cosine = float(np.cos(np.radians(float(entry.get("slope", 0.0)))))
    temperature = None
    if "temperature" in entry:
        temperature = float(entry["temperature"])
    if "temperature" in known.model.needs and temperature is None:
        raise DataError(f"{path}: {where}: {known.model.name} needs its temperature in degC")
    covariance = None
    # Parameters that were stated, not fitted, have no uncertainty to carry on.
    if np.any(known.covariance != 0.0):
        covariance = known.covariance
    return Damper(
        known.model,
        known.theta,
        int(entry.get("storey", 1)),
        # Once for the drift that reaches the damper, once for its force that is horizontal.
        float(entry.get("count", 1)) * cosine**2,
        covariance,
        temperature,
        known.reference,
        STIFFNESS_UNITS[known.units.stiffness],
        AMPLITUDE_UNITS[known.units.amplitude],
        cosine,
    )


def _flat(parameters: Mapping[str, Any]) -> dict[str, float]:
    """Parameters by name; TOML reads ``inertia.m = 0.6`` without quotes as a table of its own."""
    values: dict[str, float] = {}
    for name, value in parameters.items():
        if isinstance(value, dict):
            values |= {f"{name}.{own}": float(each) for own, each in value.items()}
        else:
            values[name] = float(value)
    return values


def read_record(spec: str, rng: np.random.Generator) -> Record:
    """The record that a user names: a CSV file, or ``artificial``, or ``artificial:3.0`` with its peak in m/s^2.

    The file has columns ``time [s]`` and ``acceleration [m/s^2]`` (or ``[g]``, ``[cm/s^2]``), at equal steps.

    Raises
    ------
    DataError
        If there is none, or it cannot be used, in one line.
    """
    if spec == "artificial" or spec.startswith("artificial:"):
        _, _, peak = spec.partition(":")
        try:
            largest = float(peak or 3.0)
        except ValueError:
            raise DataError(f"'{spec}': write artificial:3.0 with the peak in m/s^2") from None
        return artificial(rng, peak=largest)
    path = Path(spec)
    try:
        # Before it is read, as above.
        if path.stat().st_size > LONGEST:
            raise DataError(f"{path} is too large for a record: {LONGEST >> 20} MiB at most")
        # Spreadsheets put a byte order mark before the first title.
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise DataError(f"{path} is no text in UTF-8") from None
    rows = [line for line in lines if line.strip() and not line.startswith("#")]
    header = ""
    if rows:
        header = rows[0]
    factor = _acceleration_unit(header, path)
    samples = []
    try:
        for row in rows[1:]:
            # What stands in further columns is not asked about.
            first_two = row.split(",")[:2]
            samples.append([float(cell) for cell in first_two])
        values = np.array(samples, dtype=float)
    except ValueError as error:
        raise DataError(f"{path}: {error}") from None
    if values.ndim != 2 or values.shape[1:] != (2,):
        raise DataError(f"{path}: a record has two columns, time [s] and acceleration [m/s^2]")
    try:
        return Record.of(values[:, 0], factor * values[:, 1], path.stem)
    except SpringpotError as error:
        # The name of the record is the path, which stands before it already.
        raise DataError(f"{path}: {str(error).removeprefix(f'{path.stem}: ')}") from None


def _acceleration_unit(header: str, path: Path) -> float:
    titles = [title.strip().lower() for title in header.split(",")[:2]]
    if len(titles) != 2 or titles[0] != "time [s]" or not titles[1].startswith("acceleration ["):
        raise DataError(f"{path}: write 'time [s],acceleration [m/s^2]' in the first line, with the unit it has")
    unit = titles[1].removeprefix("acceleration [").rstrip("]")
    if unit not in ACCELERATIONS:
        raise DataError(f"{path}: unknown unit [{unit}] of an acceleration: known are {', '.join(ACCELERATIONS)}")
    return ACCELERATIONS[unit]
