"""What a perfect fitter with this library would find in noise-free data.

Which other effects come close.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hidden_effects.bases import LAWS, Real
from hidden_effects.cases import Case
from hidden_effects.effects import EFFECTS, Effect, Scene
from hidden_effects.fit import Coordinates, Network, jacobian, refit, whiten
from hidden_effects.scaling import HEAT


def fitted_base(case: Case) -> tuple[Network, Real]:
    """Return the model the user believes in, and its best parameters for the noise-free data."""
    law = case.network.law if "+" in case.model else None
    network = replace(case.network, law=law, effects=(), heating=False)
    return (
        network,
        refit(
            network, case.theta[: network.size_of_base], case.sweep, case.K_true, case.sigma, 100
        )[0],
    )


def rivals(case: Case, starts: int = 3) -> dict[str, float]:
    """Return for every effect of the library the noise-free chi-square that base + effect leaves.

    A rival of the truth that leaves less than about 6 cannot be told from it by these data; for a
    case from outside the library the smallest value is what stays unexplained.
    """
    base, theta = fitted_base(case)
    has_field = case.temperature is not None
    rng = np.random.default_rng([11, case.seed])
    left = {}
    for effect in EFFECTS.values():
        if effect.needs == "amplitude" and case.amplitude is None:
            continue
        if effect.needs == "field" and not has_field:
            continue
        left[effect.name] = min(_with_effect(case, base, theta, effect, rng) for _ in range(starts))
    if has_field and base.law is None:
        left |= {name: _with_law(case, base, theta, name) for name in LAWS}
    if has_field and base.law is not None:
        left[HEAT] = _with_heat(case, base, theta)
    return left


def sizes() -> dict[str, int]:
    """Return how many parameters every effect has."""
    counts = {name: len(effect.parameters) for name, effect in EFFECTS.items()}
    return counts | {name: len(law.parameters) for name, law in LAWS.items()} | {HEAT: 1}


def _with_effect(
    case: Case, base: Network, theta: Real, effect: Effect, rng: np.random.Generator
) -> float:
    """Refit base + effect from a random shape and the size that a linearisation asks for."""
    k0 = base.stiffness(case.sweep, theta)
    drawn = np.array(effect.draw(rng, Scene(case.sweep, k0, base.reduced(case.sweep, theta))))
    grown = replace(base, effects=(effect,))
    change = whiten(grown.stiffness(case.sweep, np.concatenate([theta, drawn])) - k0, case.sigma)
    at = Coordinates.around(base.kinds, theta)
    q = np.linalg.qr(jacobian(base, at, at.to_search(theta), case.sweep, case.sigma))[0]
    seen = change - q @ (q.T @ change)
    wanted = float(seen @ whiten(case.K_true - k0, case.sigma)) / max(float(seen @ seen), 1e-300)
    drawn[0] *= wanted if effect.signs else float(np.clip(wanted, 0.02, 1e3))
    return refit(grown, np.concatenate([theta, drawn]), case.sweep, case.K_true, case.sigma, 80)[1]


def _with_heat(case: Case, base: Network, theta: Real) -> float:
    """Refit base + self-heating, from a tenth of a degree and from three at the hottest row."""
    assert case.amplitude is not None
    power = float(
        np.max(0.5 * case.omega * base.stiffness(case.sweep, theta).imag * case.amplitude**2)
    )
    grown = replace(base, heating=True)
    starts = [np.append(theta, degrees / max(power, 1e-300)) for degrees in (0.1, 3.0)]
    return min(refit(grown, p, case.sweep, case.K_true, case.sigma, 80)[1] for p in starts)


def _with_law(case: Case, base: Network, theta: Real, name: str) -> float:
    """Refit base + temperature law."""
    own = np.array([2e4]) if name == "arrhenius-shift" else np.array([3.0, 120.0])
    grown = replace(base, law=LAWS[name])
    return refit(grown, np.concatenate([theta, own]), case.sweep, case.K_true, case.sigma, 120)[1]
