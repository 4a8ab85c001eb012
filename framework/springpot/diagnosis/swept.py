"""What one sweep cannot tell.

A gain that drifts while it is measured looks like a phase that is wrong.

Beside any material a gain that goes as omega^e is a phase of -e pi/2: K omega^e = K (i omega)^e
exp(-i e pi/2), and K (i omega)^e is a material again. A specimen that stiffens, dries or recovers
during a sweep from one end of the frequencies to the other so passes for an instrument whose phase
is off.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from springpot.identification.material import is_material
from springpot.measurement.sweeps import sweeps_of
from springpot.misfit.refit import Refit, refit
from springpot.thresholds import EVIDENCE

from .grown import Search

LARGEST = 0.5
"""Drift from first to last row, as a logarithm, beyond which nobody calls the rows one sweep."""
FINE = 1e-4
"""Of a drift: a hundredth of a per cent."""
LEAST_WORTH = 1e-4
"""Drift below which the words would say 0 %."""


@dataclass(frozen=True)
class SweepDrift:
    """A drifting gain that explains the data in an effect's place.

    Attributes
    ----------
    effect : str
        The effect.
    share : float
        By how much the gain grows from the first row to the last, relative to it.
    """

    effect: str
    share: float

    @property
    def says(self) -> str:
        """As the last of a row of names."""
        return f"a gain that drifts by {100.0 * self.share:.2g} % while the sweep is measured"


def drift_in_place(search: Search) -> SweepDrift | None:
    """The effect of the best grown model in whose place a drifting gain explains the data as well.

    None without one.

    Asked only of one sweep from one end of the frequencies to the other, beside a free spectrum.

    Parameters
    ----------
    search : Search
        A finished search.
    """
    data, grown = search.base.data.raw, search.grown
    steps = np.diff(data.omega)
    one_way = bool(np.all(steps > 0) or np.all(steps < 0))
    if not grown or not is_material(search.base.model) or not one_way or len(sweeps_of(data)) > 1:
        return None
    best = grown[0]
    as_good = best.refit.fair_rss + 2.0 * EVIDENCE.as_good
    least, likeliest = as_good, None
    # A drift is slow: what is narrow is nothing that it could stand for.
    for effect in [effect for effect in best.effects if not effect.narrow]:
        share, rss = _drifting(_without(search, effect.name))
        # As many parameters as an effect of one; one of more would have to explain more to be
        # preferred.
        nearer = rss <= as_good and (likeliest is None or rss < least)
        if nearer and abs(share) > LEAST_WORTH:
            least, likeliest = rss, SweepDrift(effect.name, share)
    return likeliest


def _without(search: Search, effect: str) -> Refit:
    """The fit of the best grown model's other effects alone."""
    others = [name for name in search.grown[0].names if name != effect]
    alone = (grown.refit for grown in search.grown if list(grown.names) == others)
    return next(alone, search.base)


def _drifting(before: Refit) -> tuple[float, float]:
    """Drift of the gain with which a fit follows the data best, and the whitened squares left."""
    from scipy.optimize import minimize_scalar  # a diagnosis that never asks must not wait for it

    mean = before.data.mean
    time = np.linspace(0.0, 1.0, len(mean))

    def left(drift: float) -> float:
        undone = replace(mean, stiffness=mean.stiffness * np.exp(-drift * time))
        data = replace(before.data, raw=undone, mean=undone)
        return refit(before.model, data, before.noise, [before.theta], starts=0).fair_rss

    best = minimize_scalar(
        left, bounds=(-LARGEST, LARGEST), method="bounded", options={"xatol": FINE}
    )
    return float(np.expm1(best.x)), float(best.fun)
