"""Laws of temperature judged against factors that know of no law."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from springpot.distributions import chi2_sf, normal_sf, student
from springpot.errors import DataError, OptionError
from springpot.identification.free_factors import Factors, superposed_fit
from springpot.identification.held_material import intervals_beside_material
from springpot.identification.known_factors import Allowed
from springpot.identification.problem import Objective
from springpot.identification.uncertainty import Uncertainty
from springpot.measurement.measurement import Measurement
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import TEMPERATURE_UNITS, normal_unit, temperature_in_celsius
from springpot.rheology.effect import Effect, Layer
from springpot.rheology.elements import Compliance, Continuum, Relaxation
from springpot.rheology.factors import arrhenius, temperature_power, vogel, wlf
from springpot.rheology.grammar import Formula
from springpot.rheology.model import Model
from springpot.rheology.nodes import shift
from springpot.rheology.parameters import Parameter, box_of
from springpot.rheology.points import KELVIN, Complex, Points, Real
from springpot.thresholds import INTERVAL, SUPERPOSITION, VERDICT

from ..numerics import NEGLIGIBLE, SMALLEST, level_means, rms

Verdict = Literal["holds", "departs", "cannot-tell"]
TRIES = 12
"""Starts of a law's fit along its second parameter, which alone can have two minima."""
BISECTIONS = 8
"""Of the size of a law's own error between 1e-6 and all that the factors range over.

Known to a few per cent.
"""
SLOWER = (
    "it relaxes more slowly when hot: no law of temperature does so; is the column a temperature,"
    " or did the specimen dry or cure?"
)


@dataclass(frozen=True)
class Law:
    """A law with parameters.

    Attributes
    ----------
    name : str
        What people call it.
    equation : str
        In words of a formula, temperatures in kelvin, Tr that of reference.
    element : Formula
        Responds with ln a, or with b where it is `vertical`.
    vertical : bool
        Whether it is one of vertical factors.
    """

    name: str
    equation: str
    element: Formula
    vertical: bool = False


DirectFit: TypeAlias = Callable[[Formula], tuple[Real, Real, Real]]
"""A law's element to its parameters (k,) fitted to the data, and the ends (k,) of their intervals.
"""

LAWS = (
    Law("Arrhenius", "ln a = Ea / R (1 / T - 1 / Tr)", arrhenius()),
    Law("WLF", "log10 a = -C1 (T - Tr) / (C2 + T - Tr)", wlf()),
    Law("VFT", "ln a = B / (T - T0) - B / (Tr - T0)", vogel()),
    Law("power of temperature", "b = (T / Tr)^n", temperature_power(), vertical=True),
)


@dataclass(frozen=True, eq=False)
class LawFit:
    """A law fitted to free factors, each weighted by what is known of it.

    Attributes
    ----------
    law : Law
        The law.
    values, low, high : ndarray, shape (k,)
        Its parameters with 95 % intervals, widened where it does not follow the factors. Those of a
        shift are the parameters of a material with this law fitted to the data, as any other
        model's.
    log_factors : ndarray, shape (m,)
        What it gives at the levels.
    departure : float
        Root mean square of the difference in ln a (or ln b) at the levels that are judged.
    chance : float
        That scatter of the factors alone leaves a departure like this; nan where there is nothing
        to judge by.
    evidence : float
        Minus twice the log-evidence by BIC; of two laws the smaller is the better.
    verdict : str
        ``holds``, ``departs``, or ``cannot-tell`` where the law has as many parameters as there are
        factors.
    worst : float
        The level at which it is furthest off, by what is known of the factor there.
    """

    law: Law
    values: Real
    low: Real
    high: Real
    log_factors: Real
    departure: float
    chance: float
    evidence: float
    verdict: Verdict
    worst: float

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        rows = zip(self.law.element.parameters, self.values, self.low, self.high, strict=True)
        parameters = {
            p.name: {"value": v, "low": low, "high": high, "unit": p.unit.label or "-"}
            for p, v, low, high in rows
        }
        factor = "a"
        if self.law.vertical:
            factor = "b"
        return {
            "law": self.law.name,
            "equation": self.law.equation,
            "of": factor,
            "parameters": parameters,
            "departure": self.departure,
            "chance": self.chance,
            "bic": self.evidence,
            "verdict": self.verdict,
            "worst_at": self.worst,
        }


class JudgedLaws(NamedTuple):
    """What the factors say of the laws of temperature.

    Attributes
    ----------
    laws : list of LawFit
        The best of each kind first.
    refused : list of str
        One sentence for each law that no material could follow here.
    """

    laws: list[LawFit]
    refused: list[str]


def judged_laws(
    factors: Factors,
    placed: NDArray[np.bool_],
    told: NDArray[np.bool_],
    direct: DirectFit,
    allowed: Allowed,
) -> JudgedLaws:
    """All laws of temperature, none for another column.

    Parameters
    ----------
    factors : Factors
        The free factors.
    placed : ndarray of bool, shape (m,)
        Levels that the data place beside the others; how widely, the covariance says.
    told : ndarray of bool, shape (m,)
        Levels whose vertical factors the data tell; others show what was expected of them, which is
        no evidence.
    direct : callable
        Of a law: its parameters (k,) fitted to the data themselves, and the ends of their
        intervals.
    allowed : Allowed
        How far neighbouring levels can be shifted.
    """
    if factors.column != "temperature":
        return JudgedLaws([], [])
    # The factor of the reference is one by definition: a law that goes through it has shown
    # nothing.
    judging = placed & (np.arange(len(factors)) != factors.reference)
    fits: list[LawFit] = []
    refused: list[str] = []
    for law in LAWS:
        known = judging
        if law.vertical:
            known = judging & told & (factors.reach_b < SUPERPOSITION.vertical_unknown)
        used = np.flatnonzero(known)
        if len(used) < len(law.element.parameters):
            continue
        judged = _fitted(law, factors, used, direct)
        if judged is None:
            continue
        beyond = ""
        if not law.vertical:
            beyond = allowed.broken_by(judged.log_factors)
        if beyond:
            refused.append(f"{law.name} is refused: it {beyond}")
        else:
            fits.append(judged)
    # WLF and VFT are one curve: which of them comes first is not left to rounding.
    return JudgedLaws(
        sorted(fits, key=lambda one: (one.law.vertical, round(one.evidence, 3))), refused
    )


def slower_when_hot(factors: Factors, determined: NDArray[np.bool_]) -> list[str]:
    """A sentence where the shifts rise with temperature beyond their scatter.

    Every law of temperature falls.

    Parameters
    ----------
    factors : Factors
        The free factors.
    determined : ndarray of bool, shape (m,)
        Levels whose factors are known.
    """
    used = np.flatnonzero(determined & (np.arange(len(factors)) != factors.reference))
    if factors.column != "temperature" or not len(used):
        return []
    away, log_a = factors.levels[used] - factors.levels[factors.reference], factors.log_a[used]
    covariance = factors.covariance[np.ix_(used, used)] + NEGLIGIBLE**2 * np.eye(len(used))
    # The slope of least squares over its standard deviation.
    weighing = np.linalg.solve(covariance, away)
    score = float(weighing @ log_a) / float(np.sqrt(weighing @ away))
    # Where factors share much of their error, their weighted slope may have the sign of none of
    # them.
    if float(away @ log_a) > 0.0 and normal_sf(score) < VERDICT.structure_alarm:
        return [SLOWER]
    return []


@dataclass(frozen=True, eq=False)
class _Task:
    """One law beside the factors of some levels.

    Attributes
    ----------
    law : Law
        The law.
    at : Points
        All levels, as the law's element takes them.
    used : ndarray of int
        Numbers of the levels that are judged.
    target : ndarray
        Their ln a or ln b.
    covariance : ndarray
        Of `target`.
    low, high : ndarray, shape (k,)
        Bounds of the parameters.
    """

    law: Law
    at: Points
    used: NDArray[np.int64]
    target: Real
    covariance: Real
    low: Real
    high: Real

    def log_factor(self, theta: Real) -> Real:
        """What the law gives at all levels."""
        value = self.law.element.respond(theta, self.at).value.real
        # Laws of horizontal factors give ln a themselves.
        if not self.law.vertical:
            return value
        return np.log(np.maximum(value, SMALLEST))

    def solve(self, starts: list[Real], own: float = 0.0) -> tuple[Real, float, Real]:
        """Best parameters, chi-square and slopes, the law being off by `own` at each level."""
        covariance = self.covariance + own**2 * np.eye(len(self.used))
        # Factors share errors through the reference: whitened, they are independent numbers.
        whiten = np.linalg.inv(np.linalg.cholesky(covariance))

        def misfit(theta: Real) -> Real:
            return np.asarray(
                whiten @ (self.log_factor(theta)[self.used] - self.target), dtype=np.float64
            )

        ends = [
            least_squares(misfit, start, bounds=(self.low, self.high), x_scale="jac")
            for start in starts
        ]
        best = min(ends, key=lambda end: float(end.cost))
        return best.x, 2.0 * float(best.cost), np.asarray(best.jac, dtype=np.float64)

    def at_bound(self, theta: Real) -> bool:
        """Whether a parameter rests on a bound.

        It is then the bound's value and not the material's.
        """
        width = NEGLIGIBLE * (self.high - self.low)
        return bool(np.any((theta - self.low < width) | (self.high - theta < width)))

    def own_error(self, start: Real, spare: int) -> float:
        """How far the law is off at each level by itself.

        So that its misfit is what is to be expected.

        Without it, factors that share an error would draw a law that is not theirs to one side of
        all of them.
        """
        low, high = NEGLIGIBLE, float(np.ptp(self.target)) + NEGLIGIBLE
        for _ in range(BISECTIONS):
            # By its logarithm, as the size of the error is not known to a power of ten.
            middle = float(np.sqrt(low * high))
            square = self.solve([start], middle)[1]
            if square > spare:
                low = middle
            else:
                high = middle
        return high


def _fitted(
    law: Law, factors: Factors, used: NDArray[np.int64], direct: DirectFit
) -> LawFit | None:
    """A law at the levels that are used; none where it needs constants that no material has."""
    kelvin = factors.levels + KELVIN
    reference = float(kelvin[factors.reference])
    offset, target = 0, factors.log_a[used]
    if law.vertical:
        # In the covariance the vertical factors follow on all horizontal ones.
        offset, target = len(factors), factors.log_b[used]
    block = np.ix_(used + offset, used + offset)
    covariance = factors.covariance[block] + NEGLIGIBLE**2 * np.eye(len(used))
    at = Points(np.zeros(len(factors)), temperature=kelvin, reference_temperature=reference)
    task = _Task(law, at, used, target, covariance, *_box(law, kelvin, reference))
    theta, square, slopes = task.solve(_starts(task.low, task.high))
    # More parameters fit better by chance alone: each costs the logarithm of the number of factors.
    evidence = square + len(theta) * float(np.log(max(len(used), 2)))
    spare = len(used) - len(theta)
    verdict, chance = _verdict(square, spare)
    misfit = 1.0
    if verdict == "departs":
        theta, _, slopes = task.solve([theta], task.own_error(theta, spare))
    elif verdict == "holds":
        # A misfit that is too small to be told still widens the intervals.
        misfit = square / spare
    spread = np.sqrt(np.diag(np.linalg.pinv(slopes.T @ slopes)) * max(1.0, misfit))
    # Scatter that is known from the factors alone has no degrees of freedom to be short of.
    freedom = inf
    if misfit > 1.0 or verdict == "departs":
        freedom = spare
    reach = student(INTERVAL, freedom) * spread
    bounds = (np.maximum(theta - reach, task.low), np.minimum(theta + reach, task.high))
    # Of a constant whose interval is all its range nothing is known.
    empty = (bounds[0] <= task.low) & (bounds[1] >= task.high)
    if task.at_bound(theta) or np.any(empty):
        return None
    if not law.vertical:
        # One engine: the constants are those of a model with this law, whatever command asks.
        theta, low, high = direct(law.element)
        bounds = (low, high)
        if task.at_bound(theta):
            return None
    given = task.log_factor(theta)
    away = given[used] - target
    # By what is known of each factor: far off where nothing is known is no departure.
    sigmas = np.abs(away) / np.sqrt(np.diag(covariance))
    worst = float(factors.levels[used[int(np.argmax(sigmas))]])
    off = rms(away)
    return LawFit(law, theta, *bounds, given, off, chance, evidence, verdict, worst)


def _verdict(square: float, spare: int) -> tuple[Verdict, float]:
    """What a chi-square with `spare` degrees of freedom says of a law, and the chance of it."""
    # As many levels as parameters: any law goes through them.
    if spare == 0:
        return "cannot-tell", float("nan")
    chance = float(chi2_sf(square, spare))
    if chance < VERDICT.structure_alarm:
        return "departs", chance
    return "holds", chance


def _box(law: Law, kelvin: Real, reference: float) -> tuple[Real, Real]:
    """Bounds of the parameters (k,), the pole below the coldest level."""
    parameters = law.element.parameters
    low, high = box_of(parameters)
    coldest = float(kelvin.min())
    for i, parameter in enumerate(parameters):
        if _is_pole(parameter):
            # A kelvin below: at the pole itself the law is endless.
            high[i] = coldest - 1.0
        elif parameter.unit.label == "K" and law.element.kind == "wlf":
            low[i] = reference - coldest + 1.0
    return low, high


def _is_pole(parameter: Parameter) -> bool:
    return parameter.unit.label == "K" and parameter.scale == "linear"


def _starts(low: Real, high: Real) -> list[Real]:
    """One start, or several along the second parameter."""
    first = low[0] + 0.05 * (high[0] - low[0])
    if len(low) == 1:
        return [np.array([first])]
    # By factors: nobody knows in which decade of its range the parameter lies.
    near = np.geomspace(0.02, 0.9, TRIES // 3)
    return [np.array([first, low[1] + share * (high[1] - low[1])]) for share in near]


@dataclass(frozen=True, eq=False)
class Direct:
    """The data to which laws are fitted, and what stands beside them.

    Attributes
    ----------
    measurement : Measurement
        All sweeps, with the temperature of reference.
    weighing : Objective
        How points weigh.
    unfitted : Continuum
        Any material, as these data show it.
    upwards : Effect, optional
        Free vertical factors.
    unit : float, optional
        Variance of a weighted residual, by which vertical factors are weighed against what is
        expected of them.
    """

    measurement: Measurement
    weighing: Objective
    unfitted: Continuum
    upwards: Effect | None = None
    unit: float | None = None

    def __call__(self, element: Formula) -> tuple[Real, Real, Real]:
        """A law's parameters (k,), and the ends of their 95 % intervals."""
        law = Effect("law", shift, element, "a law", Layer.TEMPERATURE)
        model = Model("material", self.unfitted, effects=(law,))
        if self.upwards is not None:
            model = model + self.upwards
        best = superposed_fit(model, self.measurement, self.weighing, unit=self.unit)
        low, high = intervals_beside_material(Uncertainty.of(best))
        first = len(best.model.material.parameters)
        own = slice(first, first + len(element.parameters))
        return best.theta[own], low[own], high[own]


SHOWN = {"relaxation": Relaxation(), "creep": Compliance()}
"""Any material, as tests of each kind show it."""
PER_DECADE = 20
"""Points of a decade of time: a spectrum changes little from one to the next (a factor of 1.12)."""


class AfterSteps(NamedTuple):
    """Tests as one set of points.

    Attributes
    ----------
    unfitted : Continuum
        Any material, as these tests show it.
    points : Measurement
        Moduli or compliances at 1 / t, with the temperature of each.
    """

    unfitted: Continuum
    points: Measurement


def after_steps(tests: Sequence[TimeTest]) -> AfterSteps:
    """What all tests show at 1 / t, with the temperature of each sample.

    The time counts from the middle of the step, as after a ramp the answer is that of a sudden step
    there (L. J. Zapas and J. C. Phillips, 1971, J. Res. NBS 75A, 33). Of samples that lie closer
    than twenty to a decade the mean is taken.

    Parameters
    ----------
    tests : sequence of TimeTest
        Relaxations or creep, each at one temperature.

    Raises
    ------
    DataError
        If a test is of another kind than these or than the first, its temperature is not known, or
        what it shows is not positive.
    """
    kind = tests[0].kind
    columns = [_shown(test.in_units(tests[0].units), kind) for test in tests]
    rates, values, celsius = (np.concatenate(column) for column in zip(*columns, strict=True))
    points = Measurement(
        rates,
        values.astype(np.complex128),
        conditions={"temperature": celsius},
        units=tests[0].units,
        name=" + ".join(dict.fromkeys(test.name.partition("#")[0] for test in tests)),
        provenance=tests[0].provenance,
    )
    return AfterSteps(SHOWN[kind], points)


def _shown(test: TimeTest, kind: str) -> tuple[Real, Real, Real]:
    """One over time, what was read after the step, and the temperature (n,)."""
    if test.kind not in SHOWN or test.kind != kind:
        raise DataError(
            f"{test.name}: a master curve is made of sweeps, of relaxations or of creep, all alike,"
            f" and this is a test of {test.kind}"
        )
    if test.temperature is None:
        raise DataError(
            f"{test.name}: a master curve needs the temperature: add a column, or open it as"
            f" '{test.provenance.get('file', test.name)}?temperature=25[degC]'"
        )
    clock = test.time - test.start
    seen = clock > test.rise
    values = test.response[seen] / test.loading.value[-1]
    if not len(values) or np.any(values <= 0.0):
        raise DataError(
            f"{test.name}: what it shows is not positive after the step: leave such samples out"
        )
    log_rates = -np.log(clock[seen] - 0.5 * test.rise)
    bins = np.unique(np.floor(log_rates * PER_DECADE / np.log(10.0)), return_inverse=True)[1]
    rates = np.exp(level_means(bins, log_rates))
    return rates, level_means(bins, values), np.full(len(rates), test.temperature)


def by_one_number(objective: Objective) -> Objective:
    """An objective for data that are one number at each point, and have no loss."""

    def weights(measurement: Measurement) -> Complex:
        return np.asarray(objective.weighing(measurement).real, dtype=np.complex128)

    return Objective(objective.name, objective.summary, weights, objective.logarithmic)


_LEVEL = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def unit_of(column: str) -> str:
    """Unit in which levels of a column are told; the data do not say that of others."""
    # Of other columns the data tell no unit.
    if column != "temperature":
        return ""
    return "degC"


def level_of(text: str, column: str = "temperature") -> float:
    """The level that a text such as ``25degC``, ``298.15K`` or ``0.5`` names; temperatures in degC.

    Raises
    ------
    OptionError
        If it is no number, or has a unit that the column does not have.

    Examples
    --------
    >>> from springpot.superposition import level_of
    >>> level_of("298.15K"), level_of("0.5", "humidity")
    (25.0, 0.5)
    """
    parts = _LEVEL.fullmatch(text)
    if parts is None:
        raise OptionError(
            f"reference '{text}' is no number: write a level such as {_example(column)}"
        )
    value, unit = float(parts[1]), parts[2]
    if not unit:
        return value
    if column != "temperature":
        raise OptionError(f"reference '{text}': {column} has no unit here; write the number only")
    known = normal_unit(unit)
    if known not in TEMPERATURE_UNITS:
        raise OptionError(f"reference '{text}': unknown unit '{unit}'; write degC, K or degF")
    return temperature_in_celsius(value, known)


def _example(column: str) -> str:
    if column == "temperature":
        return "25degC"
    return "0.5"
