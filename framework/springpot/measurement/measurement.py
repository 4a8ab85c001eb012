"""Dynamic test data: complex stiffness against frequency and the conditions of the test."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sized
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.errors import DataError, plain
from springpot.lazy import Drawn
from springpot.rheology.points import HELD, HELD_OTHER, KELVIN, ROOM, Complex, Points, Real

from ..numerics import NEGLIGIBLE, SMALLEST, rows_alike
from .geometry import Conversion, Geometry, html_of, to_modulus, to_stiffness, words_of
from .rows import Rows, digest_of_columns, rows_without
from .units import AMPLITUDE_UNITS, Units

CONDITIONS = ("temperature", "amplitude")
NEARLY = 0.85
"""Likeness of a name to one of these from which it is taken for a slip."""
WARM = 200.0
"""degC above which a number that ends in .15, as every whole degree does in kelvin, is taken for
one in kelvin.
"""
_DTYPES: dict[str, np.dtype[Any]] = {
    "omega": np.dtype(np.float64),
    "stiffness": np.dtype(np.complex128),
    "sd": np.dtype(np.complex128),
    "repeat": np.dtype(np.int64),
    "harmonics": np.dtype(np.complex128),
}
_KINDS = {"f": "real numbers", "c": "numbers", "i": "whole numbers", "U": "words"}


@dataclass(frozen=True, eq=False)
class Measurement(Rows, Drawn):
    """Measured complex stiffness (or modulus) with its conditions.

    Its picture is storage and loss against frequency, or against amplitude or temperature where
    only these vary.

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Angular frequency in rad/s. This and the other columns may be lists.
    stiffness : ndarray of complex, shape (n,)
        K' + i K'' in ``units.stiffness``.
    sd : ndarray of complex, shape (n,), optional
        Standard deviation of K' (real part) and of K'' (imaginary part), in the same unit.
    conditions : mapping of str to ndarray, shape (n,)
        Columns beside the frequency: ``temperature`` in degC, ``amplitude`` in ``units.amplitude``,
        others by any name that is not nearly one of these two.
    repeat : ndarray of int, shape (n,), optional
        Which repetition a row belongs to.
    harmonics : ndarray of complex, shape (n, h), optional
        Higher force harmonics H_2, H_3, ... over the first, nan where not measured. Time is counted
        from the maximum of the displacement's first harmonic: with x = X cos(omega t) the force is
        the real part of K X (exp(i omega t) + H_2 exp(2 i omega t) + H_3 exp(3 i omega t) + ...).
        So H_n = (U_n / U_1) exp(-i (n - 1) phi) for amplitudes U_n and phi the phase of X_1;
        Coulomb friction has H_3 = 1/3, a hardening cubic spring k3 x^3 alone H_3 = 1/3 as well,
        with K real. Where only its size is known, |H_3| is the condition ``h3``; see `harmonic`.
    units : Units
        The units the data came in.
    name : str
        Shown in reports.
    provenance : mapping of str to str
        Where the data come from.
    labels : mapping of str to ndarray of str, shape (n,)
        Columns of words beside the frequency, such as the specimen or the file.
    reference : float, optional
        Temperature in kelvin at which shift factors are one, for rows taken from a larger
        measurement; by default the measured temperature nearest to the median.

    Raises
    ------
    DataError
        If the columns differ in length or hold values that cannot be measured.

    Examples
    --------
    >>> import numpy as np, springpot
    >>> frequency = [1.0, 2.0, 4.0]
    >>> storage, loss = np.array([100.0, 140.0, 185.0]), np.array([73.0, 86.0, 92.0])
    >>> omega = 2 * np.pi * np.array(frequency)
    >>> units = springpot.Units("kN/m", "mm")
    >>> springpot.Measurement(omega, storage + 1j * loss, units=units, name="damper")
    <Measurement damper: 3 points, 1 to 4 Hz>
    """

    omega: Real
    stiffness: Complex
    sd: Complex | None = None
    conditions: Mapping[str, Real] = field(default_factory=dict)
    repeat: NDArray[np.int64] | None = None
    harmonics: Complex | None = None
    units: Units = field(default_factory=Units)
    name: str = "measurement"
    provenance: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, NDArray[np.str_]] = field(default_factory=dict)
    reference: float | None = None
    control: ClassVar[str] = "frequency"
    kind: ClassVar[str] = "sweep"

    def __repr__(self) -> str:
        units = self.units
        low, high = (
            units.on_clock(float(self.frequency.min())),
            units.at(float(self.frequency.max())),
        )
        beside = "".join(f", {name}" for name in self.conditions)
        return f"<Measurement {plain(self.name)}: {len(self)} points, {low:.3g} to {high}{beside}>"

    def _repr_html_(self) -> str:
        return html_of(self)

    def __post_init__(self) -> None:
        if not isinstance(self.units, Units):
            raise DataError(
                f"{self.name}: units are Units('kN/m', 'mm'), of stiffness and amplitude:"
                f" {self.units!r}"
            )
        # Looked at before it is made complex, when a loss that was forgotten can no longer be told
        # from none.
        without_loss = not _holds_complex(self.stiffness)
        # Frozen all the way down: what is worked out of the data is remembered, and must stay true.
        object.__setattr__(self, "provenance", MappingProxyType(dict(self.provenance)))
        for name, dtype in _DTYPES.items():
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, self._array(name, values, dtype))
        for name, dtype in (("conditions", np.dtype(np.float64)), ("labels", np.dtype(np.str_))):
            mapping = {
                key: self._array(key, column, dtype) for key, column in getattr(self, name).items()
            }
            object.__setattr__(self, name, MappingProxyType(mapping))
        # Checked when made, so that no later step need ask whether data are whole.
        self._check()
        if without_loss:
            raise DataError(f"{self.name}: stiffness is real: give storage + 1j * loss")

    def _array(self, name: str, values: ArrayLike, dtype: np.dtype[Any]) -> NDArray[Any]:
        """A column as an array of its kind; the same object where it is one."""
        allowed = {"c": "biufc", "f": "biuf", "i": "biuf"}
        try:
            given = np.asarray(values)
            if dtype.kind in allowed and given.dtype.kind not in allowed[dtype.kind]:
                raise ValueError
            # Not a number, and numbers that are too large, are no whole ones and warn when they are
            # made so.
            if (
                dtype.kind == "i"
                and given.dtype.kind == "f"
                and not np.all(np.abs(given) < 2.0**63)
            ):
                raise ValueError
            column = given
            # Words are words at any length, and stay the same object.
            if not given.dtype.kind == dtype.kind == "U":
                column = given.astype(dtype, copy=False)
            if dtype.kind == "i" and np.any(column != given):
                raise ValueError
        except (ValueError, TypeError):
            raise DataError(f"{self.name}: column {name} must hold {_KINDS[dtype.kind]}") from None
        dimensions = 1
        if name == "harmonics":
            dimensions = 2
        if column.ndim != dimensions:
            raise DataError(
                f"{self.name}: column {name} must have one value for each measured point"
            )
        return column

    def _check(self) -> None:
        n = len(self.omega)
        columns: dict[str, Sized | None] = {
            "stiffness": self.stiffness,
            "sd": self.sd,
            "repeat": self.repeat,
            "harmonics": self.harmonics,
        }
        columns |= {**self.conditions, **self.labels}
        for column, values in columns.items():
            if values is not None and len(values) != n:
                raise DataError(
                    f"{self.name}: column {column} has {len(values)} rows where omega has {n}"
                )
        if n == 0:
            raise DataError(f"{self.name}: no measured points")
        if not (np.all(np.isfinite(self.omega)) and np.all(self.omega > 0)):
            raise DataError(f"{self.name}: frequencies must be positive and finite")
        if not np.all(np.isfinite(self.stiffness)):
            raise DataError(f"{self.name}: storage and loss must be finite")
        # Errors are relative to |K|: a point without any would count without end.
        nothing = np.flatnonzero(self.stiffness == 0)
        if len(nothing):
            place = f"first at {self.units.at(float(self.frequency[nothing[0]]), 4)}"
            few = f"in {len(nothing)} of {n} points"
            raise DataError(
                f"{self.name}: storage and loss are both zero {few}, {place}; leave them out"
            )
        if self.sd is not None and not np.all(
            np.isfinite(self.sd) & (self.sd.real > 0) & (self.sd.imag > 0)
        ):
            raise DataError(f"{self.name}: standard deviations must be positive and finite")
        self._check_conditions()

    def _check_conditions(self) -> None:
        for condition in CONDITIONS:
            # Of the columns that models know: a further one may well be missing at some points.
            lost = np.flatnonzero(~np.isfinite(self.conditions.get(condition, np.zeros(0))))
            if len(lost):
                place = f"first at {self.units.at(float(self.frequency[lost[0]]), 4)}"
                few = f"in {len(lost)} of {len(self)} points"
                raise DataError(
                    f"{self.name}: {condition} is no finite number {few}, {place}; leave them out"
                )
        celsius = self.conditions.get("temperature")
        if celsius is not None and np.min(celsius) < -KELVIN:
            raise DataError(
                f"{self.name}: temperature is in degC, and below the absolute zero of -273.15"
            )
        if celsius is not None and np.all(
            (celsius > WARM) & (np.abs(celsius % 1.0 - KELVIN % 1.0) < NEGLIGIBLE)
        ):
            raise DataError(
                f"{self.name}: temperature is in degC; {celsius[0]:g} looks like kelvin:"
                " subtract 273.15"
            )
        for condition in self.conditions:
            if advice := misspelt(condition):
                raise DataError(f"{self.name}: condition '{condition}' {advice}")

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        # Mapping proxies cannot cross to a worker process; plain dictionaries can.
        plain = (
            dict(self.conditions),
            self.repeat,
            self.harmonics,
            self.units,
            self.name,
            dict(self.provenance),
            dict(self.labels),
            self.reference,
        )
        return Measurement, (self.omega, self.stiffness, self.sd, *plain)

    @cached_property
    def reference_temperature(self) -> float:
        """Where a shift factor is one, in kelvin.

        `reference`, or the measured temperature nearest to the median.
        """
        temperature = self.conditions.get("temperature")
        if self.reference is not None:
            return self.reference
        if temperature is None:
            return ROOM
        # The lower median: a temperature that was measured, and not the mean of two.
        return float(np.sort(temperature)[(len(temperature) - 1) // 2]) + KELVIN

    @property
    def seen(self) -> tuple[float, float]:
        """Lowest and highest angular frequency in rad/s."""
        return float(self.omega.min()), float(self.omega.max())

    @cached_property
    def points(self) -> Points:
        """Where a model of these data is evaluated."""
        return points_at(np.log(self.omega), self.conditions, self.reference_temperature)

    def harmonic(self, order: int) -> Complex | Real | None:
        """A force harmonic over the first, shape (n,), nan where not measured; None without any.

        Complex by `harmonics`; real where a condition named ``h3`` or the like tells its size only.

        Parameters
        ----------
        order : int
            2, 3, ...
        """
        if self.harmonics is not None and self.harmonics.shape[1] > order - 2:
            return self.harmonics[:, order - 2]
        return self.conditions.get(f"h{order}")

    def subset(
        self, rows: NDArray[np.bool_] | NDArray[np.int64], name: str | None = None
    ) -> Measurement:
        """The rows chosen by a mask or by indices.

        With a `name` they are data of their own. Without one they stay part of these: parameters
        that refer to the reference temperature mean the same for both.
        """
        chosen: dict[str, Any] = {"reference": None}
        for column in _DTYPES:
            values = getattr(self, column)
            if values is not None:
                chosen[column] = values[rows]
        for mapping in ("conditions", "labels"):
            chosen[mapping] = {key: column[rows] for key, column in getattr(self, mapping).items()}
        if name is not None:
            chosen["name"] = name
        elif "temperature" in self.conditions:
            # The rows that are left would have another median, and shift factors another place
            # where they are one.
            chosen["reference"] = self.reference_temperature
        chosen["provenance"] = _of_rows(self.provenance, chosen["stiffness"])
        return replace(self, **chosen)

    def excluding(self, **unwanted: float | str) -> Measurement:
        """The data without some rows.

        Parameters
        ----------
        **unwanted : float or str
            Conditions that the rows to be left out have together, such as ``frequency="40..60"``
            (Hz) or ``row=3`` (the first row is 1); see `springpot.measurement.select`.

        Raises
        ------
        DataError
            If there is no such column or value, or nothing would be left.

        Examples
        --------
        >>> import springpot
        >>> data = springpot.read("artificial-hidden")
        >>> len(data), len(data.excluding(frequency="..1"))
        (40, 34)
        """
        return self.subset(
            rows_without(self, {name: str(value) for name, value in unwanted.items()})
        )

    def to_dataframe(self) -> Any:
        """The rows as a `pandas.DataFrame`, under the headings of a CSV file.

        Raises
        ------
        OptionError
            If pandas is not installed.
        """
        from .rows import dataframe

        return dataframe(self)

    def to_xarray(self) -> Any:
        """The rows as an `xarray.Dataset` along ``point``, conditions as coordinates.

        Raises
        ------
        OptionError
            If xarray is not installed.
        """
        from .rows import dataset

        return dataset(self)

    @classmethod
    def from_dataframe(cls, frame: Any) -> Measurement:
        """A measurement of a table whose headings are those of a CSV file: ``storage [kN/m]``.

        Parameters
        ----------
        frame : pandas.DataFrame
            With frequency or omega, storage and loss; columns of numbers are conditions, those of
            words labels.

        Raises
        ------
        DataError
            If a column or its unit is missing.
        """
        from .rows import arguments_of

        return cls(**arguments_of(frame))

    def in_units(self, units: Units) -> Measurement:
        """The same in the units of another test; frequencies are told as in its own file.

        Parameters
        ----------
        units : Units
            Of stiffness and amplitude.

        Raises
        ------
        DataError
            If one is of a stiffness and the other of a modulus.
        """
        stiffer = self.units.factor_to(units, self.name, "the other test")
        conditions = dict(self.conditions)
        if "amplitude" in conditions:
            longer = AMPLITUDE_UNITS[self.units.amplitude] / AMPLITUDE_UNITS[units.amplitude]
            conditions["amplitude"] = conditions["amplitude"] * longer
        sd = None
        if self.sd is not None:
            sd = self.sd * stiffer
        return replace(
            self,
            stiffness=self.stiffness * stiffer,
            sd=sd,
            conditions=conditions,
            units=replace(units, clock=self.units.clock, letter=self.units.letter),
        )

    def as_modulus(self, geometry: Geometry, unit: str = "Pa") -> Measurement:
        """The material that a specimen or damper of this geometry is made of.

        See `interface.as_modulus`.
        """
        return self._through(to_modulus(self, geometry, unit))

    def as_stiffness(
        self, geometry: Geometry, unit: str | None = None, amplitude: str | None = None
    ) -> Measurement:
        """A damper of this geometry, of the measured material; see `interface.as_stiffness`."""
        return self._through(to_stiffness(self, geometry, unit, amplitude))

    def _through(self, change: Conversion) -> Measurement:
        """The other side of a geometry."""
        # Other columns, such as the temperature, mean the same of the specimen and of its material.
        conditions = dict(self.conditions)
        if "amplitude" in conditions:
            conditions["amplitude"] = change.amplitude(conditions["amplitude"])
        sd = None
        if self.sd is not None:
            sd = change.stiffness(self.sd)
        return replace(
            self,
            stiffness=change.stiffness(self.stiffness),
            sd=sd,
            conditions=conditions,
            units=change.units,
            provenance={**self.provenance, "geometry": words_of(change.geometry)},
        )

    def digest(self) -> str:
        """SHA-256 of everything in it that a fit can see.

        By content and not by name or order of columns.
        """
        names = ("omega", "stiffness", "sd", "repeat", "harmonics", "reference")
        columns = {name: getattr(self, name) for name in names}
        columns |= {**self.conditions, **self.labels}
        return digest_of_columns(self.units, columns, alone=("omega",))

    def levels(self, name: str) -> NDArray[np.int64]:
        """Number (n,) of the level of a condition that each row belongs to, ascending.

        Neighbouring values that lie closer than a rig holds what was set are one level.
        """
        return held_levels(name, self.conditions[name])

    def sweeps(self, held: Collection[str] = CONDITIONS) -> Iterator[tuple[str, NDArray[np.int64]]]:
        """Labels and row numbers of the frequency sweeps, one per set of conditions and repeat.

        Parameters
        ----------
        held : collection of str
            Conditions that were held during a sweep.
        """
        columns = {
            name: self.conditions[name]
            for name in CONDITIONS
            if name in self.conditions and name in held
        }
        if self.repeat is not None:
            columns["repeat"] = self.repeat.astype(float)
        if not columns:
            yield "all", np.arange(len(self))
            return
        levels = (
            numbers_of_levels(column, HELD_OTHER * float(np.max(np.abs(column))))
            for column in columns.values()
        )
        for rows in rows_alike(*levels):
            means = (f"{name} {np.mean(column[rows]):.4g}" for name, column in columns.items())
            yield ", ".join(means), rows


def points_at(
    log_omega: Real, conditions: Mapping[str, Real], reference_temperature: float
) -> Points:
    """Points (n,) under conditions as a measurement has them, with temperatures in degC.

    The reference in kelvin.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.measurement import points_at
    >>> points_at(np.zeros(1), {"temperature": np.array([20.0])}, 293.15).temperature
    array([293.15])
    """
    kelvin = conditions.get("temperature")
    if kelvin is not None:
        kelvin = kelvin + KELVIN
    # Of any name: effects with a factor for each level ask for them.
    others = {name: column for name, column in conditions.items() if name not in CONDITIONS}
    return Points(log_omega, conditions.get("amplitude"), kelvin, reference_temperature, others)


def _holds_complex(values: ArrayLike) -> bool:
    """Whether a list new to NumPy holds complex numbers, or what is no number, told of later."""
    try:
        return np.asarray(values).dtype.kind not in "biuf"
    except (ValueError, TypeError):
        return True


def held_levels(name: str, column: Real) -> NDArray[np.int64]:
    """Number of the level of each value, ascending, for values that a rig holds only nearly."""
    x = column
    # How nearly an amplitude is held is a share of it: a step of the logarithm.
    if name == "amplitude":
        x = np.log(np.maximum(np.abs(column), SMALLEST))
    return numbers_of_levels(x, HELD.get(name, 0.0))


def numbers_of_levels(column: Real, apart: float) -> NDArray[np.int64]:
    """Number (n,) of the level of each value, in ascending order.

    Levels lie further apart than that.
    """
    order = np.argsort(column, kind="stable")
    number = np.zeros(len(column), dtype=np.int64)
    # Neighbour by neighbour: a drift within a level may add up to more than the distance of two.
    number[order[1:]] = np.cumsum(np.diff(column[order]) > apart)
    return number


def misspelt(condition: str) -> str:
    """What to say of a name that is nearly a known condition's, or nothing.

    Examples
    --------
    >>> from springpot.measurement import misspelt
    >>> misspelt("temprature").split(":")[0]
    "is nearly 'temperature'"
    """
    if condition in CONDITIONS or not condition.isalpha():  # temperature_2 is no slip
        return ""
    # A misspelt condition would be a column that no model knows, and its effect be missed without a
    # word.
    near = get_close_matches(condition.lower().rstrip("s"), CONDITIONS, n=1, cutoff=NEARLY)
    if not near:
        return ""
    known = " and ".join(CONDITIONS)
    return f"is nearly '{near[0]}': models know {known}; write that, or a plainly different name"


def _of_rows(provenance: Mapping[str, str], stiffness: Complex) -> dict[str, str]:
    """What is still true of some rows.

    A note on negative values only where one of them is negative.
    """
    kept = dict(provenance)
    if np.all(stiffness.real >= 0.0):
        kept.pop("note storage", None)
    if np.all(stiffness.imag >= 0.0):
        kept.pop("note loss", None)
    if 2 * np.sum((stiffness.real < 0.0) & (stiffness.imag < 0.0)) <= len(stiffness):
        kept.pop("note sign", None)
    return kept
