"""The master curve: free factors, the reduced data, the laws, and whether superposition holds.

Beside it is said which factors are not determined, and what repeats tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.identification.free_factors import (
    FactorRows,
    Factors,
    factors_of,
    superposed_fit,
    told_by_data,
)
from springpot.identification.known_factors import (
    Allowed,
    KnownFactors,
    allowed_shifts,
    interval_of,
    known_factors,
)
from springpot.identification.levels_alone import FEW, Alone, weighing_of
from springpot.identification.native import Fit
from springpot.identification.problem import Objective, default_objective
from springpot.lazy import Drawn, Printed
from springpot.measurement.independence import at_one_frequency
from springpot.measurement.measurement import Measurement
from springpot.measurement.timetest import TimeTest
from springpot.numerics import rms
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.elements import Compliance, Continuum
from springpot.rheology.levels import Levels, level_text
from springpot.rheology.model import Model
from springpot.rheology.nodes import chain, shift
from springpot.rheology.points import HELD, KELVIN, Complex, Real
from springpot.thresholds import SUPERPOSITION
from springpot.writing import number

from .laws import Direct, LawFit, after_steps, by_one_number, judged_laws, slower_when_hot, unit_of
from .simplicity import Simplicity, simplicity

WHY = {
    "no overlap": (
        "the sweeps do not overlap with the rest; their factors are not determined, as many fit"
        " alike: the interval goes from where they would begin to overlap"
    ),
    "flat": (
        "storage and loss are flat within their scatter, so that there is nothing to shift by:"
        " any factor a fits"
    ),
    "too few points": (
        f"sweeps of fewer than {FEW} frequencies;"
        " their factors are known to no better than a decade"
    ),
    "at the end of the search": (
        "the search ended at the end of its range; the factors are not determined"
    ),
    "wide": (
        "the sweeps overlap too little or are too straight;"
        " their factors are known to no better than a decade"
    ),
}
"""What is said of the levels whose factor is not determined, by its reason."""


def undetermined(factors: Factors, known: KnownFactors) -> list[str]:
    """One sentence for each reason for which factors are not determined."""
    reasons = np.array(known.reason)
    notes = []
    for reason, why in WHY.items():
        there = factors.levels[reasons == reason].tolist()
        if there:
            notes.append(
                f"{', '.join(level_text(factors.column, value) for value in there)}: {why}"
            )
    return notes


def not_told_apart(factors: Factors, told: NDArray[np.bool_]) -> list[str]:
    """A sentence for levels at which a shift does what a vertical factor would do as well."""
    if np.all(told):
        return []
    names = ", ".join(level_text(factors.column, value) for value in factors.levels[~told].tolist())
    return [
        f"{names}: a and b cannot be told apart, as the sweeps are nearly straight: b is taken as"
        " near to 1 as the data allow, and the interval of a holds for such a b"
    ]


def vertical_range(factors: Factors, told: NDArray[np.bool_]) -> list[str]:
    """A sentence where the data ask for vertical factors that physics does not explain."""
    if factors.column != "temperature":
        return []
    span = float(np.exp(np.ptp(factors.log_b[told])))
    if span < SUPERPOSITION.vertical_range:
        return []
    return [
        f"the vertical factors range over a factor of {span:.2g}, more than density and rubber"
        " elasticity explain: the data contradict smaller ones, as a changed geometry, a slip or a"
        " failure of superposition would"
    ]


def repeats_in_words(rows: FactorRows, own: Alone) -> list[str]:
    """A sentence where repeated sweeps differ, which no curve can follow."""
    scatter = own.repeats
    far = np.flatnonzero(scatter > SUPERPOSITION.repeats_differ)
    if not len(far):
        return []
    names = ", ".join(rows.named(i) for i in far.tolist())
    return [
        f"repeated sweeps differ by up to {100.0 * scatter.max():.2g} % ({names}),"
        " which no curve can follow"
    ]


SCHEMA = "springpot.mastercurve/1"


class Level(NamedTuple):
    """One level of a master curve.

    Attributes
    ----------
    value : float
        The level, a temperature in degC.
    points : int
        Measured there.
    a, a_low, a_high : float
        Factor of the frequency with its 95 % interval.
    b, b_low, b_high : float
        Factor of the stiffness.
    error, alone : float
        Relative error of the curve here, and of a material that follows this level only (nan with
        too few points).
    determined : bool
        Whether the data connect it with the reference.
    reason : str
        Why not: ``no overlap``, ``flat``, ``too few points``, ``at the end of the search`` or
        ``wide``; empty where it is determined.
    """

    value: float
    points: int
    a: float
    a_low: float
    a_high: float
    b: float
    b_low: float
    b_high: float
    error: float
    alone: float
    determined: bool
    reason: str


@dataclass(frozen=True, eq=False)
class MasterCurve(Drawn, Printed):
    """Sweeps at many levels brought onto one curve.

    Its picture has the curve, the factors and what is left.

    Attributes
    ----------
    fit : Fit
        The material with its factors; these are one at another level than `reference`.
    factors : Factors
        Factors and their covariance, one at the reference.
    reduced : Measurement
        All points at a omega, divided by b: the curve at the reference.
    vertical : bool
        Whether there are vertical factors.
    error_without_vertical : float
        Relative error with a shift alone.
    laws : tuple of LawFit
        Laws of temperature, the best first; those of vertical factors last.
    simplicity : Simplicity
        Whether one curve is enough, and where not.
    known : KnownFactors
        Levels whose factor is determined, why the others' is not, and where each may lie.
    notes : tuple of str
        What a user should know.
    seconds : float
        Time taken.
    """

    fit: Fit
    factors: Factors
    reduced: Measurement
    vertical: bool
    error_without_vertical: float
    laws: tuple[LawFit, ...]
    simplicity: Simplicity
    known: KnownFactors
    notes: tuple[str, ...]
    seconds: float

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Levels (m,) whose factor of frequency the data tell to a decade or better."""
        return self.known.determined

    @property
    def data(self) -> Measurement:
        """What was measured."""
        return self.fit.measurement

    @property
    def unit(self) -> str:
        """Unit of the levels; empty where the data do not say."""
        return unit_of(self.factors.column)

    @property
    def reference(self) -> float:
        """The level at which both factors are one, a temperature in degC."""
        return float(self.factors.levels[self.factors.reference])

    @property
    def levels(self) -> list[Level]:
        """The levels in ascending order."""
        counts = np.bincount(FactorRows.of(self.fit).number)
        factors, rest, known = self.factors, self.simplicity, self.known
        lowest, highest = interval_of(factors.log_b, factors.reach_b)
        rows = []
        for i in range(len(factors)):
            of_a = np.exp([factors.log_a[i], known.low[i], known.high[i]]).tolist()
            ends = (*of_a, *np.exp([factors.log_b[i], lowest[i], highest[i]]).tolist())
            head = (float(factors.levels[i]), int(counts[i]))
            errors = (float(rest.level_error[i]), float(rest.level_alone[i]))
            told = (bool(known.determined[i]), known.reason[i])
            rows.append(Level._make((*head, *ends, *errors, *told)))
        return rows

    @property
    def columns(self) -> tuple[str, ...]:
        """What was measured: ``omega``, ``storage`` and ``loss``.

        Or ``time``, and ``relaxation`` or ``compliance``.
        """
        return FactorRows.of(self.fit).material.columns

    @property
    def measured_unit(self) -> str:
        """Unit of what was measured."""
        unit = self.data.units.stiffness
        if "compliance" in self.columns:
            unit = f"1/{unit}"
        return unit

    def drawn(self, omega: Real, stiffness: Complex) -> tuple[Real, ...]:
        """Points or a curve (n,) in these columns, in SI and the unit of the data."""
        if self.columns[0] == "time":
            return 1.0 / omega, stiffness.real
        return omega, stiffness.real, stiffness.imag

    def curve(self, omega: Real) -> NDArray[np.complex128]:
        """The material at the reference for `omega` (n,) in rad/s, in the data's unit.

        After steps its relaxation function, or its compliance, at the times 1 / `omega`.
        """
        # The fit has its factor one at a level of its own choice: the curve is carried from there.
        shift_by, lift_by = self._to_reference
        material = replace(self.fit.model, effects=())
        weights = self.fit.theta[: len(material.parameters)]
        return np.asarray(
            lift_by * material.stiffness(weights, omega * shift_by), dtype=np.complex128
        )

    @property
    def _to_reference(self) -> tuple[float, float]:
        """Factors a and b of the reference as fitted."""
        fitted, reference = factors_of(FactorRows.of(self.fit)), self.factors.reference
        return float(np.exp(fitted.log_a[reference])), float(np.exp(fitted.log_b[reference]))

    def __repr__(self) -> str:
        rest = self.simplicity
        return (
            f"<MasterCurve {self.data.name}: {len(self.factors)} levels of {self.factors.column},"
            f" reference {self.reference:g} {self.unit}, error {100 * rest.error:.2g} %,"
            f" {rest.verdict}>"
        )

    def to_dict(self) -> dict[str, Any]:
        """Schema ``springpot.mastercurve/1``."""
        rest = self.simplicity
        data = self.reduced
        return {
            "schema": SCHEMA,
            "data": self.data.name,
            "column": self.factors.column,
            "unit": self.unit,
            "reference": self.reference,
            "vertical": self.vertical,
            "error": {
                "relative_rms": rest.error,
                "without_vertical": self.error_without_vertical,
                "each_level_alone": rest.alone,
            },
            "levels": [level._asdict() for level in self.levels],
            "laws": [law.to_dict() for law in self.laws],
            "simplicity": rest.to_dict(),
            "curve": {
                **dict(zip(self.columns, self.drawn(data.omega, data.stiffness), strict=True)),
                "unit": self.measured_unit,
                "determined": data.conditions["determined"] > 0.0,
            },
            "notes": list(self.notes),
            "seconds": self.seconds,
        }


def mastercurve(
    measured: Measurement | Sequence[TimeTest],
    *,
    column: str = "temperature",
    reference: float | None = None,
    vertical: bool = True,
    objective: Objective | None = None,
) -> MasterCurve:
    """Bring sweeps onto one curve by free factors of frequency and stiffness at each level.

    Parameters
    ----------
    measured : Measurement or sequence of TimeTest
        Frequency sweeps at two levels or more, or relaxations or creep at as many temperatures.
    column : str
        The condition whose levels are shifted.
    reference : float, optional
        Level at which the factors are one, a temperature in degC; the measured level nearest to it
        is taken. By default the middle one.
    vertical : bool
        Whether the stiffness has a factor too.
    objective : Objective, optional
        How the misfit is measured; by default weighted by given standard deviations, else relative.

    Raises
    ------
    SpringpotError
        If the column is missing, has one level only, or the frequency was not varied.
    """
    began = perf_counter()
    unfitted, measurement = Continuum(), measured
    if not isinstance(measurement, Measurement):
        unfitted, measurement = after_steps(measurement)
        objective = by_one_number(objective or default_objective(measurement))
    # First of all: a slip in the name of a column must not cost a fit.
    _check(measurement, column)
    # First what each level gives by itself: a level that no material follows must not bend the
    # curve of the others.
    weighing, own, note = weighing_of(measurement, column, objective, unfitted)
    alone, rows = _fits(measurement, column, vertical, weighing, unfitted)
    fitted = factors_of(rows)
    at, remarks = _reference(fitted, reference)
    # Referred only now: a fit is the same whatever level is asked for.
    factors = fitted.referred_to(at)
    if isinstance(unfitted, Compliance):
        factors = factors.of_modulus
    known = known_factors(rows, fitted, factors, own)
    told = told_by_data(rows, at)
    notes = [
        *filter(None, [note]),
        *remarks,
        *undetermined(factors, known),
        *slower_when_hot(factors, known.determined),
        *not_told_apart(factors, told),
        *vertical_range(factors, told),
        *repeats_in_words(rows, own),
    ]
    laws, said = _laws(rows, factors, known, told & vertical, _allowed(rows, fitted, own))
    notes += said
    return MasterCurve(
        rows.fit,
        factors,
        _reduced(rows, fitted, factors, known),
        vertical,
        _error(alone),
        tuple(laws),
        simplicity(rows, replace(own, cost=own.cost * own.share**2)),
        known,
        tuple(notes),
        perf_counter() - began,
    )


SIDEWAYS = "a factor of the frequency for each level"
UPWARDS = "a factor of the stiffness for each level"


def _fits(
    measurement: Measurement,
    column: str,
    vertical: bool,
    weighing: Objective,
    unfitted: Continuum,
) -> tuple[Fit, FactorRows]:
    """The material with a shift, and where asked for a vertical factor, for each level."""
    sideways = Effect("shift", shift, Levels(column, "a", True), SIDEWAYS, Layer.TEMPERATURE)
    model = Model("material", unfitted, effects=(sideways,))
    alone = superposed_fit(model, measurement, weighing)
    if not vertical:
        return alone, FactorRows.of(alone)
    whole = superposed_fit(model + _upwards(column), measurement, weighing, alone=alone)
    return alone, FactorRows.of(whole)


def _upwards(column: str) -> Effect:
    levels = Levels(column, "b", False)
    return Effect("vertical", chain, levels, UPWARDS, Layer.TEMPERATURE)


def _allowed(rows: FactorRows, fitted: Factors, own: Alone) -> Allowed:
    return allowed_shifts(rows.fit.measurement, rows.elements[0], fitted.log_b[rows.number], own)


def _laws(
    rows: FactorRows,
    factors: Factors,
    known: KnownFactors,
    told: NDArray[np.bool_],
    allowed: Allowed,
) -> tuple[list[LawFit], list[str]]:
    """Laws of temperature and what is said of them.

    They are judged against free factors: a law within the fit would bend them to itself. Their
    constants are those of a fit to the data, which any other command gives of the same model.
    """
    data, unfitted = rows.fit.measurement, replace(rows.material, rates=())
    if factors.reference != rows.elements[0].reference:
        # A law is one where the curve is, of another level than that of the data too.
        data = replace(data, reference=float(factors.levels[factors.reference]) + KELVIN)
    alone = direct = Direct(data, rows.fit.objective, unfitted)
    if rows.expected is not None:
        direct = replace(alone, upwards=_upwards(factors.column), unit=rows.expected.unit)
    laws, said = judged_laws(factors, known.placed, told, direct, allowed)
    if direct is not alone:
        said = [*said, *_without_vertical(laws, alone)]
    return laws, said


def _without_vertical(laws: list[LawFit], alone: Direct) -> list[str]:
    """What a shift's best law is in a model without vertical factors, where that is another."""
    for law in laws[:1]:
        if law.law.vertical:
            break
        values, low, high = alone(law.law.element)
        if np.all((law.low <= values) & (values <= law.high)):
            break
        said = [
            f"{p.name} {number(v, 4)} [{number(a, 4)}, {number(b, 4)}] {p.unit.label}".rstrip()
            for p, v, a, b in zip(law.law.element.parameters, values, low, high, strict=True)
        ]
        return [
            f"a model with {law.law.name} and no vertical factors has {', '.join(said)}: there the"
            " shift does what b does here"
        ]
    return []


def _check(measurement: Measurement, column: str) -> None:
    if column not in measurement.conditions:
        known = ", ".join(measurement.conditions) or "no condition at all"
        mend = ""
        if measurement.conditions:
            mend = ": name one with --column"
        raise DataError(
            f"{measurement.name}: there is no column '{column}' to shift by;"
            f" the data have {known}{mend}"
        )
    if not np.all(np.isfinite(measurement.conditions[column])):
        raise DataError(
            f"{measurement.name}: column {column} has rows without a number; leave them out"
        )
    if at_one_frequency(measurement):
        raise DataError(
            f"{measurement.name}: all points have one frequency; a curve needs frequency sweeps"
        )


def _error(fitted: Fit) -> float:
    data = fitted.measurement
    # Relative, so that glassy and rubbery ends, decades apart, count alike.
    off = np.abs(fitted.model.stiffness(fitted.theta, data.points) / data.stiffness - 1.0)
    return rms(off)


def _reference(factors: Factors, wanted: float | None) -> tuple[int, list[str]]:
    """Number of the reference level, and a note where it is not what was asked for."""
    if wanted is None:
        return factors.reference, []
    # Only at a measured level are the factors known to be one; between levels they would rest on a
    # law.
    nearest = int(np.argmin(np.abs(factors.levels - wanted)))
    there = float(factors.levels[nearest])
    room = 1e-2 * max(abs(there), abs(wanted))
    if factors.column == "temperature":
        room = HELD["temperature"]
    if abs(there - wanted) <= room:
        return nearest, []
    asked, used = level_text(factors.column, wanted), level_text(factors.column, there)
    return nearest, [f"nothing was measured at {asked}: the reference is the nearest level, {used}"]


def _reduced(
    rows: FactorRows, fitted: Factors, factors: Factors, known: KnownFactors
) -> Measurement:
    """All points at the reference, each with what is known of its factor."""
    data, reference = rows.fit.measurement, factors.reference
    factor, x = rows.reduced
    a, b = float(np.exp(fitted.log_a[reference])), float(np.exp(fitted.log_b[reference]))
    ratio = factor / b
    conditions = {}
    for name, values in data.conditions.items():
        # Under its own name the column would make the curve look like sweeps at many levels again.
        if name == fitted.column:
            name = f"measured {name}"
        conditions[name] = values
    # Whoever takes the table alone must see which of its points lie anywhere.
    conditions["a"] = np.exp(factors.log_a)[rows.number]
    conditions["a_low"], conditions["a_high"] = (
        np.exp(known.low)[rows.number],
        np.exp(known.high)[rows.number],
    )
    conditions["determined"] = known.determined[rows.number].astype(np.float64)
    sd = None
    if data.sd is not None:
        sd = data.sd / ratio
    return replace(
        data,
        omega=np.exp(x) / a,
        stiffness=data.stiffness / ratio,
        sd=sd,
        conditions=conditions,
        name=f"{data.name}, master curve",
        reference=None,
    )
