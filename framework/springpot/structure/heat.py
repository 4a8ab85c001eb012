"""What a damper takes over a record warms it, which a model that knows temperature would feel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .damper import Damper
from .frame import Mode
from .motion import Motion


def rises_of(motion: Motion) -> list[float | None]:
    """By how many kelvin one damper of each entry warms; nothing where its capacity is not stated.

    As if no heat left it: records are shorter than a damper takes to cool.
    """
    rises: list[float | None] = []
    for damper, taken in zip(motion.frame.dampers, motion.work[-1].tolist(), strict=True):
        rises.append(None if damper.heat_capacity is None else taken / damper.heat_capacity)
    return rises


def notes_of_heat(motion: Motion, mode: Mode) -> list[str]:
    """One line for each damper that warms: what its model would feel of it.

    Parameters
    ----------
    motion : Motion
        Under a record.
    mode : Mode
        Of its frame, where stiffness is compared.
    """
    pairs = zip(motion.frame.dampers, rises_of(motion), strict=True)
    return [
        f"damper {i}: {_felt(damper, rise, mode)}"
        for i, (damper, rise) in enumerate(pairs, 1)
        if rise is not None
    ]


def _felt(damper: Damper, rise: float, mode: Mode) -> str:
    warms = f"warms by {rise:.3g} K if no heat leaves it"
    if damper.temperature is None or "temperature" not in damper.model.needs:
        return f"{warms}; its model knows no temperature, and stays as it was"
    warm = replace(damper, temperature=damper.temperature + rise)
    at = np.array([2j * np.pi * mode.frequency])
    ratio = float(np.abs(warm.stiffness(at)[0] / damper.stiffness(at)[0])[0])
    return (
        f"{warms}, and its model would feel it: |K| at mode 1 would end at {100 * ratio:.3g} % of"
        f" that at {damper.temperature:g} degC, which the motion has throughout"
    )
