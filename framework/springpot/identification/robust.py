"""Robust fits: numbers that lie far off count less, by Huber's loss or by the soft one.

Least squares with weights that follow the residuals, until both stand still (P. J. Huber, 1964,
doi:10.1214/aoms/1177703732; P. W. Holland and R. E. Welsch, 1977, doi:10.1080/03610927708827533).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.rheology.points import Complex, Real

from ..numerics import MOST_STEPS, NEGLIGIBLE, NORMAL, SMALLEST
from .native import Fit
from .problem import Objective
from .uncertainty import Uncertainty

Fitted = TypeVar("Fitted")

TUNED = {"huber": 1.345, "soft-l1": 1.29}
"""Standard deviations at which a loss bends: of normal noise 95 % of the efficiency is kept."""


@dataclass(frozen=True, eq=False)
class Counted:
    """The weights of an objective, each times what its number counts.

    Parameters
    ----------
    weights : callable
        Of the objective.
    counts : ndarray, shape (2n,)
        Roots of what K' and then K'' of each point count, at most one.
    """

    weights: Callable[[Measurement], Complex]
    counts: Real

    def __call__(self, measurement: Measurement) -> Complex:
        """The weights (n,) of the measurement that was fitted."""
        base, (real, imag) = self.weights(measurement), np.split(self.counts, 2)
        return np.asarray(base.real * real + 1j * base.imag * imag, dtype=np.complex128)


def counted(objective: Objective, counts: Real, loss: str) -> Objective:
    """The objective in which each number counts for so much."""
    weights = Counted(objective.weights, counts)
    return replace(objective, name=f"{objective.name}, {loss}", weights=weights)


def influence(off: Real, loss: str) -> tuple[Real, Real]:
    """What residuals (n,) in standard deviations count, and the slope of count times residual."""
    size, bend = np.abs(off), TUNED[loss]
    if loss == "huber":
        return bend / np.maximum(size, bend), (size <= bend).astype(float)
    count = 1.0 / np.sqrt(1.0 + (size / bend) ** 2)
    return count, count**3


def until_at_rest(
    begun: Fitted,
    off: Callable[[Fitted], list[Real]],
    refit: Callable[[Fitted, list[Real]], Fitted],
    loss: str,
) -> tuple[Fitted, list[Real]]:
    """A fit and the roots of what its numbers count, each by the other until both stand still.

    Parameters
    ----------
    begun
        The fit in which all count alike.
    off : callable
        Of a fit, how far its numbers are off in standard deviations, test by test.
    refit : callable
        From a fit, by the roots of what the numbers count.
    loss : {"huber", "soft-l1"}
        By which they count less.
    """
    best, counts = begun, [np.ones(len(each)) for each in off(begun)]
    for _ in range(MOST_STEPS):
        found = [np.sqrt(influence(each, loss)[0]) for each in off(best)]
        moved = max(float(np.abs(new - old).max()) for new, old in zip(found, counts, strict=True))
        counts = found
        if moved < NEGLIGIBLE:
            break
        best = refit(best, counts)
    return best, counts


def robust_fit(
    begun: Fit, loss: str, refit: Callable[[Objective, Real], Fit]
) -> tuple[Uncertainty, str]:
    """The fit in which what is far off counts less, how sure it is, and what is told of it.

    Parameters
    ----------
    begun : Fit
        By least squares.
    loss : {"huber", "soft-l1"}
        By which it counts less.
    refit : callable
        Fits again by an objective, from parameters (p,).
    """
    base, spare = begun.objective, max(begun.dof, 1)
    # So far off are numbers that a fit goes through.
    rounding = max(float(np.sqrt(begun.task.floor[0] / spare)), SMALLEST)

    def scaled(fit: Fit) -> tuple[Real, float]:
        residual = replace(fit, objective=base).residual
        scale = NORMAL * float(np.median(np.abs(residual))) * np.sqrt(len(residual) / spare)
        return residual, max(scale, rounding)

    def off(fit: Fit) -> list[Real]:
        residual, scale = scaled(fit)
        return [residual / scale]

    def again(fit: Fit, counts: list[Real]) -> Fit:
        return refit(counted(base, counts[0], loss), fit.theta)

    # Of a fit that goes through its data nothing is far off.
    if scaled(begun)[1] == rounding:
        return Uncertainty.of(begun), f"{loss}: no number lies off"
    best, (counts,) = until_at_rest(begun, off, again, loss)
    residual, scale = scaled(best)
    known = replace(Uncertainty.of(best), spread=_spread(best, residual / scale, scale, loss))
    return known, _told(best, counts, loss)


def _spread(fit: Fit, off: Real, scale: float, loss: str) -> tuple[float, float]:
    """Standard deviation of a counted residual, and its degrees of freedom.

    P. J. Huber, Robust Statistics, 1981, section 7.6: the scatter of what pulls, over the mean
    slope of it, with the correction of few data.
    """
    count, slope = influence(off, loss)
    size, free, mean = len(off), len(fit.theta), float(np.mean(slope))
    few = 1.0 + free / size * float(np.var(slope)) / mean**2
    pulls = float(np.sum((count * off) ** 2)) / max(fit.dof, 1)
    # The Jacobian of the fit has the counts in it already.
    variance = few**2 * pulls / mean**2 * float(np.mean(count))
    return scale * float(np.sqrt(variance)), float(fit.dof)


def _told(fit: Fit, counts: Real, loss: str) -> str:
    data, half = fit.measurement, counts**2 < 0.5
    if not half.any():
        return f"{loss}: no number counts less than half"
    of_point = counts.reshape(2, -1).min(axis=0)
    least = int(np.argmin(of_point))
    place, share = data.units.at(float(data.frequency[least])), 100.0 * float(of_point[least]) ** 2
    return (
        f"{loss}: {int(half.sum())} of {len(counts)} numbers count less than half,"
        f" the least at {place} ({share:.2g} %)"
    )


def kept_of(known: Uncertainty) -> dict[str, Any]:
    """What a file keeps of a robust fit; nothing of another."""
    weights = known.fit.objective.weights
    if not isinstance(weights, Counted):
        return {}
    return {"counts": weights.counts.tolist(), "spread": known.spread}


def objective_again(
    kept: Mapping[str, Any],
    name: str,
    data: Measurement,
    objective_of: Callable[[str, Measurement], Objective],
) -> tuple[Objective, tuple[float, float] | None]:
    """The objective of a kept fit, and the spread where it was robust."""
    if "counts" not in kept:
        return objective_of(name, data), None
    base, _, loss = name.rpartition(", ")
    counts, (scale, dof) = np.array(kept["counts"], dtype=float), kept["spread"]
    if counts.shape != (2 * len(data),) or loss not in TUNED:
        raise ValueError("the counts cannot be those of the data")
    return counted(objective_of(base, data), counts, loss), (float(scale), float(dof))
