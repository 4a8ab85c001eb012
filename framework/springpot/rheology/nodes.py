"""The algebra: a network node gives its complex stiffness and the exact derivatives of it.

Leaves are elements (see `elements`); inner nodes are the four compositions, each of which adds up
in one plane: parallel in K, series in 1/K, chain in ln K, shift in ln omega.

The inertia of a specimen is a shear wave that crosses it, of mass m and quasi-static stiffness K.
With z^2 = m omega^2 / K (that is, omega h sqrt(rho / G)), the force at the moving side is K z cot z
and at the fixed side K z / sin z. Both are functions of u = -E / K alone, where E = -m omega^2 is
the mass element.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np

from .parameters import Parameter
from .points import Complex, Points, Real

VALUE, GRADIENT, FULL = 0, 1, 2
_ABSENT: Complex = np.empty(0, dtype=complex)


class Response(NamedTuple):
    """Complex stiffness with its derivatives; what was not asked for is empty.

    Attributes
    ----------
    value : ndarray, shape (..., n)
        Complex stiffness K.
    by_theta : ndarray, shape (..., p, n)
        dK/dtheta for each of the p parameters.
    by_log_omega : ndarray, shape (..., n)
        dK / d ln omega.
    """

    value: Complex
    by_theta: Complex = _ABSENT
    by_log_omega: Complex = _ABSENT


def repeated(column: Complex, frequencies: tuple[int, ...]) -> Complex:
    """The same numbers (..., 1) at all frequencies (..., n).

    Of many points it is a view, which takes no memory.
    """
    if len(frequencies) > 1:
        return np.broadcast_to(column, np.broadcast_shapes(column.shape, frequencies))
    # A single point is what most optimisers ask for: to write its few numbers is six times as quick
    # as a view.
    if column.ndim == 1:
        return column.repeat(frequencies[0])
    return np.broadcast_to(column, (*column.shape[:-1], frequencies[0]))


def _whole(storage: Real, loss: Real) -> Complex:
    """K of its parts, which may be those of a spring: a column, and nothing."""
    whole = np.empty_like(storage, dtype=complex)
    whole.real, whole.imag = storage, loss
    return whole


def _together(a: Complex, b: Complex) -> Complex:
    """Stiffness of two parts in series, a b / (a + b).

    A complex division takes as long as eight products.

    The quotient comes first, so that no product of two large or two small numbers leaves the range.
    """
    both = a + b
    # In place: this runs at every evaluation of a search, and a table of its own for each step
    # would cost as much.
    np.divide(b, both, out=both)
    both *= a
    return both


class Node:
    """A part of a network: an element or a composition of nodes."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters in the order in which `respond` takes them."""
        raise AssertionError(f"{type(self).__name__} does not say its parameters")

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """Evaluate the node.

        Parameters
        ----------
        theta : ndarray, shape (..., p)
            Parameters; leading axes are evaluated side by side.
        at : Points
            Frequencies and conditions of the n points.
        depth : {VALUE, GRADIENT, FULL}
            Value only, with dK/dtheta, or with dK/d ln omega as well.
        """
        raise AssertionError(f"{type(self).__name__} does not respond")

    def parts(self, theta: Real, at: Points) -> tuple[Real, Real]:
        """K' and K'' of many parameters (m, p), which broadcast with (m, n).

        The same numbers as those of `respond`, apart: a search reads each by itself.
        """
        value = self.respond(theta, at).value
        return value.real, value.imag

    @property
    def needs(self) -> frozenset[str]:
        """Condition columns (such as "amplitude") without which the node cannot be evaluated."""
        return frozenset()

    @property
    def absent_at(self) -> float | None:
        """Where its first parameter makes it vanish, if it is one that knows."""
        return None

    def bound_to(self, at: Points) -> Node:
        """The node with what it takes from the data, such as levels; mostly itself."""
        return self

    def within(self, theta: Real) -> tuple[Real, Node]:
        """The node that this one stands for, with that node's parameters.

        An element stands for itself.
        """
        return theta, self

    @property
    def released(self) -> Node:
        """The node with all its parameters free, within the bounds of physics; mostly itself."""
        return self

    @property
    def held(self) -> dict[str, float]:
        """Parameters of the `released` node that are held at a value, by name; mostly none."""
        return {}

    @property
    def origins(self) -> tuple[str, ...]:
        """For each parameter its name in the `released` node."""
        return tuple(parameter.name for parameter in self.parameters)

    def with_prefix(self, prefix: str) -> Node:
        """The node with every parameter name preceded by `prefix` and a dot."""
        # Wrapped and not copied: an element of a plugin need know nothing of prefixes.
        return Renamed(self, prefix)


@dataclass(frozen=True)
class Renamed(Node):
    """A node whose parameters carry the name of the effect they belong to."""

    node: Node
    prefix: str

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        return tuple(p.renamed(f"{self.prefix}.{p.name}") for p in self.node.parameters)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters, each with the prefix."""
        return self._parameters

    @property
    def needs(self) -> frozenset[str]:
        """What the inner node needs."""
        return self.node.needs

    def within(self, theta: Real) -> tuple[Real, Node]:
        """The inner node, whose parameters have the same values."""
        return theta, self.node

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The inner node's response: names change nothing."""
        return self.node.respond(theta, at, depth)

    def parts(self, theta: Real, at: Points) -> tuple[Real, Real]:
        """Those of the inner node."""
        return self.node.parts(theta, at)


@dataclass(frozen=True)
class Composition(Node):
    """Nodes put together; theta is the concatenation of theirs.

    Attributes
    ----------
    plane : str
        What adds up: ``stiffness``, ``compliance``, ``log-complex`` or ``shift``. In this plane a
        missing node shows.
    symbol, unit : str
        How a residual in this plane is written; ``{}`` stands for the unit of K.
    shows : str
        What is simple in this plane.
    order : int
        Which of two effects of one layer joins first: the lower one.
    flat : bool
        Whether nodes nested in one of its own kind are the same as those side by side.
    """

    children: tuple[Node, ...]
    plane: ClassVar[str] = "stiffness"
    symbol: ClassVar[str] = "ΔK"
    unit: ClassVar[str] = "{}"
    shows: ClassVar[str] = "what is missing in parallel"
    order: ClassVar[int] = 0
    flat: ClassVar[bool] = False

    @classmethod
    def of(cls, nodes: Sequence[Node]) -> Node:
        """The nodes put together; one alone is itself."""
        children: list[Node] = []
        for node in nodes:
            # Parallel within parallel is one row of parts; a chain within a chain is not, as its
            # order counts.
            if cls.flat and isinstance(node, cls):
                children.extend(node.children)
            else:
                children.append(node)
        if len(children) == 1:
            return children[0]
        return cls(tuple(children))

    @classmethod
    def label(cls, stiffness: str) -> str:
        """Of an axis of residuals, such as ``ΔK [kN/m]``; `stiffness` is the unit of K."""
        return f"{cls.symbol} [{cls.unit.format(stiffness)}]"

    @staticmethod
    def residual(measured: Complex, modelled: Response) -> Complex:
        """What is missing in this plane, measured minus modelled; both of shape (n,)."""
        return measured - modelled.value

    @staticmethod
    def slope(modelled: Response) -> Complex:
        """Change of K (n,) for a unit of what adds up in this plane."""
        return np.ones_like(modelled.value)

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        # Children in their order: theta is what they take, one after the other.
        parameters: list[Parameter] = []
        for child in self.children:
            parameters += child.parameters
        return tuple(parameters)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters of all children in order."""
        return self._parameters

    @cached_property
    def cuts(self) -> tuple[slice, ...]:
        """Where each child's parameters stand in theta."""
        # Asked at every evaluation, and the same each time: worked out once.
        ends = np.cumsum([0] + [len(child.parameters) for child in self.children]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @property
    def needs(self) -> frozenset[str]:
        """What any child needs."""
        return frozenset().union(*(child.needs for child in self.children))

    def _respond_each(self, theta: Real, at: Points, depth: int) -> list[Response]:
        parts = zip(self.children, self.cuts, strict=True)
        return [child.respond(theta[..., cut], at, depth) for child, cut in parts]

    def _parts_each(self, theta: Real, at: Points) -> list[tuple[Real, Real]]:
        each = zip(self.children, self.cuts, strict=True)
        return [child.parts(theta[..., cut], at) for child, cut in each]


def _joined(parts: Sequence[Response], factors: Sequence[Complex] | None) -> Complex:
    """dK/dtheta of the whole: each part's own, times its factor dK/dK_part."""
    if factors is None:
        # All are one, as of parts side by side: nothing is to be multiplied.
        blocks = [part.by_theta for part in parts]
    else:
        blocks = [f[..., None, :] * part.by_theta for f, part in zip(factors, parts, strict=True)]
    # Parts that hang on fewer axes, such as one that is held, are repeated along the others.
    lead = max((block.shape[:-2] for block in blocks), key=len)
    return np.concatenate([_lead(block, lead) for block in blocks], axis=-2)


def _lead(block: Complex, lead: tuple[int, ...]) -> Complex:
    if block.shape[:-2] == lead:
        return block
    return np.broadcast_to(block, lead + block.shape[-2:])


def _combine(
    value: Complex, parts: Sequence[Response], factors: Sequence[Complex] | None, depth: int
) -> Response:
    """The chain rule shared by parallel, series and chain: dK = sum factor_i dK_i."""
    if depth == VALUE:
        return Response(value)
    by_theta = _joined(parts, factors)
    # The slope by ln omega serves what moves the frequency only: most fits are spared it.
    if depth == GRADIENT:
        return Response(value, by_theta)
    slopes = [part.by_log_omega for part in parts]
    if factors is not None:
        slopes = [f * slope for f, slope in zip(factors, slopes, strict=True)]
    return Response(value, by_theta, sum(slopes[1:], slopes[0]))


class Parallel(Composition):
    """Stiffnesses add: all children feel the same displacement.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, parallel, spring
    >>> both = parallel(spring("a"), spring("b"))
    >>> both.respond(np.array([2.0, 3.0]), Points.at([1.0])).value.real
    array([5.])
    """

    flat = True

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K = sum K_i."""
        parts = self._respond_each(theta, at, depth)
        value = sum((part.value for part in parts[1:]), parts[0].value)
        return _combine(value, parts, None, depth)

    def parts(self, theta: Real, at: Points) -> tuple[Real, Real]:
        """Sums of K_i' and of K_i''."""
        (storage, loss), *others = self._parts_each(theta, at)
        for more, lost in others:
            storage, loss = storage + more, loss + lost
        return storage, loss


class Series(Composition):
    """Compliances add: all children carry the same force.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, series, spring
    >>> series(spring("a"), spring("b")).respond(np.array([2.0, 3.0]), Points.at([1.0])).value.real
    array([1.2])
    """

    plane, order, flat = "compliance", 1, True
    symbol, unit, shows = "Δ(1/K)", "1/({})", "what is missing in series"

    @staticmethod
    def residual(measured: Complex, modelled: Response) -> Complex:
        """1/K measured minus modelled."""
        return 1.0 / measured - 1.0 / modelled.value

    @staticmethod
    def slope(modelled: Response) -> Complex:
        """Slope dK / d(1/K) = -K^2."""
        return -(modelled.value**2)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """1/K = sum 1/K_i, so that dK/dK_i = (K/K_i)^2."""
        parts = self._respond_each(theta, at, depth)
        # Two by two takes one division for each further part; the sum of inverses takes two more.
        if depth == VALUE:
            return Response(reduce(_together, (part.value for part in parts)))
        value = 1.0 / sum((1.0 / part.value for part in parts[1:]), 1.0 / parts[0].value)
        factors = [(value / part.value) ** 2 for part in parts]
        return _combine(value, parts, factors, depth)

    def parts(self, theta: Real, at: Points) -> tuple[Real, Real]:
        """Of two by two, whose quotients are of complex numbers."""
        value = reduce(_together, (_whole(*each) for each in self._parts_each(theta, at)))
        return value.real, value.imag


class Chain(Composition):
    """Logarithms add: what the measurement chain does to the force signal.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, chain, gain, spring
    >>> chain(spring(), gain()).respond(np.array([2.0, 0.1]), Points.at([1.0])).value.real
    array([2.2])
    """

    plane, order = "log-complex", 5
    symbol, unit, shows = "Δ ln K", "-, rad", "what is missing in the signal chain"

    @staticmethod
    def residual(measured: Complex, modelled: Response) -> Complex:
        """Measured minus modelled ln K: a relative error, and a phase."""
        return np.asarray(np.log(measured / modelled.value), dtype=np.complex128)

    @staticmethod
    def slope(modelled: Response) -> Complex:
        """Slope dK / d ln K = K."""
        return modelled.value

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K = K_a K_b."""
        parts = self._respond_each(theta, at, depth)
        first, second = parts[0].value, parts[1].value
        return _combine(first * second, parts, [second, first], depth)


class Shift(Composition):
    """Frequencies are rescaled.

    The first child is read at omega times a_T, whose logarithm the second gives.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, arrhenius, dashpot, shift
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 30.0])
    >>> shift(dashpot(), arrhenius()).respond(np.array([1.0, 50.0]), at).value.imag.round(3)
    array([1.   , 0.508])
    """

    plane, order = "shift", 3
    symbol, unit, shows = "Δ ln ω", "-", "what is missing in the frequency scale"

    @staticmethod
    def residual(measured: Complex, modelled: Response) -> Complex:
        """By how much ln omega would have to move, to first order; a shift is real."""
        return (measured - modelled.value) / modelled.by_log_omega

    @staticmethod
    def slope(modelled: Response) -> Complex:
        """Slope dK / d ln omega."""
        return modelled.by_log_omega

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K(omega) = K_a(omega a_T); the second child responds with the real ln a_T."""
        base_theta, shift_theta = theta[..., self.cuts[0]], theta[..., self.cuts[1]]
        log_shift = self.children[1].respond(shift_theta, at, depth)
        # A real ln a_T keeps powers of s cheap; a complex theta (tests of derivatives) must pass
        # through.
        exact = log_shift.value.real
        if np.iscomplexobj(theta):
            exact = log_shift.value  # type: ignore[assignment]
        moved = at.shifted(exact)
        # The derivative by a shift is that by ln omega: the base gives it even where only a
        # gradient is asked for.
        asked = FULL
        if depth == VALUE:
            asked = VALUE
        base = self.children[0].respond(base_theta, moved, asked)
        if depth == VALUE:
            return Response(base.value)
        # A change of the shift moves the frequency: dK = (dK / d ln omega) d ln a_T.
        slope = base.by_log_omega
        by_theta = np.concatenate(
            [base.by_theta, slope[..., None, :] * log_shift.by_theta], axis=-2
        )
        if depth == GRADIENT:
            return Response(base.value, by_theta)
        # The shift may itself depend on the frequency: then ln(omega a_T) does not grow as ln
        # omega.
        return Response(base.value, by_theta, slope * (1.0 + log_shift.by_log_omega))


@dataclass(frozen=True)
class Composing:
    """How two nodes become one: what an effect names, and what networks are written with.

    Parameters
    ----------
    kind : type of Composition
        The node that holds them.

    Examples
    --------
    >>> from springpot.rheology import dashpot, parallel, spring
    >>> type(parallel(spring(), dashpot())).__name__
    'Parallel'
    >>> parallel.kind.plane
    'stiffness'
    """

    kind: type[Composition]

    def __call__(self, *nodes: Node) -> Node:
        """The nodes together, the first seen through or moved by the others where order counts."""
        return self.kind.of(nodes)


parallel = Composing(Parallel)
"""Nodes side by side; nested ones are flattened."""
series = Composing(Series)
"""Nodes one after the other; nested ones are flattened."""
chain = Composing(Chain)
"""The first node seen through a measurement chain, the second."""
shift = Composing(Shift)
"""The first node with its frequency axis moved by the second."""

PLANES: tuple[type[Composition], ...] = (Parallel, Series, Chain, Shift)
"""The compositions in whose planes residuals are shown, on paper and on pages."""


@dataclass(frozen=True)
class Mapped(Node):
    """A network whose element parameters are functions of other, published parameters.

    Parameters
    ----------
    node : Node
        The network in element parameters.
    outer : tuple of Parameter
        The published parameters.
    forward : callable
        Published parameters (..., q) to element parameters (..., p).
    jacobian : callable
        Its derivative, (..., q) to (..., p, q).
    """

    node: Node
    outer: tuple[Parameter, ...]
    forward: Callable[[Real], Real]
    jacobian: Callable[[Real], Real]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The published parameters."""
        return self.outer

    @property
    def needs(self) -> frozenset[str]:
        """What the inner node needs."""
        return self.node.needs

    def within(self, theta: Real) -> tuple[Real, Node]:
        """The inner network with its element parameters."""
        return self.forward(theta), self.node

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The inner response, its derivative carried through the map."""
        # Elements know nothing of published parameters: one chain rule here serves all of them.
        inner = self.node.respond(self.forward(theta), at, depth)
        if depth == VALUE:
            return inner
        by_outer = np.matmul(np.swapaxes(self.jacobian(theta), -1, -2), inner.by_theta)
        return inner._replace(by_theta=by_outer)


@dataclass(frozen=True)
class Scaled(Node):
    """A node whose stiffness is multiplied by a known number: more or less of the same specimen.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, spring
    >>> from springpot.rheology.nodes import Scaled
    >>> Scaled(spring(), 3.0).respond(np.array([2.0]), Points.at([1.0])).value.real
    array([6.])
    """

    node: Node
    factor: float

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The inner node's parameters."""
        return self.node.parameters

    @property
    def needs(self) -> frozenset[str]:
        """What the inner node needs."""
        return self.node.needs

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The inner response times the factor."""
        return Response(*(self.factor * part for part in self.node.respond(theta, at, depth)))


def rename(parameter: Parameter, name: str) -> Parameter:
    """`parameter` under another name, its unit unchanged."""
    return replace(parameter, name=name)


SMALL = 0.02
"""Below this |u| the power series is exact to rounding and the closed form is not."""
MOVING_SERIES = (1.0, -1 / 3, -1 / 45, -2 / 945, -1 / 4725, -2 / 93555, -1382 / 638512875)
FIXED_SERIES = (1.0, 1 / 6, 7 / 360, 31 / 15120, 127 / 604800, 73 / 3421440, 1414477 / 653837184000)
_SERIES = {
    moving_side: (terms, [k * term for k, term in enumerate(terms)][1:])
    for moving_side, terms in ((True, MOVING_SERIES), (False, FIXED_SERIES))
}


class SpecimenWave(Composition):
    """The first child carried by a wave in a specimen whose mass element is the second child.

    The children are the specimen without inertia and its mass, -m omega^2.

    Attributes
    ----------
    moving_side : bool
        Whether the force is measured where the specimen is moved, or at its other, fixed end.
    """

    order = 6
    moving_side: ClassVar[bool] = True

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K f(u), u = -E / K; dK_m/dK = f - u f', dK_m/dE = -f'."""
        parts = self._respond_each(theta, at, depth)
        # Of K and E alone: so the wave needs no geometry, and the chain rule no third part.
        u = -parts[1].value / parts[0].value
        f, slope = wave_factor(u, self.moving_side)
        return _combine(parts[0].value * f, parts, [f - u * slope, -slope], depth)


class FixedSideWave(SpecimenWave):
    """The same where the force is measured at the fixed end."""

    moving_side = False


def wave_factor(u: Complex, moving_side: bool) -> tuple[Complex, Complex]:
    """Z cot z (moving side) or z / sin z (fixed side) with z = sqrt(u), and its derivative by u."""
    small = np.abs(u) < SMALL
    # Where no point needs it the series is left out: this runs at every step of a search.
    if not small.any():
        return _closed(u, moving_side)
    value, slope = _closed(np.where(small, 1.0, u), moving_side)
    near = u[small]
    value[small], slope[small] = (_power_series(near, terms) for terms in _SERIES[moving_side])
    return value, slope


def _power_series(u: Complex, terms: Sequence[float]) -> Complex:
    """Sum of the terms times powers of u, by Horner's rule."""
    total: Complex = terms[-2] + terms[-1] * u
    for term in terms[-3::-1]:
        total = term + total * u
    return total


def _closed(u: Complex, moving_side: bool) -> tuple[Complex, Complex]:
    z = np.sqrt(u.astype(complex))
    # Both functions are even in z: the root above the real axis keeps the exponential from
    # overflowing.
    z = np.where(z.imag < 0.0, -z, z)
    p = np.exp(1j * z)
    below = p * p - 1.0
    cotangent = 1j * (p * p + 1.0) / below
    cosecant = 2j * p / below
    if moving_side:
        return z * cotangent, (cotangent - z * cosecant**2) / (2.0 * z)
    return z * cosecant, cosecant * (1.0 - z * cotangent) / (2.0 * z)


moving_side_wave = Composing(SpecimenWave)
"""Specimen inertia as felt by a force transducer at the moving side."""
fixed_side_wave = Composing(FixedSideWave)
"""Specimen inertia as felt by a force transducer at the fixed side."""
