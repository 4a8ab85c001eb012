"""What a fit says of another test, sample by sample, and the verdict on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from springpot.drawing import draw
from springpot.measurement.covered import Covered
from springpot.measurement.units import Units
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .sizes import rms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCHEMA = "springpot.prediction/2"
VAGUE = 0.5
"""Expected error from which a fit says nothing of a test: it may be off by its own size."""
HOLDS = 2.0
"""Error over what was to be expected up to which a prediction holds.

Nineteen of twenty of a normal error do.
"""


@dataclass(frozen=True, eq=False)
class TestPrediction:
    """What a model says of a test that it was not fitted to.

    Attributes
    ----------
    model, test : str
        Their names.
    kind : str
        Of the test; ``sweep`` for one at frequencies.
    at : ndarray, shape (m,)
        Time in s, or frequency in Hz for K' and again for K''.
    value, low, high : ndarray, shape (m,)
        Prediction and its band, from the uncertainty of the parameters alone.
    measured : ndarray, shape (m,)
        What the test gave.
    error : float
        Root mean square of the difference over that of the signal.
    expected : float
        The same as it was to be expected: from the parameters, the misfit of the fit itself and the
        test's noise.
    bias : float
        Mean difference over the size of the signal: above zero where the model says too much.
    inside : float
        Share of the samples at times (or frequencies) that the fitted tests saw.
    error_inside : float
        The error of these alone; nan where there are none.
    unit : str
        Of the value.
    level : float
        Probability of the band.
    judged : bool
        Whether the test was measured; otherwise there is nothing to judge by.
    outside : ndarray of bool, shape (m,)
        Which samples lie outside of what the fitted tests saw.
    covered : Covered
        What the fitted tests measured.
    notes : tuple of str
        What else one should know.
    quantity : str
        What the value is: force or displacement, stress or strain; of a sweep storage and then
        loss.
    clock : {"Hz", "rad/s"}
        In which frequencies of a sweep are told.
    """

    __test__ = False  # pytest takes it for a test otherwise

    model: str
    test: str
    kind: str
    at: Real
    value: Real
    low: Real
    high: Real
    measured: Real
    error: float
    expected: float
    bias: float
    inside: float
    error_inside: float
    unit: str
    outside: NDArray[np.bool_]
    covered: Covered
    notes: tuple[str, ...] = ()
    judged: bool = True
    quantity: str = "value"
    clock: str = "Hz"
    level: float = INTERVAL

    def plot(self, path: str | Path | None = None) -> Figure | Axes | Path:
        """The prediction with its band beside what was measured; see `springpot.drawing.draw`."""
        return draw(self, path)

    @property
    def verdict(self) -> str:
        """``holds``, ``fails``, ``vague`` where the fit says hardly anything, or ``not-judged``."""
        if not self.judged:
            return "not-judged"
        # First: an error beyond even a wide expectation is a failure, not a vague prediction.
        if self.error > HOLDS * self.expected:
            return "fails"
        if self.expected > VAGUE:
            return "vague"
        return "holds"

    @property
    def holds(self) -> bool:
        """Whether the fit tells of this test, and the difference is no larger than expected."""
        return self.verdict == "holds"

    @property
    def says(self) -> str:
        """One sentence."""
        if not self.judged:
            wide = rms(0.5 * (self.high - self.low)) / max(rms(self.value), 1e-300)
            return (
                f"{self.test} is predicted to within {100 * wide:.2g} % by the uncertainty of the"
                " parameters"
            )
        size = f"{100 * self.error:.2g} % off, where {100 * self.expected:.2g} % was to be expected"
        beyond = ""
        if self.inside < 1.0:
            beyond = (
                f"; {100 * (1.0 - self.inside):.0f} % of it lies beyond what the fitted tests saw"
            )
            if self.inside > 0.0:
                beyond += f", {100 * self.error_inside:.2g} % off within"
        if self.verdict == "vague":
            return f"the fit hardly says anything of {self.test}: {size}{beyond}"
        if self.holds:
            return f"the prediction of {self.test} holds: {size}{beyond}"
        way = "too little"
        if self.bias > 0:
            way = "too much"
        worst = self.at[int(np.argmax(np.abs(self.value - self.measured)))]
        place = f"{worst:.3g} s"
        if self.kind == "sweep":
            place = Units(clock=self.clock).at(worst)
        mean = f"{100 * abs(self.bias):.2g} % {way} on average, worst at {place}"
        return f"the prediction of {self.test} does not hold: {size}; {mean}{beyond}"

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.prediction/2``."""
        clock = "time"
        if self.kind == "sweep":
            clock = "frequency"
        columns = (self.at, self.value, self.low, self.high, self.measured, self.outside)
        names = (clock, "value", "low", "high", "measured", "outside_measured")
        rows = zip(*(column.tolist() for column in columns), strict=True)
        points = [dict(zip(names, row, strict=True)) for row in rows]
        # JSON has no nan: what was not judged, or not seen, is null.
        error = expected = bias = error_inside = None
        if self.judged:
            error, expected, bias = self.error, self.expected, self.bias
        if self.inside > 0.0:
            error_inside = self.error_inside
        return {
            "schema": SCHEMA,
            "model": self.model,
            "data": self.test,
            "kind": self.kind,
            "level": self.level,
            "unit": self.unit,
            "verdict": self.verdict,
            "holds": self.holds,
            "error": error,
            "expected_error": expected,
            "bias": bias,
            "inside": self.inside,
            "error_inside": error_inside,
            "says": self.says,
            "points": points,
            "measured": self.covered.to_dict(),
            "notes": list(self.notes),
        }
