"""How a fit stands: its error against the noise and against what any material reaches."""

from __future__ import annotations

import numpy as np

from springpot.comparison.comparing import compare
from springpot.comparison.result import ONLY_NOISE
from springpot.errors import DataError
from springpot.identification.population import Specimens
from springpot.identification.problem import default_objective
from springpot.identification.result import Identification, Standing
from springpot.misfit.floor import FEWEST_ABOUT_MODEL
from springpot.misfit.material import lowest_error
from springpot.timetests.comparing import judgement_of
from springpot.timetests.floor import material_floor

SHORT = 1.5
"""Times the error that the native solver reaches with the same model, from which a search did not
come to its end: where both ended at the best, they agree to several digits.
"""


def standing_of(identified: Identification) -> Standing | None:
    """How the error of a fit stands against noise and any material.

    None where the data are too few to tell.

    Parameters
    ----------
    identified : Identification
        The fit. The floors are those of `compare`, which fits the same model to the same data.
    """
    if identified.uncertainty is None:
        return _of_tests(identified)
    if identified.fit.dof < FEWEST_ABOUT_MODEL:
        return None
    try:
        # With the seed of the fit: asked twice, its standing is the same.
        rng = np.random.default_rng(identified.seed)
        [judged] = compare(identified.measurement, [identified.model], rng).judgements
    except DataError:
        # Rows that repeat a point are one point to a comparison: where too few are left, it refuses
        # what was fitted.
        return None
    error, says = judged.error, judged.says
    good = not (judged.fails or judged.unclear)
    # Another objective weighs the points otherwise: its error may be larger though its search ended
    # at its best.
    alike = identified.fit.objective.name == default_objective(identified.measurement).name
    best = max(error.relative_rms, error.noise_floor)
    # Where the model itself fails, a longer search mends nothing.
    if good and alike and identified.relative_rms > SHORT * best:
        good = False
        says = (
            f"the search stopped short, this model reaches {100 * error.relative_rms:.2g} % on"
            " these data: give it a larger budget, or leave the optimiser out"
        )
    specimens = Specimens.of(identified.measurement)
    if specimens is not None and (scatter := specimens.scatter(identified.fit)):
        # To a comparison the rows of all files are repeats: their differences pass for noise there.
        says = says.replace(
            ONLY_NOISE, f"what is left is that specimens differ by {100.0 * scatter:.2g} %"
        )
    # Of all rows, as the error that is printed beside it: a comparison looks at some of many.
    lowest = lowest_error(
        identified.model, identified.measurement, identified.theta, identified.relative_rms
    )
    return Standing(error.noise_floor, error.noise_source, lowest, good, says)


def _of_tests(identified: Identification) -> Standing:
    """The same of tests of which one at least is in time."""
    judged = judgement_of(identified, 0.0, material_floor(identified))
    error = judged.error
    good = not judged.fails
    lowest = error.material_floor
    return Standing(error.noise_floor, error.noise_source, lowest, good, judged.says)
