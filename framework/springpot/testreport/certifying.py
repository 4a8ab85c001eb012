"""Whether tests are as a code asks, how sure that is, and why one fails."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from springpot.api import diagnose
from springpot.distributions import student
from springpot.errors import DataError, SpringpotError
from springpot.measurement.from_signals import measurement_from_signals
from springpot.measurement.steady import Signals
from springpot.measurement.timetest import TimeTest
from springpot.numerics import FEWEST, SMALLEST
from springpot.thresholds import INTERVAL
from springpot.writing import NAMED

from .certificate import Certificate, Reason
from .code import TestCode, read_code
from .deciding import (
    FAILING,
    DecidedRow,
    factors_of,
    limits_of,
    missing,
    rows_of,
)
from .record import LoopRecord, read_record
from .report import report_of
from .summary import EvaluatedTest, evaluate

BESIDE = frozenset((".toml", ".md", ".html", ".json", ".png", ".svg", ".pdf", ".py", ".log"))
"""What lies in a folder beside records."""


def certify(
    tests: str | Path | LoopRecord | Sequence[str | Path | LoopRecord],
    code: str | Path | TestCode,
    *,
    why: bool = True,
) -> Certificate:
    """Whether tests are as a code asks, how sure that is, and why one fails.

    Parameters
    ----------
    tests : str, Path, LoopRecord, or a sequence of them
        Records, or folders of them.
    code : str, Path or TestCode
        The TOML file that says what is asked; see the guide to test reports.
    why : bool
        Whether the records of the tests that fail most are diagnosed, which takes seconds each.

    Returns
    -------
    Certificate
        Rows with their decisions, budgets, property factors and reasons.

    Raises
    ------
    SpringpotError
        If the code cannot be read, no record is there, or a requirement is about none of them.
    """
    if not isinstance(code, TestCode):
        code = read_code(code)
    listed = [tests] if isinstance(tests, str | Path | LoopRecord) else list(tests)
    found, left_out = _evaluated(listed, code)
    rows = rows_of(code, found)
    factors = factors_of(code, found)
    rows += limits_of(code, factors)
    reasons = []
    if why:
        # Of each test the row that it fails by most, and of the tests those that fail by most.
        failing = [row for row in rows if row.verdict == FAILING and row.test]
        worst: dict[str, DecidedRow] = {}
        for row in sorted(failing, key=_excess, reverse=True):
            worst.setdefault(row.test, row)
        by_name = {test.name: test for test in found}
        reasons = [_reason(row, by_name[row.test], code) for row in [*worst.values()][:NAMED]]
        if failing:
            reasons += _of_all(found, code)
    return Certificate(
        code,
        report_of(found),
        tuple(rows),
        tuple(factors),
        tuple(missing(code, found)),
        tuple(left_out),
        tuple(reasons),
    )


def _evaluated(
    listed: Sequence[str | Path | LoopRecord], code: TestCode
) -> tuple[list[EvaluatedTest], list[str]]:
    found, left_out = [], []
    for given in listed:
        if isinstance(given, LoopRecord):
            found.append(evaluate(given, code.cycles))
            continue
        for spec in _files(given):
            try:
                found.append(evaluate(read_record(spec), code.cycles))
            # Of a folder the rest counts all the same; what was named is meant.
            except DataError as error:
                if spec == given:
                    raise
                left_out.append(str(error))
    if not found:
        reason = f": {left_out[0]}" if left_out else ""
        raise DataError(
            f"{listed[0] if listed else 'nothing'}: no record of a test is there{reason}"
        )
    return found, left_out


def _files(given: str | Path) -> list[str | Path]:
    """A file as it was named, or the files of a folder in the order of their names."""
    folder = Path(given)
    if not folder.is_dir():
        return [given]
    return [
        path
        for path in sorted(folder.iterdir())
        if path.is_file() and path.suffix.lower() not in BESIDE and not path.name.startswith(".")
    ]


def _excess(row: DecidedRow) -> float:
    """By how many uncertainties a result lies outside."""
    beyond = max(row.low - row.budget.value, row.budget.value - row.high)
    return float(beyond / max(row.budget.standard, SMALLEST))


def _reason(row: DecidedRow, test: EvaluatedTest, code: TestCode) -> Reason:
    """What is hidden in the record of a test that fails."""
    says = list(_with_temperature(test, row.quantity))
    # What a diagnosis cannot say, such as of too short a record, is said in its place.
    try:
        diagnosis = diagnose(_judged(test), code.model)
    except SpringpotError as error:
        return Reason(test.name, (*says, f"no diagnosis: {error}"), ())
    says.insert(0, diagnosis.says)
    return Reason(test.name, tuple(says), tuple(diagnosis.leading))


def _of_all(tests: Sequence[EvaluatedTest], code: TestCode) -> list[Reason]:
    """What is hidden in all tests together, as a sweep over their frequencies, where they have any.

    One frequency cannot tell a lag from a softer material, or a mass from a spring.
    """
    timed = [test for test in tests if test.record.timed]
    if len({f"{test.frequency.value:.2g}" for test in timed}) < FEWEST:
        return []
    records = [test.record for test in timed]
    signals = [
        Signals(each.time, each.displacement, each.force, each.displacement_unit, each.force_unit,
                each.name)
        for each in records
    ]  # fmt: skip
    name = f"all {len(timed)} tests together"
    try:
        diagnosis = diagnose(measurement_from_signals(signals, name=name), code.model)
    except SpringpotError as error:
        return [Reason(name, (f"no diagnosis: {error}",), ())]
    return [Reason(name, (diagnosis.says,), tuple(diagnosis.leading))]


def _judged(test: EvaluatedTest) -> TimeTest:
    """The record from its beginning to the end of some whole cycles."""
    record = test.record
    if not record.timed:
        raise DataError("the record has no time")
    last = test.cycles[min(FEWEST, len(test.cycles)) - 1]
    rows = record.time <= last.stop
    return TimeTest.of_history(
        record.time[rows] - record.time[0],
        record.displacement[rows],
        record.force[rows],
        record.displacement_unit,
        record.force_unit,
        control="displacement",
        name=record.name,
    )


def _with_temperature(test: EvaluatedTest, quantity: str) -> list[str]:
    """How a quantity changes from cycle to cycle, and the temperature with it, if surely."""
    if quantity not in BY_CYCLE or len(test.cycles) < FEWEST:
        return []
    number = np.arange(len(test.cycles), dtype=float)
    told = {}
    for name in (quantity, "T"):
        if name not in test.means:
            continue
        values = np.array([each[name].value for each in test.each])
        slope, sd = _trend(number, values)
        if abs(slope) > student(INTERVAL, len(number) - 2) * sd:
            told[name] = slope
    if quantity not in told:
        return []
    share = told[quantity] / test.means[quantity].value
    line = f"{quantity} changes by {100 * share:+.2g} % a cycle"
    if "T" in told:
        line += (
            f" while the temperature changes by {told['T']:+.2g} K: {100 * share / told['T']:+.2g}"
            " % a kelvin"
        )
    return [line]


BY_CYCLE = frozenset(("F0", "K_eff", "C_eff", "xi_eff", "W_d", "K'", "K''", "eta", "F_peak"))
"""Quantities that warming or wear change from cycle to cycle."""


def _trend(number: Any, values: Any) -> tuple[float, float]:
    """Slope of a straight line, and its deviation."""
    away = number - number.mean()
    size = float(away @ away)
    slope = float(away @ values) / size
    left = values - values.mean() - slope * away
    return slope, float(np.sqrt(left @ left / max(len(values) - 2, 1) / size))
