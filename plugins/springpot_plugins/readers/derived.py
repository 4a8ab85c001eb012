"""Moduli from what stands for them (viscosity, compliance, damping, work), and units they lack."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from springpot.errors import DataError
from springpot.measurement import FILE_UNITS, LENGTH_UNITS, MODULUS_UNITS, known_unit, normal_unit
from springpot.measurement.from_signals import stiffness_unit
from springpot.rheology import Real
from springpot.rheology.points import COLDEST

from .choices import ask_units, in_hertz, in_units_of_file
from .proposals import unit_proposal
from .table import Column
from .titles import (
    COMPLIANCE_UNITS,
    DAMPING_UNITS,
    RECEPTANCE_UNITS,
    UNITS,
    VISCOSITY_UNITS,
    Heading,
)

RATIOS = ("loss_factor", "damping_ratio")
"""Plain numbers, which need no unit."""

VISCOSITIES = ("dynamic_viscosity", "out_of_phase_viscosity")
COMPLIANCES = ("storage_compliance", "loss_compliance")


def with_moduli(roles: Mapping[str, Column]) -> dict[str, Column]:
    """The columns, with storage and loss, or a magnitude, in Pa for what is no modulus.

    |G*| = omega |eta*|; G'' = omega eta' and G' = omega eta''; G* = 1 / (J' - i J'');
    K'' = omega c for a damping coefficient, or W / (pi X^2) for the work W of a cycle, beside a
    storage stiffness, and K' = sqrt(|K|^2 - K''^2) beside a dynamic one; |K| = F / X of the
    amplitudes of force and displacement; tan delta = 2 xi for the damping ratio xi = W / (2 pi K'
    X^2) of ISO 22762-1.

    Raises
    ------
    DataError
        If a damping coefficient or the work of a cycle alone gives more than the whole stiffness.
    """
    columns = dict(roles)
    # First, since it gives a loss factor, from which all that follows goes on as from a measured
    # one.
    if "damping_ratio" in columns:
        column = columns.pop("damping_ratio")
        columns["loss_factor"] = _column(
            column, "loss_factor", 2.0 * _si(column, UNITS["damping_ratio"]), "-"
        )
    if "viscosity" in columns:
        column = columns.pop("viscosity")
        columns["magnitude"] = _column(
            column, "magnitude", _omega(columns) * _si(column, VISCOSITY_UNITS)
        )
    elif columns.keys() >= set(VISCOSITIES):
        dynamic, other = (columns.pop(role) for role in VISCOSITIES)
        columns["loss"] = _column(dynamic, "loss", _omega(columns) * _si(dynamic, VISCOSITY_UNITS))
        columns["storage"] = _column(
            other, "storage", _omega(columns) * _si(other, VISCOSITY_UNITS)
        )
    elif "damping" in columns and "loss" not in columns:
        column = columns.pop("damping")
        loss = _omega(columns) * _si(column, DAMPING_UNITS)
        columns["loss"] = _column(column, "loss", loss, "N/m")
        if "storage" not in columns:
            columns["storage"] = _rest(columns.pop("magnitude"), loss, column)
    elif "energy" in columns and "loss" not in columns:
        columns["loss"] = _loss_of_work(columns.pop("energy"), columns["amplitude"])
        if "storage" not in columns:
            loss = _si(columns["loss"], MODULUS_UNITS)
            columns["storage"] = _rest(columns.pop("magnitude"), loss, columns["loss"])
    elif "force_amplitude" in columns:
        columns["magnitude"] = _over(columns.pop("force_amplitude"), columns["amplitude"])
    elif columns.keys() >= set(COMPLIANCES):
        elastic, viscous = (columns.pop(role) for role in COMPLIANCES)
        # A compliance of zero gives no finite modulus, which the measurement refuses.
        with np.errstate(all="ignore"):
            modulus = 1.0 / (_si(elastic, COMPLIANCE_UNITS) - 1j * _si(viscous, COMPLIANCE_UNITS))
        unit = "Pa"
        if known_unit(elastic.unit or "", COMPLIANCE_UNITS, elastic.name) in RECEPTANCE_UNITS:
            unit = "N/m"
        columns["storage"] = _column(elastic, "storage", modulus.real, unit)
        columns["loss"] = _column(viscous, "loss", modulus.imag, unit)
    return columns


def _loss_of_work(work: Column, amplitude: Column) -> Column:
    """Loss stiffness in N/m from the work W of a cycle, which is pi K'' X^2."""
    moved = (
        _positive(amplitude)
        * LENGTH_UNITS[known_unit(amplitude.unit or "", LENGTH_UNITS, amplitude.name)]
    )
    return _column(work, "loss", _si(work, UNITS["energy"]) / (np.pi * moved**2), "N/m")


def _over(force: Column, amplitude: Column) -> Column:
    """Dynamic stiffness from amplitudes of force and displacement, or torque and angle."""
    # In the file's own units: kN over mm is told as kN/mm, as it was measured.
    factor, unit = stiffness_unit(normal_unit(amplitude.unit or ""), normal_unit(force.unit or ""))
    return _column(force, "magnitude", factor * force.numbers() / _positive(amplitude), unit)


def _positive(amplitude: Column) -> Real:
    moved = amplitude.numbers()
    if not (moved > 0).all():
        row = int(np.argmin(moved > 0))
        raise amplitude.error(
            "the amplitude must be positive where a stiffness follows from it", row
        )
    return moved


def _rest(size: Column, loss: Real, damping: Column) -> Column:
    """Storage stiffness in N/m from the dynamic one, where the loss is known."""
    # |K|^2 = K'^2 + K''^2; in SI, as the loss comes from another quantity with units of its own.
    whole = _si(size, MODULUS_UNITS)
    left = whole**2 - loss**2
    if (left < 0).any():
        row = int(np.argmax(left < 0))
        raise damping.error("it alone gives more than the whole dynamic stiffness", row)
    unit = known_unit(size.unit or "", MODULUS_UNITS, size.name)
    return _column(size, "storage", np.sqrt(left) / MODULUS_UNITS[unit], unit)


def _omega(roles: Mapping[str, Column]) -> Real:
    clock = roles.get("omega") or roles["frequency"]
    return _si(clock, UNITS["frequency"])


def _si(column: Column, table: dict[str, float]) -> Real:
    return column.numbers() * table[known_unit(column.unit or "", table, column.name)]


def _column(like: Column, name: str, values: Real, unit: str = "Pa") -> Column:
    write: Callable[[float], str] = repr
    return replace(
        like, name=name, unit=unit, cells=list(map(write, values.tolist())), decimal_comma=False
    )


def with_units(roles: Mapping[str, Column]) -> tuple[dict[str, Column], dict[str, str]]:
    """The columns with their units, and a note where none are written.

    A frequency is then in Hz, a temperature in degC where it cannot be in K, and moduli are in the
    units of the file.

    Raises
    ------
    DataError
        If a unit is unknown.
    OpenQuestion
        If units are missing that must be known: all that are missing are asked for at once.
    """
    taken, notes = dict(roles), dict[str, str]()
    if "temperature" in roles:
        taken["temperature"], notes = in_celsius(roles["temperature"])
    bare = [
        Heading(column.title, column.title, role, None)
        for role, column in taken.items()
        if column.unit is None and role in UNITS and role not in (*RATIOS, "storage_sd", "loss_sd")
    ]
    clock = [each for each in bare if each.role == "frequency"]
    sizes = [each for each in bare if each.role != "frequency"]
    moduli = roles.keys() & {"storage", "loss", "magnitude"}
    # What has to be asked anyway is asked at once.
    if sizes and {each.role for each in sizes} != moduli:
        raise ask_units(bare)
    _require_known(roles)
    if clock:
        taken["frequency"] = replace(roles["frequency"], unit="Hz")
        notes["note clock"] = in_hertz(clock[0])
    if sizes:
        taken |= {role: replace(roles[role], unit=FILE_UNITS) for role in moduli}
        notes["note units"] = in_units_of_file(sizes)
    return taken, notes


def in_celsius(warm: Column) -> tuple[Column, dict[str, str]]:
    """Temperatures in their unit, or in degC, with a note, where no chamber is as cold in K."""
    if warm.unit is not None or warm.is_empty:
        return warm, {}
    try:
        coldest = np.nanmin(warm.numbers(gaps=True))
    except DataError:
        return warm, {}  # words, such as RT, are in no unit
    if not coldest < COLDEST:
        return warm, {}
    says = f"there is no unit, and degC is taken; write {warm.title} [degC]"
    note = f"'{warm.title}': {says}, or if it is another one say 'FILE?temperature=degF'"
    return replace(warm, unit="degC"), {"note celsius": note}


def _require_known(roles: Mapping[str, Column]) -> None:
    for role, column in roles.items():
        if column.unit is None or role not in UNITS:
            continue
        try:
            known_unit(column.unit, UNITS[role], role)
        except DataError as error:
            # All that are in it are said at once: storage alone would only lead to the same
            # question for the loss.
            alike = [
                each for each, other in roles.items() if other.unit == column.unit and each in UNITS
            ]
            raise column.error(
                f"{error}; {unit_proposal(alike, column.title, column.unit)}"
            ) from None
