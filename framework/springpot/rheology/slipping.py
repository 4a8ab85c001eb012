"""What the first harmonic of a spring that slips is, beside that of the spring."""

from __future__ import annotations

from typing import Any

import numpy as np

FOUR_OVER_PI = 4.0 / np.pi


def slip_fraction(rho: Any) -> tuple[Any, Any]:
    """K / k of a spring in series with a slider, and its derivative by rho.

    Parameters
    ----------
    rho : ndarray
        Slip force over k X; from 1 on the slider sticks and the element is a plain spring, and
        below nothing, which no force is, there is none.
    """
    # Where it sticks there is no loop: any number inside keeps the arc cosine in its range.
    sticks, none = np.real(rho) >= 1.0, np.real(rho) < 0.0
    beta = np.arccos(1.0 - 2.0 * np.where(sticks | none, 0.5, rho))
    value = (beta - 0.5 * np.sin(2.0 * beta) + 1j * np.sin(beta) ** 2) / np.pi
    slope = FOUR_OVER_PI * (np.sin(beta) + 1j * np.cos(beta))
    value, slope = np.where(sticks, 1.0, value), np.where(sticks, 0.0, slope)
    return np.where(none, 0.0, value), np.where(none, 0.0, slope)
