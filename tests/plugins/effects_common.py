"""Base models, points and moderate sizes shared by the tests of effects."""

from __future__ import annotations

import numpy as np

from springpot.registry import plugins
from springpot.rheology import Effect, Model, Parameter, Points

# Those with a factor for each level have no parameters before they meet data:
# tests/rheology/test_levels.py.
EFFECTS = {
    effect.name: effect
    for effect in plugins().items("effect")
    if not (effect.by_levels or effect.of_test)
}
BASES = {
    "fractional-zener": {"k1": 1.0, "k2": 3.0, "c": 0.8, "alpha": 0.6},
    "fractional-maxwell": {"k": 2.0, "c": 1.3, "alpha": 0.7},
}
POINTS = Points(
    np.log(np.array([0.2, 0.5, 1.0, 1.7, 3.0, 4.2])),
    amplitude=np.array([0.6, 1.4, 0.9, 2.0, 1.1, 0.7]),
    temperature=np.array([290.0, 310.0, 300.0, 280.0, 305.0, 293.0]),
    reference_temperature=298.0,
)
SIZES = {
    "omega_r": 9.0,
    "zeta": 0.2,
    "phi": 0.3,
    "g": 0.2,
    "e": 0.15,
    "tau": 0.07,
    "k3": -0.2,
    "q": -0.05,
    "n": 1.3,
    "C1": 8.0,
    "C2": 120.0,
    "Ea": 40.0,
    "b": 0.5,
    "F": 0.4,
    "a": 0.4,
    "alpha": 0.35,
    "h": 0.5,
    "m": 0.3,
    "k": 1.5,
    "Xc": 1.2,
    "s": 0.2,
    "c": 0.6,
    "c3": 0.05,
    "beta": 0.6,
    "Xh": 0.8,
    "Vc": 1.7,
}


def size(parameter: Parameter) -> float:
    return SIZES[parameter.name.rpartition(".")[2]]


def own_theta(effect: Effect) -> np.ndarray:
    return np.array([size(parameter) for parameter in effect.element.parameters])


def base(name: str) -> Model:
    return plugins().model(name)


def values(model: Model, base_name: str) -> dict[str, float]:
    known = BASES[base_name]
    return {p.name: known[p.name] if p.name in known else size(p) for p in model.parameters}


def grown(base_name: str, *names: str) -> tuple[Model, np.ndarray]:
    model = base(base_name)
    for name in names:
        model = model + EFFECTS[name]
    return model, model.vector(values(model, base_name))


def cauchy(function, x: float, radius: float, nodes: int = 24) -> np.ndarray:
    """Derivative at x of an analytic function, by Cauchy's integral over a circle."""
    turn = np.exp(2j * np.pi * np.arange(nodes) / nodes)
    return sum(function(x + radius * t) / t for t in turn) / (nodes * radius)


def stencil(function, x: float, step: float) -> np.ndarray:
    """Derivative at x of a function of a real variable, by central differences of eighth order."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    return (
        sum(w * (function(x + i * step) - function(x - i * step)) for i, w in weights.items())
        / step
    )
