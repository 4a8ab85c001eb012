"""A code of tests: what a small TOML file requires of records, each with its source.

Amounts stand in it as people write them: a number with a unit of any spelling that fits.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from springpot.errors import DataError, OptionError
from springpot.files import toml_in
from springpot.measurement.units import (
    ANGLE_UNITS,
    FORCE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    TIME_UNITS,
)

from .quantities import BY_NAME
from .summary import range_of

_NUMBER = r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d{1,2})?"
_AMOUNT = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*")
_RANGE = re.compile(rf"\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*(.*?)\s*")
Dimension = tuple[int, int, int]
"""Powers of force, length and time."""

_KINDS: tuple[tuple[dict[str, float], Dimension], ...] = (
    (FORCE_UNITS, (1, 0, 0)),
    (LENGTH_UNITS, (0, 1, 0)),
    (TIME_UNITS, (0, 0, 1)),
    (ANGLE_UNITS, (0, 0, 0)),
    (PRESSURE_UNITS, (1, -2, 0)),
    ({"J": 1.0, "kJ": 1e3}, (1, 1, 0)),
    ({"-": 1.0, "1": 1.0, "%": 0.01, "": 1.0}, (0, 0, 0)),
    ({"Hz": 1.0, "mHz": 1e-3, "kHz": 1e3}, (0, 0, -1)),
    # Of no power of the others: a temperature is compared with temperatures alone.
    ({"degC": 1.0}, (7, 7, 7)),
)


def _unit_factor(unit: str) -> tuple[float, Dimension]:
    """Factor to SI and dimension of a product of units, with what stands behind a slash below."""
    for table, dimension in _KINDS:
        if unit in table:
            return table[unit], dimension
    factor, total = 1.0, (0, 0, 0)
    parts = re.split(r"\s*([/*]|\s)\s*", unit)
    side = 1
    for word in parts:
        if word == "/":
            # All that stands behind it is divided by.
            side = -1
        if word in {"", " ", "*", "/"}:
            continue
        if word == unit:
            raise DataError(f"unit '{unit:.20}' is not known")
        one, dimension = _unit_factor(word)
        factor *= one**side
        total = (
            total[0] + side * dimension[0],
            total[1] + side * dimension[1],
            total[2] + side * dimension[2],
        )
    return factor, total


def ratio_of_units(written: str, wanted: str) -> float:
    """Factor from one unit to another.

    Raises
    ------
    DataError
        If one is unknown, or they are units of different things.

    Examples
    --------
    >>> round(ratio_of_units("kJ", "kN mm")), ratio_of_units("kN/m", "N/mm")
    (1000, 1.0)
    """
    if written == wanted:
        return 1.0
    (one, first), (other, second) = _unit_factor(written), _unit_factor(wanted)
    if first != second:
        raise DataError(f"'{written:.20}' is no unit of what is in {wanted}")
    return one / other


def amount(value: object, wanted: str) -> float:
    """A number in a unit, from text such as ``0.5 kN/mm``; a bare number is one of no unit.

    Raises
    ------
    DataError
        If it is none, or of another unit.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        if wanted in {"-", "1"}:
            try:
                return float(value)
            except OverflowError:
                raise DataError("a number is too large") from None
        raise DataError(f"{value!s:.40} has no unit: write '{value} {wanted}'")
    match = _AMOUNT.fullmatch(str(value)[:80]) if isinstance(value, str) else None
    if match is None:
        raise DataError(f"'{value!s:.40}' is no number with a unit, such as '1 {wanted}'")
    if not match[2] and wanted not in {"-", "1"}:
        raise DataError(f"{value} has no unit: write '{value} {wanted}'")
    return float(match[1]) * ratio_of_units(match[2], wanted)


def between(value: object, wanted: str) -> tuple[float, float]:
    """The ends of text such as ``0.9..1.1 Hz``; one that is missing is infinite.

    Raises
    ------
    DataError
        If it is none, or of another unit.
    """
    match = _RANGE.fullmatch(value[:80]) if isinstance(value, str) else None
    if match is None or (match[1] is None and match[2] is None):
        raise DataError(f"'{value!s:.40}' is no range, such as '0.9..1.1 {wanted}'")
    factor = ratio_of_units(match[3], wanted)
    low = float("-inf") if match[1] is None else factor * float(match[1])
    high = float("inf") if match[2] is None else factor * float(match[2])
    if not low < high:
        raise DataError(f"'{value!s:.40}' runs backwards")
    return low, high


T = TypeVar("T")

STATUS = ("unchecked", "signed")
"""Whether somebody with the text of a standard has compared the file with it."""
OF, TO = ("cycle", "test", "mean"), ("mean", "nominal", "value")
ACTS = {"force": "-", "displacement": "-", "phase": "rad", "temperature": "K"}
"""What an error of an instrument acts on, and its unit; gains are shares."""
MEANS = {"expanded": 1.0 / 1.959964, "limits": 3.0**-0.5, "standard": 1.0}
"""Standard uncertainty of what is stated: 95 % of a normal, ends of a rectangle (GUM 4.3)."""
GUARDS = ("expanded", "none")


@dataclass(frozen=True)
class RequiredTest:
    """A test that must be there: so many records with a motion in these ranges."""

    name: str
    records: str
    count: int
    cycles: int
    ranges: Mapping[str, object]
    source: str


@dataclass(frozen=True)
class Requirement:
    """A tolerance on a quantity.

    Of each cycle, each test or the mean of the tests, as a ratio to a mean or the nominal, or as a
    value; `low` and `high` are as they were written.
    """

    name: str
    quantity: str
    of: str
    to: str
    low: object
    high: object
    records: str
    source: str


@dataclass(frozen=True)
class PropertyFactor:
    """How far a property goes up and down for one cause: stated, or measured on records."""

    name: str
    low: float
    high: float
    quantity: str
    records: str
    reference: str
    source: str


@dataclass(frozen=True)
class StatedError:
    """An error of type B: its standard uncertainty, and whether all tests share it.

    `coefficients` are relative changes of quantities for one kelvin, of a temperature.
    """

    name: str
    acts: str
    standard: float
    shared: bool
    coefficients: Mapping[str, float]
    source: str


@dataclass(frozen=True)
class TestCode:
    """What a code file says; see `read_code`."""

    __test__ = False

    path: Path
    name: str
    status: str
    signed_by: str
    source: str
    cycles: tuple[int, int] | None
    model: str | None
    nominal: Mapping[str, object]
    tests: tuple[RequiredTest, ...]
    requirements: tuple[Requirement, ...]
    factors: tuple[PropertyFactor, ...]
    system: float
    limits: tuple[float, float]
    errors: tuple[StatedError, ...]
    guard: str


def read_code(path: str | Path) -> TestCode:
    """The code that a TOML file describes.

    Raises
    ------
    DataError
        If it cannot be read, or something in it is unknown, missing or of no use: one line with the
        file and the key.
    """
    path = Path(path)
    whole = toml_in(path)
    with _named(path, ""):
        _only(
            whole, {"code", "nominal", "test", "require", "factor", "factors", "error", "decision"}
        )
    code = _table(whole, "code", path)
    with _named(path, "[code]"):
        _only(code, {"name", "status", "signed_by", "source", "cycles", "model"})
        status = _word(code, "status", STATUS)
        signed_by = _text(code, "signed_by", "")
        if status == "signed" and not signed_by:
            raise DataError("status = 'signed' needs signed_by = 'WHO, WHEN'")
        cycles = range_of(_text(code, "cycles")) if "cycles" in code else None
        model = _text(code, "model") if "model" in code else None
        name, source = _text(code, "name"), _text(code, "source")
    nominal = _table(whole, "nominal", path)
    with _named(path, "[nominal]"):
        for quantity in nominal:
            _known(quantity)
    factors, decision = _table(whole, "factors", path), _table(whole, "decision", path)
    with _named(path, "[factors]"):
        _only(factors, {"system", "low", "high"})
        system = _share(factors, "system", 1.0)
        limits = _number(factors, "low", 0.0), _number(factors, "high", float("inf"))
    with _named(path, "[decision]"):
        _only(decision, {"guard"})
        guard = _word(decision, "guard", GUARDS)
    requirements = _each(whole, "require", path, lambda entry: _requirement(entry, nominal))
    if not requirements:
        raise DataError(f"{path}: there is no [[require]]: nothing is asked of the tests")
    return TestCode(
        path,
        name,
        status,
        signed_by,
        source,
        cycles,
        model,
        nominal,
        _each(whole, "test", path, _test),
        requirements,
        _each(whole, "factor", path, _factor),
        system,
        limits,
        _each(whole, "error", path, _error),
        guard,
    )


@contextmanager
def _named(path: Path, where: str) -> Iterator[None]:
    """Let every error within say the file and the place."""
    try:
        yield
    except (DataError, OptionError) as error:
        place = f"{path}: {where}".rstrip(": ")
        raise DataError(f"{place}: {error}") from None


def _table(whole: Mapping[str, Any], name: str, path: Path) -> Mapping[str, Any]:
    found = whole.get(name, {})
    if not isinstance(found, dict):
        raise DataError(f"{path}: {name} is a table: [{name}]")
    if name == "code" and not found:
        raise DataError(f"{path}: there is no [code] with name, status and source")
    return found


def _each(
    whole: Mapping[str, Any], name: str, path: Path, read: Callable[[Mapping[str, Any]], T]
) -> tuple[T, ...]:
    entries = whole.get(name, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise DataError(f"{path}: each {name} is a [[{name}]]")
    made = []
    for i, entry in enumerate(entries, 1):
        with _named(path, f"[[{name}]] {i}"):
            made.append(read(entry))
    return tuple(made)


def _only(given: Mapping[str, Any], known: set[str]) -> None:
    if unknown := sorted(set(given) - known):
        raise DataError(f"there is no '{unknown[0]:.40}'; there are {', '.join(sorted(known))}")


def _text(given: Mapping[str, Any], key: str, otherwise: str | None = None) -> str:
    value = given.get(key, otherwise)
    if not isinstance(value, str) or (otherwise is None and not value.strip()):
        raise DataError(f"{key} is text: {key} = '...'")
    return value


def _word(given: Mapping[str, Any], key: str, words: tuple[str, ...]) -> str:
    value = given.get(key, words[0])
    if value not in words:
        raise DataError(f"{key} is {' or '.join(words)}, not '{value!s:.40}'")
    return str(value)


def _number(given: Mapping[str, Any], key: str, otherwise: float) -> float:
    value = given.get(key, otherwise)
    try:
        if isinstance(value, int | float | str):
            return amount(value, "-")
        raise DataError(f"'{value!s:.40}' is no number")
    except DataError as error:
        raise DataError(f"{key}: {error}") from None


def _share(given: Mapping[str, Any], key: str, otherwise: float) -> float:
    value = _number(given, key, otherwise)
    if not 0.0 <= value <= 1.0:
        raise DataError(f"{key} is a share from 0 to 1, not {value:g}")
    return value


def _count(given: Mapping[str, Any], key: str) -> int:
    value = given.get(key, 1)
    if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= 10_000:
        raise DataError(f"{key} is a whole number from 1 on, not '{value!s:.40}'")
    return value


def _known(quantity: str) -> str:
    if quantity not in BY_NAME:
        raise DataError(f"quantity '{quantity:.20}' is none of {', '.join(BY_NAME)}")
    return quantity


def _test(entry: Mapping[str, Any]) -> RequiredTest:
    ranges = {"amplitude", "frequency", "v_peak", "T"}
    _only(entry, {"name", "records", "count", "cycles", "source", *ranges})
    given = {key: entry[key] for key in ranges & set(entry)}
    units = {"amplitude": "mm", "frequency": "Hz", "v_peak": "mm/s"}
    for key, value in given.items():
        try:
            if key in units:
                # The unit of a displacement may be another; that it is written well is told now.
                between(value, units[key])
        except DataError as error:
            raise DataError(f"{key}: {error}") from None
    return RequiredTest(
        _text(entry, "name"),
        _text(entry, "records", "*"),
        _count(entry, "count"),
        _count(entry, "cycles"),
        given,
        _text(entry, "source", ""),
    )


def _requirement(entry: Mapping[str, Any], nominal: Mapping[str, object]) -> Requirement:
    _only(entry, {"name", "quantity", "of", "to", "within", "low", "high", "records", "source"})
    quantity, to = _known(_text(entry, "quantity")), _word(entry, "to", TO)
    of = _word(entry, "of", OF)
    if to == "nominal" and quantity not in nominal:
        raise DataError(f"[nominal] has no {quantity}, to which the ratio is")
    if (of, to) == ("mean", "mean"):
        raise DataError("of = 'mean' goes with to = 'nominal' or 'value'")
    if ("within" in entry) == bool({"low", "high"} & set(entry)):
        raise DataError("give within = '15 %', or low and high")
    low, high = entry.get("low"), entry.get("high")
    if "within" in entry:
        if to == "value":
            raise DataError("within is for ratios: give low and high of a value")
        share = _share(entry, "within", 0.0)
        low, high = 1.0 - share, 1.0 + share
    elif to != "value":
        low, high = (None if each is None else amount(each, "-") for each in (low, high))
    name, records = _text(entry, "name"), _text(entry, "records", "*")
    return Requirement(name, quantity, of, to, low, high, records, _text(entry, "source", ""))


def _factor(entry: Mapping[str, Any]) -> PropertyFactor:
    _only(entry, {"name", "low", "high", "quantity", "records", "reference", "source"})
    measured = {"quantity", "records", "reference"} & set(entry)
    if bool(measured) == bool({"low", "high"} & set(entry)):
        raise DataError("give low and high, or quantity, records and reference")
    if measured:
        quantity = _known(_text(entry, "quantity"))
        places = _text(entry, "records"), _text(entry, "reference")
    else:
        quantity, places = "", ("", "")
    low, high = _number(entry, "low", 1.0), _number(entry, "high", 1.0)
    if not 0.0 < low <= 1.0 <= high:
        raise DataError(f"low is from 0 to 1 and high from 1 on, not {low:g} and {high:g}")
    return PropertyFactor(
        _text(entry, "name"), low, high, quantity, *places, _text(entry, "source", "")
    )


def _error(entry: Mapping[str, Any]) -> StatedError:
    _only(entry, {"name", "acts", "accuracy", "means", "shared", "coefficient", "source"})
    acts = _word(entry, "acts", tuple(ACTS)) if "acts" in entry else _text(entry, "acts")
    shared = entry.get("shared", True)
    if not isinstance(shared, bool):
        raise DataError("shared is true or false")
    if acts == "temperature":
        value = _kelvin(entry.get("accuracy"))
    else:
        value = amount(entry.get("accuracy"), ACTS[acts])
    if not value >= 0.0:
        raise DataError(f"accuracy is positive, not {value:g}")
    given = entry.get("coefficient", {})
    if not isinstance(given, dict) or bool(given) != (acts == "temperature"):
        raise DataError("coefficient = {K_eff = '-1 %/K'} goes with acts = 'temperature'")
    coefficients = {_known(key): _kelvin(each, "%/K") / 100.0 for key, each in given.items()}
    standard = value * MEANS[_word(entry, "means", tuple(MEANS))]
    name = _text(entry, "name")
    return StatedError(name, acts, standard, shared, coefficients, _text(entry, "source", ""))


def _kelvin(value: object, unit: str = "K") -> float:
    """A difference of temperature, or per cent for one kelvin."""
    if isinstance(value, str) and value.replace(" ", "").endswith(unit):
        return amount(value.replace(" ", "").removesuffix(unit), "-")
    raise DataError(f"'{value!s:.40}' is no number of {unit}: write '0.5 {unit}'")
