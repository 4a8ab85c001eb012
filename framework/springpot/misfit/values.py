"""Parameters with their intervals, in the units in which they are printed."""

from __future__ import annotations

from springpot.identification.fitted_quantities import in_short
from springpot.identification.held_material import intervals_beside_material
from springpot.identification.material import shifted_by
from springpot.identification.result import known_of_sweep
from springpot.identification.uncertainty import Uncertainty, uses_sd
from springpot.identification.value import Quantities, Value
from springpot.thresholds import VERDICT

from .refit import Refit


def printed(refit: Refit, by_profile: bool = True) -> dict[str, Value]:
    """All parameters with their 95 % intervals, in the units in which they are printed.

    They are those that `identify` gives, as the error beside them is: what a noise weighs otherwise
    ends elsewhere, and one model has one answer. Where a model does not fit, its misfit and not
    given standard deviations sets how uncertain they are.

    Parameters
    ----------
    refit : Refit
        A fit.
    by_profile : bool
        Whether wide intervals beside a free spectrum are taken by profile, which takes some 50 ms
        each.
    """
    units, known = refit.identified.measurement.units, _known(refit)
    # The constants of superposition are those of a master curve, whatever command asks.
    if by_profile or shifted_by(refit.model):
        low, high = intervals_beside_material(known)
    else:
        low, high = known.interval()
    rows = {}
    for i, parameter in enumerate(known.fit.model.parameters):
        # The lines of a free spectrum are told as a whole, as a spectrum.
        if parameter.detail:
            continue
        factor, label = units.of(parameter.unit)
        value, least, most = (
            float(numbers[i]) * factor for numbers in (known.fit.theta, low, high)
        )
        rows[parameter.name] = Value(value, least, most, label)
    return rows


def quantities_of(refit: Refit) -> Quantities:
    """Those of its material, with intervals that rest on the same uncertainty."""
    raw = refit.data.raw
    return in_short(known_of_sweep(_known(refit)), raw.name, [raw])


def _known(refit: Refit) -> Uncertainty:
    best = refit.identified
    fits = refit.relative_rms < VERDICT.misfit * refit.floor
    return Uncertainty(best, absolute=fits and uses_sd(best))
