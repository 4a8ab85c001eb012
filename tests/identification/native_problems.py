"""Artificial data for the tests of the native solver.

Section 5.1 of the paper, and random truths in its box.
"""

from __future__ import annotations

import numpy as np

from paper_problems import OMEGA, TRUTHS
from springpot.measurement import Measurement
from springpot.registry import parse_model
from springpot.rheology import Complex, Model, Points, Real

__all__ = ["OMEGA", "POINTS", "TRUTHS", "noisy", "random_truths", "relative_weights", "setup"]

POINTS = Points.at(OMEGA)


def setup(name: str) -> tuple[Model, Real, Measurement]:
    """A model of the paper, its true parameters and noise-free data."""
    model = parse_model(name)
    theta = model.vector(TRUTHS[name])
    return model, theta, Measurement(OMEGA, model.stiffness(theta, OMEGA))


def noisy(stiffness: Complex, level: float, rng: np.random.Generator) -> Complex:
    """Complex Gaussian noise of `level` times |K| on each part."""
    parts = rng.standard_normal((2, *stiffness.shape))
    return stiffness + level * np.abs(stiffness) * (parts[0] + 1j * parts[1])


def relative_weights(stiffness: Complex) -> Complex:
    """Weights of the relative objective."""
    return (1.0 + 1.0j) / np.abs(stiffness)


def random_truths(name: str, count: int, rng: np.random.Generator) -> tuple[Model, Real, Complex]:
    """Truths uniform in the paper's box, and their data.

    The box is k0 < kinf < 1000, tau in (0, 1) s, alpha in (0.05, 1).
    """
    model = parse_model(name)
    assert model.search is not None
    stiffnesses = np.sort(1000.0 * rng.random((count, 2)), axis=1)
    times = np.column_stack([rng.random(count), rng.uniform(0.05, 1.0, count)])
    own = stiffnesses if len(model.parameters) == 4 else stiffnesses[:, 1:]
    theta = model.search.to_elements(np.column_stack([own, times]))
    return model, theta, model.stiffness(theta, POINTS)
