"""Parameters of a model: their names, bounds and units, and the coordinates of a search for them.

A unit is held as a *dimension* in terms of the measured stiffness ``K``, time and amplitude, not as
a fixed string, so that the same model fits a damper in kN/m and a fluid in Pa and prints the unit
that fits each.

Where one searches every parameter is a ratio to its natural size, so that all directions are alike;
one searched by its logarithm becomes ln(theta / size). A springpot's constant becomes the logarithm
of its stiffness at the reference frequency, c omega^alpha, which unlike c itself is all but
independent of alpha.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import inf
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError
from springpot.numerics import Complex, Real

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

    def size(self, stiffness: Any, time: Any, amplitude: Any, order: Any) -> Any:
        """How much one of it is where stiffness, time and amplitude are of these sizes.

        Parameters
        ----------
        stiffness, time, amplitude : float
            In the units of the data.
        order : float or ndarray
            The power of time, where another parameter tells it.

        Examples
        --------
        >>> from springpot.rheology import Dimension
        >>> Dimension(stiffness=1, time=2).size(400.0, 0.5, 1.0, 0.0)
        100.0
        """
        power = order if isinstance(self.time, str) else self.time
        return stiffness**self.stiffness * time**power * amplitude**self.amplitude


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


def box_of(parameters: Sequence[Parameter]) -> tuple[Real, Real]:
    """Lower and upper bounds (p,) of parameters."""
    return np.array([p.lower for p in parameters]), np.array([p.upper for p in parameters])


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

    @cached_property
    def box(self) -> tuple[Real, Real]:
        """Lower and upper bounds (p,) of theta."""
        return box_of(self.parameters)

    def named(self, theta: Real) -> dict[str, float]:
        """Values of a parameter vector (p,) by their names."""
        return dict(zip(self.names, theta.tolist(), strict=True))

    def picked(self, values: Mapping[str, float]) -> Real:
        """Parameter vector from a mapping that may hold more, such as those of a larger model."""
        return np.array([values[name] for name in self.names], dtype=float)

    def vector(self, values: Mapping[str, float]) -> Real:
        """Parameter vector from a mapping of names to values.

        Raises
        ------
        ModelError
            If a name is unknown or missing.
        """
        # A name too many is told before one that lacks: it is mostly the misspelt form of that one.
        known = set(self.names)
        unknown = [name for name in values if name not in known]
        if unknown:
            raise ModelError(
                f"{self.name} has no parameter '{unknown[0]}': it has {', '.join(self.names)}"
            )
        missing = [name for name in self.names if name not in values]
        if missing:
            raise ModelError(
                f"{self.name} needs a value of each parameter: {', '.join(missing)} missing"
            )
        return self.picked(values)


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


MARGIN = 1.01
"""The paper's repair of a violated kinf > k0: kinf becomes 1.01 k0 (section 4)."""


@dataclass(frozen=True)
class SearchForm:
    """Parameters to search in, with the exact map to the element parameters.

    Parameters
    ----------
    parameters : tuple of Parameter
        What is searched.
    to_elements : callable
        (..., q) to (..., p).
    jacobian : callable
        (..., q) to (..., p, q).
    from_elements : callable
        (..., p) to (..., q).
    ordered : tuple of int or None
        Indices (low, high) of two searched stiffnesses (or orders) of which the second must exceed
        the first.
    margin : float
        Where it does not, it becomes `margin` times the first: 1.01 in the paper, 1 for orders,
        which may be equal.
    """

    parameters: tuple[Parameter, ...]
    to_elements: Callable[[Real], Real]
    jacobian: Callable[[Real], Real]
    from_elements: Callable[[Real], Real]
    ordered: tuple[int, int] | None = None
    margin: float = MARGIN

    def repaired(self, x: Real) -> Real:
        """`x` with kinf = 1.01 k0 wherever kinf > k0 is violated (and likewise for orders)."""
        if self.ordered is None:
            return x
        low, high = self.ordered
        violated = x[..., high] <= x[..., low]
        # Most points keep the order: they are spared a copy.
        if not violated.any():
            return x
        mended = x.copy(order="K")
        mended[..., high] = np.where(violated, self.margin * x[..., low], x[..., high])
        return mended


def columns(*parts: Real | float) -> Real:
    """Parameter vectors (..., p) from their p components, each (...) or a number.

    Complex ones stay complex.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import columns
    >>> columns(np.array([1.0, 2.0]), 5.0)
    array([[1., 5.],
           [2., 5.]])
    """
    if not any(isinstance(part, np.ndarray) and part.ndim for part in parts):
        return np.array(parts) * 1.0
    # Each component lies side by side, as the elements take them.
    lead = np.broadcast_shapes(*(np.shape(part) for part in parts))
    x = np.empty((len(parts), *lead), np.result_type(float, *parts))
    for component, part in zip(x, parts, strict=True):
        component[...] = part
    return x.transpose(*range(1, x.ndim), 0)


def components(x: Real) -> Real:
    """The components (p, ...) of parameter vectors (..., p)."""
    # By hand, for `moveaxis` takes longer than an element.
    return x.transpose(-1, *range(x.ndim - 1))


def rows(*parts: Real) -> Real:
    """Jacobian (..., p, q) from its p rows (..., q).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import rows
    >>> rows(np.array([1.0, 0.0]), np.array([2.0, 3.0]))
    array([[1., 0.],
           [2., 3.]])
    """
    # Mostly they are alike: to broadcast takes longer than to join them.
    if len({part.shape for part in parts}) > 1:
        return np.stack(np.broadcast_arrays(*parts), axis=-2)
    return np.stack(parts, axis=-2)


# The maps are functions of the module, so that a fit of a model that has one can be pickled.


def _time_to_elements(x: Real) -> Real:
    k, tau, alpha = components(x)
    # The springpot is as stiff as the spring at omega = 1 / tau: (c / k) = tau^alpha.
    return columns(k, k * tau**alpha, alpha)


def _time_jacobian(x: Real) -> Real:
    k, tau, alpha = components(x)
    power = tau**alpha
    c = k * power
    one, nil = np.ones_like(k), np.zeros_like(k)
    return rows(
        columns(one, nil, nil),
        columns(power, alpha * c / tau, c * np.log(tau)),
        columns(nil, nil, one),
    )


def _time_from_elements(theta: Real) -> Real:
    k, c, alpha = components(theta)
    return columns(k, (c / k) ** (1.0 / alpha), alpha)


def _maxwell_to_elements(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    return columns(k0, kinf - k0, tau**alpha * (kinf - k0), alpha)


def _maxwell_jacobian(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    power = tau**alpha
    c = power * (kinf - k0)
    one, nil = np.ones_like(k0), np.zeros_like(k0)
    return rows(
        columns(one, nil, nil, nil),
        columns(-one, one, nil, nil),
        columns(-power, power, alpha * c / tau, c * np.log(tau)),
        columns(nil, nil, nil, one),
    )


def _maxwell_from_elements(theta: Real) -> Real:
    k1, k2, c, alpha = components(theta)
    return columns(k1, k1 + k2, (c / k2) ** (1.0 / alpha), alpha)


def _kelvin_to_elements(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    gap = kinf - k0
    return columns(kinf, k0 * kinf / gap, tau**alpha * kinf**2 / gap, alpha)


def _kelvin_jacobian(x: Real) -> Real:
    k0, kinf, tau, alpha = components(x)
    gap = kinf - k0
    power = tau**alpha
    c = power * kinf**2 / gap
    one, nil = np.ones_like(k0), np.zeros_like(k0)
    return rows(
        columns(nil, one, nil, nil),
        columns((kinf / gap) ** 2, -((k0 / gap) ** 2), nil, nil),
        columns(c / gap, power * kinf * (kinf - 2 * k0) / gap**2, alpha * c / tau, c * np.log(tau)),
        columns(nil, nil, nil, one),
    )


def _kelvin_from_elements(theta: Real) -> Real:
    k1, k2, c, alpha = components(theta)
    return columns(k1 * k2 / (k1 + k2), k1, (c / (k1 + k2)) ** (1.0 / alpha), alpha)


def _limits() -> tuple[Parameter, ...]:
    return (stiffness("k0", "k₀"), stiffness("kinf", "k∞"), relaxation_time(), order())


@dataclass(frozen=True)
class _Limits:
    """The maps of `limits_form` for p parameters."""

    count: int

    def to_elements(self, x: Real) -> Real:
        return columns(x[..., 0], x[..., 1] - x[..., 0], *np.moveaxis(x[..., 2:], -1, 0))

    def jacobian(self, x: Real) -> Real:
        step = np.eye(self.count)
        step[1, 0] = -1.0
        return np.broadcast_to(step, (*x.shape[:-1], *step.shape))

    def from_elements(self, theta: Real) -> Real:
        return columns(
            theta[..., 0], theta[..., 0] + theta[..., 1], *np.moveaxis(theta[..., 2:], -1, 0)
        )


def limits_form(parameters: tuple[Parameter, ...]) -> SearchForm:
    """The form (k0, kinf, ...) of a model whose parameters are (k0, k1, ...) with kinf = k0 + k1.

    Parameters
    ----------
    parameters : tuple of Parameter
        The model's; all but the second are searched as they are.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import limits_form, stiffness
    >>> limits_form((stiffness("k0"), stiffness("k1"))).to_elements(np.array([2.0, 5.0]))
    array([2., 3.])
    """
    searched = (*_limits()[:2], *parameters[2:])
    maps = _Limits(len(parameters))
    return SearchForm(searched, maps.to_elements, maps.jacobian, maps.from_elements, ordered=(0, 1))


TIME_FORM = SearchForm(
    (stiffness("k"), relaxation_time(), order()),
    _time_to_elements,
    _time_jacobian,
    _time_from_elements,
)
"""(k, tau, alpha) of the three-parameter models, tau^alpha = c / k; eq. (20), (21), (33)."""
MAXWELL_FORM = SearchForm(
    _limits(), _maxwell_to_elements, _maxwell_jacobian, _maxwell_from_elements, ordered=(0, 1)
)
"""(k0, kinf, tau, alpha) of the Maxwell type: k1 = k0, k2 = kinf - k0, c = tau^alpha k2; eq.

(9), (35).
"""
KELVIN_FORM = SearchForm(
    _limits(), _kelvin_to_elements, _kelvin_jacobian, _kelvin_from_elements, ordered=(0, 1)
)
"""(k0, kinf, tau, alpha) of the Kelvin type, inverse of eq. (6), (34)."""


Slopes = TypeVar("Slopes", Real, Complex)
WIDEST = 12.0 * float(np.log(10.0))
"""A parameter twelve decades from its natural size leaves no trace in the data."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The map between a model's parameters and the coordinates of the native solver.

    Parameters
    ----------
    parameters : sequence of Parameter
        The model's parameters.
    size : ndarray, shape (B, p)
        Natural size for each data set, without the power of time of a fractional order.
    log : ndarray of bool, shape (p,)
        Which are searched by their logarithm.
    pairs : tuple of (int, int)
        Positions of each constant whose unit holds a fractional order, and of that order.
    log_omega : float
        Logarithm of the reference frequency.
    amplitude : float
        Typical amplitude.
    """

    parameters: tuple[Parameter, ...]
    size: Real
    log: NDArray[np.bool_]
    pairs: tuple[tuple[int, int], ...]
    log_omega: float
    amplitude: float = 1.0

    @classmethod
    def of(
        cls,
        parameters: Sequence[Parameter],
        log_omega: float,
        stiffness: Real,
        amplitude: float = 1.0,
    ) -> Coordinates:
        """Coordinates for data of these sizes.

        Parameters
        ----------
        parameters : sequence of Parameter
            The model's parameters, length p.
        log_omega : float
            Mean logarithm of the angular frequencies.
        stiffness : ndarray, shape (B,)
            Typical |K| of each data set.
        amplitude : float
            Typical amplitude.
        """
        # Remembered for each model: a study fits one to thousands of data sets.
        layout = _layout(tuple(parameters))
        return cls(
            tuple(parameters),
            layout.sizes(log_omega, stiffness, amplitude),
            layout.log,
            layout.pairs,
            log_omega,
            amplitude,
        )

    def at_unit_stiffness(self) -> Coordinates:
        """The same for data whose typical |K| is 1, shape (1, p)."""
        size = _layout(self.parameters).sizes(self.log_omega, np.ones(1), self.amplitude)
        return replace(self, size=size)

    def rows(self, which: NDArray[np.intp]) -> Coordinates:
        """Those of some of the data sets."""
        return replace(self, size=self.size[which])

    def theta(self, u: Real, size: Real) -> Real:
        """Parameters (..., p) at `u` (..., p), the sizes being `size` (..., p)."""
        # A trial may overflow: it then has no finite objective and is taken back.
        with np.errstate(over="ignore"):
            theta: Real = np.where(self.log, np.exp(u), u) * size
            for constant, order in self.pairs:
                theta[..., constant] *= np.exp(-self.log_omega * theta[..., order])
        return theta

    def u(self, theta: Real, size: Real) -> Real:
        """Search coordinates (..., p) of the parameters `theta` (..., p)."""
        ratio = theta / size
        for constant, order in self.pairs:
            ratio[..., constant] *= np.exp(self.log_omega * theta[..., order])
        # Zero has no logarithm: it is put further down than any search goes.
        tiny = np.exp(-2.0 * WIDEST)
        return np.where(self.log, np.log(np.where(self.log, np.maximum(ratio, tiny), 1.0)), ratio)

    def carry(self, by_theta: Slopes, theta: Real, size: Real) -> Slopes:
        """Turn derivatives by theta (..., p, m) into those by u, in place."""
        for constant, order in self.pairs:
            # The coordinate of c stands still while the order moves: c itself then has to follow,
            # as omega^-alpha.
            drift = -self.log_omega * theta[..., constant, None]
            by_theta[..., order, :] += drift * by_theta[..., constant, :]
        # d theta / du is theta itself of a logarithm, and the size of a ratio.
        by_theta *= np.where(self.log, theta, size)[..., None]
        return by_theta

    def slopes(self, theta: Real, size: Real) -> Real:
        """Derivative of theta by u at one point, shape (p, p)."""
        return self.carry(np.eye(len(theta)), theta, size).T

    @cached_property
    def bounds(self) -> tuple[Real, Real]:
        """Lower and upper u for each data set, shape (B, p).

        Half-open ones end twelve decades from the natural size.
        """
        lower, upper = (end / self.size for end in box_of(self.parameters))
        with np.errstate(divide="ignore", invalid="ignore"):
            low = np.where(self.log, np.log(np.maximum(lower, 0.0)), lower)
            high = np.where(self.log, np.log(np.maximum(upper, 0.0)), upper)
        # A range with two ends is searched to both of them.
        ended = ~self.log.astype(bool) | (np.isfinite(low) & np.isfinite(high))
        low = np.where(ended, low, np.maximum(low, -WIDEST))
        return low, np.where(ended, high, np.minimum(high, WIDEST))


@dataclass(frozen=True, eq=False)
class _Layout:
    """What a model's parameters say about its coordinates, whatever the data."""

    base: Real
    powers: Real
    log: NDArray[np.bool_]
    pairs: tuple[tuple[int, int], ...]

    def sizes(self, log_omega: float, stiffness: Real, amplitude: float) -> Real:
        """Natural sizes (B, p) of the parameters of data with these |K| (B,)."""
        ends = np.array([-log_omega, np.log(amplitude)])
        # A product of powers of |K|, time and amplitude, by its logarithm.
        logs = np.log(stiffness)[:, None] * self.powers[0] + ends @ self.powers[1:]
        sizes: Real = np.exp(logs) * self.base
        return sizes


@lru_cache(maxsize=256)
def _layout(parameters: tuple[Parameter, ...]) -> _Layout:
    names = {parameter.name: i for i, parameter in enumerate(parameters)}
    pairs = tuple((i, names[p.unit.time]) for i, p in enumerate(parameters) if p.unit.time in names)
    sized = [_size(p) for p in parameters]
    return _Layout(
        np.array([size[0] for size in sized]),
        np.array([size[1:] for size in sized]).reshape(-1, 3).T,
        np.array([p.scale == "log" for p in parameters]),
        pairs,
    )


def _size(parameter: Parameter) -> tuple[float, float, float, float]:
    """Natural size as a factor and powers of |K|, time and amplitude."""
    if parameter.scale == "linear" and np.isfinite(parameter.upper - parameter.lower):
        # What has two ends, such as an order, is measured by the way between them, whatever the
        # data.
        return parameter.upper - parameter.lower, 0.0, 0.0, 0.0
    unit = parameter.unit
    # A power of time that is itself a parameter is dealt with where its value is known: see
    # `pairs`.
    time = 0.0
    if not isinstance(unit.time, str):
        time = float(unit.time)
    return parameter.typical, float(unit.stiffness), time, float(unit.amplitude)
