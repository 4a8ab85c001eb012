"""What a table with a time lacks to be a test, and what to write."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import LENGTH_UNITS
from springpot.rheology import Real

from ..readers.names import role_of
from ..readers.titles import heading
from .sections import Section

EXAMPLES = {
    "time": "s",
    "relaxation": "Pa",
    "compliance": "1/Pa",
    "displacement": "mm",
    "force": "N",
}
"""What to write in a hint."""
_THERE_AND_BACK = 2
"""Passages of the middle by a record that is no oscillation."""


def lacking(section: Section, path: Path) -> DataError:
    """What a table with a time needs to be a test."""
    there = ", ".join(title.text for title in section.titles[:12])
    if section.roles >= {"displacement", "force"}:
        return DataError(
            f"{path}: displacement and force are in units that make no stiffness (columns: {there})"
        )
    if any(role_of(title.text.partition("[")[0]) == "flow" for title in section.titles):
        # A rate or a viscosity beside a stress: no column of it, whatever it is called, would make
        # it a test.
        return DataError(
            f"{path}: steady flow, neither an oscillation nor a test in time; give the step that"
            f" oscillates, creeps or relaxes (columns: {there})"
        )
    lacks, has = "force", "displacement"
    if "force" in section.roles:
        lacks, has = has, lacks
        if (place := _distance(section)) is not None:
            return DataError(f"{path}: {_instead(section, place, path)} (columns: {there})")
    return DataError(
        f"{path}: a {has} without a {lacks} is no test; add {lacks} [{EXAMPLES[lacks]}], or say"
        f" which column is the relaxation modulus: 'FILE?2=relaxation[Pa]' (columns: {there})"
    )


def _distance(section: Section) -> int | None:
    """The first column with a length that is no displacement by its name, such as a gap."""
    lengths = (
        i for i, title in enumerate(section.titles) if not title.role and title.unit in LENGTH_UNITS
    )
    return next(lengths, None)


def _instead(section: Section, place: int, path: Path) -> str:
    """What to make of a force against a distance, as of a sample compressed at a constant speed."""
    title = section.titles[place]
    what = f"no column of displacement beside the force, but '{title.text}'"
    if _moves_once(section.column(place)):
        what += (
            ", which moves one way: a compression or pull is no oscillation and has no storage and"
            " loss modulus"
        )
    if heading(title.text).role == "gap":
        # A gap is there before the specimen is touched, and falls where the force rises.
        return (
            f"{what}; for a test in time at small deformations add a column displacement"
            f" [{title.unit}], the gap at first contact less each gap"
        )
    return (
        f"{what}; if it counts from the first contact,"
        f" 'FILE?{place + 1}=displacement[{title.unit}]' opens it as a test in time, for small"
        " deformations"
    )


def _moves_once(distance: Real) -> bool:
    """Whether a distance passes its middle at most twice: there, and perhaps back."""
    known = distance[np.isfinite(distance)]
    if len(known) < 2:
        return False
    beyond = known > 0.5 * (known.max() + known.min())
    return int(np.count_nonzero(np.diff(beyond))) <= _THERE_AND_BACK
