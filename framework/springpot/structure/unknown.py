"""What is not known of fitted parameters, as moves along axes that are apart from each other.

A positive parameter moves by its logarithm: known within a factor, it must not go below zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.model import Model
from springpot.rheology.points import Real


def _by_factors(model: Model, theta: Real) -> NDArray[np.bool_]:
    log = np.array([parameter.scale == "log" for parameter in model.parameters], dtype=bool)
    return log & (theta > 0.0)


def sizes_of(model: Model, theta: Real) -> Real:
    """By how much theta (p,) changes with a move of one, to begin with."""
    return np.where(_by_factors(model, theta), theta, 1.0)


def axes_of(model: Model, theta: Real, covariance: Real) -> Real:
    """Moves (p, q) by one standard deviation each, from the covariance (p, p) of theta (p,)."""
    size = sizes_of(model, theta)
    # By eigenvalues: the covariance of a parameter on its bound is zero, and rounding may make it
    # less.
    squares, axes = np.linalg.eigh(covariance / np.outer(size, size))
    return np.asarray(axes * np.sqrt(np.abs(squares)))


def moved(model: Model, theta: Real, move: Real) -> Real:
    """Parameters after a move (p,), within their bounds: beyond, they would be no such model."""
    log = _by_factors(model, theta)
    there = np.where(log, theta * np.exp(np.where(log, move, 0.0)), theta + move)
    lower = np.array([parameter.lower for parameter in model.parameters])
    upper = np.array([parameter.upper for parameter in model.parameters])
    return np.clip(there, lower, upper)
