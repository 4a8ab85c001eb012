"""Which channel of a time signal is what: time, displacement and force by name and unit, in several languages."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import (
    ANGLE_UNITS,
    FORCE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STRAIN_UNITS,
    TIME_UNITS,
    TORQUE_UNITS,
    Choice,
    Signals,
    known_unit,
)
from springpot.rheology import Real

from .names import fold
from .titles import tidy

NAMES: dict[str, tuple[str, ...]] = {
    "time": (
        "time",
        "t",
        "temps",
        "zeit",
        "tiempo",
        "tempo",
        "elapsed time",
        "time stamp",
        "laufzeit",
        "total time",
        "running time",
        "test time",
        "prüfzeit",
        "x_value",
    ),
    "displacement": (
        *(
            "displacement",
            "disp",
            "x",
            "q",
            "u",
            "stroke",
            "position",
            "deformation",
            "actuator displacement",
            "lvdt",
        ),
        *("deplacement", "course", "weg", "verschiebung", "auslenkung", "kolbenweg", "desplazamiento", "spostamento"),
        *("corsa", "deslocamento", "strain", "shear strain", "gamma", "γ", "dehnung", "deformacion", "deformazione"),
        *(
            "crosshead",
            "extension",
            "axial displacement",
            "axial position",
            "axial disp",
            "traverse",
            "machine position",
        ),
        *("angle", "rotation", "angular displacement", "winkel", "drehwinkel", "angulo", "angolo", "d"),
    ),
    "force": (
        *("force", "f", "load", "actuator force", "load cell", "axial force", "damper force", "effort", "kraft"),
        *("last", "kolbenkraft", "fuerza", "carga", "forza", "carico", "forca", "stress", "shear stress", "sigma"),
        *("σ", "τ", "tau", "tau_yx", "contrainte", "spannung", "schubspannung", "tension", "esfuerzo", "sforzo"),
        *("torque", "moment", "couple", "drehmoment", "coppia", "par", "p"),
    ),
}
UNITS = {
    "time": TIME_UNITS,
    "displacement": LENGTH_UNITS | STRAIN_UNITS | ANGLE_UNITS,
    "force": FORCE_UNITS | PRESSURE_UNITS | TORQUE_UNITS,
}
ADVICE = {"time": "time [s]", "displacement": "displacement [mm]", "force": "force [N]"}
_LARGEST = 1e100
_EXAMPLE = {"time": "s", "displacement": "mm", "force": "N"}
_ANY = {unit for table in UNITS.values() for unit in table}
_OF = {fold(name): channel for channel, names in reversed(NAMES.items()) for name in names}
_RANK = {fold(name): i for names in NAMES.values() for i, name in enumerate(names)}
_BRACKETED = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$")


@lru_cache(maxsize=2048)
def channel_of(title: str) -> tuple[str | None, str | None, str]:
    """Channel, unit and bare name of a title: ``force [kN]``, ``force_kN``, ``Kraft / kN`` or ``force``."""
    title = " ".join(title[:200].lstrip("#% ").split())
    match = _BRACKETED.match(title)
    bare = title if match and tidy(match[2]) in _ANY else re.sub(r"\s*\([^()]* .*$", "", title)
    if (found := _OF.get(fold(bare))) is not None:
        return found, None, bare
    if (match := _BRACKETED.match(bare)) and match[1]:
        stem = re.sub(r"\s*\([^()]*\)$", "", match[1])
        return _OF.get(fold(match[1])) or _OF.get(fold(stem)), match[2].strip(), stem
    for match in reversed(list(re.finditer(r"\s*/\s+|\s+in\s+|_|\s+", bare))[:20]):
        stem, said = bare[: match.start()], bare[match.end() :]
        channel = _OF.get(fold(stem))
        for unit in (said.replace("_per_", "/"), said.replace("_", " ")):
            if channel is not None and tidy(unit) in UNITS[channel]:
                return channel, unit, stem
    return None, None, bare


def found_in(titles: Sequence[str]) -> set[str]:
    """The channels that titles name."""
    return {channel for title in titles if (channel := channel_of(title)[0]) is not None}


@dataclass(frozen=True)
class Places:
    """Where the three channels are, and their units.

    Parameters
    ----------
    columns : tuple of int
        Column of time, displacement and force.
    units : tuple of str
        Their units.
    """

    columns: tuple[int, int, int]
    units: tuple[str, str, str]


def places_of(titles: Sequence[str], below: Sequence[str], choice: Choice) -> Places:
    """Where time, displacement and force are.

    Parameters
    ----------
    titles : sequence of str
        Names of the columns.
    below : sequence of str
        Units from a row of their own or from a file's properties; empty where there are none.
    choice : Choice
        What the user says: ``force=kN`` or ``3=force[kN]``.

    Raises
    ------
    DataError
        If a channel or its unit is missing, with what to write.
    """
    # A binary file may have names of several lines.
    titles = [" ".join(title.split()) for title in titles]
    layout: dict[str, tuple[int, str | None]] = {}
    ranks: dict[str, int] = {}
    for i, title in enumerate(titles):
        channel, unit, bare = channel_of(title)
        given = below[i].strip().strip("[]()") if i < len(below) else ""
        score = _RANK.get(fold(bare), 99)
        if channel is not None and score < ranks.get(channel, 100):
            layout[channel], ranks[channel] = (i, unit or given or None), score
    for name, meaning in choice.columns.items():
        _tell(layout, titles, name, meaning)
    shown = ", ".join(titles[:12]) or "none"
    missing = [channel for channel in UNITS if channel not in layout]
    if missing:
        spec = ",".join(f"NAME={ADVICE[channel].replace(' ', '')}" for channel in missing)
        raise DataError(
            f"no column of {' and '.join(missing)}; write {ADVICE[missing[0]]} above it, "
            f"or say which by 'FILE?{spec}' (columns: {shown:.100})"
        )
    bare_units = [channel for channel in UNITS if layout[channel][1] is None]
    if bare_units:
        spec = ",".join(f"{channel}={_EXAMPLE[channel]}" for channel in bare_units)
        names = ", ".join(f"'{titles[layout[channel][0]]}'" for channel in bare_units)
        raise DataError(
            f"column {names}: there is no unit; write {ADVICE[bare_units[0]]}, or say it by 'FILE?{spec}'"
        )
    units = [known_unit(tidy(str(layout[channel][1])), UNITS[channel], channel) for channel in UNITS]
    columns = [layout[channel][0] for channel in UNITS]
    return Places((columns[0], columns[1], columns[2]), (units[0], units[1], units[2]))


def _tell(layout: dict[str, tuple[int, str | None]], titles: Sequence[str], name: str, meaning: str) -> None:
    """What a user says of one column."""
    tests: tuple[Callable[[int, str], bool], ...] = (
        lambda i, title: name == str(i + 1) or name == title,
        lambda i, title: fold(name) == fold(channel_of(title)[2]),
        lambda i, title: layout.get(name, (-1, None))[0] == i,
        lambda i, title: channel_of(title)[0] == channel_of(name)[0] is not None,
    )
    place = next((i for test in tests for i, title in enumerate(titles) if test(i, title)), None)
    if place is None:
        raise DataError(f"no column '{name:.40}' (there are: {', '.join(titles[:12])})")
    channel, unit, _ = channel_of(meaning)
    if channel is not None:
        layout[channel] = (place, unit or channel_of(titles[place])[1])
        return
    known = next((key for key, (i, _) in layout.items() if i == place), None)
    if known is None:
        raise DataError(f"say what column '{name:.40}' is, such as 'FILE?{name}=force[{meaning:.20}]'")
    layout[known] = (place, meaning)


def signals_from(time: Real, moved: Real, pulled: Real, units: Sequence[str], path: Path, origin: str) -> Signals:
    """The channels as signals, time in seconds.

    Raises
    ------
    DataError
        If a value is so large that it cannot be a measurement, as in a broken binary file.
    """
    for name, values in (("time", time), ("displacement", moved), ("force", pulled)):
        if not isinstance(values, np.memmap) and (np.abs(values[np.isfinite(values)]) > _LARGEST).any():
            raise DataError(f"{name} has values beyond {_LARGEST:g}; the file is broken, or the wrong channel")
    factor = TIME_UNITS[units[0]]
    clock = time if factor == 1.0 else time * factor
    return Signals(clock, moved, pulled, units[1], units[2], path.name, {"file": path.name, "format": origin})
