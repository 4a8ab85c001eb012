"""Random lawful parameters and derivatives by Cauchy's integral, to test elements and models."""

from __future__ import annotations

import numpy as np

from springpot.rheology import Node, Points
from springpot.testing.networks import derivative as cauchy, sample

__all__ = ["cauchy", "check_derivatives", "sample"]


def check_derivatives(node: Node, theta: np.ndarray, at: Points) -> None:
    """Compare a node's exact derivatives, by theta (p,) and by ln omega, with Cauchy's integral."""
    response = node.respond(theta, at, depth=2)
    exact = np.swapaxes(response.by_theta, -1, -2)
    by_theta = cauchy(lambda point: node.respond(point, at).value, theta)
    # Rounding in the integral is relative to K, not to its derivative.
    natural = np.abs(response.value)[:, None] / np.abs(theta) + np.abs(exact)
    assert np.max(np.abs(exact - by_theta) / natural) < 1e-10
    by_log_omega = cauchy(
        lambda shift: node.respond(theta, at.shifted(shift[0])).value, np.zeros(1)
    )[..., 0]
    natural = np.abs(response.value) + np.abs(by_log_omega)
    assert np.max(np.abs(response.by_log_omega - by_log_omega) / natural) < 1e-9
