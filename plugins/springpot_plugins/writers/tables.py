"""The series itself: JSON for programs, CSV for people."""

from __future__ import annotations

import json

from springpot.solvers import Handoff, Writer


def to_json(handoff: Handoff) -> str:
    """Schema ``springpot.prony/1``."""
    prony = handoff.prony
    return (
        json.dumps(
            {
                "schema": "springpot.prony/1",
                "heading": handoff.heading(),
                "model": handoff.model,
                "parameters": handoff.parameters,
                "unit": handoff.unit,
                "is_modulus": handoff.is_modulus,
                "modulus": handoff.letter or None,
                "measured_rad_per_s": handoff.covered,
                "shift": None if handoff.shift is None else handoff.shift.to_dict(),
                "band_rad_per_s": list(prony.band),
                "largest_error": prony.error,
                "equilibrium": prony.equilibrium,
                "viscosity": prony.viscosity,
                "instantaneous": prony.instantaneous,
                "terms": [
                    {"weight": weight, "time_s": time, "outside_measured": outside}
                    for weight, time, outside in zip(
                        prony.weights.tolist(),
                        prony.times.tolist(),
                        handoff.outside.tolist(),
                        strict=True,
                    )
                ],
            },
            indent=1,
        )
        + "\n"
    )


def to_csv(handoff: Handoff) -> str:
    """Comments, then a row for each term; the spring has an endless time and the dashpot none."""
    unit = handoff.unit or "-"
    lines = [f"# {line}" for line in handoff.heading()]
    lines.append(f"term,weight [{unit}],time [s]")
    lines.append(f"spring,{handoff.prony.equilibrium:.9g},inf")
    if handoff.prony.viscosity:
        lines.append(f"dashpot (weight times s),{handoff.prony.viscosity:.9g},0")
    for i, (weight, time) in enumerate(
        zip(handoff.prony.weights, handoff.prony.times, strict=True), 1
    ):
        lines.append(f"{i},{weight:.9g},{time:.9g}")
    return "\n".join(lines) + "\n"


def _list(texts: list[str]) -> str:
    """A list of documents."""
    return "[\n" + ",\n".join(text.rstrip("\n") for text in texts) + "\n]\n"


WRITERS = (
    Writer(
        "json",
        to_json,
        "the series with all that is known about it, for programs",
        ".json",
        several=_list,
    ),
    Writer(
        "csv",
        to_csv,
        "the series as a table of weights and times",
        ".csv",
        aliases=("prony",),
        several="".join,
    ),
)
