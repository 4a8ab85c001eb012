"""The law of a damper over several tests: F = C |v|^alpha."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.distributions import f_quantile, student
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, WHERE

from .summary import EvaluatedTest


@dataclass(frozen=True, eq=False)
class VelocityLaw:
    """Force at the middle of the loop over the speed there, F0 = C |v|^alpha.

    Parameters
    ----------
    constant, exponent : float
        C and alpha.
    constant_ends, exponent_ends : tuple of float
        Their intervals.
    unit : str
        Of C.
    scatter : float
        Relative deviation of a test from the law.
    source : str
        Where the intervals come from: ``noise`` of the tests, or ``tests``: their scatter about the
        law.
    """

    constant: float
    exponent: float
    constant_ends: tuple[float, float]
    exponent_ends: tuple[float, float]
    unit: str
    scatter: float
    source: str

    def force(self, speed: Real) -> Real:
        """The force at speeds."""
        return np.asarray(self.constant * np.abs(speed) ** self.exponent * np.sign(speed))

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        (c_low, c_high), (low, high) = self.constant_ends, self.exponent_ends
        return {
            "C": {"value": self.constant, "low": c_low, "high": c_high, "unit": self.unit},
            "alpha": {"value": self.exponent, "low": low, "high": high, "unit": "-"},
            "scatter": self.scatter,
            "from": self.source,
        }


def velocity_law(tests: Sequence[EvaluatedTest]) -> VelocityLaw | None:
    """The law of tests at different speeds, by least squares of the logarithms.

    None of fewer than two speeds, of other units, or where a force has no logarithm.

    Parameters
    ----------
    tests : sequence of EvaluatedTest
        At least two that differ in speed.
    """
    known = [test for test in tests if {"F0", "v_peak"} <= test.means.keys()]
    units = {(test.record.displacement_unit, test.record.force_unit) for test in known}
    if len(known) < 2 or len(units) > 1:
        return None
    means = [(test.means["v_peak"], test.means["F0"]) for test in known]
    speed, force = np.array([[each.value for each in pair] for pair in means]).T
    speed_sd, force_sd = np.array([[each.sd for each in pair] for pair in means]).T
    if not ((speed > 0).all() and (force > 0).all()):
        return None
    x, y = np.log(speed), np.log(force)
    if np.ptp(x) <= student(INTERVAL, np.inf) * np.hypot.reduce(speed_sd / speed):
        return None
    exponent = 1.0
    # The slope says how much of the error of a speed is one of the force.
    for _ in range(3):
        variance = (force_sd / force) ** 2 + (exponent * speed_sd / speed) ** 2
        variance = np.maximum(variance, np.finfo(float).eps ** 2)
        design = np.stack([np.ones_like(x), x], axis=1) / np.sqrt(variance)[:, None]
        covariance = np.linalg.inv(design.T @ design)
        level, exponent = (covariance @ design.T @ (y / np.sqrt(variance))).tolist()
    left = y - level - exponent * x
    freedom, source = float("inf"), "noise"
    chi = float(np.sum(left**2 / variance))
    count = len(x) - 2
    if count and chi > count * float(f_quantile(1.0 - WHERE.levels_differ, count, 1e9)):
        # Tests that scatter by more than their own noise count alike: what parts them is theirs.
        design = np.stack([np.ones_like(x), x], axis=1)
        level, exponent = np.linalg.lstsq(design, y, rcond=None)[0].tolist()
        left = y - level - exponent * x
        covariance = np.linalg.inv(design.T @ design) * float(left @ left) / count
        freedom, source = float(count), "tests"
    reach = student(INTERVAL, freedom) * np.sqrt(np.diag(covariance))
    way, pull = next(iter(units))
    per = "1/s" if way == "-" else f"{way}/s"
    return VelocityLaw(
        float(np.exp(level)),
        exponent,
        (float(np.exp(level - reach[0])), float(np.exp(level + reach[0]))),
        (exponent - float(reach[1]), exponent + float(reach[1])),
        f"{pull}/({per})^alpha",
        float(np.sqrt(left @ left / count)) if count else 0.0,
        source,
    )
