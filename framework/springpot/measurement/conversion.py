"""Tests made of tests: several as one, and those of a damper as of its material."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from springpot.errors import DataError
from springpot.rheology.points import Real

from .geometry import Geometry
from .measurement import CONDITIONS, Measurement
from .timetest import TimeTest
from .units import AMPLITUDE_UNITS, LENGTH_UNITS, STRAIN_UNITS, one_modulus

if TYPE_CHECKING:
    from .covered import OtherTest


FILE = "file"
LEVELS = "levels {}"
"""Where the provenance of a measurement tells what the levels of a column are called."""

_EXAMPLES = {"temperature": "temperature=20[degC]", "amplitude": "amplitude=0.5[mm]"}
"""How a condition of all rows of a file is said behind its name."""


def file_of(name: str) -> str:
    """The file of a test, which may be one of several in it: ``creep#2``."""
    return name.partition("#")[0]


def levels_in_words(data: Measurement, column: str) -> list[str] | None:
    """What the levels of a numbered column are called, in the order of their numbers."""
    told = data.provenance.get(LEVELS.format(column))
    if told is None:
        return None
    return [str(word) for word in json.loads(told)]


def joined(measurements: Sequence[Measurement]) -> Measurement:
    """All rows one after the other, in the units of the first, with the label ``file``.

    Parameters
    ----------
    measurements : sequence of Measurement
        Two or more, all of a stiffness or all of a modulus. Rows at the same frequency and
        conditions are repeats of one another, whichever file they come from.

    Returns
    -------
    Measurement
        With standard deviations if all have them, with temperature and amplitude, of which all must
        have the same, and with the further columns that all have.

    Raises
    ------
    DataError
        If a stiffness is to join a modulus, or one modulus another, if temperature or amplitude is
        known of some only, or if two hold the same numbers.
    """
    first = measurements[0]
    letter = one_modulus((each.name, each.units) for each in measurements)
    for other in measurements[1:]:
        _refuse_unlike(first, other)
    refuse_copies(measurements)
    scale = [_factor(each, first) for each in measurements]
    sd = None
    # Deviations of some rows alone would be weights on no common scale.
    if all(each.sd is not None for each in measurements):
        sd = np.concatenate(
            [
                by * each.sd
                for by, each in zip(scale, measurements, strict=True)
                if each.sd is not None
            ]
        )
    some = _known_of_some(measurements)
    notes: dict[str, str] = {}
    if some:
        notes["note columns"] = (
            f"{', '.join(sorted(some))}: known of some of the files only, and left out"
        )
    return Measurement(
        np.concatenate([each.omega for each in measurements]),
        np.concatenate([by * each.stiffness for by, each in zip(scale, measurements, strict=True)]),
        sd=sd,
        conditions={
            name: _column(name, measurements) for name in first.conditions if name not in some
        },
        repeat=_repeats(measurements),
        units=replace(first.units, letter=letter or first.units.letter),
        provenance=notes,
        name=" + ".join(each.name for each in measurements),
        labels={FILE: np.concatenate([np.full(len(each), each.name) for each in measurements])},
    )


def _refuse_unlike(first: Measurement, other: Measurement) -> None:
    """Tell of two measurements that are no joint test, as of a stiffness and a modulus."""
    if other.units.is_modulus != first.units.is_modulus:
        kinds = f"{first.units.stiffness} and {other.units.stiffness}"
        raise DataError(
            f"{first.name} and {other.name}: a stiffness and a modulus ({kinds}) are no joint test"
        )
    # What no effect knows of, such as a counter of points, may be missing from a file.
    if lacking := sorted(set(CONDITIONS) & (set(first.conditions) ^ set(other.conditions))):
        which = other
        if lacking[0] in other.conditions:
            which = first
        # A test at one temperature or amplitude needs no column of it: a constant behind its
        # name is as good.
        example = ",".join(_EXAMPLES[name] for name in lacking)
        raise DataError(
            f"{which.name} lacks {', '.join(lacking)}, which the others have: add the column,"
            f" or say it of all rows as in 'FILE?{example}'"
        )


def refuse_copies(tests: Iterable[Measurement | TimeTest | OtherTest]) -> None:
    """Tell of a test that is there twice: its noise would count as that of two.

    Raises
    ------
    DataError
        If two hold the same numbers.
    """
    seen: dict[object, str] = {}
    for each in tests:
        if isinstance(each, Measurement):
            told, columns = "sweep", [each.omega, each.stiffness, *each.conditions.values()]
        elif isinstance(each, TimeTest):
            told = f"{each.control} {each.temperature}"
            columns = [each.time, each.response, each.loading.value]
            columns += [] if each.warmth is None else [each.warmth]
        else:
            continue
        numbers = (told, each.units, *(column.tobytes() for column in columns))
        if numbers in seen:
            both = f"{seen[numbers]} and {each.name}"
            raise DataError(f"{both} hold the same numbers: name each test once")
        seen[numbers] = each.name


def _known_of_some(measurements: Sequence[Measurement]) -> set[str]:
    """Further columns that not all of them have."""
    every = set.intersection(*(set(each.conditions) for each in measurements))
    return set.union(*(set(each.conditions) for each in measurements)) - every


def _factor(other: Measurement, first: Measurement) -> float:
    return other.units.factor_to(first.units, other.name, first.name)


def _column(name: str, measurements: Sequence[Measurement]) -> Real:
    if name != "amplitude":
        return np.concatenate([each.conditions[name] for each in measurements])
    first = measurements[0].units.amplitude
    for each in measurements:
        # Between a length and a strain stands the size of a specimen, which nobody has told here.
        for table in (LENGTH_UNITS, STRAIN_UNITS):
            if (first in table) != (each.units.amplitude in table):
                units = f"{first} and {each.units.amplitude}"
                raise DataError(f"{each.name}: amplitudes in {units} are of different kinds")
    return np.concatenate(
        [
            each.conditions[name] * (AMPLITUDE_UNITS[each.units.amplitude] / AMPLITUDE_UNITS[first])
            for each in measurements
        ]
    )


def _repeats(measurements: Sequence[Measurement]) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Numbers of repeats that no two files share."""
    numbers, last = [], 0
    for each in measurements:
        # A file without repeats is one of them.
        own = np.zeros(len(each), dtype=np.int64)
        # Each file may begin to count where it likes.
        if each.repeat is not None:
            own = each.repeat - int(each.repeat.min())
        numbers.append(own + last)
        last += int(own.max()) + 1
    return np.concatenate(numbers)


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
