"""Named columns to a measurement.

Which column is what, units, and the checks that a user's slip runs into.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import (
    AMPLITUDE_UNITS,
    ANGLE_UNITS,
    COHERENCE,
    FILE_UNITS,
    FREQUENCY_UNITS,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    Measurement,
    Units,
    known_unit,
    misspelt,
    temperature_in_celsius,
)
from springpot.measurement.mixed_up import EXCHANGED, FAR, SIGN, exchange_note, runs_together
from springpot.measurement.replicates import NOTE as AGAIN, again_note
from springpot.rheology import Complex, Real

from .proposals import COLUMN_OF_AMPLITUDE, COLUMN_OF_TEMPERATURE, unit_proposal, usual_unit
from .table import Column
from .title_words import letter_of

ROLES = (
    *(
        "frequency",
        "omega",
        "storage",
        "loss",
        "magnitude",
        "phase",
        "loss_factor",
        "storage_sd",
        "loss_sd",
    ),
    *("temperature", "amplitude", "repeat"),
)
"""What a measurement is made of, by the names of springpot's own tables.

Other names for them are in `names`.
"""
TEXT = "text"
"""Unit that marks a column of words, so that a word that looks like a number stays a word."""
_SIZE = re.compile(r"([fiσ])_?([2-9]) ?/ ?(?:\1_?)?1|h([2-9])", re.IGNORECASE)
"""|H_n| by the names of force and of stress harmonics: F3/F1, I3/I1, I3/1, h3."""


def assign(columns: tuple[Column, ...]) -> tuple[dict[str, Column], list[Column]]:
    """Columns by role, and the others."""
    roles = {column.name: column for column in columns if column.name in ROLES}
    return roles, [column for column in columns if column.name not in ROLES]


def measurement_of(
    roles: Mapping[str, Column], others: list[Column], name: str, provenance: Mapping[str, str]
) -> Measurement:
    """The measurement in the file's own units.

    Parameters
    ----------
    roles : mapping of str to Column
        Columns by role, see `ROLES`.
    others : list of Column
        Further conditions, words and harmonics.
    name : str
        Name of the measurement.
    provenance : mapping of str to str
        Where it comes from.

    Raises
    ------
    DataError
        If a column is missing or a value cannot be used.
    """
    # What overflows is found by the checks of the measurement.
    with np.errstate(all="ignore"):
        omega = _omega(roles)
        stiffness, unit = _stiffness(roles)
        _check_something(stiffness, roles)
        sd = _deviations(roles, unit)
        conditions, amplitude_unit = _conditions(roles)
    harmonics, others = _harmonics(others)
    for column in others:
        # A misspelt temperature would otherwise become a condition that no effect knows.
        if advice := misspelt(column.name):
            raise column.error(f"the name {advice}")
    extra, labels, units = _further(others)
    known_labels = frozenset[str]()
    if "note parts" in provenance:
        # That note tells already that the steps are several runs.
        known_labels = frozenset({"step"})
    shown = Units(unit, amplitude_unit, _clock(roles), _letter(roles, unit))
    notes = {
        **_doubts(roles),
        **runs_together({**conditions, **extra}, labels, known_labels),
    }
    provenance = {**provenance, **{f"unit {key}": value for key, value in units.items()}, **notes}
    repeat = _repeat(roles.get("repeat"))
    measured = Measurement(
        omega=omega,
        stiffness=stiffness,
        sd=sd,
        conditions={**conditions, **extra},
        repeat=repeat,
        harmonics=harmonics,
        units=shown,
        name=name,
        provenance=provenance,
        labels=labels,
    )
    of_values = {**_negative(measured), **exchange_note(measured), **again_note(measured)}
    return replace(measured, provenance={**provenance, **of_values})


def _unit(column: Column, table: dict[str, float], advice: str, alike: Sequence[str] = ()) -> str:
    """The column's unit as the table spells it; columns of the roles `alike` have the same one."""
    if column.unit is None:
        raise column.error(f"there is no unit; {advice}")
    try:
        return known_unit(column.unit, table, column.name)
    except DataError as error:
        proposed = unit_proposal(alike or [column.name], column.title, column.unit)
        raise column.error(f"{error}; {proposed}") from None


def _omega(roles: Mapping[str, Column]) -> Real:
    column = roles.get("omega") or roles.get("frequency")
    if column is None:
        raise DataError("no column of frequencies; write frequency [Hz] or omega [rad/s]")
    if "omega" in roles and "frequency" in roles:
        raise DataError("both omega and frequency are given; keep one")
    unit = _unit(column, FREQUENCY_UNITS, "write frequency [Hz] or omega [rad/s]")
    if column.name == "omega" and unit != "rad/s":
        raise column.error(f"omega is in rad/s; a column in {unit} is called frequency [{unit}]")
    values = column.numbers()
    wrong = values <= 0
    if wrong.any():
        row = int(np.argmax(wrong))
        raise column.error(
            f"the frequency must be positive, got {values[row]:g}; leave out the row", row
        )
    if unit == "rad/s":
        # The same bits as in the file.
        return values
    return values * FREQUENCY_UNITS[unit]


def _clock(roles: Mapping[str, Column]) -> str:
    """In which frequencies are told: in rad/s where they came so, otherwise in Hz."""
    column = roles.get("omega") or roles["frequency"]
    if column.unit is not None and known_unit(column.unit, FREQUENCY_UNITS, "") == "rad/s":
        return "rad/s"
    return "Hz"


def _letter(roles: Mapping[str, Column], unit: str) -> str:
    """The letter of the modulus (G, E, K) or stiffness (K) that the titles tell of."""
    titles = [roles[role].title for role in ("storage", "magnitude") if role in roles]
    if unit == FILE_UNITS:
        return _letter_without_unit(titles)
    return letter_of(titles, unit in PRESSURE_UNITS)


def _letter_without_unit(titles: Sequence[str]) -> str:
    """The same by names alone: what they call a stiffness is no modulus."""
    if any(usual_unit("storage", title) in PRESSURE_UNITS for title in titles):
        return letter_of(titles, is_modulus=True)
    return "K"


def _modulus(roles: Mapping[str, Column], role: str) -> tuple[Real, str]:
    column = roles[role]
    advice = f"write {column.name} [N/mm], [kN/m], [Pa] or any stiffness or pressure unit"
    moduli = ("storage", "loss", "magnitude")
    alike = [each for each in moduli if each in roles and roles[each].unit == column.unit]
    return column.numbers(), _unit(column, MODULUS_UNITS, advice, alike)


def _in_unit(values: Real, unit: str, wanted: str, column: Column) -> Real:
    """Values converted; the same bits where nothing is to be converted."""
    if unit == wanted:
        return values
    kinds = [
        {*PRESSURE_UNITS},
        {*STIFFNESS_UNITS},
        {*MODULUS_UNITS} - {*PRESSURE_UNITS} - {*STIFFNESS_UNITS},
    ]
    if not any(unit in kind and wanted in kind for kind in kinds):
        raise column.error(f"[{unit}] cannot be converted to [{wanted}] of the other column")
    return values * (MODULUS_UNITS[unit] / MODULUS_UNITS[wanted])


def _stiffness(roles: Mapping[str, Column]) -> tuple[Complex, str]:
    """K' + i K'' from storage and loss, or from one or the magnitude with phase or loss factor."""
    if "storage" in roles and "loss" in roles:
        storage, unit = _modulus(roles, "storage")
        loss, loss_unit = _modulus(roles, "loss")
        return _complex(storage, _in_unit(loss, loss_unit, unit, roles["loss"])), unit
    tangent = _tangent(roles)
    if tangent is None or not roles.keys() & {"magnitude", "storage", "loss"}:
        there = ", ".join(f"'{column.title}'" for column in roles.values())
        raise DataError(
            f"no storage and loss (found {there}); write storage [unit] and loss [unit], "
            "or magnitude [unit] with phase [deg] or loss_factor [-]"
        )
    if "storage" in roles:
        storage, unit = _modulus(roles, "storage")
        return _complex(storage, storage * np.tan(tangent)), unit
    if "loss" in roles and "magnitude" not in roles:
        loss, unit = _modulus(roles, "loss")
        return _complex(_over_tangent(loss, tangent, roles["loss"]), loss), unit
    size, unit = _modulus(roles, "magnitude")
    wrong = size <= 0
    if wrong.any():
        raise roles["magnitude"].error("the magnitude must be positive", int(np.argmax(wrong)))
    return _complex(size * np.cos(tangent), size * np.sin(tangent)), unit


def _over_tangent(loss: Real, tangent: Real, column: Column) -> Real:
    """Storage from the loss modulus and the loss angle, which must not be zero."""
    wrong = np.tan(tangent) == 0
    if wrong.any():
        raise column.error(
            "tan delta is zero, so that it gives no storage; leave out the row",
            int(np.argmax(wrong)),
        )
    return np.asarray(loss / np.tan(tangent))


def _doubts(roles: Mapping[str, Column]) -> dict[str, str]:
    """MPa beside mPa is allowed, but seldom meant."""
    if not roles.keys() >= {"storage", "loss"}:
        return {}
    storage, loss = roles["storage"].unit, roles["loss"].unit
    if not storage or not loss or storage == loss or storage.lower() != loss.lower():
        return {}
    factor = _in_si(storage) / _in_si(loss)
    if factor == 1:
        return {}
    ratio = f"a factor of {max(factor, 1 / factor):.0e}"
    return {"note units": f"storage in {storage} but loss in {loss}, {ratio}: a slip?"}


def _in_si(unit: str) -> float:
    return MODULUS_UNITS[known_unit(unit, MODULUS_UNITS, "")]


NOTES_OF_VALUES = frozenset(
    {"note storage", "note loss", "note together", "note temperature", AGAIN, EXCHANGED, SIGN}
    | {COLUMN_OF_AMPLITUDE, COLUMN_OF_TEMPERATURE}
)
"""Notes made of the values and the file's name at each opening, and not written into a file."""


def _negative(measured: Measurement) -> dict[str, str]:
    """Notes where storage or loss is negative, each by the name that the data have for it."""
    notes = {}
    if (measured.storage < 0).any():
        notes["note storage"] = _negative_storage(measured)
    if (measured.loss < 0).any():
        notes["note loss"] = _negative_loss(measured.loss, measured.units)
    return notes


def _negative_storage(measured: Measurement) -> str:
    omega, rows, units = measured.omega, measured.storage < 0, measured.units
    note = f"{units.storage} negative in {int(rows.sum())} of {len(rows)} rows"
    inertia = "the inertia of the rig or the instrument outweighs the specimen"
    if rows.all():
        return f"{note}: {inertia} at all these frequencies, or check the sign of the force"
    # A mass takes m omega^2 away: it outweighs a stiffness above some frequency, never below one.
    high = np.median(omega[rows]) > np.median(omega[~rows])
    if high and _last_of_their_sweeps(measured, rows):
        begin = units.at(float(omega[rows].min()) / FREQUENCY_UNITS["Hz"])
        return f"{note}, from {begin} on: {inertia} there, which is no error"
    if 2 * rows.sum() > len(rows):
        return f"{note}; check the sign of the force"
    place = "not at the highest frequencies, where inertia does so"
    if high:
        place = "with positive ones at higher frequencies, which inertia does not do"
    return f"{note}, {place}; noise, or the instrument at its limit"


def _last_of_their_sweeps(measured: Measurement, rows: NDArray[np.bool_]) -> bool:
    """Whether the rows are the highest frequencies of each sweep, without others between."""
    # An amplitude may move along with the frequency, and would make a sweep of every row.
    for _, sweep in measured.sweeps(held=["temperature"]):
        chosen, others = sweep[rows[sweep]], sweep[~rows[sweep]]
        if (
            len(chosen)
            and len(others)
            and measured.omega[chosen].min() < measured.omega[others].max()
        ):
            return False
    return True


def _negative_loss(loss: Real, units: Units) -> str:
    count = int((loss < 0).sum())
    note = f"{units.loss} negative in {count} of {len(loss)} rows: a specimen gives no work away"
    # In most rows it is the sign of all of them; in a few it is scatter about nearly nothing.
    if 2 * count > len(loss):
        return f"{note}; check the sign of the force or of the phase"
    return f"{note}; noise, or the instrument at its limit"


def sign_note(measured: Measurement, own: Mapping[str, Column]) -> dict[str, str]:
    """What to tell of a sweep in which force and displacement count in opposite directions.

    Parameters
    ----------
    measured : Measurement
        The sweep.
    own : mapping of str to Column
        The file's own columns by role: only what it holds itself can be turned by a hint.
    """
    # Storage alone may be taken away by a mass.
    both = (measured.storage < 0.0) & (measured.loss < 0.0)
    if 2 * both.sum() > len(measured):
        if not own.keys() >= {"storage", "loss"}:
            return {}
        hint = ",".join(f"{role}=-{own[role].unit}" for role in ("storage", "loss"))
        why, what = "storage and loss are negative, as if the force had the wrong sign", "channel"
        return {SIGN: f"{why}: if one {what} counts the other way, open 'FILE?{hint}'"}
    told = next((role for role in ("loss", "phase") if role in own and own[role].unit), "")
    if not told or not np.median(measured.loss / measured.magnitude) < -FAR:
        return {}
    # No mass takes it away, and no rig lags by so much at most frequencies.
    return {
        SIGN: (
            f"loss is negative, as if the phase had the wrong sign: if the {told} counts the other"
            f" way, open 'FILE?{told}=-{own[told].unit}'"
        )
    }


def _complex(real: Real, imaginary: Real) -> Complex:
    # Adding 1j * x would turn a storage of -0.0 into 0.0.
    value = np.empty(len(real), dtype=np.complex128)
    value.real, value.imag = real, imaginary
    return value


def _check_something(stiffness: Complex, roles: Mapping[str, Column]) -> None:
    """A point at which storage and loss are both zero was not measured."""
    nothing = np.flatnonzero(stiffness == 0)
    if len(nothing):
        more = ""
        if len(nothing) > 1:
            more = f" (and {len(nothing) - 1} more such rows)"
        column = roles.get("storage") or roles["magnitude"]
        raise column.error(
            f"storage and loss are both zero: nothing was measured, leave out the row{more}",
            int(nothing[0]),
        )


def _tangent(roles: Mapping[str, Column]) -> Real | None:
    """The loss angle in rad."""
    if "phase" in roles:
        column = roles["phase"]
        unit = _unit(column, ANGLE_UNITS, "write phase [deg] or phase [rad]")
        angle = column.numbers() * ANGLE_UNITS[unit]
        if unit == "rad" and (beyond := np.abs(angle) > 2.0 * np.pi).any():
            row = int(np.argmax(beyond))
            raise column.error(
                f"{angle[row]:g} rad is more than a cycle; if it is degrees, open 'FILE?phase=deg'",
                row,
            )
        return angle
    if "loss_factor" in roles:
        column = roles["loss_factor"]
        unit = known_unit(column.unit or "-", STRAIN_UNITS, column.name)
        return np.asarray(np.arctan(column.numbers() * STRAIN_UNITS[unit]))
    return None


def _deviations(roles: Mapping[str, Column], unit: str) -> Complex | None:
    columns = [roles[role] for role in ("storage_sd", "loss_sd") if role in roles]
    if not columns:
        return None
    # A scatter of magnitude and phase would not be that of K' and K'' alone.
    if len(columns) == 1 or "loss" not in roles:
        raise columns[0].error("standard deviations need storage, storage_sd, loss and loss_sd")
    parts = []
    for column in columns:
        values = column.numbers()
        # Without a unit they are in that of the storage, as in springpot's own tables.
        if column.unit is not None:
            values = _in_unit(values, _unit(column, MODULUS_UNITS, ""), unit, column)
        wrong = values <= 0
        if wrong.any():
            row = int(np.argmax(wrong))
            raise column.error(f"a standard deviation must be positive, got {values[row]:g}", row)
        parts.append(values)
    return _complex(*parts)


def _conditions(roles: Mapping[str, Column]) -> tuple[dict[str, Real], str]:
    """Temperature in degC and amplitude in its own unit; columns without any entry are left out."""
    conditions: dict[str, Real] = {}
    unit = "-"
    temperature, amplitude = roles.get("temperature"), roles.get("amplitude")
    if temperature is not None and not temperature.is_empty:
        scale = _unit(temperature, TEMPERATURE_UNITS, "write temperature [degC] or temperature [K]")
        celsius = temperature_in_celsius(temperature.numbers(), scale)
        if (celsius < -273.15).any():
            raise temperature.error("below absolute zero", int(np.argmin(celsius)))
        conditions["temperature"] = celsius
    if amplitude is not None and not amplitude.is_empty:
        unit = _unit(
            amplitude, AMPLITUDE_UNITS, "write amplitude [mm], or amplitude [-] for a strain"
        )
        moved = amplitude.numbers()
        if (moved <= 0).any():
            row = int(np.argmin(moved))
            raise amplitude.error(f"the amplitude must be positive, got {moved[row]:g}", row)
        conditions["amplitude"] = moved
    return conditions, unit


def _repeat(column: Column | None) -> NDArray[np.int64] | None:
    if column is None or column.is_empty:
        return None
    values = column.numbers()
    # Beyond 2^53 a float skips whole numbers, so that two repeats could become one.
    wrong = (values != np.round(values)) | (np.abs(values) > 2**53)
    if wrong.any():
        raise column.error("the number of the repeat must be whole", int(np.argmax(wrong)))
    return values.astype(np.int64)


def _harmonics(others: list[Column]) -> tuple[Complex | None, list[Column]]:
    """Columns h2_re, h2_im, h3_re, ... as complex numbers (n, h), and what is left."""
    parts = {column.name: column for column in others}
    orders = [n for n in range(2, 65) if f"h{n}_re" in parts and f"h{n}_im" in parts]
    if not orders:
        return None, others
    values = np.full((len(others[0].cells), max(orders) - 1), complex(np.nan, np.nan))
    for n in orders:
        values[:, n - 2] = _complex(
            parts[f"h{n}_re"].numbers(gaps=True), parts[f"h{n}_im"].numbers(gaps=True)
        )
    used = {f"h{n}_re" for n in orders} | {f"h{n}_im" for n in orders}
    return values, [column for column in others if column.name not in used]


def _further(
    others: list[Column],
) -> tuple[dict[str, Real], dict[str, NDArray[np.str_]], dict[str, str]]:
    """Other columns: numbers as conditions (nan where empty) and their units, words as labels."""
    numbers, words, units = {}, {}, {}
    for column in others:
        if column.is_empty:
            continue
        size = _SIZE.fullmatch(column.name)
        unit = column.unit or "-"
        if size and unit in STRAIN_UNITS and column.is_numeric():
            share = column.numbers(gaps=True) * STRAIN_UNITS[unit]
            numbers[f"h{size[2] or size[3]}"] = share
        elif column.unit != TEXT and column.is_numeric():
            numbers[column.name] = column.numbers(gaps=True)
            if column.name == COHERENCE and unit == "%":
                numbers[column.name] *= STRAIN_UNITS[unit]
            elif unit != "-":
                units[column.name] = unit
        else:
            words[column.name] = np.array([cell.strip() for cell in column.cells])
    return numbers, words, units
