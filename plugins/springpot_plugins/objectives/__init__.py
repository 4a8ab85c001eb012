"""The built-in objectives."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from springpot.errors import DataError
from springpot.hooks import hookimpl
from springpot.measurement import Measurement
from springpot.rheology import Complex

if TYPE_CHECKING:
    from springpot.identification import Objective

NOTHING = 1e-3
"""Share of |K| below which a part is known by its noise alone, in any instrument."""


def _equal(measurement: Measurement) -> Complex:
    return np.full(measurement.stiffness.shape, 1.0 + 1.0j, dtype=np.complex128)


def _relative(measurement: Measurement) -> Complex:
    # By the magnitude for both parts: relative to itself, a loss of nearly nothing would outweigh
    # all else.
    return np.asarray((1.0 + 1.0j) / measurement.magnitude, dtype=np.complex128)


def _relative_each(measurement: Measurement) -> Complex:
    # Each by itself, as pyRheo and others have it; what is nothing beside the other divides by
    # little, and not by zero.
    least = NOTHING * measurement.magnitude
    storage, loss = (
        np.maximum(np.abs(part), least) for part in (measurement.storage, measurement.loss)
    )
    return np.asarray(1.0 / storage + 1.0j / loss, dtype=np.complex128)


def _given_sd(measurement: Measurement) -> Complex:
    if measurement.sd is None:
        advice = "give the columns storage_sd and loss_sd, or choose 'relative'"
        raise DataError(f"{measurement.name} has no standard deviations to weigh by: {advice}")
    return np.asarray(1.0 / measurement.sd.real + 1.0j / measurement.sd.imag, dtype=np.complex128)


@hookimpl
def springpot_objectives() -> Iterable[Objective]:
    """The paper's objective and four others."""
    from springpot.identification import Objective

    return (
        Objective(
            "paper", "sum of (K' - K'_m)^2 + (K'' - K''_m)^2, eq. (44)", _equal, citation="eq. (44)"
        ),
        Objective("relative", "the differences of K' and K'' over |K_m|", _relative),
        Objective(
            "relative-each", "the differences of K' and of K'', each over itself", _relative_each
        ),
        Objective("log", "the differences of ln|K| and of the phase", _equal, logarithmic=True),
        Objective("weighted", "the differences over their given standard deviations", _given_sd),
    )
