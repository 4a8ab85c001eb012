"""The five artificial problems of section 5.1 of the paper, without noise."""

from __future__ import annotations

from functools import cache

import numpy as np

from springpot.identification import Problem
from springpot.measurement import Measurement
from springpot.registry import parse_model, plugins

KBAR = 1000.0
FOUR = {"k1": 600.0, "k2": 400.0, "c": 150.0, "alpha": 0.6}
THREE = {"k": 400.0, "c": 150.0, "alpha": 0.6}
TRUTHS = {
    "springpot": {"c": 150.0, "alpha": 0.6},
    "fractional-kelvin": THREE,
    "fractional-maxwell": THREE,
    "fractional-kelvin4": FOUR,
    "fractional-zener": FOUR,
}
OMEGA = 2.0 * np.pi * np.arange(0.5, 14.0, 1.0)


@cache
def artificial(name: str) -> Problem:
    """The problem of one of the five models with k-bar = 1000 kN/m."""
    model = parse_model(name)
    data = Measurement(OMEGA, model.stiffness(model.vector(TRUTHS[name]), OMEGA))
    return Problem.of(model, data, plugins().find("objective", "paper"), KBAR)


def truth(name: str) -> np.ndarray:
    """Its true element parameters."""
    return artificial(name).model.vector(TRUTHS[name])


def scale(name: str) -> float:
    """Sum of |K|^2: the objective of a model that says nothing."""
    return float(np.sum(artificial(name).measurement.magnitude ** 2))
