"""Rows of a test, what is known of each, and which of them have what a user asks for.

Such as ``temperature=20``. With complex stiffness as whoever asks for it wants to see it (Hz,
storage, loss, magnitude), as tables of pandas and xarray too, and the digest by which data are
known again.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from functools import cached_property
from hashlib import sha256
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.errors import DataError, OptionError
from springpot.rheology.points import HELD, Complex, Real
from springpot.writing import LISTED

from ..numerics import ALIKE
from .units import FREQUENCY_UNITS, TEMPERATURE_UNITS, Units, known_unit, temperature_in_celsius


class Moduli:
    """What has a complex stiffness at angular frequencies, measured or predicted.

    Attributes
    ----------
    omega : ndarray, shape (n,)
        In rad/s.
    stiffness : ndarray of complex, shape (n,)
        K = K' + i K''.

    Examples
    --------
    >>> from springpot import Measurement
    >>> data = Measurement([62.83185307179586], [3.0 + 4.0j])
    >>> data.frequency, data.magnitude
    (array([10.]), array([5.]))
    """

    omega: Real
    stiffness: Complex

    def __len__(self) -> int:
        return len(self.omega)

    @property
    def frequency(self) -> Real:
        """Frequency f = omega / 2 pi in Hz, shape (n,)."""
        return self.omega / (2.0 * np.pi)

    @property
    def storage(self) -> Real:
        """Storage modulus K', shape (n,)."""
        return self.stiffness.real

    @property
    def loss(self) -> Real:
        """Loss modulus K'', shape (n,)."""
        return self.stiffness.imag

    @cached_property
    def magnitude(self) -> Real:
        """|K|, shape (n,)."""
        return np.abs(self.stiffness)


SAME_AMPLITUDE = 0.05
"""Relative range within which amplitudes are one; other conditions are so within one per cent."""
PLACES = ("frequency", "omega", "row", "sample")
"""Columns that all tests of a kind have: they go without saying."""


class Asked(Protocol):
    """A test whose rows can be asked for by what stands beside them."""

    @property
    def name(self) -> str:
        """Shown in messages."""

    @property
    def labels(self) -> Mapping[str, NDArray[np.str_]]:
        """Columns of words."""

    @property
    def columns(self) -> Mapping[str, Real]:
        """Columns of numbers, each of a row."""

    def __len__(self) -> int: ...


class Rows(Moduli):
    """What has conditions, words and repeats beside each complex stiffness.

    Attributes
    ----------
    name : str
        Shown in messages.
    conditions : mapping of str to ndarray, shape (n,)
        Columns of numbers beside the frequency.
    labels : mapping of str to ndarray of str, shape (n,)
        Columns of words beside the frequency.
    repeat : ndarray of int, shape (n,), or None
        Which repetition a row belongs to.
    units : Units
        Of stiffness, amplitude and frequency.
    """

    name: str
    conditions: Mapping[str, Real]
    labels: Mapping[str, NDArray[np.str_]]
    repeat: NDArray[np.int64] | None
    units: Units

    @property
    def columns(self) -> dict[str, Real]:
        """The numbers that a condition may stand for, by its name."""
        own = {
            "frequency": self.frequency,
            "omega": self.omega,
            "row": np.arange(1.0, len(self) + 1.0),
            **self.conditions,
        }
        if self.repeat is not None:
            own["repeat"] = self.repeat.astype(float)
        return own


def rows_with(measured: Asked, wanted: Mapping[str, str]) -> NDArray[np.bool_]:
    """A mask (n,) of the rows that have all the wanted conditions.

    See `springpot.measurement.select`.

    Raises
    ------
    DataError
        If there is no such column or value, with those that there are.
    """
    # Each further condition narrows the choice.
    rows = np.ones(len(measured), dtype=bool)
    for key, value in wanted.items():
        rows &= _matching(measured, key, value)
    return rows


def rows_without(measured: Asked, unwanted: Mapping[str, str]) -> NDArray[np.bool_]:
    """A mask (n,) of the rows that lack one of the conditions.

    Raises
    ------
    DataError
        If there is no such column or value, or nothing would be left.
    """
    rows = ~rows_with(measured, unwanted)
    if not rows.any():
        raise DataError(f"{measured.name}: nothing would be left")
    return rows


def _matching(measured: Asked, key: str, value: str) -> NDArray[np.bool_]:
    if key in measured.labels:
        return _matching_words(measured, key, value)
    column = _column(measured, key)
    if ".." in value:
        return _between(measured, key, value, column)
    number = _number(measured, key, value)
    # Batches 1001 and 1002 are a thousandth apart: a number of no known kind means itself where it
    # stands there.
    if key not in ("amplitude", "temperature", "frequency", "omega") and np.any(column == number):
        return np.asarray(column == number)
    # Measured conditions are never quite what was set; a row has a number, which is exact.
    reach = (SAME_AMPLITUDE if key == "amplitude" else 0.01) * abs(number)
    if key == "temperature":
        reach = HELD[key]
    elif key in ("row", "sample"):
        reach = 0.0
    rows: NDArray[np.bool_] = np.abs(column - number) <= reach * (1 + ALIKE)
    if not rows.any():
        known = np.unique([float(f"{v:.3g}") for v in np.unique(column[np.isfinite(column)])])
        raise DataError(
            f"{measured.name}: no {key} near {value} (there are:"
            f" {_listed([f'{v:g}' for v in known])})"
        )
    return rows


def _column(measured: Asked, key: str) -> Real:
    """The numbers that a condition stands for."""
    columns = measured.columns
    if key not in columns:
        there = [name for name in columns if name not in PLACES]
        raise DataError(
            f"{measured.name} has no condition '{key}'"
            f" (there are: {', '.join([*there, *measured.labels]) or 'none'})"
        )
    return columns[key]


def _between(measured: Asked, key: str, value: str, column: Real) -> NDArray[np.bool_]:
    """Rows between two ends, either of which may be left open."""
    first, _, last = value.partition("..")
    low, high = -np.inf, np.inf
    if first.strip():
        low = _number(measured, key, first)
    if last.strip():
        high = _number(measured, key, last)
    slack = ALIKE * float(
        np.max(np.abs(column))
    )  # a frequency in Hz was once rad/s, and ends are included
    rows: NDArray[np.bool_] = (column >= low - slack) & (column <= high + slack)
    if not rows.any():
        least, most = float(np.min(column)), float(np.max(column))
        raise DataError(
            f"{measured.name}: no {key} in {value} (there are {least:.4g} to {most:.4g})"
        )
    return rows


def _number(measured: Asked, key: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise DataError(
            f"{measured.name}: {key}={value} is no number or range such as 1..10"
        ) from None


def _matching_words(measured: Asked, key: str, value: str) -> NDArray[np.bool_]:
    column = measured.labels[key]
    known = [str(word) for word in np.unique(column)]
    low = value.lower()
    # Case first as it is typed: two specimens may be called A and a.
    exact = [word for word in known if word == value] or [
        word for word in known if word.lower() == low
    ]
    begins = [word for word in known if re.match(re.escape(low) + r"(?!\w)", word.lower())]
    within = [word for word in known if low in word.lower()]
    # The surest first: a word that is written out means itself, though it may begin another one.
    matches = exact or begins or within
    if not value:
        matches = exact
    if len(matches) != 1:
        reason = f"no {key} '{value}'"
        if matches:
            reason = f"several values of {key} match '{value}'"
        raise DataError(f"{measured.name}: {reason} (there are: {_listed(matches or known)})")
    return np.asarray(column == matches[0])


def _listed(values: list[str]) -> str:
    # A message is one line: a column of a thousand values must not fill the screen.
    if len(values) > LISTED:
        values = [*values[: LISTED - 2], "...", values[-1]]
    return ", ".join(values)


TOLD = 24
"""Binary digits of a number that count, as many as single precision has.

They tell 1e-7 apart; whatever is nearer than that is arithmetic, see `scatter.LEAST_RELATIVE`. Half
of the digits of a double lie behind them: the chance that rounding leads a computed number over the
edge between two of them is 1e-8.
"""
DEEPEST = 40
"""Binary digits below the largest of what is read together, 1e-12 of it, that count.

A zero that is computed is any number of some 1e-16 of it, as where a sine crosses zero.
"""


def digest_of_columns(
    about: object, columns: Mapping[str, ArrayLike | None], alone: Collection[str]
) -> str:
    """SHA-256 of columns by name, and of the words that go with them, alike on every processor.

    Exponentials and sines differ from one to the next in their last bit, so that columns which are
    computed have other bytes where they are opened. What counts is what a fit can tell apart.

    Parameters
    ----------
    about : object
        What is plain text as its own representation.
    columns : mapping of str to array_like
        Numbers, words or whole numbers, in any order; None for one that is not there.
    alone : collection of str
        Those of which each number stands for itself, over however many decades: of any other a
        number is read beside the largest, of complex ones its two parts beside each other.
    """
    seen = sha256(f"{about!r}\n".encode())
    for key in sorted(key for key, column in columns.items() if column is not None):
        values: NDArray[Any] = np.ascontiguousarray(columns[key])
        kind = values.dtype.newbyteorder("<")
        # Kind and shape too, as the same bytes may be other numbers.
        seen.update(f"{key!r} {kind.str} {values.shape}\n".encode())
        if kind.kind == "c":
            values = told(values.view(float).reshape(*values.shape, 2))
        elif kind.kind == "f":
            values = told(values[..., np.newaxis] if key in alone else values)
        seen.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    return seen.hexdigest()


def told(values: Real) -> Real:
    """Numbers (..., n) to the digits that count, those along the last axis read together.

    Examples
    --------
    >>> import numpy as np
    >>> turns = np.sin([0.0, np.pi / 2.0, np.pi])
    >>> turns[2] == 0.0, told(turns).tolist()
    (np.False_, [0.0, 1.0, 0.0])
    """
    finite = np.isfinite(values)
    plain = np.where(finite, values, 0.0)
    power = np.frexp(plain)[1] - TOLD
    # The largest to its own digits first: beside 0.99999999999999989 the same counts as beside 1.
    largest = np.max(np.abs(_multiples(plain, power)), axis=-1, keepdims=True, initial=0.0)
    numbers = _multiples(plain, np.maximum(power, np.frexp(largest)[1] - DEEPEST))
    # Nothing has one sign, and so has what is no number.
    return np.where(finite, numbers + 0.0, np.where(np.isnan(values), np.nan, values))


def _multiples(numbers: Real, power: NDArray[np.int32]) -> Real:
    """The nearest multiples of powers of two, which no rounding of its own makes inexact."""
    return np.ldexp(np.rint(np.ldexp(numbers, -power)), power)


def told_of(number: float) -> float:
    """One number to the digits that count."""
    return float(told(np.array([number]))[0])


_HEADING = re.compile(r"\s*([^\[\]]+?)\s*(?:\[([^\[\]]*)\])?\s*")
PARTS = ("storage", "loss", "storage_sd", "loss_sd")


def library(name: str) -> Any:
    """A library that is no part of springpot.

    Raises
    ------
    OptionError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError:
        raise OptionError(f"this needs {name}: pip install 'springpot[frames]'") from None


def columns_of(data: Any) -> dict[str, Any]:
    """The columns of a measurement under the headings of its CSV file: ``storage [kN/m]``."""
    units = data.units
    columns: dict[str, Any] = {"omega [rad/s]": data.omega}
    if units.clock == "Hz":
        columns = {"frequency [Hz]": data.omega / (2.0 * np.pi)}
    columns |= {
        f"storage [{units.stiffness}]": data.storage,
        f"loss [{units.stiffness}]": data.loss,
    }
    if data.sd is not None:
        columns[f"storage_sd [{units.stiffness}]"] = data.sd.real
        columns[f"loss_sd [{units.stiffness}]"] = data.sd.imag
    for name, column in data.conditions.items():
        columns[f"{name} [{units.of_condition(name)}]"] = column
    if data.repeat is not None:
        columns["repeat"] = data.repeat
    return {**columns, **data.labels}


def dataframe(data: Any) -> Any:
    """The measurement as a `pandas.DataFrame`."""
    frame = library("pandas").DataFrame(columns_of(data))
    frame.attrs["name"] = data.name
    return frame


def dataset(data: Any) -> Any:
    """The measurement as an `xarray.Dataset` along ``point``."""
    xarray, units = library("xarray"), data.units
    columns = {**data.conditions, **data.labels}
    if data.repeat is not None:
        columns["repeat"] = data.repeat
    coordinates = {"omega": ("point", data.omega, {"units": "rad/s"})}
    for name, column in columns.items():
        coordinates[name] = ("point", column, {"units": units.of_condition(name)})
    values = {"stiffness": data.stiffness}
    if data.sd is not None:
        values["sd"] = data.sd
    told = {"units": units.stiffness}
    variables = {name: ("point", column, told) for name, column in values.items()}
    return xarray.Dataset(variables, coordinates, {"name": data.name})


def arguments_of(frame: Any) -> dict[str, Any]:
    """What a `Measurement` is made of, from a table whose headings are those of a CSV file.

    Raises
    ------
    DataError
        If frequency, storage or loss is missing, or has no unit or an unknown one.
    """
    columns: dict[str, tuple[Any, str | None]] = {}
    for heading in frame.columns:
        match = _HEADING.fullmatch(str(heading))
        if match is None:
            raise DataError(f"'{heading!s:.40}' is no heading such as 'storage [kN/m]'")
        columns[match[1]] = (frame[heading].to_numpy(), match[2])
    missing = [name for name in ("storage", "loss") if name not in columns]
    rates = [name for name in ("frequency", "omega") if name in columns]
    if missing or not rates:
        raise DataError(f"the table has no column '{[*missing, 'frequency'][0]}' with its unit")
    rate, clock = columns.pop(rates[0])
    clock = known_unit(clock or "", FREQUENCY_UNITS, f"the {rates[0]}")
    stiffness = columns["storage"][1] or ""
    parts = {name: columns.pop(name)[0].astype(float) for name in PARTS if name in columns}
    amplitude = columns.get("amplitude", (None, None))[1] or "-"
    units = Units(stiffness, amplitude, "rad/s" if clock == "rad/s" else "Hz")
    found: dict[str, Any] = {
        "omega": rate.astype(float) * FREQUENCY_UNITS[clock],
        "stiffness": parts["storage"] + 1j * parts["loss"],
        "units": units,
        "name": str(frame.attrs.get("name", "table")),
    }
    if "storage_sd" in parts and "loss_sd" in parts:
        found["sd"] = parts["storage_sd"] + 1j * parts["loss_sd"]
    if "repeat" in columns:
        found["repeat"] = columns.pop("repeat")[0].astype(np.int64)
    return found | _conditions(columns)


def _conditions(columns: dict[str, tuple[Any, str | None]]) -> dict[str, Any]:
    """Columns of numbers are conditions, those of words labels."""
    numbers, words = {}, {}
    for name, (column, unit) in columns.items():
        if not np.issubdtype(column.dtype, np.number):
            words[name] = column.astype(str)
            continue
        numbers[name] = column.astype(float)
        if name == "temperature":
            unit = known_unit(unit or "", TEMPERATURE_UNITS, "the temperature")
            numbers[name] = temperature_in_celsius(numbers[name], unit)
    return {"conditions": numbers, "labels": words}
