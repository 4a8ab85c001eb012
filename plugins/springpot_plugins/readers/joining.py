"""Several parts of a file as one measurement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from springpot.measurement import (
    ANGLE_UNITS,
    FILE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    STRAIN_UNITS,
    Measurement,
    OpenQuestion,
    Question,
)
from springpot.rheology import Complex

_ALIKE = (
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    LENGTH_UNITS,
    STRAIN_UNITS,
    ANGLE_UNITS,
    {FILE_UNITS: 1.0},
)
"""Units that can be converted into each other."""


def joined(parts: Sequence[Measurement], names: Sequence[str], name: str, note: str) -> Measurement:
    """Several parts as one measurement, in the units of the first, with the label ``step``.

    Columns that are not in every part, or not in the same unit, are left out, and a note says so.

    All must be moduli, or all stiffnesses: see `require_one_kind`.
    """
    unit = parts[0].units.stiffness
    parts = [_in_unit(part, unit) for part in parts]
    amplitude = next(
        (part.units.amplitude for part in parts if "amplitude" in part.conditions), "-"
    )
    parts = [_with_amplitude(part, amplitude) for part in parts]
    common = [
        key for key in parts[0].conditions if all(_has(part, key, parts[0]) for part in parts)
    ]
    # A "step" of a part itself gives way to the name of the part, which tells them apart.
    words = [
        key
        for key in parts[0].labels
        if all(key in part.labels for part in parts) and key != "step"
    ]
    labels = {key: np.concatenate([part.labels[key] for part in parts]) for key in words}
    labels["step"] = np.concatenate(
        [np.full(len(p), word) for p, word in zip(parts, names, strict=True)]
    )
    dropped = sorted(set().union(*(part.conditions for part in parts)) - set(common))
    notes = {"note parts": note}
    if dropped:
        notes["note columns"] = (
            f"not in every part, or in other units, left out: {', '.join(dropped)}"
        )
    counted = [part.repeat for part in parts if part.repeat is not None]
    repeat = None
    if len(counted) == len(parts):
        repeat = np.concatenate(counted)
    if "amplitude" not in common:
        # The unit of a column that was left out is none of the whole.
        amplitude = "-"
    return Measurement(
        omega=np.concatenate([part.omega for part in parts]),
        stiffness=np.concatenate([part.stiffness for part in parts]),
        sd=_together(parts, lambda part: part.sd),
        conditions={
            key: np.concatenate([part.conditions[key] for part in parts]) for key in common
        },
        repeat=repeat,
        units=replace(parts[0].units, amplitude=amplitude),
        name=name,
        provenance={**parts[0].provenance, **notes},
        labels=labels,
    )


def _together(
    parts: Sequence[Measurement], column: Callable[[Measurement], Complex | None]
) -> Complex | None:
    """A column that every part has, or none."""
    columns = [values for part in parts if (values := column(part)) is not None]
    if len(columns) < len(parts):
        return None
    return np.concatenate(columns)


def _has(part: Measurement, key: str, first: Measurement) -> bool:
    """Whether a part has a condition, in the unit of the first part."""
    if key == "amplitude" and part.units.amplitude != first.units.amplitude:
        return False
    unit_key = f"unit {key}"
    return key in part.conditions and part.provenance.get(unit_key) == first.provenance.get(
        unit_key
    )


def _factor(unit: str, wanted: str) -> float | None:
    """From one unit to another; None where they measure different things."""
    for table in _ALIKE:
        if unit in table and wanted in table:
            return table[unit] / table[wanted]
    return None


def require_one_kind(parts: Sequence[Measurement], numbers: Mapping[str, int]) -> None:
    """Check that parts can be joined; `numbers` are those of the parts in their file, by name.

    Raises
    ------
    OpenQuestion
        If some are moduli and others stiffnesses: which part is meant?
    """
    wanted = parts[0].units.stiffness
    for part in parts:
        if _factor(part.units.stiffness, wanted) is None:
            message = (
                f"its parts come in {wanted} and {part.units.stiffness}; choose one, such as"
                " 'FILE#1'"
            )
            answers = {name: f"#{number}" for name, number in numbers.items()}
            raise OpenQuestion(message, [Question("part", "part", answers)])


def _in_unit(part: Measurement, wanted: str) -> Measurement:
    """The part with storage and loss in another unit; the same bits where it is the same."""
    unit = part.units.stiffness
    if unit == wanted:
        return part
    factor = _factor(unit, wanted)
    assert factor is not None, "all parts are of one kind"
    sd = part.sd
    if sd is not None:
        sd = sd * factor
    return replace(
        part, stiffness=part.stiffness * factor, sd=sd, units=replace(part.units, stiffness=wanted)
    )


def _with_amplitude(part: Measurement, wanted: str) -> Measurement:
    """The part with its amplitude in another unit, if it can be converted."""
    unit = part.units.amplitude
    factor = _factor(unit, wanted)
    if "amplitude" not in part.conditions or unit == wanted or factor is None:
        return part
    conditions = {**part.conditions, "amplitude": part.conditions["amplitude"] * factor}
    return replace(part, conditions=conditions, units=replace(part.units, amplitude=wanted))
