"""Parameters with their intervals, in the units in which they are printed."""

from __future__ import annotations

from springpot.identification.held_material import intervals_beside_material
from springpot.identification.level_weights import shifted_by
from springpot.identification.uncertainty import Uncertainty
from springpot.identification.value import Value
from springpot.thresholds import VERDICT

from .refit import Refit


def printed(refit: Refit, by_profile: bool = True) -> dict[str, Value]:
    """All parameters with their 95 % intervals, in the units in which they are printed.

    Where a model does not fit, its misfit and not the noise sets how uncertain they are.

    Parameters
    ----------
    refit : Refit
        A fit.
    by_profile : bool
        Whether wide intervals beside a free spectrum are taken by profile, which takes some 50 ms
        each.
    """
    units = refit.fit.measurement.units
    fits = refit.fit.dof <= 0 or refit.relative_rms < VERDICT.misfit * refit.floor
    known = Uncertainty(refit.fit, absolute=fits)
    shifted = bool(shifted_by(refit.model))
    if shifted:
        # The constants of superposition are those of a master curve, whatever command asks.
        known = Uncertainty.of(refit.identified)
    if by_profile or shifted:
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
