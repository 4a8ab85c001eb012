"""Moduli from what stands in their place: complex viscosity, its parts, compliances, or logarithms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from springpot.measurement import MODULUS_UNITS, known_unit
from springpot.rheology import Real

from .grid import MISSING, is_number
from .table import Column
from .titles import COMPLIANCE_UNITS, DAMPING_UNITS, UNITS, VISCOSITY_UNITS

VISCOSITIES = ("dynamic_viscosity", "out_of_phase_viscosity")
COMPLIANCES = ("storage_compliance", "loss_compliance")


def with_moduli(roles: Mapping[str, Column]) -> dict[str, Column]:
    """The columns, with storage and loss, or a magnitude, in Pa for what is no modulus.

    |G*| = omega |eta*|; G'' = omega eta' and G' = omega eta''; G* = 1 / (J' - i J'');
    K'' = omega c for a damping coefficient beside a storage stiffness, or K' = sqrt(|K|^2 - (omega c)^2) beside a
    dynamic one; tan delta = 2 xi for the damping ratio xi = W / (2 pi K' X^2) of ISO 22762-1, W the work of a cycle.

    Raises
    ------
    DataError
        If a damping coefficient alone gives more than the whole stiffness.
    """
    found = dict(roles)
    if "damping_ratio" in found:
        column = found.pop("damping_ratio")
        found["loss_factor"] = _column(column, "loss_factor", 2.0 * _si(column, UNITS["damping_ratio"]), "-")
    if "viscosity" in found:
        column = found.pop("viscosity")
        found["magnitude"] = _column(column, "magnitude", _omega(found) * _si(column, VISCOSITY_UNITS))
    elif found.keys() >= set(VISCOSITIES):
        dynamic, other = (found.pop(role) for role in VISCOSITIES)
        found["loss"] = _column(dynamic, "loss", _omega(found) * _si(dynamic, VISCOSITY_UNITS))
        found["storage"] = _column(other, "storage", _omega(found) * _si(other, VISCOSITY_UNITS))
    elif "damping" in found and "loss" not in found:
        column = found.pop("damping")
        loss = _omega(found) * _si(column, DAMPING_UNITS)
        found["loss"] = _column(column, "loss", loss, "N/m")
        if "storage" not in found:
            found["storage"] = _rest(found.pop("magnitude"), loss, column)
    elif found.keys() >= set(COMPLIANCES):
        elastic, viscous = (found.pop(role) for role in COMPLIANCES)
        # A compliance of zero gives no finite modulus, which the measurement refuses.
        with np.errstate(all="ignore"):
            modulus = 1.0 / (_si(elastic, COMPLIANCE_UNITS) - 1j * _si(viscous, COMPLIANCE_UNITS))
        found["storage"] = _column(elastic, "storage", modulus.real)
        found["loss"] = _column(viscous, "loss", modulus.imag)
    return found


def _rest(size: Column, loss: Real, damping: Column) -> Column:
    """Storage stiffness in N/m from the dynamic one, where the loss is known."""
    whole = _si(size, MODULUS_UNITS)
    left = whole**2 - loss**2
    if (left < 0).any():
        row = int(np.argmax(left < 0))
        raise damping.error("omega times the damping coefficient is more than the whole dynamic stiffness", row)
    return _column(size, "storage", np.sqrt(left), "N/m")


def unlogged(column: Column, base: str) -> Column:
    """The column itself of one that holds its logarithms, to base ``10`` or ``e``; others as they are."""
    if not base:
        return column
    cells = [cell if cell.strip() in MISSING or not is_number(cell) else _power(base, cell) for cell in column.cells]
    return replace(column, cells=cells, decimal_comma=False)


def _power(base: str, cell: str) -> str:
    number = float(cell.strip().replace(",", ".").replace("−", "-").replace("D", "E").replace("d", "e"))
    with np.errstate(all="ignore"):
        value = float(np.exp(number) if base == "e" else np.power(10.0, number))
    # A mere "inf" would pass for a gap; this is refused later, with its line.
    return repr(value) if np.isfinite(value) else "infinity"


def _omega(roles: Mapping[str, Column]) -> Real:
    clock = roles.get("omega") or roles["frequency"]
    return _si(clock, UNITS["frequency"])


def _si(column: Column, table: dict[str, float]) -> Real:
    values: Real = column.numbers() * table[known_unit(column.unit or "", table, column.name)]
    return values


def _column(like: Column, name: str, values: Real, unit: str = "Pa") -> Column:
    write: Callable[[float], str] = repr
    return replace(like, name=name, unit=unit, cells=list(map(write, values.tolist())), decimal_comma=False)
