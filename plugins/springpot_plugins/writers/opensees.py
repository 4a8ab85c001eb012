"""OpenSees: a uniaxial material of one elastic and several Maxwell ones in parallel, for dampers.

Of a solid it is stress over strain along one axis, so that its modulus is Young's. The alpha of its
Maxwell material is the power of a dashpot's speed, here 1; it is no fractional order.
"""

from __future__ import annotations

from collections.abc import Callable

from springpot.solvers import Handoff, Writer

WHOLE = 100
"""Tag of the first material as a whole, above the most terms that there may be.

Its parts count up from one, those of the next material from 101.
"""


SLIDERS = ("elasto-sliding", "smooth-hysteresis")
"""What has a uniaxial material of its own: dry friction alone, without a stiffness, has none."""


def _materials(handoff: Handoff) -> list[tuple[str, list[str]]]:
    prony = handoff.prony
    parts: list[tuple[str, list[str]]] = [("Elastic", [f"{prony.equilibrium:.9g}"])]
    if prony.viscosity:
        parts.append(("Viscous", [f"{prony.viscosity:.9g}", "1.0"]))
    for weight, time in zip(prony.weights, prony.times, strict=True):
        # With a length of 1, force and displacement stand for stress and strain.
        parts.append(("Maxwell", [f"{weight:.9g}", f"{weight * time:.9g}", "1.0", "1.0"]))
    return parts + [_slider(name, values) for name, values in handoff.beside.items()]


def _slider(name: str, values: dict[str, float]) -> tuple[str, list[str]]:
    """A material that slides: its kind, and its numbers."""
    k, force = values["k"], values["F"]
    if name == "elasto-sliding":
        return "ElasticPP", [f"{k:.9g}", f"{force / k:.9g}"]
    # z of ours is one at the limit, that of OpenSees is a displacement: F z = k Z.
    n, beta = values["n"], values["beta"]
    size = (k / force) ** n
    numbers = [0.0, k, n, (1.0 - beta) * size, beta * size, 1.0, 0.0, 0.0, 0.0]
    return "BoucWen", [f"{number:.9g}" if number else "0.0" for number in numbers]


def _script(line: Callable[[str, int, list[str]], str]) -> Callable[[Handoff], str]:
    def text(handoff: Handoff) -> str:
        parts = _materials(handoff)
        lines = [f"# {words}" for words in handoff.heading()]
        whole = handoff.number * WHOLE
        first = whole - WHOLE + 1
        lines.append(
            f"# the damper is material {whole}; of Maxwell: K, C, power of the speed, length"
        )
        if handoff.beside:
            lines.append(
                "# of ElasticPP: k, strain at which it slips; of BoucWen: alpha, k, n, gamma, beta,"
                " Ao, deltas"
            )
        if handoff.is_modulus:
            lines.append(
                "# stress over strain of one axis, as trusses and fibres take it: Young's modulus"
            )
        lines += [line(kind, tag, numbers) for tag, (kind, numbers) in enumerate(parts, first)]
        lines.append(
            line("Parallel", whole, [str(tag) for tag in range(first, first + len(parts))])
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
        several="".join,
        beside=SLIDERS,
    ),
    Writer(
        "openseespy",
        _script(_python),
        "OpenSeesPy: the same for an interpreter called ops",
        ".py",
        modulus="E",
        several="".join,
        beside=SLIDERS,
    ),
)
