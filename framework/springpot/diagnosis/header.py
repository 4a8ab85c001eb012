"""What the file's header says of an effect, beside what the diagnosis finds of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from springpot.measurement import PRESSURE_UNITS, Measurement

from .result import Candidate, Diagnosis, Value

FACTS = {
    "inertia as modulus": ("inertia", "m", "a moment of inertia that takes {said} omega^2 from the modulus"),
    "compliance as modulus": ("series-spring", "k", "an instrument compliance that is a spring of {said} in series"),
    "friction as viscosity": ("parallel-dashpot", "c", "a bearing friction that is a viscosity of {said}"),
}
"""Fact of the header: the effect that it would be, its parameter in the same unit, and what it means."""
CLOSE = 1.5
"""Ratio up to which two values are said to agree."""


def with_header(diagnosis: Diagnosis, measurement: Measurement) -> Diagnosis:
    """The diagnosis, with a note for each constant of the file's header whose effect was found, or may have been."""
    notes = tuple(header_notes(diagnosis, measurement))
    return replace(diagnosis, notes=(*diagnosis.notes, *notes)) if notes else diagnosis


def header_notes(diagnosis: Diagnosis, measurement: Measurement) -> Iterator[str]:
    """One sentence for each such constant; none where the data are no modulus."""
    if not measurement.units.is_modulus:
        return
    pascal = PRESSURE_UNITS[measurement.units.stiffness]
    for fact, (effect, parameter, means) in FACTS.items():
        said = measurement.provenance.get(fact)
        found = next((c for c in diagnosis.candidates if c.effect == effect and c.verdict != "absent"), None)
        if said is None or found is None or parameter not in found.parameters:
            continue
        # A mass is printed in SI, whatever unit the data came in.
        value = _scaled(found.parameters[parameter], 1.0 if parameter == "m" else pascal)
        yield f"the file's header gives {means.format(said=said)}; {_beside(float(said.split()[0]), value, found)}"


def _scaled(value: Value, factor: float) -> Value:
    return replace(value, value=value.value * factor, low=value.low * factor, high=value.high * factor)


def _beside(said: float, value: Value, found: Candidate) -> str:
    shown = f"{value.value:.3g} [{value.low:.3g}, {value.high:.3g}]"
    ratio = value.value / said if said > 0 else float("inf")
    if value.low <= said <= value.high or 1 / CLOSE <= ratio <= CLOSE:
        return f"{found.effect} of {shown} agrees with it, as if the instrument had not corrected for it"
    if ratio < 1:
        return f"{found.effect} is found as {shown}, {ratio:.2g} of it: what a correction left, or another cause"
    return f"{found.effect} is found as {shown}, {ratio:.2g} times as much: the header does not explain it"
