"""How a fit stands: its error against the noise and against what any material reaches."""

from __future__ import annotations

import numpy as np

from springpot.diagnosis import compare
from springpot.errors import DataError
from springpot.identification import Identification, Standing

FEWEST_SPARE = 4
"""Degrees of freedom from which the scatter about a model says how large the noise is."""
BELIEVED = 0.1
"""Relative error beyond which scatter about a model is no noise unless repeats or given standard deviations say so:
rigs and rheometers repeat a stiffness within a few per cent."""


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
    error, says = judged.error, judged.says
    good = not (judged.fails or judged.unclear)
    if good and error.noise_source == "estimated" and error.relative_rms > BELIEVED:
        good, says = False, f"{says}, but noise of {100 * error.noise_floor:.2g} % is no good measurement: repeat it"
    return Standing(error.noise_floor, error.noise_source, error.material_floor, good, says)
