"""How sure a measured quantity is: the budget of a laboratory (GUM, JCGM 100:2008).

Type A is what the tests show: the noise of a record or the scatter of its cycles. Type B is what is
stated of the instruments. An error that all tests share moves all of them together: it cancels in a
ratio between them and does not in a mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import ndtr, stdtr

from springpot.distributions import student
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .code import StatedError
from .quantities import BY_NAME
from .summary import EvaluatedTest


@dataclass(frozen=True)
class BudgetLine:
    """One contribution to a standard uncertainty, in the unit of the result.

    Parameters
    ----------
    name : str
        Where it comes from.
    kind : str
        ``A`` or ``B``.
    standard : float
        Standard uncertainty.
    freedom : float
        Degrees of freedom; infinite of what is stated.
    """

    name: str
    kind: str
    standard: float
    freedom: float


@dataclass(frozen=True)
class ErrorBudget:
    """A result with all that makes it unsure.

    Parameters
    ----------
    value : float
        The result.
    lines : tuple of BudgetLine
        What contributes.
    """

    value: float
    lines: tuple[BudgetLine, ...]

    @property
    def standard(self) -> float:
        """Combined standard uncertainty: the root of the sum of squares."""
        return float(np.sqrt(sum(line.standard**2 for line in self.lines)))

    @property
    def freedom(self) -> float:
        """Effective degrees of freedom (Welch and Satterthwaite, JCGM 100:2008, G.4)."""
        below = sum(line.standard**4 / line.freedom for line in self.lines)
        if below == 0.0:
            return float("inf")
        return float(self.standard**4 / below)

    @property
    def coverage(self) -> float:
        """Factor k between the standard and the expanded uncertainty, at 95 %."""
        return float(student(INTERVAL, self.freedom))

    @property
    def expanded(self) -> float:
        """Expanded uncertainty U."""
        return self.coverage * self.standard

    def outside(self, low: float, high: float) -> float:
        """Chance that the true value lies outside of these, given the result."""
        if self.standard == 0.0:
            return float(not low <= self.value <= high)
        ends = [(each - self.value) / self.standard for each in (low, high)]
        below, above = (self._below(each) for each in (ends[0], -ends[1]))
        return below + above

    def _below(self, ratio: float) -> float:
        if not np.isfinite(ratio):
            return float(ratio > 0)
        if np.isfinite(self.freedom):
            return float(stdtr(self.freedom, ratio))
        return float(ndtr(ratio))

    def scaled(self, factor: float) -> ErrorBudget:
        """The same in another unit."""
        by = abs(factor)
        lines = tuple(replace(line, standard=by * line.standard) for line in self.lines)
        return ErrorBudget(factor * self.value, lines)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "value": self.value,
            "standard": self.standard,
            "coverage_factor": self.coverage,
            "expanded": self.expanded,
            "lines": [
                {
                    "name": line.name,
                    "type": line.kind,
                    "standard": line.standard,
                    "freedom": line.freedom if np.isfinite(line.freedom) else None,
                }
                for line in self.lines
            ],
        }


def sensitivity(test: EvaluatedTest, quantity: str, error: StatedError) -> float:
    """Change of a quantity for an error of one: a share, one radian or one kelvin."""
    value = test.means[quantity].value
    if error.acts == "force":
        return value * BY_NAME[quantity].force
    if error.acts == "displacement":
        return value * BY_NAME[quantity].way
    if error.acts == "temperature":
        return value * error.coefficients.get(quantity, 0.0)
    return _of_phase(test, quantity)


def _of_phase(test: EvaluatedTest, quantity: str) -> float:
    """By what a phase between the channels moves a quantity: K' + i K'' is turned."""
    means = {name: told.value for name, told in test.means.items()}
    loss, stroke = means["K''"], test.amplitude
    secant = abs(means["K_eff"])
    # Without a clock the secant stands for the part in phase.
    storage = means.get("K'", means["K_eff"])
    omega = 2.0 * np.pi * test.frequency.value
    turned = {
        "F+": -loss * stroke,
        "F-": loss * stroke,
        "F0": storage * stroke,
        "K_eff": -loss,
        "W_d": np.pi * stroke**2 * storage,
        "C_eff": storage / omega,
        "K'": -loss,
        "K''": storage,
    }
    if secant > 0.0:
        turned["xi_eff"] = 0.5 * (storage + loss**2 / means["K_eff"]) / secant
    if storage != 0.0:
        turned["eta"] = 1.0 + (loss / storage) ** 2
    return float(turned.get(quantity, 0.0))


def combined(
    value: float,
    tests: Sequence[EvaluatedTest],
    quantity: str,
    slopes: Real,
    errors: Sequence[StatedError],
    own: Sequence[BudgetLine] | None = None,
) -> ErrorBudget:
    """The budget of a result that is made of the means of tests.

    Parameters
    ----------
    value : float
        The result.
    tests : sequence of EvaluatedTest
        What it is made of.
    quantity : str
        Which quantity of them.
    slopes : ndarray, shape (n,)
        Change of the result for a change of each test's mean.
    errors : sequence of StatedError
        Type B.
    own : sequence of BudgetLine, optional
        Type A, where it is not that of the means.
    """
    lines = list(own) if own is not None else list(_type_a(tests, quantity, slopes))
    for error in errors:
        moved = slopes * np.array([sensitivity(test, quantity, error) for test in tests])
        # One error of all tests adds up with its sign, errors of their own as squares.
        size = abs(float(np.sum(moved))) if error.shared else float(np.sqrt(np.sum(moved**2)))
        lines.append(BudgetLine(error.name, "B", size * error.standard, float("inf")))
    return ErrorBudget(value, tuple(lines))


def _type_a(tests: Sequence[EvaluatedTest], quantity: str, slopes: Real) -> list[BudgetLine]:
    """A line for each test: of many, one for all."""
    told = [test.means[quantity] for test in tests]
    return [
        BudgetLine(
            f"{'scatter of cycles' if each.source == 'cycles' else 'noise'}, {test.name}",
            "A",
            abs(slope) * each.sd,
            each.freedom,
        )
        for test, each, slope in zip(tests, told, slopes.tolist(), strict=True)
        if slope
    ]
