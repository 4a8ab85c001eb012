"""Records of the ground's acceleration that a user names: CSV, PEER's AT2, or drawn ones."""

from __future__ import annotations

import re
from collections.abc import Iterable
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from springpot.errors import DataError, SpringpotError
from springpot.files import text_in

from .motion import STRONGEST, GroundMotion, artificial

if TYPE_CHECKING:
    from springpot.rheology.points import Real

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
    if not 0.0 < largest < STRONGEST:
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
