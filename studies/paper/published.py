"""Tables 1 and 2 as printed.

Tables 3 to 6 are in the package, where the reconstructions are computed from them.
"""

from __future__ import annotations

from collections.abc import Mapping

MODELS = {
    "springpot": "springpot",
    "fractional-kelvin": "Kelvin, three parameters",
    "fractional-maxwell": "Maxwell, three parameters",
    "fractional-kelvin4": "Kelvin type, four parameters",
    "fractional-zener": "Maxwell type, four parameters",
}
"""The five models of section 5.1 and what the paper calls them.

It gives no results of the springpot.
"""

TABLE_1 = {
    "fractional-kelvin": {"k": 399.6, "c": 150.1, "alpha": 0.5999},
    "fractional-maxwell": {"k": 400.0, "c": 150.0, "alpha": 0.6000},
    "fractional-kelvin4": {"k1": 595.7, "k2": 405.0, "c": 147.8, "alpha": 0.6094},
    "fractional-zener": {"k1": 599.9, "k2": 400.3, "c": 150.4, "alpha": 0.5989},
}
"""Data without noise, swarm applied 5 times; kN/m, kN s^alpha/m."""

TABLE_2 = {
    ("fractional-kelvin", 0.01): {"k": 390.5, "c": 152.8, "alpha": 0.5962},
    ("fractional-kelvin", 0.02): {"k": 405.1, "c": 149.9, "alpha": 0.5999},
    ("fractional-maxwell", 0.01): {"k": 398.2, "c": 150.6, "alpha": 0.6027},
    ("fractional-maxwell", 0.02): {"k": 401.9, "c": 150.8, "alpha": 0.5962},
    ("fractional-kelvin4", 0.01): {"k1": 606.8, "k2": 391.0, "c": 156.2, "alpha": 0.5815},
    ("fractional-kelvin4", 0.02): {"k1": 596.5, "k2": 404.3, "c": 151.4, "alpha": 0.6039},
    ("fractional-zener", 0.01): {"k1": 590.9, "k2": 412.3, "c": 165.7, "alpha": 0.5818},
    ("fractional-zener", 0.02): {"k1": 605.7, "k2": 392.7, "c": 137.9, "alpha": 0.6101},
}
"""Data with noise of one draw for each level, swarm applied 20 times; the same units."""

DIGITS = {"k": 1, "k1": 1, "k2": 1, "c": 1, "alpha": 4}
"""Decimals that Tables 1 and 2 print."""


def as_printed(theta: Mapping[str, float]) -> dict[str, float]:
    """Parameters rounded as Tables 1 and 2 print them."""
    return {name: round(value, DIGITS[name]) for name, value in theta.items()}


def largest_error(theta: Mapping[str, float], truth: Mapping[str, float]) -> float:
    """The largest relative error of a parameter."""
    return max(abs(theta[name] / truth[name] - 1.0) for name in truth)


def in_columns(theta: Mapping[str, float]) -> tuple[float | None, ...]:
    """Values under the paper's headings k1, k2 or k, c, alpha."""
    return theta.get("k1"), theta.get("k2", theta.get("k")), theta.get("c"), theta.get("alpha")


FLUIDS = {
    "springpot": "springpot",
    "fractional-kelvin": "Kelvin",
    "fractional-maxwell": "Maxwell",
    "fractional-kelvin4": "standard",
    "fractional-zener": "Zener",
    "fractional-maxwell-ab": "Maxwell with two orders, eq. (27)",
}
"""Models of fluids and what section 5.3 calls them."""


def in_fluid_columns(model: str, theta: Mapping[str, float]) -> tuple[float | None, ...]:
    """Values under the headings E or E1, eta or eta2, E2, alpha of Tables 4 to 6."""
    if model == "fractional-maxwell-ab":
        return theta["k"], theta["k"] * theta["tau"] ** theta["beta"], None, theta["beta"]
    if model == "oldroyd-b":
        return (
            theta["k0"],
            theta["k1"] * theta["tau"] ** theta["alpha"],
            theta["k1"],
            theta["alpha"],
        )
    return theta.get("k1", theta.get("k")), theta["c"], theta.get("k2"), theta["alpha"]
