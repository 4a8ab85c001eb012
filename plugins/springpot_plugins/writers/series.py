"""The Prony series itself, and in the format of solvers.

JSON for programs, CSV for people; the Python file needs numpy alone. ANSYS Mechanical APDL has MP
and TB,PRONY, whose elastic constants are those of fast loading; LS-DYNA *MAT_GENERAL_VISCOELASTIC
(076), with terms G and beta = 1/tau, for the bulk too.

COMSOL: parameters to load from a file, of the fractional model itself and of its branches. Its
solid mechanics has springpots since version 6.2, so that a fractional model needs no series there;
the branches serve the generalised Maxwell model of all versions, which takes shear moduli. The
parameters of the model are those of the modulus that was measured. Rows of a parameter file are
name, expression and description.

OpenSees: a uniaxial material of one elastic and several Maxwell ones in parallel, for dampers. Of a
solid it is stress over strain along one axis, so that its modulus is Young's. The alpha of its
Maxwell material is the power of a dashpot's speed, here 1; it is no fractional order.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable

from springpot.errors import ModelError
from springpot.rheology import Real
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


TABLES = (
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


TEMPLATE = '''"""{heading}"""

import numpy as np

EQUILIBRIUM = {equilibrium:.17g}
VISCOSITY = {viscosity:.17g}
WEIGHTS = np.array([{weights}])
TIMES = np.array([{times}])


def stiffness(omega):
    """Complex stiffness at the angular frequencies omega in rad/s."""
    s = 1j * np.atleast_1d(omega)
    turned = s[:, None] * TIMES
    return EQUILIBRIUM + VISCOSITY * s + (turned / (1 + turned)) @ WEIGHTS


def respond(t, displacement):
    """Force for a displacement, straight between samples and before them at its first value."""
    t, x = np.asarray(t, dtype=float), np.asarray(displacement, dtype=float)
    state, force = np.zeros(len(TIMES)), np.empty(len(t))
    speed = np.gradient(x, t)
    force[0] = EQUILIBRIUM * x[0] + VISCOSITY * speed[0]
    for k in range(1, len(t)):
        z = (t[k] - t[k - 1]) / TIMES
        state = np.exp(-z) * state - np.expm1(-z) / z * (x[k] - x[k - 1])
        force[k] = EQUILIBRIUM * x[k] + VISCOSITY * speed[k] + WEIGHTS @ state
    return force
'''


def to_python(handoff: Handoff) -> str:
    """The file."""
    prony = handoff.prony
    # The heading goes between three quotes, and may hold a file's name with anything in it.
    quoted = "\n".join(handoff.heading()).replace("\\", "\\\\").replace('"', '\\"')
    return TEMPLATE.format(
        heading=quoted + "\n",
        equilibrium=prony.equilibrium,
        viscosity=prony.viscosity,
        weights=_listed(prony.weights),
        times=_listed(prony.times),
    )


def _listed(numbers: Real) -> str:
    # Seventeen digits read back as the same bits.
    return ", ".join(f"{number:.17g}" for number in numbers)


PYTHON = Writer(
    "python",
    to_python,
    "a file with stiffness(omega) and respond(t, x) that needs numpy alone",
    ".py",
)


PER_LINE = 3
"""Constants of a TBDATA line, kept at three for readers of older releases (it takes six)."""


def to_ansys(handoff: Handoff) -> str:
    """Relative moduli and times in turn, for shear, and for volume if the bulk modulus relaxes."""
    solid, number = handoff.solid, handoff.number
    lines = [f"! {line}" for line in (*handoff.heading(), solid.says)]
    lines += [
        "! moduli are instantaneous",
        f"MP,EX,{number},{solid.young:.9g}",
        f"MP,PRXY,{number},{solid.poisson:.9g}",
    ]
    for kind, series in (("SHEAR", solid.shear), ("BULK", solid.bulk)):
        pairs = zip(series.weights / series.instantaneous, series.times, strict=True)
        constants = [number for pair in pairs for number in pair]
        if constants:
            lines.append(f"TB,PRONY,{number},1,{len(series.times)},{kind}")
        for start in range(0, len(constants), PER_LINE):
            part = ",".join(f"{each:.9g}" for each in constants[start : start + PER_LINE])
            lines.append(f"TBDATA,{start + 1},{part}")
    if handoff.shift is not None:
        # Its sign differs from manual to manual, and a wrong one would be slow where it is fast.
        lines.append(
            f"! TB,SHIFT,{number} is left to you (unchecked here): the law is in the lines above"
        )
    return "\n".join(lines) + "\n"


ANSYS = Writer(
    "ansys",
    to_ansys,
    "ANSYS Mechanical APDL: TB,PRONY",
    ".mac",
    solid=True,
    dashpot=False,
    several="".join,
)


WIDTH = 10
"""Of a field of a fixed card; numbers take one sign less, so that they stand apart."""
MOST = 18
"""Terms that the card holds (LS-DYNA keyword manual, volume II, *MAT_076).

The long-term modulus takes one.
"""


def field(number: float) -> str:
    """A number in nine signs, with as many digits as they hold."""
    for digits in range(8, 1, -1):
        # Leading zeros of the exponent take the room of digits.
        text = re.sub(r"e([-+])0*", r"e\1", f"{number:.{digits}g}").replace("e+", "e")
        if len(text) < WIDTH:
            return text.rjust(WIDTH)
    return f"{number:.1g}".rjust(WIDTH)


def to_lsdyna(handoff: Handoff) -> str:
    """A keyword card of shear and bulk modulus.

    Raises
    ------
    ModelError
        If there are more terms than the card holds.
    """
    solid = handoff.solid
    shear, bulk = solid.shear, solid.bulk
    if len(shear.times) + 1 > MOST:
        raise ModelError(
            f"ls-dyna takes {MOST - 1} terms beside the long-term modulus, not {len(shear.times)}: "
            "widen the tolerance, narrow the band or give --terms"
        )
    lines = ["*KEYWORD", *(f"$ {line}" for line in (*handoff.heading(), solid.says))]
    lines += [
        "$ the card takes shear and bulk moduli; the term without decay is the long-term",
        (
            "$ define the density RO by *PARAMETER: the card needs one, and no test of stiffness"
            " tells it"
        ),
        *_of_shift(handoff),
        "*MAT_GENERAL_VISCOELASTIC_TITLE",
        handoff.name,
        "$#     mid        ro      bulk       pcf        ef      tref         a         b",
        f"{handoff.number:>{WIDTH}}{'&RO':>{WIDTH}}{field(bulk.instantaneous)}",
        "$#    lcid        nt    bstart     tramp     lcidk       ntk   bstartk    trampk",
        "",
        "$#      gi     betai        ki    betaki",
    ]
    terms = [(shear.equilibrium, 0.0), *zip(shear.weights, 1.0 / shear.times, strict=True)]
    volume = [bulk.equilibrium, *bulk.weights]
    for i, (weight, rate) in enumerate(terms):
        line = field(weight) + field(rate)
        # A constant bulk modulus is that of the first card alone.
        if not solid.constant:
            line += field(volume[i]) + field(rate)
        lines.append(line)
    return "\n".join([*lines, "*END"]) + "\n"


def _of_shift(handoff: Handoff) -> list[str]:
    """That the law of temperature is left out, where there is one."""
    if handoff.shift is None:
        return []
    # Its sign differs from source to source, and a wrong one would be slow where it is fast.
    return ["$ TREF, A and B are left to you (unchecked here): the law is in the lines above"]


def _one_deck(texts: list[str]) -> str:
    """One file of many materials."""
    bodies = [text.removeprefix("*KEYWORD\n").removesuffix("*END\n") for text in texts]
    return "".join(["*KEYWORD\n", *bodies, "*END\n"])


LS_DYNA = Writer(
    "ls-dyna",
    to_lsdyna,
    "LS-DYNA: *MAT_GENERAL_VISCOELASTIC",
    ".k",
    solid=True,
    dashpot=False,
    aliases=("lsdyna",),
    several=_one_deck,
)


_VALUE = re.compile(r"^(\S+)\s*(.*)$")


def to_comsol(handoff: Handoff) -> str:
    """The table, comments in front."""
    prony, unit = handoff.prony, _unit(handoff.unit)
    lines = [f"% {line}" for line in handoff.heading()]
    numbers = {name: _VALUE.match(value) for name, value in handoff.parameters.items()}
    for name, match in numbers.items():
        assert match is not None
        unit_text = match[2]
        for other, theirs in numbers.items():
            assert theirs is not None
            # The power of time of a springpot is the value of its order.
            unit_text = re.sub(rf"\^{re.escape(other)}(?![\w.])", f"^{theirs[1]}", unit_text)
        lines.append(
            f'{_name(name)} {match[1]}{_unit(unit_text)} "{name} of {handoff.model}, as measured"'
        )
    lines.append(f'G_inf {prony.equilibrium:.9g}{unit} "long-term stiffness or modulus"')
    if prony.viscosity:
        lines.append(
            f'eta {prony.viscosity:.9g}{_unit(f"{handoff.unit} s".strip())} "dashpot beside the'
            ' branches"'
        )
    for i, (weight, time) in enumerate(zip(prony.weights, prony.times, strict=True), 1):
        lines.append(f'G_{i} {weight:.9g}{unit} "branch {i}"')
        lines.append(f'tau_{i} {time:.9g}[s] "relaxation time of branch {i}"')
    return "\n".join(lines) + "\n"


def _name(text: str) -> str:
    """A name that may be a variable."""
    return re.sub(r"\W", "_", text)


def _unit(text: str) -> str:
    """``kN s^0.5/m`` as ``[kN*s^0.5/m]``; nothing for a pure number."""
    bare = text.strip()
    if bare in ("", "-"):
        return ""
    return f"[{bare.replace(' ', '*')}]"


COMSOL = Writer(
    "comsol",
    to_comsol,
    "COMSOL: a parameter file of the fractional model and its branches",
    ".txt",
    modulus="G",
)


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


OPENSEES = (
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
