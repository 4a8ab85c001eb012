"""Which channel of a time signal is what.

Time, displacement and force by name and unit, in several languages.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import (
    ANGLE_UNITS,
    FORCE_UNITS,
    FREQUENCY_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    TIME_UNITS,
    TORQUE_UNITS,
    Choice,
    Measurement,
    OpenQuestion,
    Question,
    Reader,
    Signals,
    known_unit,
    measurement_from_signals,
    normal_unit,
)
from springpot.measurement.timetest import IMMENSE
from springpot.rheology import Real

from .languages import CHANNELS
from .names import fold
from .titles import apart_from_sign, require_word

_IGNORED = ("ignore", "none")
"""What a user says (``?3=ignore``) of a column that is to be left alone."""
STRAINS = ("strain", "shear strain", "gamma", "γ", "dehnung", "deformacion", "deformazione")
"""Names of what is no displacement but one over a length."""
STRESSES = (
    *("stress", "shear stress", "sigma", "σ", "τ", "tau", "tau_yx", "contrainte", "spannung"),
    *("schubspannung", "tension", "esfuerzo", "sforzo"),
)
"""Names of what is no force but one over an area."""
NAMES: dict[str, tuple[str, ...]] = {
    "time": (
        *("time", "t", "temps", "zeit", "tiempo", "tempo", "elapsed time", "laufzeit"),
        *("total time", "running time", "test time", "prüfzeit", "time stamp", "timestamp"),
        *("zeitstempel", "datum/zeit", "datum uhrzeit", "datum/uhrzeit", "date and time"),
        *("elapsed", "uhrzeit", "date/time", "datetime", "date time", "horodatage", "x_value"),
        *("temps d'essai", "durée d'essai", "tempo di prova", "tiempo de ensayo", "prüfdauer"),
    ),
    "displacement": (
        *("displacement", "disp", "x", "q", "u", "stroke", "position", "deformation"),
        *("actuator displacement", "lvdt", "deplacement", "course", "weg", "verschiebung"),
        *("auslenkung", "kolbenweg", "desplazamiento", "spostamento", "corsa", "deslocamento"),
        *STRAINS,
        *("crosshead", "extension", "axial displacement", "axial position", "axial disp"),
        *("traverse", "traversenweg", "machine position", "standardweg", "angle", "rotation"),
        *("angular displacement", "winkel", "drehwinkel", "angulo", "angolo"),
        *(
            "d",
            "dep",
            "depl",
            "depla",
            "allongement",
            "allungamento",
            "alargamiento",
            "verlängerung",
        ),
        *("indentation", "indentation depth", "penetration", "penetration depth", "pd"),
    ),
    "force": (
        *("force", "f", "load", "actuator force", "load cell", "axial force", "damper force"),
        *("effort", "kraft", "last", "kolbenkraft", "standardkraft", "prüfkraft", "fuerza"),
        *("force standard", "standard force", "forza standard", "fuerza estándar"),
        *("carga", "forza", "carico", "forca", *STRESSES),
        *("torque", "moment", "couple", "drehmoment", "coppia", "par", "p"),
    ),
}
NAMES = {channel: (*names, *CHANNELS[channel]) for channel, names in NAMES.items()}
UNITS = {
    "time": TIME_UNITS,
    "displacement": LENGTH_UNITS | STRAIN_UNITS | ANGLE_UNITS,
    "force": FORCE_UNITS | PRESSURE_UNITS | TORQUE_UNITS,
}
ADVICE = {"time": "time [s]", "displacement": "displacement [mm]", "force": "force [N]"}
_FEW = {
    "time": ("s", "ms"),
    "displacement": ("mm", "m", "in", "%", "rad"),
    "force": ("N", "kN", "lbf", "MPa", "N m"),
}
"""Units that a page offers for a column that it asks for: those that test machines write."""
_EXAMPLE = {"time": "s", "displacement": "mm", "force": "N"}
_ANY = {unit for table in UNITS.values() for unit in table}
_OF_A_SWEEP = {*FREQUENCY_UNITS, *TEMPERATURE_UNITS}
_OF = {fold(name): channel for channel, names in reversed(NAMES.items()) for name in names}
_RANK = {fold(name): i for names in NAMES.values() for i, name in enumerate(names)}
_BRACKETED = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$")


_PREFIX = re.compile(
    r"(?:[a-z]{1,6}\d{1,5}[a-z]{0,2}[\s_.:-]{1,3})?"
    r"(?:ch(?:an(?:nel)?)?|kanal|voie|canal|canale|ai|チャンネル|通道)[\s_.:#-]{0,3}\d{1,3}[\s_.:)-]{1,3}(?=\S)",
    re.IGNORECASE,
)
"""What an amplifier writes before the name of a channel.

``Ch 1 Kraft``, ``Channel 2. Load``, ``MX840_CH_1 Weg``.
"""
_NUMBERED = re.compile(r"[\s_#.-]{0,2}\d{1,2}(?:\s+-\s.*)?$")
"""A sensor's number behind its name, or a clock's with its rate.

``LVDT 3``, ``Zeit 1 - Standardmessrate``.
"""
_TIMES = re.compile(r"[x×*]\s*10{1,9}(?!\d)|10\s*\^")
"""A factor among the words of a title: whether the numbers are to be multiplied is asked for."""
_WAY = "s"
"""The German symbol of a displacement; without a length beside it, it is the unit of a time."""
_NOT_MEASURED = frozenset(
    (
        *("command", "cmd", "setpoint", "set", "soll", "sollwert", "consigne", "target", "error"),
        *("limit", "max", "min", "peak", "offset", "mean", "rate", "amplitude", "range"),
        *("maximum", "minimum", "cumulative", "total", "count"),
        *("log", "log10", "loge", "lg", "ln"),
    )
)
"""Words of a channel that was not measured, or is no channel at each moment."""
_WORST = 1000
"""Added to the rank of a name whose unit is none of its channel.

A sensor in volts beside the calibrated one.
"""


@lru_cache(maxsize=2048)
def channel_of(title: str) -> tuple[str | None, str | None, str]:
    """Channel, unit and bare name of a title.

    ``force [kN]``, ``force_kN``, ``Kraft / kN`` or ``Ch 1 Kraft``.
    """
    title = " ".join(title[:200].lstrip("#% ").split())
    named = _channel(title)
    if named[0] is None and (match := _PREFIX.match(title)):
        named = _channel(title[match.end() :])
    if named[0] is None:
        return _numbered(title)
    return named


def _numbered(title: str) -> tuple[str | None, str | None, str]:
    """The channel of a sensor that has a number; single letters with one are any sensor's."""
    words, unit = title, None
    if match := _BRACKETED.match(title):
        words, unit = match[1], match[2]
    if words.strip() == _WAY and normal_unit(unit or "") in LENGTH_UNITS:
        return "displacement", unit, words
    bare = _NUMBERED.sub("", words)
    # "x1" and "F 2" may be anything: of a letter or two the number could be the whole difference.
    if (channel := _OF.get(fold(bare))) is not None and len(fold(bare)) > 2:
        return channel, unit, bare
    if _TIMES.search(words):
        return None, None, title
    parts = [fold(word) for word in re.split(r"[\s_.-]+", words)]
    channels = {_OF[word] for word in parts if word in _OF and len(word) > 2}
    if len(channels) != 1 or unit is None or _NOT_MEASURED & set(parts):
        return None, None, title
    channel = channels.pop()
    # "Weg oben [mm]", "Load cell 50kN [kN]": words beside the name are a place or a type, if the
    # unit fits.
    if normal_unit(unit) not in UNITS[channel]:
        return None, None, title
    return channel, unit, words


def _channel(title: str) -> tuple[str | None, str | None, str]:
    match = _BRACKETED.match(title)
    bare = title
    if not match or normal_unit(match[2]) not in _ANY:
        # Several words in parentheses are a remark, unless they are a unit, such as (N m).
        bare = re.sub(r"\s*\([^()]* .*$", "", title)
    if (channel := _OF.get(fold(bare))) is not None:
        return channel, None, bare
    if (match := _BRACKETED.match(bare)) and match[1]:
        stem = re.sub(r"\s*\([^()]*\)$", "", match[1])
        return _OF.get(fold(match[1])) or _OF.get(fold(stem)), match[2].strip(), stem
    for match in reversed(list(re.finditer(r"\s*/\s+|\s+in\s+|_|\s+", bare))[:20]):
        stem, unit_text = bare[: match.start()], bare[match.end() :]
        channel = _OF.get(fold(stem))
        for over in ("/", " "):
            unit = unit_text.replace("_per_", "/").replace("_", over)
            if channel is not None and normal_unit(unit) in UNITS[channel]:
                return channel, unit, stem
    return None, None, bare


def found_in(titles: Sequence[str]) -> set[str]:
    """The channels that titles name; ``f (Hz)`` is no force, and ``T (°C)`` no time."""
    named = [channel_of(title)[:2] for title in titles]
    return {
        channel
        for channel, unit in named
        if channel is not None and normal_unit(unit or "") not in _OF_A_SWEEP
    }


@dataclass(frozen=True)
class Places:
    """Where the three channels are, and their units.

    Parameters
    ----------
    columns : tuple of int
        Column of time, displacement and force.
    units : tuple of str
        Their units.
    signs : tuple of float
        1, or -1 for a channel that counts the other way.
    notes : tuple of str
        What the user should know of the choice.
    """

    columns: tuple[int, int, int]
    units: tuple[str, str, str]
    signs: tuple[float, float, float] = (1.0, 1.0, 1.0)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Place:
    """One channel: its column, its unit, and how surely it is the one meant (lower is surer)."""

    column: int
    unit: str | None
    rank: int = 0


def places_of(titles: Sequence[str], below: Sequence[str], choice: Choice) -> Places:
    """Where time, displacement and force are.

    Parameters
    ----------
    titles : sequence of str
        Names of the columns.
    below : sequence of str
        Units from a row of their own or from a file's properties; empty where there are none.
    choice : Choice
        What the user says: ``force=kN``, ``3=force[kN]``, ``force=-kN`` for a force that counts
        the other way, or ``3=ignore``.

    Raises
    ------
    DataError
        If a channel or its unit is missing, with what to write.
    """
    # A binary file may have names of several lines.
    titles = [" ".join(title.split()) for title in titles]
    said = dict(choice.columns)
    for name in [name for name, meaning in said.items() if meaning in _IGNORED]:
        # As though the file called it nothing: its number stays, and another sensor may be meant.
        titles[_column(_recognised(titles, below), titles, name, said.pop(name))] = ""
    layout = _recognised(titles, below)
    notes: list[str] = []
    for name, meaning in said.items():
        notes += _apply(layout, titles, name, meaning)
    _require_all(layout, titles)
    if not said:  # which sensor is meant was then said by the user
        notes += _sensors_left(layout, titles, below)
    columns, units, signs = [], [], []
    for channel in UNITS:
        sign, unit = apart_from_sign(str(layout[channel].unit).strip())
        columns.append(layout[channel].column)
        units.append(known_unit(normal_unit(unit), UNITS[channel], channel))
        signs.append(sign)
    return Places(
        (columns[0], columns[1], columns[2]),
        (units[0], units[1], units[2]),
        (signs[0], signs[1], signs[2]),
        tuple(notes),
    )


def _unit_below(below: Sequence[str], i: int) -> str:
    """The unit in the row of units, which may be shorter than that of the names."""
    if i >= len(below):
        return ""
    return below[i].strip().strip("[]()")


def _recognised(titles: Sequence[str], below: Sequence[str]) -> dict[str, _Place]:
    """The channels that names and units tell; of several the one whose name is surest."""
    layout: dict[str, _Place] = {}
    for i, title in enumerate(titles):
        channel, unit, bare = channel_of(title)
        if channel is None:
            continue
        unit = unit or _unit_below(below, i) or None
        # A name that only resembles those of the list is less sure than any of them.
        rank = _RANK.get(fold(bare), 99)
        # It is still taken where there is no other, so that the error names it.
        if unit is not None and normal_unit(unit) not in UNITS[channel]:
            rank += _WORST
        if channel not in layout or rank < layout[channel].rank:
            layout[channel] = _Place(i, unit, rank)
    return layout


def _sensors_left(
    layout: Mapping[str, _Place], titles: Sequence[str], below: Sequence[str]
) -> list[str]:
    """A note for each channel that several sensors measured, of which one is taken."""
    notes = []
    for channel, place in layout.items():
        others = []
        for i, title in enumerate(titles):
            other, unit, _ = channel_of(title)
            unit = unit or _unit_below(below, i)
            # In another unit it is another quantity, such as the raw volts of the same sensor.
            if (
                other == channel
                and i != place.column
                and normal_unit(unit) == normal_unit(place.unit or "")
            ):
                others.append(f"'{title}'")
        # Several clocks tell the same time.
        if others and channel != "time":
            notes.append(f"{channel} is '{titles[place.column]}', not {' or '.join(others[:3])}")
    return notes


def _require_all(layout: dict[str, _Place], titles: Sequence[str]) -> None:
    """Ask for the channels and units that are missing."""
    missing = [channel for channel in UNITS if channel not in layout]
    if missing:
        shown = ", ".join(titles[:12]) or "none"
        spec = ",".join(f"NAME={ADVICE[channel].replace(' ', '')}" for channel in missing)
        message = (
            f"no column of {' and '.join(missing)}; write {ADVICE[missing[0]]} above it, "
            f"or say which by 'FILE?{spec}' (columns: {shown:.100})"
        )
        if missing == ["time"]:
            message += (
                "; of samples that are evenly spaced say how many there are a second:"
                " 'FILE?rate=1000[Hz]'"
            )
        free = set(range(len(titles))) - {place.column for place in layout.values()}
        raise OpenQuestion(message, [_which(channel, titles, sorted(free)) for channel in missing])
    bare = {key: titles[layout[key].column] for key in UNITS if layout[key].unit is None}
    if bare:
        units = {key: example_unit(title, _EXAMPLE[key]) for key, title in bare.items()}
        spec = ",".join(f"{channel}={unit}" for channel, unit in units.items())
        names = ", ".join(f"'{title}'" for title in bare.values())
        first = next(iter(bare))
        message = (
            f"column {names}: there is no unit; write {first} [{units[first]}],"
            f" or say it by 'FILE?{spec}'"
        )
        raise OpenQuestion(
            message, [Question.of_unit(each, unit, UNITS[each]) for each, unit in units.items()]
        )


def example_unit(title: str, usual: str) -> str:
    """A unit that a column with this title may have: a strain none, a stress no force's."""
    called = channel_of(title)[2].casefold()
    if called in STRAINS:
        return "-"
    return "Pa" if called in STRESSES else usual


def _which(channel: str, titles: Sequence[str], free: Sequence[int]) -> Question:
    """The question for the column that a channel is, by number: a title may hold anything."""
    answers = {}
    for i in free:
        name = titles[i] or f"column {i + 1}"
        for unit in _FEW[channel]:
            answers[f"{name} [{unit}]"] = f"{i + 1}={channel}[{unit}]"
    return Question(channel, "column", answers)


def _apply(layout: dict[str, _Place], titles: Sequence[str], name: str, meaning: str) -> list[str]:
    """Put what a user says of one column into the layout.

    Notes of what the file itself says otherwise.
    """
    require_word(meaning)
    column = _column(layout, titles, name, meaning)
    channel, unit, _ = channel_of(meaning)
    if channel is not None:
        before = layout.get(channel)
        layout[channel] = _Place(column, unit or channel_of(titles[column])[1])
        return _overruled(channel, before, layout[channel], titles)
    # No channel was said, so that it is the unit of one that is known already.
    channel = next((key for key, place in layout.items() if place.column == column), None)
    if channel is None:
        raise DataError(
            f"say what column '{name:.40}' is, such as 'FILE?{name}=force[{meaning:.20}]'"
        )
    before = layout[channel]
    layout[channel] = _Place(column, meaning)
    return _overruled(channel, before, layout[channel], titles)


def _column(layout: Mapping[str, _Place], titles: Sequence[str], name: str, meaning: str) -> int:
    """The column that a user calls by number, title or channel.

    Of several it is the one that would be taken without the hint, which says more of it and never
    another.
    """
    taken = {place.column for place in layout.values()}
    tests: tuple[Callable[[int, str], bool], ...] = (
        lambda i, title: name == str(i + 1) or name == title,
        lambda i, title: name in layout and layout[name].column == i,
        lambda i, title: with_numbers_of(name, title) and fold(name) == fold(channel_of(title)[2]),
        lambda i, title: (
            with_numbers_of(name, title) and channel_of(title)[0] == channel_of(name)[0] is not None
        ),
    )
    # An exact name in any place goes before a mere likeness.
    passing = ([i for i, title in enumerate(titles) if is_meant(i, title)] for is_meant in tests)
    named = next((places for places in passing if places), [])
    named = [i for i in named if i in taken] or named
    if not named:
        raise DataError(f"no column '{name:.40}' (there are: {', '.join(titles[:12])})")
    if len(named) > 1:
        shown = " or ".join(f"{i + 1}, '{titles[i]}'" for i in named[:4])
        instead = f"write {named[0] + 1}={meaning:.40} or another number in its place"
        raise DataError(f"'{name:.40}' may be column {shown}; {instead}")
    return named[0]


def with_numbers_of(name: str, title: str) -> bool:
    """Whether a title has the numbers of a name: ``Force 2`` is not ``Force [kN]``."""
    return set(re.findall(r"\d+", name)) <= set(re.findall(r"\d+", title))


def _overruled(
    channel: str, before: _Place | None, now: _Place, titles: Sequence[str]
) -> list[str]:
    """What the file says otherwise than the user."""
    if before is not None and before.column != now.column:
        return [f"{channel} is '{titles[now.column]}' as you said, not '{titles[before.column]}'"]
    own = channel_of(titles[now.column])
    if own[0] not in (None, channel):
        return [f"'{titles[now.column]}' is {channel} as you said; its name says {own[0]}"]
    given, unit = own[1], now.unit or ""
    if before is not None:
        given = before.unit
    if given is not None and normal_unit(given) != normal_unit(unit.removeprefix("-")):
        return [f"'{titles[now.column]}' is in {unit} as you said; the file says {given}"]
    return []


def _times(channel: Real, factor: float) -> Real:
    if factor == 1.0:
        # A mapped channel stays mapped, and exact values stay the same bits.
        return channel
    return channel * factor


def signals_from(values: Sequence[Real], places: Places, path: Path, origin: str) -> Signals:
    """The channels (time, displacement, force) as signals, time in seconds.

    Raises
    ------
    DataError
        If a value is so large that it cannot be a measurement, as in a broken binary file.
    """
    for name, channel in zip(UNITS, values, strict=True):
        if (
            not isinstance(channel, np.memmap)
            and (np.abs(channel[np.isfinite(channel)]) > IMMENSE).any()
        ):
            raise DataError(
                f"{name} has values beyond {IMMENSE:g}; the file is broken, or the wrong channel"
            )
    factors = (TIME_UNITS[places.units[0]] * places.signs[0], *places.signs[1:])
    clock, moved, pulled = map(_times, values, factors)
    facts = {"file": path.name, "format": origin}
    if places.notes:
        facts["note columns"] = "; ".join(places.notes)
    return Signals(clock, moved, pulled, places.units[1], places.units[2], path.name, facts)


def reader_of_signals(
    name: str,
    summary: str,
    recognises: Callable[[bytes], float],
    signals: Callable[[Path, Choice], Signals],
) -> Reader:
    """The reader of a format that is told by its signals, whose measurement is their one row.

    Parameters
    ----------
    name, summary, recognises, signals
        As of `springpot.measurement.Reader`.
    """
    # No functions within this one: those could not be handed to another process.
    read = partial(_read_signals, signals)
    return Reader(name, summary, recognises, read, signals=signals)


def _read_signals(
    signals: Callable[[Path, Choice], Signals], path: Path, choice: Choice
) -> Measurement:
    """The measurement of one row that the signals give."""
    return measurement_from_signals([signals(path, choice)])
