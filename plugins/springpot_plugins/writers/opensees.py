"""OpenSees: a uniaxial material of one elastic and several Maxwell ones in parallel, for dampers.

Of a solid it is stress over strain along one axis, so that its modulus is Young's. The alpha of its
Maxwell material is the power of a dashpot's speed, here 1; it is no fractional order.
"""

from __future__ import annotations

from collections.abc import Callable

from springpot.solvers import Handoff, Writer

FIRST, WHOLE = 1, 100
"""Tags: the parts count up from the first.

The whole is 100, above the most terms that there may be.
"""


def _materials(handoff: Handoff) -> list[tuple[str, list[str]]]:
    prony = handoff.prony
    parts: list[tuple[str, list[str]]] = [("Elastic", [f"{prony.equilibrium:.9g}"])]
    if prony.viscosity:
        parts.append(("Viscous", [f"{prony.viscosity:.9g}", "1.0"]))
    for weight, time in zip(prony.weights, prony.times, strict=True):
        # With a length of 1, force and displacement stand for stress and strain.
        parts.append(("Maxwell", [f"{weight:.9g}", f"{weight * time:.9g}", "1.0", "1.0"]))
    return parts


def _script(line: Callable[[str, int, list[str]], str]) -> Callable[[Handoff], str]:
    def text(handoff: Handoff) -> str:
        parts = _materials(handoff)
        lines = [f"# {words}" for words in handoff.heading()]
        lines.append(
            f"# the damper is material {WHOLE}; of Maxwell: K, C, power of the speed, length"
        )
        if handoff.is_modulus:
            lines.append(
                "# stress over strain of one axis, as trusses and fibres take it: Young's modulus"
            )
        lines += [line(kind, tag, numbers) for tag, (kind, numbers) in enumerate(parts, FIRST)]
        lines.append(
            line("Parallel", WHOLE, [str(tag) for tag in range(FIRST, FIRST + len(parts))])
        )
        return "\n".join(lines) + "\n"

    return text


def _tcl(kind: str, tag: int, numbers: list[str]) -> str:
    return f"uniaxialMaterial {kind} {tag} {' '.join(numbers)}"


def _python(kind: str, tag: int, numbers: list[str]) -> str:
    return f'ops.uniaxialMaterial("{kind}", {tag}, {", ".join(numbers)})'


WRITERS = (
    Writer(
        "opensees",
        _script(_tcl),
        "OpenSees in Tcl: Elastic and Maxwell materials in parallel",
        ".tcl",
        modulus="E",
    ),
    Writer(
        "openseespy",
        _script(_python),
        "OpenSeesPy: the same for an interpreter called ops",
        ".py",
        modulus="E",
    ),
)
