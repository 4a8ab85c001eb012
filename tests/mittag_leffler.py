"""Reference values of the Mittag-Leffler function: 26-digit quadrature of a spectral integral."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

ORDERS = (0.1, 0.3, 0.5, 0.7, 0.9, 0.99)


def table(alpha: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """x and E_(alpha,beta)(-x) for beta = "1", "a" (alpha) and "1+a" (1 + alpha)."""
    with (Path(__file__).parent / "mittag_leffler.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    x = np.array([float(row["x"]) for row in rows])
    return x, {
        beta: np.array([float(row[f"{alpha};{beta}"]) for row in rows])
        for beta in ("1", "a", "1+a")
    }
