"""A test of a further kind: neither a sweep of stiffness nor an answer against time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.rheology.points import KELVIN, ROOM, Real

from .units import Units

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
