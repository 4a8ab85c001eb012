"""The temperature to which shift constants refer.

Without it they cannot be compared with published ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.measurement import Measurement
from springpot.rheology.lookup import find_effect
from springpot.rheology.nodes import Node
from springpot.rheology.points import KELVIN, Points, Real

PROBES = (290.0, 330.0)
"""Kelvin; what refers to a temperature changes if the reference moves from one to the other."""


def refers(node: Node) -> bool:
    """Whether parameters of `node` mean something else at another reference temperature."""
    theta: Real = np.array([parameter.typical for parameter in node.parameters])
    ones = np.ones(2)
    # Tried, not asked: whatever element a plugin offers, this is what its parameters do.
    at_probes = [Points(np.zeros(2), ones, np.array(PROBES), reference) for reference in PROBES]
    one, other = (node.respond(theta, points).value for points in at_probes)
    return not np.array_equal(one, other)


def reference_note(
    measurement: Measurement | None, nodes: Iterable[Node], unit: str = "degC"
) -> str:
    """One sentence on the reference temperature; empty where no parameter shown refers to one.

    Parameters
    ----------
    measurement : Measurement or None
        The data, which set the reference; an answer from a file knows none.
    nodes : iterable of Node
        Networks or elements whose parameters are shown.
    unit : {"degC", "°C"}
        How degrees are written.
    """
    if measurement is None or "temperature" not in measurement.conditions:
        return ""
    if not any(refers(node) for node in nodes):
        return ""
    # The way through kelvin leaves rounding behind.
    celsius = round(measurement.reference_temperature - KELVIN, 2)
    return (
        f"shift constants refer to T_ref = {celsius:g} {unit}, where the shift is 1; "
        "all other parameters are those at this temperature"
    )


def effects_note(measurement: Measurement, names: Iterable[str], unit: str = "degC") -> str:
    """`reference_note` for the parameters of effects given by name."""
    return reference_note(measurement, _elements(names), unit)


def _elements(names: Iterable[str]) -> Iterator[Node]:
    for name in names:
        try:
            yield find_effect(name).element
        # An effect that was handed in for this one diagnosis is in no registry.
        except ModelError:
            continue
