"""Another test than those of a fit: how it is asked for, and what of it the tests covered.

Beyond what they covered, in frequency, temperature and amplitude, a model is an extrapolation.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.rheology.points import KELVIN, ROOM, Real, held

from .measurement import CONDITIONS, Measurement
from .timetest import TimeTest
from .units import AMPLITUDE_UNITS, Units

if TYPE_CHECKING:
    from springpot.rheology.intime import Traced
    from springpot.rheology.model import Model


@dataclass(frozen=True, eq=False, kw_only=True)
class OtherTest(ABC):
    """What was measured in a test, and what a model says of it: all that a new kind has to tell.

    Identified, diagnosed, discovered, compared and drawn like every other test, alone or beside
    others of the same specimen. A reader of tests in time returns it; see docs/plugins.md.

    Parameters
    ----------
    name : str
        Shown in reports.
    units : Units
        Of the stiffness that it tells of.
    temperature : float, optional
        In degC.
    provenance : mapping of str to str
        Where the data come from.
    marks : mapping of str to float
        Further conditions by name, such as the number of the specimen.

    Attributes
    ----------
    kind : str
        What such a test is called.
    control : {"frequency", "displacement", "force"}
        What was imposed: effects of the same control apply to it.
    quantity, unit, clock : str
        What its numbers are, in which unit, and what they stand over.
    """

    kind: ClassVar[str]
    control: ClassVar[str] = "frequency"
    quantity: ClassVar[str]
    unit: ClassVar[str] = "-"
    clock: ClassVar[str] = "f [Hz]"

    name: str = "test"
    units: Units = field(default_factory=Units)
    temperature: float | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)
    marks: Mapping[str, float] = field(default_factory=dict)

    @property
    @abstractmethod
    def at(self) -> Real:
        """Where each number (m,) was measured: frequency in Hz, or time in s."""

    @property
    @abstractmethod
    def measured(self) -> Real:
        """The numbers (m,)."""

    @property
    @abstractmethod
    def sd(self) -> Real:
        """Their standard deviations (m,)."""

    @property
    @abstractmethod
    def stiffness(self) -> float:
        """Typical |K|, from which searches begin."""

    @abstractmethod
    def answer(self, model: Model, theta: Real, reference: float) -> Traced:
        """What a model says of the numbers (m,), with derivatives by its parameters (m, p)."""

    @abstractmethod
    def subset(self, rows: NDArray[np.bool_]) -> Self:
        """The same with some of its rows alone."""

    def __len__(self) -> int:
        return len(self.at)

    @property
    def seen(self) -> tuple[float, float]:
        """Angular frequencies in rad/s between which it tells of the specimen."""
        at = self.at[self.at > 0.0]
        if self.control == "frequency":
            return 2.0 * np.pi * float(at.min()), 2.0 * np.pi * float(at.max())
        return 1.0 / float(at.max()), 1.0 / float(at.min())

    @property
    def reach(self) -> float:
        """Largest displacement, nothing where it is not known."""
        return 0.0

    @property
    def reference_temperature(self) -> float:
        """Its temperature in kelvin, that of a room where it is not known."""
        if self.temperature is None:
            return ROOM
        return self.temperature + KELVIN

    @property
    def conditions(self) -> dict[str, Real]:
        """What was set beside the load, of each number (m,): its temperature in degC."""
        found = {name: np.full(len(self.at), value) for name, value in self.marks.items()}
        if self.temperature is not None:
            found["temperature"] = np.full(len(self.at), self.temperature)
        return found

    @property
    def labels(self) -> Mapping[str, NDArray[np.str_]]:
        """Columns of words: none stands beside the numbers."""
        return {}

    @property
    def columns(self) -> dict[str, Real]:
        """The numbers (n,) by which rows are chosen."""
        return {"row": np.arange(1.0, len(self) + 1.0), **self.conditions}

    def in_units(self, units: Units) -> Self:
        """The same in the units of another test of the specimen.

        Raises
        ------
        DataError
            If these are others: a kind that can be converted says how.
        """
        if units.stiffness == self.units.stiffness:
            return self
        raise DataError(
            f"{self.name} tells of {self.units.stiffness} and the other test of {units.stiffness}:"
            " give both in one unit"
        )


ROUNDED = 1.001
"""Factor by which a frequency may lie outside and still be a measured one.

Numbers are typed with few digits.
"""
RATE = "frequency"


@dataclass(frozen=True)
class Covered:
    """Ranges of what was measured.

    Parameters
    ----------
    rate : tuple of float
        Angular frequency in rad/s, or one over the time in s since the load moved; from nothing to
        infinity where nothing was measured.
    conditions : mapping of str to tuple of float
        Temperature in degC, amplitude in the unit of the tests, others by name; those alone that
        are known.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement.covered import Covered
    >>> conditions = {"temperature": [20.0, 20.0]}
    >>> data = Measurement([1.0, 10.0], [1.0 + 1j, 2.0 + 1j], conditions=conditions)
    >>> Covered.of([data]).outside(np.array([5.0, 50.0]), {}).tolist()
    [False, True]
    """

    rate: tuple[float, float] = (0.0, np.inf)
    conditions: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @classmethod
    def of(
        cls, tests: Sequence[TimeTest | Measurement | OtherTest], units: Units | None = None
    ) -> Covered:
        """Of tests that one model was fitted to, amplitudes in these units, or the first's."""
        rates: list[float] = []
        columns: dict[str, list[Real]] = {}
        unit = AMPLITUDE_UNITS[(units or tests[0].units).amplitude]
        for test in tests:
            rates += test.seen
            for name, column in _conditions_of(test).items():
                factor = 1.0
                if name == "amplitude":
                    factor = AMPLITUDE_UNITS[test.units.amplitude] / unit
                columns.setdefault(name, []).append(factor * column[np.isfinite(column)])
        together = {name: np.concatenate(parts) for name, parts in columns.items()}
        ends = {name: (float(c.min()), float(c.max())) for name, c in together.items() if len(c)}
        return cls((min(rates), max(rates)), ends)

    def beyond(
        self, omega: Real, conditions: Mapping[str, Real], room: float = ROUNDED
    ) -> dict[str, NDArray[np.bool_]]:
        """Which points (n,) lie outside, by the name of what lies outside.

        Names of none are left out.

        Parameters
        ----------
        omega : ndarray, shape (n,)
            In rad/s.
        conditions : mapping of str to ndarray
            As in `Measurement`, one value or n.
        room : float
            Factor by which a frequency may lie outside and still be one of those measured.
        """
        low, high = self.rate
        found = {RATE: (omega < low / room) | (omega > high * room)}
        for name, column in conditions.items():
            if name in self.conditions:
                ends = np.array(self.conditions[name])
                least, most = ends + held(name, ends) * np.array([-1.0, 1.0])
                outside = (column < least) | (column > most)
                found[name] = np.broadcast_to(outside, omega.shape)
        return {name: mask for name, mask in found.items() if mask.any()}

    def outside(
        self, omega: Real, conditions: Mapping[str, Real], room: float = ROUNDED
    ) -> NDArray[np.bool_]:
        """Whether each point (n,) lies outside in anything; see `beyond`."""
        masks = self.beyond(omega, conditions, room).values()
        return np.asarray(np.any([np.zeros(omega.shape, dtype=bool), *masks], axis=0))

    def remark(
        self,
        omega: Real,
        conditions: Mapping[str, Real],
        units: Units,
        room: float = ROUNDED,
        of: str = "points",
    ) -> str:
        """One line on the points (or modes, ...) that lie outside; nothing where all are inside."""
        beyond = self.beyond(omega, conditions, room)
        if not beyond:
            return ""
        count = int(np.any(list(beyond.values()), axis=0).sum())
        said = " and ".join(self.span(name, units) for name in beyond)
        return (
            f"beyond the measured {said} ({count} of {len(omega)} {of}) the band holds only if"
            " the model does"
        )

    def span(self, name: str, units: Units) -> str:
        """The range of a condition or of the frequency, with its unit."""
        if name == RATE:
            low, high = (rate / (2.0 * np.pi) for rate in self.rate)
            return f"{units.on_clock(low):.3g} to {units.at(high)}"
        low, high = self.conditions[name]
        return f"{name} of {between(low, high)} [{units.of_condition(name)}]"

    def told(self, units: Units) -> str:
        """All ranges that effects may need, in one line."""
        known = [name for name in CONDITIONS if name in self.conditions]
        return ", ".join(self.span(name, units) for name in (RATE, *known))

    def to_dict(self) -> dict[str, Any]:
        """As plain data: ends of each range, the frequency in rad/s.

        Without those of nothing measured.
        """
        ranges = {name: list(ends) for name, ends in self.conditions.items()}
        # JSON has no word for infinity.
        if np.isfinite(self.rate[1]):
            ranges["omega"] = list(self.rate)
        return ranges

    @classmethod
    def read(cls, kept: Mapping[str, Any]) -> Covered:
        """What `to_dict` gave."""
        ends = {name: (float(low), float(high)) for name, (low, high) in kept.items()}
        if "omega" in ends and not 0.0 < ends["omega"][0] <= ends["omega"][1]:
            raise ValueError(f"frequencies from {between(*ends['omega'])} rad/s are none")
        return cls(ends.pop("omega", (0.0, np.inf)), ends)


def between(low: float, high: float) -> str:
    """A range in words; one number where its ends are the same as printed."""
    ends = dict.fromkeys([f"{low:.4g}", f"{high:.4g}"])
    return " to ".join(ends)


def _conditions_of(test: TimeTest | Measurement | OtherTest) -> dict[str, Real]:
    """Temperature and amplitude of a test, and the further columns of a sweep."""
    if not isinstance(test, TimeTest):
        return dict(test.conditions)
    found = {name: np.array([value]) for name, value in test.marks.items()}
    # The answer to a step is often written for a step of one, whatever it was in truth.
    if test.control == "displacement" and test.kind not in ("relaxation", "recovery"):
        found["amplitude"] = np.array([0.0, np.abs(test.loading.value).max()])
    if test.temperature is not None:
        found["temperature"] = np.array([test.temperature])
    if test.warmth is not None:
        found["temperature"] = test.warmth
    return found
