"""Another test of the same specimen.

What a fitted model says of it, with a band, and whether it holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import student
from springpot.identification.normal import spread_of
from springpot.identification.prediction import Known
from springpot.lazy import Drawn
from springpot.measurement.covered import Covered
from springpot.measurement.opening import Test
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import AMPLITUDE_UNITS, Units, one_modulus
from springpot.misfit.error import plain
from springpot.misfit.residuals_of_tests import TestPart, part_of
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from ..numerics import DEVIATIONS, SMALLEST, rms
from .hypotheses import noise_answer
from .specimen import require_its_conditions

NEAR = 2.0
"""Factor by which a time may lie beyond those that a fit saw and still be one of them."""


SCHEMA = "springpot.prediction/2"
VAGUE = 0.5
"""Expected error from which a fit says nothing of a test: it may be off by its own size."""
HEARD = (
    "most of what is to be expected is the model's answer to noise of the channel that was imposed,"
    " which the specimen never felt: filter both channels alike first"
)
"""What is said of a motion whose noise rules the prediction."""


@dataclass(frozen=True, eq=False)
class TestPrediction(Drawn):
    """What a model says of a test that it was not fitted to.

    Its picture is the prediction with its band beside what was measured.

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

    def __repr__(self) -> str:
        return f"<TestPrediction {self.model}: {self.says}>"

    @property
    def verdict(self) -> str:
        """``holds``, ``fails``, ``vague`` where the fit says hardly anything, or ``not-judged``."""
        if not self.judged:
            return "not-judged"
        # First: an error beyond even a wide expectation is a failure, not a vague prediction.
        if self.error > DEVIATIONS * self.expected:
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
            wide = rms(0.5 * (self.high - self.low)) / max(rms(self.value), SMALLEST)
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
        place = f"{plain(worst)} s"
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


def predict_test(known: Known, test: Test, level: float = INTERVAL) -> TestPrediction:
    """Predict a test and judge the prediction.

    Parameters
    ----------
    known : Identification or Known
        A fit to other tests of the specimen.
    test : TimeTest or Measurement
        The test.
    level : float
        Probability of the band.

    Returns
    -------
    TestPrediction
        In the units of the fit where both are of one kind.

    Raises
    ------
    SpringpotError
        If the model needs a condition that the test lacks, or one is of a stiffness and the other
        of a modulus.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> from springpot.timetests import identify, predict_test
    >>> model, t = springpot.parse_model("fractional-maxwell"), np.geomspace(0.01, 100.0, 60)
    >>> theta = model.theta(k=400.0, c=60.0, alpha=0.5)
    >>> scatter = 1.0 + 0.01 * np.random.default_rng(1).normal(size=60)
    >>> relaxed, crept = scatter * model.relaxation(theta, t), scatter * model.creep(theta, t)
    >>> fit = identify(springpot.TimeTest.of_relaxation(t, relaxed, "kPa"), model)
    >>> predict_test(fit, springpot.TimeTest.of_compliance(t, crept, "kPa")).holds
    True
    """
    known = known.of_specimen
    require_its_conditions(known.model, test)
    # The test is brought to the fit, for not every parameter has a unit of its own; what it says is
    # told as it was measured.
    own, part, back = part_of(test), part_of(test.in_units(known.units)), _back(test, known.units)
    rows = np.flatnonzero(part.sure)
    answer = part.answer(known.model, known.theta, known.reference, rows)
    value, by_theta = back * answer.value, back * answer.by_theta
    measured, size, noise, heard = _beside(known, own, part, rows, value)
    # Relative to the signal, so that tests in different units and of any kind are judged alike.
    share, counted = (value - measured) / size, part.counted[rows]
    down, up = known.ways(spread_of(by_theta, known.theta_covariance), by_theta)
    times, known_sd = student(level, known.dof), np.maximum(down, up)
    # One over a time is a frequency only nearly: what lies near the ends was seen.
    asked = part.rate[rows], {name: column[rows] for name, column in part.conditions.items()}
    inside = ~known.covered.outside(*asked, NEAR)
    # Independent reasons to be off: what the parameters leave open and the noise of the test, in
    # its response and in what was imposed, which the model answers to and the specimen never felt.
    usual = np.hypot(known_sd, noise) / size
    notes = [known.covered.remark(*asked, known.units, NEAR)]
    expected = np.hypot(rms(usual[counted]), known.misfit)
    of_imposed = rms((heard / size)[counted])
    if of_imposed > expected:
        notes.append(HEARD)
    return TestPrediction(
        model=known.model.name,
        test=test.name,
        kind=test.kind,
        at=own.at[rows],
        value=value,
        low=value - times * down,
        high=value + times * up,
        measured=measured,
        error=rms(share[counted]),
        expected=float(np.hypot(expected, of_imposed)),
        # "Too much" is larger in size, whatever the sign of the response.
        bias=float(np.mean((share * np.sign(measured))[counted])),
        inside=float(np.mean(inside)),
        error_inside=rms(share[inside & counted]) if inside.any() else float("nan"),
        unit=own.unit,
        outside=~inside,
        covered=known.covered,
        notes=tuple(filter(None, notes)),
        judged=own.judged,
        quantity=own.quantity,
        clock=test.units.clock,
        level=level,
    )


def _beside(
    known: Known, own: TestPart, part: TestPart, rows: NDArray[np.intp], value: Real
) -> tuple[Real, Real, Real, Real]:
    """What was measured (m,), its size, its noise, and the answer to noise of what was imposed."""
    if not own.judged:
        # A test that was not measured is its own prediction: nothing is missed, nothing judged.
        none = np.zeros(len(rows))
        return value, np.full(len(rows), rms(value)), none, none
    noise = own.sd[rows]
    heard = noise * noise_answer(part, known.model, known.theta, known.reference)[rows]
    return own.measured[rows], own.size[rows], noise, heard


def _back(test: Test, units: Units) -> float:
    """By how much what a test tells is more in its own units than in others."""
    one_modulus([("the fit", units), ("the test", test.units)])
    stiffer = units.factor_to(test.units, "the fit", "the test")
    longer = AMPLITUDE_UNITS[units.amplitude] / AMPLITUDE_UNITS[test.units.amplitude]
    if not isinstance(test, TimeTest):
        return stiffer
    return longer if test.control == "force" else stiffer * longer
