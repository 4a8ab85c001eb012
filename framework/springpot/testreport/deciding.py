"""What a code asks of tests, answered: each row with its uncertainty and its decision.

How sure a measured quantity is, is the budget of a laboratory (GUM, JCGM 100:2008). Type A is what
the tests show: the noise of a record or the scatter of its cycles. Type B is what is stated of the
instruments. An error that all tests share moves all of them together: it cancels in a ratio between
them and does not in a mean.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from scipy.special import ndtr, stdtr

from springpot.distributions import student
from springpot.errors import DataError
from springpot.plain_data import Plain
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL
from springpot.writing import counted

from .code import PropertyFactor, RequiredTest, Requirement, StatedError, TestCode, amount, between
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


CONFORMING, UNDECIDED, FAILING = "conforming", "undecided", "not conforming"


@dataclass(frozen=True)
class DecidedRow:
    """One result against its limits.

    Parameters
    ----------
    name : str
        What is required.
    quantity : str
        Of which quantity.
    subject : str
        The test, with its cycle, or all tests.
    test : str
        Name of the test that it is about, or of the one farthest from the limits.
    unit : str
        Of the result: ``-`` of a ratio.
    budget : ErrorBudget
        The result and its uncertainty.
    low, high : float
        The limits.
    verdict : str
        ``conforming``, ``undecided`` or ``not conforming``.
    source : str
        Of the limits.
    """

    name: str
    quantity: str
    subject: str
    test: str
    unit: str
    budget: ErrorBudget
    low: float
    high: float
    verdict: str
    source: str

    @property
    def risk(self) -> float:
        """Chance that the true value lies outside of the limits."""
        return self.budget.outside(self.low, self.high)

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "name": self.name,
            "quantity": self.quantity,
            "subject": self.subject,
            "unit": self.unit,
            **self.budget.to_dict(),
            "limits": {"low": _finite(self.low), "high": _finite(self.high)},
            "chance_outside": self.risk,
            "verdict": self.verdict,
            "source": self.source,
        }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def decided(budget: ErrorBudget, low: float, high: float, guard: str) -> str:
    """Whether a result lies within limits.

    With a guard band of its expanded uncertainty (ISO 14253-1, ILAC-G8: w = U): conforming is what
    lies within by more than that, not conforming what lies outside by more, and undecided what is
    between. Of what is said to conform at most 2.5 % at a limit do not, and the other way round.
    Without a guard band the result is taken as it is.
    """
    band = budget.expanded if guard == "expanded" else 0.0
    if low + band <= budget.value <= high - band:
        return CONFORMING
    if budget.value < low - band or budget.value > high + band:
        return FAILING
    return UNDECIDED if band else FAILING


def rows_of(code: TestCode, tests: Sequence[EvaluatedTest]) -> list[DecidedRow]:
    """All rows that a code asks for.

    Raises
    ------
    DataError
        If no test is there for a requirement, or the tests do not have what it is about.
    """
    rows = []
    for asked in code.requirements:
        chosen = [test for test in tests if fnmatchcase(test.name, asked.records)]
        if not chosen:
            raise DataError(f"{code.path}: '{asked.name}': no test is named {asked.records}")
        lacking = [test.name for test in chosen if asked.quantity not in test.means]
        if lacking:
            raise DataError(
                f"{code.path}: '{asked.name}': {lacking[0]} has no {asked.quantity} (no time)"
                if asked.quantity != "T"
                else f"{code.path}: '{asked.name}': {lacking[0]} has no temperature"
            )
        if len({test.unit(asked.quantity) for test in chosen}) > 1:
            raise DataError(f"{code.path}: '{asked.name}': the tests are in different units")
        rows += list(_rows(code, asked, chosen))
    return rows


def _rows(
    code: TestCode, asked: Requirement, tests: Sequence[EvaluatedTest]
) -> Iterator[DecidedRow]:
    if asked.of == "cycle":
        for i, test in enumerate(tests):
            for cycle in range(test.first, test.last + 1):
                budget = _of_cycle(code, asked, test, cycle)
                yield _row(code, asked, f"{test.name}, cycle {cycle}", tests[i], budget)
        return
    values = np.array([test.means[asked.quantity].value for test in tests])
    count = len(tests)
    unit = np.eye(count)
    if asked.of == "mean":
        far = tests[int(np.argmax(np.abs(values - values.mean())))]
        budget = combined(
            float(values.mean()), tests, asked.quantity, np.full(count, 1.0 / count), code.errors
        )
        yield _row(
            code, asked, f"mean of {counted(count, 'test')}", far, _scaled(code, asked, far, budget)
        )
        return
    for i, test in enumerate(tests):
        if asked.to == "mean":
            mean = float(values.mean())
            slopes = unit[i] / mean - values[i] / (count * mean**2)
            budget = combined(values[i] / mean, tests, asked.quantity, slopes, code.errors)
        else:
            budget = combined(values[i], tests, asked.quantity, unit[i], code.errors)
            budget = _scaled(code, asked, test, budget)
        yield _row(code, asked, test.name, test, budget)


def _of_cycle(code: TestCode, asked: Requirement, test: EvaluatedTest, cycle: int) -> ErrorBudget:
    """A cycle against the mean of its test, in which all stated errors cancel, or as it is."""
    told, mean = test.each[cycle - 1][asked.quantity], test.means[asked.quantity]
    if asked.to == "mean":
        # A cycle is part of the mean that it is compared with.
        share = np.sqrt(1.0 - 1.0 / (test.last - test.first + 1))
        line = BudgetLine(
            _origin(told.source), "A", share * told.sd / abs(mean.value), told.freedom
        )
        return ErrorBudget(told.value / mean.value, (line,))
    line = BudgetLine(_origin(told.source), "A", told.sd, told.freedom)
    slope = np.array([told.value / mean.value if mean.value else 1.0])
    budget = combined(told.value, [test], asked.quantity, slope, code.errors, [line])
    return _scaled(code, asked, test, budget)


def _origin(source: str) -> str:
    return {"noise": "noise", "cycles": "scatter of cycles"}[source]


def _scaled(
    code: TestCode, asked: Requirement, test: EvaluatedTest, budget: ErrorBudget
) -> ErrorBudget:
    """As a ratio to the nominal value, where that is asked for."""
    if asked.to != "nominal":
        return budget
    unit = test.unit(asked.quantity)
    try:
        nominal = amount(code.nominal[asked.quantity], unit)
    except DataError as error:
        raise DataError(f"{code.path}: [nominal] {asked.quantity}: {error}") from None
    if nominal == 0.0:
        raise DataError(f"{code.path}: [nominal] {asked.quantity}: no ratio is to nothing")
    return budget.scaled(1.0 / nominal)


def _row(
    code: TestCode, asked: Requirement, subject: str, test: EvaluatedTest, budget: ErrorBudget
) -> DecidedRow:
    unit = test.unit(asked.quantity) if asked.to == "value" else "-"
    ends = []
    for given, otherwise in ((asked.low, -np.inf), (asked.high, np.inf)):
        try:
            ends.append(otherwise if given is None else amount(given, unit))
        except DataError as error:
            raise DataError(f"{code.path}: '{asked.name}': {error}") from None
    low, high = ends
    return DecidedRow(
        asked.name,
        asked.quantity,
        subject,
        test.name,
        unit,
        budget,
        low,
        high,
        decided(budget, low, high, code.guard),
        asked.source,
    )


def missing(code: TestCode, tests: Sequence[EvaluatedTest]) -> list[str]:
    """The tests that a code asks for and that are not there, each in a line."""
    lines = []
    for asked in code.tests:
        found = [test for test in tests if _is(code, asked, test)]
        if len(found) < asked.count:
            lines.append(
                f"'{asked.name}' asks for {asked.count} with {asked.cycles} whole cycles"
                f"{_told(asked)}: there are {len(found)}"
            )
    return lines


def _told(asked: RequiredTest) -> str:
    return "".join(f", {key} {value}" for key, value in sorted(asked.ranges.items()))


def _is(code: TestCode, asked: RequiredTest, test: EvaluatedTest) -> bool:
    if not fnmatchcase(test.name, asked.records) or len(test.cycles) < asked.cycles:
        return False
    seen = {"amplitude": (test.amplitude, test.record.displacement_unit)}
    if test.record.timed:
        seen["frequency"] = (test.frequency.value, "Hz")
    for name in ("v_peak", "T"):
        if name in test.means:
            seen[name] = (test.means[name].value, test.unit(name))
    for key, text in asked.ranges.items():
        if key not in seen:
            return False
        value, unit = seen[key]
        try:
            low, high = between(text, unit)
        except DataError as error:
            raise DataError(f"{code.path}: [[test]] '{asked.name}' {key}: {error}") from None
        if not low <= value <= high:
            return False
    return True


@dataclass(frozen=True)
class FoundFactor(Plain):
    """A property modification factor: its ends, stated or measured."""

    name: str
    low: ErrorBudget
    high: ErrorBudget
    source: str


def factors_of(code: TestCode, tests: Sequence[EvaluatedTest]) -> list[FoundFactor]:
    """Each factor of a code, and the product of all, of which the system takes its share.

    Raises
    ------
    DataError
        If no test is there for one that is to be measured.
    """
    found = [_factor(code, each, tests) for each in code.factors]
    if not found:
        return []
    ends = []
    for side in ("low", "high"):
        parts: list[ErrorBudget] = [getattr(each, side) for each in found]
        product = float(np.prod([part.value for part in parts]))
        lines = [
            BudgetLine(
                f"{each.name}: {line.name}",
                line.kind,
                code.system * product / part.value * line.standard,
                line.freedom,
            )
            for each, part in zip(found, parts, strict=True)
            for line in part.lines
        ]
        ends.append(ErrorBudget(1.0 + code.system * (product - 1.0), tuple(lines)))
    return [*found, FoundFactor("all, of the system", ends[0], ends[1], code.source)]


def _factor(code: TestCode, factor: PropertyFactor, tests: Sequence[EvaluatedTest]) -> FoundFactor:
    if not factor.quantity:
        low, high = ErrorBudget(factor.low, ()), ErrorBudget(factor.high, ())
        return FoundFactor(factor.name, low, high, factor.source)
    groups = []
    for pattern in (factor.records, factor.reference):
        chosen = [
            test
            for test in tests
            if fnmatchcase(test.name, pattern) and factor.quantity in test.means
        ]
        if not chosen:
            raise DataError(
                f"{code.path}: factor '{factor.name}': no test named {pattern} has"
                f" {factor.quantity}"
            )
        groups.append(chosen)
    varied, reference = groups
    base = float(np.mean([test.means[factor.quantity].value for test in reference]))
    ratios = [_ratio(code, factor.quantity, test, reference, base) for test in varied]
    # What lies between the reference and these is within.
    one = ErrorBudget(1.0, ())
    low, high = (choose([one, *ratios], key=lambda each: each.value) for choose in (min, max))
    return FoundFactor(factor.name, low, high, factor.source)


def _ratio(
    code: TestCode,
    quantity: str,
    test: EvaluatedTest,
    reference: Sequence[EvaluatedTest],
    base: float,
) -> ErrorBudget:
    value = test.means[quantity].value / base
    # A test that is one of the reference has part in both.
    others = [each for each in reference if each is not test]
    share = -value / (base * len(reference))
    slopes = [1.0 / base + share * (len(others) < len(reference)), *([share] * len(others))]
    return combined(value, [test, *others], quantity, np.array(slopes), code.errors)


def limits_of(code: TestCode, factors: Sequence[FoundFactor]) -> list[DecidedRow]:
    """Rows of the factors of the system, where a code limits them."""
    rows = []
    for side, low, high in (("low", code.limits[0], np.inf), ("high", -np.inf, code.limits[1])):
        if not factors or not (low > 0.0 or np.isfinite(high)):
            continue
        budget = getattr(factors[-1], side)
        verdict = decided(budget, low, high, code.guard)
        rows.append(
            DecidedRow(
                f"property factors, {side}",
                "-",
                "all",
                "",
                "-",
                budget,
                low,
                high,
                verdict,
                code.source,
            )
        )
    return rows


SURE = 1e-4
"""A chance below it is not told by its size: the tails of a distribution are not known so far."""


def chance(value: float) -> str:
    """A chance in per cent.

    Examples
    --------
    >>> chance(0.0234), chance(1e-9), chance(1.0)
    ('2.3 %', '< 0.01 %', '> 99.99 %')
    """
    if value < SURE:
        return "< 0.01 %"
    if value > 1.0 - SURE:
        return "> 99.99 %"
    # With two digits it would be a hundred.
    if value > 0.99:
        return f"{100.0 * value:.2f} %"
    return f"{100.0 * value:.2g} %"
