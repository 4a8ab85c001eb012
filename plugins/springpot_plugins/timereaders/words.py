"""What titles mean in a table of a test in time."""

from __future__ import annotations

from dataclasses import replace

from springpot.measurement import (
    MODULUS_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    TIME_UNITS,
    normal_unit,
)

from ..readers.channels import UNITS as CHANNELS, channel_of
from ..readers.names import EXACT, fold, names_a_modulus, role_of
from ..readers.titles import COMPLIANCE_UNITS, UNITS, Heading, Vocabulary, plain_title

MEASURED = frozenset({"relaxation", "compliance", "displacement", "force"})
"""What stands against time."""
DYNAMIC = frozenset({"omega", "frequency", "storage", "loss", "phase", "loss_factor", "magnitude"})
"""Columns of a sweep, which may well list the time of each point."""
STRETCH = "stretch"
"""Of lengths, deformed over undeformed: what rubber is often told by, one more than the strain."""
_STRETCHES = frozenset(
    (
        *("stretch", "stretchratio", "extensionratio", "elongationratio", "lambda", "λ"),
        *("streckung", "verstreckung", "streckverhaltnis", "tauxdelongation", "伸长比", "拉伸比"),
    )
)
_UNITS = {
    **CHANNELS,
    STRETCH: {"-": 1.0},
    "relaxation": MODULUS_UNITS,
    "compliance": COMPLIANCE_UNITS,
    "temperature": TEMPERATURE_UNITS,
}
_OWN = ("relaxation", "compliance", "relaxation_time")
"""What a name as a whole says, though a part of it may name a channel."""
# In a table against time a strain is the displacement, by whatever name.
_AS_IN_SWEEPS = {
    "amplitude": "displacement",
    # Of a rheometer it stands beside the test; only against a length is it one.
    **dict.fromkeys(("stress", "torque", "normal_force"), "force"),
}
_SYMBOLS = {
    **dict.fromkeys(("G", "E", "M", "K"), ("relaxation", MODULUS_UNITS)),
    **dict.fromkeys(("J", "D"), ("compliance", COMPLIANCE_UNITS)),
}
"""Letters that a unit of theirs makes known, as K may be a temperature."""
_WITHOUT_UNIT = {"G": "relaxation", "E": "relaxation", "J": "compliance"}
"""Letters that against time are nothing else."""


def _role(name: str) -> str | None:
    """What a name stands for."""
    if fold(name) in _STRETCHES:
        return STRETCH
    role = role_of(name)
    if role in _OWN or EXACT.get(name) == "temperature":
        return role
    return channel_of(name)[0] or _AS_IN_SWEEPS.get(str(role), role)


def _plain(title: str) -> Heading:
    """The heading of ``time [s]``, or of ``Ch 1 Kraft`` above ``kN``."""
    named = plain_title(" ".join(title.lstrip("# ").split()))
    role = _role(named.name)
    channel, unit, bare = channel_of(title)
    if role not in (*_OWN, "temperature") and channel is not None:
        return Heading(title, bare, channel, unit or named.unit)
    return replace(named, title=title, role=role)


def _by_unit(named: Heading) -> Heading:
    """The heading whose unit tells what its name leaves open: t is a time or a temperature."""
    role, unit = named.role, normal_unit(named.unit or "")
    known, units = _SYMBOLS.get(named.name, (None, {}))
    if role in ("time", "temperature"):
        if unit in TEMPERATURE_UNITS:
            role = "temperature"
        elif unit in TIME_UNITS:
            role = "time"
    elif role == STRETCH and named.unit and unit in CHANNELS["displacement"] and unit != "-":
        # In mm or per cent it counts from nothing.
        role = "displacement"
    elif role == "compliance" and named.unit and unit in STRAIN_UNITS:
        # A creep may be noted as the strain itself.
        role = "displacement"
    elif unit in units:
        role = known
    elif role is None and not named.unit:
        role = _WITHOUT_UNIT.get(named.name)
    elif names_a_modulus(named.name) and unit in MODULUS_UNITS:
        # Against time a modulus is that of a relaxation.
        role = "relaxation"
    elif role is None and unit in COMPLIANCE_UNITS:
        role = "compliance"
    elif role in CHANNELS and named.unit and unit not in CHANNELS[role]:
        other = role_of(named.name)
        if unit in UNITS.get(str(other), {}):
            role = other
        elif role == "displacement" and unit in CHANNELS["force"]:
            # G_A [Pa] is no amplitude gamma_a.
            role = None
    return replace(named, role=role)


def with_strain(roles: set[str]) -> set[str]:
    """These roles, with a displacement where there is a stretch, of which it is made."""
    return roles | ({"displacement"} if STRETCH in roles else set())


def _is_test(roles: set[str]) -> bool:
    """Whether columns of these roles are a test in time."""
    return "time" in roles and (
        bool(roles & {"relaxation", "compliance"})
        or with_strain(roles) >= {"displacement", "force"}
    )


IN_TIME = Vocabulary(
    _role, _plain, _by_unit, _UNITS, tuple(_UNITS), frozenset({"time"}), MEASURED, _is_test
)
"""Tables of what a specimen did against time."""
