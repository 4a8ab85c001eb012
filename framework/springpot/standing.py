"""How a fit stands: its error against the noise and against what any material reaches."""

from __future__ import annotations

import numpy as np

from springpot.diagnosis import compare
from springpot.errors import DataError
from springpot.identification import Identification, Standing

FEWEST_SPARE = 4
"""Degrees of freedom from which the scatter about a model says how large the noise is."""


def standing_of(found: Identification) -> Standing | None:
    """How the error of a fit stands against noise and any material; None where the data are too few to tell.

    Parameters
    ----------
    found : Identification
        The fit. Only its model and data count: the floors are those of `compare`.
    """
    if found.fit.dof < FEWEST_SPARE:
        return None
    try:
        [judged] = compare(found.measurement, [found.model], np.random.default_rng(found.seed)).judgements
    except DataError:
        # Rows that repeat a point are one point to a comparison: where too few are left, it refuses what was fitted.
        return None
    error, good = judged.error, not (judged.fails or judged.unclear)
    return Standing(error.noise_floor, error.noise_source, error.material_floor, good, judged.says)
