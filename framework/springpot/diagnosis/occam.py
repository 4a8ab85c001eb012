"""Marginal likelihoods: what a model explains, less what its parameters cost."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.identification import Uncertainty, Window, held_costs, shown
from springpot.rheology import Real

from .bases import orthonormal
from .harmonics import harmonic_evidence
from .refit import Refit
from .search import Grown, Search
from .unknown import Unknown, unknowns

Rows: TypeAlias = NDArray[np.int64]

UNKNOWN_SIZE = float(np.log(10.0 * np.log(10.0) / np.sqrt(2.0 * np.pi)))
"""Cost of a size that may lie anywhere in ten decades."""
UNKNOWN_SIGN = float(np.log(2.0))
"""Cost of a size that may be positive or negative."""
VAGUE = 10.0
"""Square of the relative width within which a parameter other than a size is known beforehand."""
RIVALS = 6.0
"""Log-likelihood within which a model rivals the best one, whatever its parameters cost."""
OPEN = 0.3
"""Relative variance from which a parameter is held to be left open by the data."""
LEAST_INFLUENCE = 1.0
"""Change of K over the noise, per natural unit of a parameter, below which its effect does without it."""
PLACES = 9
"""Places in its range at which an open parameter is held in turn."""
LEAST_SHARE = 0.02
"""Share of its range below which a parameter is not open."""


def marginal(found: Search, grown: Grown) -> float:
    """Log of the marginal likelihood of a grown model, by Laplace's method, up to what all models share.

    What an effect's parameters cost is the logarithm of how much narrower the data make them than they were. Its
    size is of unknown order of magnitude, and of unknown sign where physics allows both; its parameters are known the
    better, the more the effect explains: to a relative width of one over the square root of the drop in chi-square
    (MacKay 1992, doi:10.1162/neco.1992.4.3.415). One that the data leave less certain than that costs less.
    """
    spent = len(grown.refit.own) - len(found.base.own)
    cost = UNKNOWN_SIGN * sum(effect.element.parameters[0].lower < 0.0 for effect in grown.effects)
    explained = _discounted(found, grown.refit.log_likelihood, spent, len(grown.effects))
    return explained + harmonic_evidence(grown.refit) - cost + _refund(found, grown)


def _refund(found: Search, grown: Grown) -> float:
    """What is charged too much for parameters, sizes apart, that the data hardly determine.

    An effect with one that has gone beyond what the data show pays in full: it has become a simpler effect. One that
    the data leave open pays for the share of its range in which the model fits as well.
    """
    refit = grown.refit
    if not np.all(np.isfinite(refit.fit.jacobian_u)):
        return 0.0
    uncertainty = Uncertainty(refit.fit, absolute=True)
    variance = np.where(uncertainty.at_bound != 0, np.inf, np.diag(uncertainty.covariance))
    rival = refit.log_likelihood > found.best.log_likelihood - RIVALS
    kept, shares = [], 0.0
    for rows in _extras(found, grown):
        seen = [_seen(refit, i, rival and bool(variance[i] > OPEN)) for i in rows]
        if min(seen) > 0.0:
            kept.append(rows)
            shares += float(np.sum(np.log(seen)))
    if not kept:
        return 0.0
    nuisances = np.concatenate(kept)
    drop = max(2.0 * (refit.log_likelihood - found.base.log_likelihood), 0.0)
    needed = np.minimum(drop, VAGUE * _sharpness(refit, nuisances, uncertainty.at_bound))
    return max(0.5 * float(len(nuisances) * np.log1p(drop) - np.sum(np.log1p(needed))) + shares, 0.0)


def _sharpness(refit: Refit, rows: Rows, at_bound: Rows) -> Real:
    """How sharply the data determine some parameters together, all others free: principal precisions (q,).

    Where only a combination of them is determined, one direction is sharp and the others are open.
    """
    slopes = np.where(at_bound == 0, refit.fit.jacobian_u, 0.0)
    others = orthonormal(np.delete(slopes, rows, axis=1))
    left = slopes[:, rows] - others @ (others.T @ slopes[:, rows])
    return np.asarray(np.linalg.svd(left, compute_uv=False) ** 2, dtype=np.float64)


def _extras(found: Search, grown: Grown) -> list[list[int]]:
    """For each effect added, the numbers of its parameters other than its size."""
    sizes = {(each.name, each.element.parameters[0].name) for each in grown.effects}
    mine: dict[str, list[int]] = {}
    for i, parameter in enumerate(grown.refit.model.parameters):
        owner, _, short = parameter.name.rpartition(".")
        if owner and parameter.name not in found.base.model.names and (owner.partition("#")[0], short) not in sizes:
            mine.setdefault(owner, []).append(i)
    return list(mine.values())


def _seen(refit: Refit, i: int, left_open: bool) -> float:
    """One where the data show a parameter, 0 where they do not, and where they leave it open the share of its range.

    Two temperatures cannot tell two constants of a shift: the fit ends anywhere along a valley, and where is chance.
    """
    if np.linalg.norm(refit.fit.jacobian_u[:, i]) < LEAST_INFLUENCE:
        return 0.0
    parameter = refit.model.parameters[i]
    low, high = shown(parameter, Window.of(refit.fit.measurement))
    if low < float(refit.theta[i]) < high:
        return 1.0
    if not left_open or not low < high:
        return 0.0
    spread = np.geomspace if parameter.scale == "log" else np.linspace
    worse = held_costs(refit.fit, parameter.name, spread(low, high, PLACES)) - refit.rss
    share = float(np.mean(np.exp(-0.5 * np.maximum(worse, 0.0))))
    return share if share > LEAST_SHARE else 0.0


def likeliest_unknown(found: Search) -> Unknown:
    """The kind of structure without a name that explains the data best."""
    return max(unknowns(found.frame), key=lambda kind: _evidence_of(found, kind))


def unknown_marginal(found: Search) -> float:
    """Log-evidence of all such kinds together, of even prior weight."""
    evidence = np.array([_evidence_of(found, kind) for kind in unknowns(found.frame)])
    return float(evidence.max() + np.log(np.mean(np.exp(evidence - evidence.max()))))


def _evidence_of(found: Search, kind: Unknown) -> float:
    """Log-evidence of one kind on top of the base model: it costs the more, the more shapes and places it has."""
    frame = found.frame
    left = float(frame.rest @ frame.rest) - kind.drop
    likelihood = found.base.noise.log_likelihood(left, frame.size)
    return _discounted(found, likelihood, kind.shapes, 1) - float(np.log(kind.places))


def _discounted(found: Search, log_likelihood: float, spent: int, effects: int) -> float:
    drop = max(2.0 * (log_likelihood - found.base.log_likelihood), 0.0)
    return float(log_likelihood - effects * UNKNOWN_SIZE - 0.5 * spent * np.log1p(drop))
