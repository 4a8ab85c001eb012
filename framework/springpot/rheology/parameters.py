"""Parameters of a model: their names, bounds and units.

A unit is held as a *dimension* in terms of the measured stiffness ``K``, time and amplitude, not as
a fixed string, so that the same model fits a damper in kN/m and a fluid in Pa and prints the unit
that fits each.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Literal, TypeAlias

import numpy as np

from springpot.errors import ModelError

from .points import Real

Scale = Literal["log", "linear"]
Exponent: TypeAlias = tuple[tuple[str, float], ...]
"""A power as a sum: ``(("", 1), ("n", -1))`` is 1 - n."""


@dataclass(frozen=True, slots=True)
class Dimension:
    """Powers of the measured stiffness, of time and of the amplitude that make a parameter's unit.

    Parameters
    ----------
    stiffness : float
        Power of the unit of the measured stiffness or modulus.
    time : float or str
        Power of the second, or the name of the parameter (a fractional order) that is this power.
    amplitude : float
        Power of the unit of the measured amplitude.
    label : str
        A fixed unit such as ``"kJ/mol"`` or ``"K"``, for what has no such powers.
    beyond : tuple of (str, Exponent)
        Further units with their powers: a kelvin, a column of the data by its name, and a
        stiffness, time or amplitude to a power that a parameter decides. What they come to in the
        data is in the parameter's typical size.

    Examples
    --------
    >>> from springpot import Units
    >>> from springpot.rheology import Dimension
    >>> Units("kN/m", "mm").of(Dimension(stiffness=1, time=2))
    (1000.0, 'kg')
    >>> Units("Pa").of(Dimension(stiffness=1, time=1))
    (1.0, 'Pa s')
    """

    stiffness: float = 0
    time: float | str = 0
    amplitude: float = 0
    label: str = ""
    beyond: tuple[tuple[str, Exponent], ...] = ()


STIFFNESS = Dimension(stiffness=1)
VISCOSITY = Dimension(stiffness=1, time=1)
INERTANCE = Dimension(stiffness=1, time=2)
FORCE = Dimension(stiffness=1, amplitude=1)
AMPLITUDE = Dimension(amplitude=1)
SECOND = Dimension(time=1)
RADIAN_PER_SECOND = Dimension(time=-1)
PURE = Dimension()


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a model.

    Parameters
    ----------
    name : str
        What users type, such as ``"k"`` or ``"inertia.m"``.
    symbol : str
        What is printed in formulas.
    unit : Dimension
        The unit in powers of stiffness, time and amplitude.
    lower, upper : float
        Bounds that a result never leaves.
    scale : {"log", "linear"}
        Whether the parameter is searched by its logarithm (positive, of unknown size) or as it is.
    typical : float
        Size in the natural unit of the data; starts are drawn around it.
    detail : bool
        Whether it is one of many that are told as a whole, such as a line of a spectrum, and left
        out of lists.

    Examples
    --------
    >>> from springpot.rheology import Parameter
    >>> Parameter("k", "k").renamed("mount.k").name
    'mount.k'
    """

    name: str
    symbol: str
    unit: Dimension = PURE
    lower: float = 0.0
    upper: float = inf
    scale: Scale = "log"
    typical: float = 1.0
    detail: bool = False

    @property
    def is_order(self) -> bool:
        """Whether it is a fractional order.

        A pure number from 0 to 1, which is no share told by its logarithm.
        """
        return (
            self.unit == PURE and self.scale == "linear" and (self.lower, self.upper) == (0.0, 1.0)
        )

    def renamed(self, name: str) -> Parameter:
        """The same parameter under another name; an order named in its unit moves along."""
        unit = self.unit
        if isinstance(unit.time, str):
            # The order belongs to the same part, and has its prefix.
            prefix, dot, _ = name.rpartition(".")
            unit = replace(unit, time=f"{prefix}{dot}{unit.time}")
        return replace(self, name=name, unit=unit)


class HasParameters(ABC):
    """What has parameters in a fixed order, which is that of theta.

    A model of sweeps or of tests in time.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """The expression that names it."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters in the order of theta."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The parameters' names in the order of theta."""
        return tuple(parameter.name for parameter in self.parameters)

    def vector(self, values: Mapping[str, float]) -> Real:
        """Parameter vector from a mapping of names to values.

        Raises
        ------
        ModelError
            If a name is unknown or missing.
        """
        # A name too many is told before one that lacks: it is mostly the misspelt form of that one.
        unknown = [name for name in values if name not in self.names]
        if unknown:
            raise ModelError(
                f"{self.name} has no parameter '{unknown[0]}': it has {', '.join(self.names)}"
            )
        missing = [name for name in self.names if name not in values]
        if missing:
            raise ModelError(
                f"{self.name} needs a value of each parameter: {', '.join(missing)} missing"
            )
        return np.array([values[name] for name in self.names], dtype=float)


def order(name: str = "alpha", symbol: str = "α") -> Parameter:
    """A fractional order, bounded to [0, 1]: beyond 1 it would pass inertia off as material.

    Examples
    --------
    >>> from springpot.rheology import order
    >>> order().lower, order().upper
    (0.0, 1.0)
    """
    # Not by its logarithm: zero is an order like any other, that of a spring.
    return Parameter(name, symbol, PURE, 0.0, 1.0, "linear", 0.5)


def stiffness(name: str = "k", symbol: str = "k") -> Parameter:
    """A positive spring stiffness or modulus.

    Examples
    --------
    >>> from springpot.rheology import stiffness
    >>> stiffness("k1").scale
    'log'
    """
    return Parameter(name, symbol, STIFFNESS)


def viscosity(name: str = "c", symbol: str = "c") -> Parameter:
    """A positive dashpot constant.

    Examples
    --------
    >>> from springpot import Units
    >>> from springpot.rheology import viscosity
    >>> Units("kN/m", "mm").of(viscosity().unit)
    (1.0, 'kN s/m')
    """
    return Parameter(name, symbol, VISCOSITY)


def quasi_property(name: str = "c", order_name: str = "alpha", symbol: str = "c") -> Parameter:
    """A springpot's constant, in stiffness times second to the power of its order.

    Examples
    --------
    >>> from springpot import Units
    >>> from springpot.rheology import quasi_property
    >>> Units("kN/m", "mm").of(quasi_property().unit)
    (1.0, 'kN s^alpha/m')
    """
    return Parameter(name, symbol, Dimension(stiffness=1, time=order_name))


def relaxation_time(name: str = "tau", symbol: str = "τ") -> Parameter:
    """A positive relaxation or retardation time.

    Examples
    --------
    >>> from springpot import Units
    >>> from springpot.rheology import relaxation_time
    >>> Units("Pa").of(relaxation_time().unit)
    (1.0, 's')
    """
    return Parameter(name, symbol, SECOND)
