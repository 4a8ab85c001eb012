"""Sweeps at several temperatures whose factors are known."""

import numpy as np

import springpot
from springpot.registry import parse_model

TEMPERATURES = np.array([0.0, 15.0, 30.0, 45.0, 60.0])
REFERENCE = 2
C1, C2 = 8.0, 120.0
LOG_A = -np.log(10.0) * C1 * (TEMPERATURES - 30.0) / (C2 + TEMPERATURES - 30.0)
LOG_B = np.log((TEMPERATURES + 273.15) / 303.15)
MODEL, THETA = parse_model("fractional-zener"), np.array([1.0, 30.0, 2.0, 0.6])


def material(omega):
    return MODEL.stiffness(THETA, omega)


def measured(sweep, noise=0.005, seed=0, points=13, decades=2.0, column="temperature"):
    """`sweep(i, omega)` at each temperature, with relative noise."""
    omega = np.geomspace(10.0 ** (-decades / 2), 10.0 ** (decades / 2), points)
    stiffness = np.concatenate([sweep(i, omega) for i in range(len(TEMPERATURES))])
    random = np.random.default_rng(seed)
    error = random.normal(size=len(stiffness)) + 1j * random.normal(size=len(stiffness))
    conditions = {column: np.repeat(TEMPERATURES, points)}
    return springpot.Measurement(
        np.tile(omega, len(TEMPERATURES)),
        stiffness * (1.0 + noise * error),
        conditions=conditions,
        name="made",
    )


def simple(i, omega):
    """Thermorheologically simple: one factor of frequency and one of stiffness."""
    return np.exp(LOG_B[i]) * material(omega * np.exp(LOG_A[i]))


def two_branches(i, omega):
    """A second branch that hardly knows of temperature."""
    branch = parse_model("maxwell")
    return simple(i, omega) + branch.stiffness(np.array([4.0, 4.0]), omega * np.exp(0.1 * LOG_A[i]))


def phase_error(i, omega):
    """The phase of one sweep is read wrongly."""
    return simple(i, omega) * np.exp(0.05j * (i == 3))


def mass(i, omega):
    """At one temperature a mass moves along: no material does that."""
    return simple(i, omega) - 0.03 * omega**2 * (i == 4)
