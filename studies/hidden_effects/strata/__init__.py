"""Further strata of the hidden-effect test.

Each is a way in which measurements differ from the plain designs. ``draw(stratum, seed)`` returns
the case of this seed, always the same; kinds within a stratum take turns.
"""

from __future__ import annotations

from collections.abc import Callable
from zlib import crc32

import numpy as np

from hidden_effects.scaling import NotVisible
from hidden_effects.strata.drawn import Drawn
from hidden_effects.strata.measured import Written, measured
from hidden_effects.strata.noise import noise
from hidden_effects.strata.rig import notch, replicates, ripple, rounding
from hidden_effects.strata.several import three, two
from hidden_effects.strata.time_domain import history, time
from hidden_effects.strata.wrong_base import wrong_base

STRATA: dict[str, Callable[[int, np.random.Generator], Drawn | Written]] = {
    "time": time,
    "history": history,
    "noise": noise,
    "wrong-base": wrong_base,
    "notch": notch,
    "ripple": ripple,
    "replicates": replicates,
    "rounding": rounding,
    "two": two,
    "three": three,
    "measured": measured,
}


def draw(stratum: str, seed: int) -> Drawn | Written:
    """Return the case of this stratum and seed."""
    for attempt in range(400):
        try:
            return STRATA[stratum](
                seed, np.random.default_rng([crc32(stratum.encode()), seed, attempt])
            )
        except NotVisible:
            continue
    raise RuntimeError(f"{stratum} {seed}: no visible case in 400 draws")
