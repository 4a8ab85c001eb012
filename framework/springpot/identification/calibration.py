"""What an instrument's calibration adds to the uncertainty of parameters.

Scatter tells how well points agree, not whether all of them are a per cent too stiff: what all have
in common is a term of its own (type B, JCGM 100:2008, 4.3), added in quadrature (5.1.2). The change
of the parameters with each term is found by fitting the same data once more, off by one standard
uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springpot.distributions import student
from springpot.errors import OptionError
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units
from springpot.rheology.model import Model
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .value import Value

QUANTILE = student(INTERVAL, float("inf"))
"""Standard uncertainties to the end of an interval of a calibration, whose size is given."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Standard uncertainties of the parameters of a fit, by where they come from.

    Attributes
    ----------
    says : str
        What the instrument promises.
    scatter : ndarray, shape (p,)
        Of what is left of the data, as without a calibration.
    moved : mapping of str to ndarray, shape (p,)
        Change of theta with one standard uncertainty of each term: ``gain`` of the stiffness, with
        the geometry in it, and ``phase``.
    """

    says: str
    scatter: Real
    moved: Mapping[str, Real]

    @property
    def shared(self) -> Real:
        """Covariance (p, p) of theta by all terms."""
        rows = np.array(list(self.moved.values()))
        return np.asarray(rows.T @ rows)

    def budget(self, names: Sequence[str], factors: Real) -> dict[str, dict[str, float]]:
        """Standard uncertainty of each parameter by term, in printed units (factors (p,))."""
        columns = {"scatter": self.scatter, **self.moved}
        return {
            name: {term: float(abs(factors[i] * each[i])) for term, each in columns.items()}
            for i, name in enumerate(names)
        }

    def widened(self, model: Model, theta: Real, low: Real, high: Real) -> tuple[Real, Real]:
        """Ends (p,) of the intervals with all terms beside what they were told by."""
        ends = [
            _widened(parameter, *of_one)
            for parameter, *of_one in zip(
                model.parameters, theta, low, high, np.sqrt(np.diag(self.shared)), strict=True
            )
        ]
        lower, upper = zip(*ends, strict=True)
        return np.array(lower), np.array(upper)

    def beside(self, values: Mapping[str, Value], model: Model, units: Units) -> dict[str, Value]:
        """Values in printed units, their intervals with all terms beside what they were told by."""
        found = dict(values)
        spread = np.sqrt(np.diag(self.shared))
        for parameter, sd in zip(model.parameters, spread.tolist(), strict=True):
            value = found.get(parameter.name)
            if value is not None:
                factor = units.of(parameter.unit)[0]
                at, low, high = value.value / factor, value.low / factor, value.high / factor
                low, high = _widened(parameter, at, low, high, sd)
                found[parameter.name] = replace(value, low=low * factor, high=high * factor)
        return found

    def to_dict(self) -> dict[str, Any]:
        """As plain data, for `read`."""
        return vars(self)

    @classmethod
    def read(cls, kept: Mapping[str, Any], count: int) -> Calibration:
        """What `to_dict` gave, of so many parameters.

        Raises
        ------
        ValueError
            If it is of others.
        """
        columns = [kept["scatter"], *kept["moved"].values()]
        # What could not be told is null.
        scatter, *moved = (np.array(each, dtype=float) for each in columns)
        if any(each.shape != (count,) for each in (scatter, *moved)):
            raise ValueError("a calibration of other parameters")
        return cls(str(kept["says"]), scatter, dict(zip(kept["moved"], moved, strict=True)))


def _widened(
    parameter: Parameter, value: float, low: float, high: float, sd: float
) -> tuple[float, float]:
    """Ends of an interval with a further standard uncertainty, within the parameter's bounds."""
    reach = QUANTILE * sd
    # A positive quantity is uncertain by a factor.
    if parameter.scale == "log" and value > 0.0:
        with np.errstate(divide="ignore"):
            down = np.hypot(np.log(value) - np.log(max(low, 0.0)), reach / value)
        up = np.hypot(np.log(high / value), reach / value)
        lower, upper = value * np.exp(-down), value * np.exp(up)
    else:
        lower, upper = value - np.hypot(value - low, reach), value + np.hypot(high - value, reach)
    lowest, highest = min(parameter.lower, low), max(parameter.upper, high)
    return max(float(lower), lowest), min(float(upper), highest)


def calibration_of(
    model: Model,
    theta: Real,
    scatter: Real,
    tests: Sequence[Test],
    terms: Mapping[str, float],
    says: str,
    again: Callable[[Sequence[Test]], Mapping[str, float]],
) -> Calibration:
    """The calibration of a fit.

    Parameters
    ----------
    model : Model
        The fitted model.
    theta, scatter : ndarray, shape (p,)
        Its parameters, and their standard uncertainties without a calibration.
    tests : sequence of Test
        What it was fitted to.
    terms : mapping of str to float
        Standard uncertainty of each term: ``gain`` relative, ``phase`` in rad.
    says : str
        What the instrument promises, in words.
    again : callable
        Fits other data from where the fit ended, and tells the parameters by name.
    """
    moved = {}
    for term, size in terms.items():
        found = again([_off(test, term, size) for test in tests])
        # Lines of a spectrum that were not found again are no parameters that anybody reads.
        moved[term] = np.array(
            [found.get(name, value) - value for name, value in zip(model.names, theta, strict=True)]
        )
    return Calibration(says, scatter, moved)


def _off(test: Test, term: str, size: float) -> Test:
    """A test as an instrument tells it that is off by so much."""
    if isinstance(test, Measurement):
        factor = 1.0 + size if term == "gain" else np.exp(1j * size)
        return replace(test, stiffness=test.stiffness * factor)
    if not isinstance(test, TimeTest):
        raise OptionError(f"{test.name}: an accuracy is of stiffness, not of {test.kind}")
    # A step has no phase; what answers to a force is stiffer by so much as it moves less.
    factor = 1.0 + size * (term == "gain")
    if test.control == "force":
        factor = 1.0 / factor
    return replace(test, response=test.response * factor)
