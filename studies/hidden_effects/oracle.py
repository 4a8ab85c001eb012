"""A plain reference to measure a tool against.

The best refit by BIC, with the generator's own formulas.

It knows the true noise and the exact form of every effect, but no equivalence classes beyond a
difference in BIC of six and no cleverness: what it cannot name, the data hardly tell.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from hidden_effects.cases import Case
from hidden_effects.fit import refit
from hidden_effects.rivals import fitted_base, rivals, sizes


def true_ratio(case: Case) -> float:
    """Relative error over noise floor of the true model itself, fitted to the noisy data.

    What chance leaves of it.

    Both as springpot defines them, the floor less what the fitted parameters follow.
    """
    theta = refit(case.network, case.theta, case.sweep, case.K, case.sigma, 200)[0]
    off = np.abs(case.network.stiffness(case.sweep, theta) / case.K - 1.0)
    followed = theta.size / (2.0 * len(case.sweep))
    return float(np.sqrt(np.mean(off**2)) / (case.floor * np.sqrt(1.0 - followed)))


def oracle(case: Case) -> dict[str, Any]:
    """Return the verdict and ranking of the reference in the form of springpot.diagnosis/2."""
    seen = replace(case, K_true=case.K)
    base, start = fitted_base(seen)
    alone = refit(base, start, seen.sweep, seen.K_true, seen.sigma, 200)[1]
    points, parameters = 2 * len(case.sweep), sizes()
    bic = {name: left + parameters[name] * np.log(points) for name, left in rivals(seen).items()}
    names = sorted(bic, key=lambda name: bic[name])
    values = np.array([bic[name] for name in names])
    weights = np.exp(-0.5 * (values - values[0]))
    total = float(weights.sum()) + len(names) * float(
        np.exp(min(-0.5 * (alone - values[0]), 700.0))
    )
    spread = np.sqrt(2.0 * points)
    if alone - values[0] <= 6.0:
        verdict = "unexplained" if alone - points > 4.0 * spread else "adequate"
    else:
        verdict = "unexplained" if values[0] - points > 4.0 * spread else "effect-missing"
    ties = [name for name in names if bic[name] - values[0] < 6.0]
    ranking = [
        {
            "effect": name,
            "class": ties if i == 0 else [name],
            "probability": float(w / total),
            "error_after": case.floor,
        }
        for i, (name, w) in enumerate(zip(names, weights, strict=True))
    ]
    return {"verdict": verdict, "error": {"noise_floor": case.floor}, "candidates": ranking}
