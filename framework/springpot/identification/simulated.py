"""Fits of simulated data: how parameters scatter when a test is repeated."""

from __future__ import annotations

import numpy as np

from springpot.distributions import student
from springpot.rheology.points import Complex, Real

from .batch import fit_batch
from .native import Fit, within_bounds
from .uncertainty import Uncertainty

NUMBERS = 4_000_000
"""Simulated numbers held at once."""


def bootstrap(fit: Fit, n: int, rng: np.random.Generator, *, parametric: bool = True) -> Real:
    """Refit simulated data.

    Parameters
    ----------
    fit : Fit
        The fit that is taken for the truth.
    n : int
        Number of simulated data sets.
    rng : numpy.random.Generator
        The only source of randomness.
    parametric : bool
        Draw Gaussian errors; otherwise draw from the residuals, with replacement.

    Returns
    -------
    ndarray, shape (n, p)
        Their parameters. Quantiles of a column are an interval (B. Efron, 1979,
        doi:10.1214/aos/1176344552).

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.identification import bootstrap, fit
    >>> data = springpot.read("artificial-hidden@frequency=..1")
    >>> best = fit(springpot.parse_model("kelvin"), data)
    >>> bootstrap(best, 5, np.random.default_rng(1)).shape
    (5, 2)
    """
    points = len(fit.measurement)
    # In blocks, as all simulated data at once may be more than memory holds.
    block = max(1, NUMBERS // (2 * points))
    refitted = []
    for first in range(0, n, block):
        errors = _errors(fit, min(block, n - first), rng, parametric)
        refitted.append(_refitted(fit, errors))
    return np.concatenate(refitted)


def over_specimens(known: Uncertainty, n: int, rng: np.random.Generator) -> Real:
    """Refit files that are drawn anew, with replacement.

    How parameters scatter when other specimens are tested.

    Parameters
    ----------
    known : Uncertainty
        Of a fit of several specimens.
    n : int
        Number of draws.
    rng : numpy.random.Generator
        The only source of randomness.

    Returns
    -------
    ndarray, shape (n, p)
        Their parameters, spread about the fit as Student's t asks of so few specimens: among G of
        them a draw scatters too little by (G - 1) / G, and no draw lies beyond the most extreme of
        them (T. C. Hesterberg, 2015, doi:10.1080/00031305.2015.1089789).
    """
    fit, specimens = known.fit, known.specimens
    assert specimens is not None, "of a fit of several specimens"
    count = specimens.count
    drawn = rng.multinomial(count, np.full(count, 1.0 / count), size=n)[:, specimens.number]
    # A file that was drawn twice counts twice; one that was not, not at all.
    weights = np.sqrt(drawn) * fit.task.weights[0]
    measured = np.broadcast_to(fit.measurement.stiffness, weights.shape)
    seeds = np.broadcast_to(fit.theta, (n, 1, len(fit.theta)))
    points, logarithmic = fit.measurement.points, fit.objective.logarithmic
    theta = fit_batch(fit.model, points, measured, weights, 2, seeds, logarithmic)[0]
    wider = known.quantile / student(known.level, np.inf) * np.sqrt(count / (count - 1))
    log = fit.task.coordinates.log & (fit.theta > 0.0) & np.all(theta > 0.0, axis=0)
    at = np.where(log, fit.theta, 1.0)
    factors = at * np.exp(wider * np.log(np.where(log, theta, 1.0) / at))
    spread = np.where(log, factors, fit.theta + wider * (theta - fit.theta))
    return within_bounds(fit.model, spread)


def _errors(fit: Fit, n: int, rng: np.random.Generator, parametric: bool) -> Complex:
    """Simulated weighted errors (n, points)."""
    size, count = Uncertainty.of(fit).scale, len(fit.measurement)
    if parametric:
        drawn = rng.standard_normal((n, 2 * count)) * size
    else:
        # The fit has taken its share of the scatter: residuals are smaller than the errors they
        # come from.
        grown = np.sqrt(2 * count / max(fit.dof, 1))
        drawn = rng.choice(fit.residual * grown, size=(n, 2 * count))
    errors: Complex = drawn[:, :count] + 1j * drawn[:, count:]
    return errors


def _refitted(fit: Fit, errors: Complex) -> Real:
    weights = fit.task.weights[0]
    shift = errors.real / weights.real + 1j * (errors.imag / weights.imag)
    # In the middle of the box the objective has the size of the data, whatever a search has come
    # to.
    base = fit.model.stiffness(fit.theta, fit.measurement.points)
    data = base + shift
    if fit.objective.logarithmic:
        data = base * np.exp(shift)
    # Begun at the fit that they come from, and at two places of their own, should noise have made
    # another valley deeper.
    seeds = np.broadcast_to(fit.theta, (len(data), 1, len(fit.theta)))
    points = fit.measurement.points
    return fit_batch(
        fit.model,
        points,
        data,
        weights,
        starts=2,
        seeds_theta=seeds,
        logarithmic=fit.objective.logarithmic,
    )[0]
