"""Factors without a law, one for each level of a condition, such as each temperature.

The levels are in the data and not in the model: an effect of this kind is a template until it is
bound to points.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError

from ..numerics import ALIKE, level_means, rows_of_levels
from .nodes import GRADIENT, VALUE, Node, Response, rename
from .parameters import Parameter
from .points import KELVIN, LARGEST_SHIFT, Points, Real, held

WIDEST = float(np.exp(LARGEST_SHIFT))
"""Bound on a factor and its inverse: free factors go as far as any law, which they contain."""


def levels_of(column: str, values: Real) -> NDArray[np.int64]:
    """Number of the level that each value belongs to, in ascending order.

    Neighbouring values that a rig does not tell apart are one level, unless they drift on and on: a
    level is never wider than twice what is held.

    Parameters
    ----------
    column : str
        Name of the condition.
    values : ndarray, shape (n,)
        Its values; temperatures in kelvin or degC.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import levels_of
    >>> levels_of("temperature", np.array([20.1, 39.9, 20.0, 40.2]))
    array([0, 1, 0, 1])
    """
    # In ascending order neighbours can be compared, and a level grow from its first value on.
    distinct, which = np.unique(values, return_inverse=True)
    room = held(column, distinct)
    number = np.zeros(len(distinct), dtype=np.int64)
    first = 0
    for i in range(1, len(distinct)):
        apart = (
            distinct[i] - distinct[i - 1] > room[i] or distinct[i] - distinct[first] > 2.0 * room[i]
        )
        if apart:
            first = i
        number[i] = number[i - 1] + apart
    return number[which.ravel()]


def level_word(value: float) -> str:
    """A level as part of a parameter's name: -22.5 is ``m22p5``, which is an identifier."""
    return f"{value:.6g}".replace("-", "m").replace("+", "").replace(".", "p")


def level_text(column: str, value: float) -> str:
    """A level as people say it: what was set, not what a sensor printed.

    Examples
    --------
    >>> from springpot.rheology.levels import level_text
    >>> level_text("temperature", 24.98)
    '25 degC'
    """
    if column == "temperature":
        return f"{round(value, 1) + 0.0:g} degC"
    return f"{column} {value:.4g}"


@dataclass(frozen=True)
class Levels(Node):
    """A positive factor for each level of a condition, one at the reference level.

    Between two levels the logarithm of the factor is interpolated; beyond them it stays.

    Parameters
    ----------
    column : str
        The condition: ``"temperature"``, ``"amplitude"`` or any column of the data.
    letter : str
        Name of the factors: ``a`` for shifts of frequency, ``b`` for vertical ones.
    logarithmic : bool
        Whether the node responds with the factor's logarithm, as `shift` asks, or with the factor,
        as `chain` asks.
    values : tuple of float
        The levels in ascending order, temperatures in kelvin. Without any the node is a template
        that changes nothing: `bound_to` gives it the levels of the data.
    reference : int
        Number of the level whose factor is one.
    """

    column: str = "temperature"
    letter: str = "a"
    logarithmic: bool = True
    values: tuple[float, ...] = ()
    reference: int = 0
    kind: str = "free factors"

    def bound_to(self, at: Points) -> Levels:
        """The node with the levels that the points have; itself if it has levels already.

        Raises
        ------
        ValueError
            If the points lack the column.
        """
        if self.values:
            return self
        column = at.need(self.column)
        number = levels_of(self.column, column)
        means = level_means(number, column)
        target = at.reference_temperature
        if self.column != "temperature":
            # The lower median, as the mean of two levels would be none.
            target = float(np.sort(column)[(len(column) - 1) // 2])
        # One level must be one: a factor of all of them would be the scale of the material once
        # more.
        reference = int(np.argmin(np.abs(means - target)))
        return replace(self, values=tuple(means.tolist()), reference=reference)

    @property
    def shown(self) -> tuple[float, ...]:
        """The levels as users write them: temperatures in degC."""
        zero = 0.0
        if self.column == "temperature":
            zero = KELVIN
        return tuple(_as_written(value - zero) for value in self.values)

    @cached_property
    def free(self) -> tuple[int, ...]:
        """Numbers of the levels whose factors are parameters."""
        return tuple(i for i in range(len(self.values)) if i != self.reference)

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        shown = self.shown
        # One decimal where it tells the levels apart: settings are round, what a rig held is not.
        words = [level_word(round(value, 1)) for value in shown]
        if len(set(words)) < len(words):
            words = [level_word(value) for value in shown]
        return tuple(
            Parameter(
                f"{self.letter}_{words[i]}",
                f"{self.letter}({shown[i]:.4g})",
                lower=1.0 / WIDEST,
                upper=WIDEST,
            )
            for i in self.free
        )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The factor of each level but the reference."""
        return self._parameters

    @property
    def needs(self) -> frozenset[str]:
        """The condition."""
        return frozenset({self.column})

    def shares(self, at: Points) -> Real:
        """Share of each free level (q, n) in the logarithm of the factor at the points."""
        column, values = at.need(self.column), np.array(self.values)
        if not self.free:
            return np.zeros((0, len(column)))
        nearest = np.argmin(np.abs(column[None, :] - values[:, None]), axis=0)
        # Within what a rig holds a value is its level, not a place between two.
        settled = np.abs(column - values[nearest]) <= held(self.column, values)[nearest]
        place = np.where(settled, values[nearest], column)
        units = np.eye(len(values))[list(self.free)]
        return np.array([np.interp(place, values, unit) for unit in units])

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The factor or its logarithm."""
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape)
        shares = self.shares(at)
        # Linear in the logarithms, in which factors between two levels are interpolated.
        log_factor = np.matmul(np.log(theta), shares)
        by_theta = shares / theta[..., :, None]
        value = log_factor
        if not self.logarithmic:
            value = np.exp(log_factor)
        value = np.broadcast_to(value, shape).astype(np.complex128)
        if depth == VALUE:
            return Response(value)
        if not self.logarithmic:
            by_theta = by_theta * value[..., None, :]
        slopes = np.broadcast_to(by_theta, (*shape[:-1], *by_theta.shape[-2:])).astype(
            np.complex128
        )
        if depth == GRADIENT:
            return Response(value, slopes)
        return Response(value, slopes, np.zeros(shape, dtype=np.complex128))


def free_factors(column: str = "temperature") -> Levels:
    """Shift factors a of the frequency, one for each level of a column, for `shift`.

    Examples
    --------
    >>> from springpot.rheology import Points, free_factors
    >>> at = Points.at([1.0, 1.0, 1.0], temperature=[0.0, 20.0, 40.0])
    >>> [parameter.name for parameter in free_factors().bound_to(at).parameters]
    ['a_0', 'a_40']
    """
    return Levels(column, "a", True)


def free_vertical_factors(column: str = "temperature") -> Levels:
    """Vertical factors b of the stiffness, one for each level of a column, for `chain`.

    Examples
    --------
    >>> from springpot.rheology import Points, free_vertical_factors
    >>> at = Points.at([1.0, 1.0], temperature=[20.0, 40.0])
    >>> [parameter.name for parameter in free_vertical_factors().bound_to(at).parameters]
    ['b_40']
    """
    return Levels(column, "b", False)


def _as_written(value: float) -> float:
    # Ten digits: 253.15 - 273.15 is not -20 to the last bit, and what is left of 273.15 - 273.15 is
    # zero.
    if not abs(value) > ALIKE:
        return 0.0
    return float(f"{value:.10g}")


@dataclass(frozen=True)
class Own(Node):
    """A node some of whose parameters each level of a condition has for itself.

    The others are shared by all levels. A point between two levels belongs to the nearer one.

    Parameters
    ----------
    node : Node
        With one value of each parameter.
    own : tuple of str
        The parameters that are each level's own.
    column : str
        The condition.
    values : tuple of float
        The levels in ascending order, temperatures in kelvin. Without any it is the node itself
        until `bound_to` gives it the levels of the data.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Own, Points, parallel, dashpot, spring
    >>> at = Points.at([1.0, 1.0, 2.0], temperature=[10.0, 30.0, 30.0])
    >>> node = Own(parallel(spring(), dashpot()), ("k",), "temperature").bound_to(at)
    >>> [parameter.name for parameter in node.parameters]
    ['k_10', 'k_30', 'c']
    >>> node.respond(np.array([5.0, 4.0, 0.5]), at).value
    array([5.+0.5j, 4.+0.5j, 4.+1.j ])
    """

    node: Node
    own: tuple[str, ...]
    column: str
    values: tuple[float, ...] = ()

    def bound_to(self, at: Points) -> Own:
        """The node with the levels that the points have; itself if it has levels already."""
        if self.values:
            return self
        column = at.need(self.column)
        number = levels_of(self.column, column)
        means = level_means(number, column)
        return replace(self, node=self.node.bound_to(at), values=tuple(means.tolist()))

    @cached_property
    def _levels(self) -> list[tuple[str, str]]:
        """Of each level what stands behind the name and the symbol of a parameter."""
        shown = Levels(self.column, values=self.values).shown
        return [(level_word(value), f"{value:.4g}") for value in shown]

    def _copies(self, parameter: Parameter) -> list[Parameter]:
        if parameter.name not in self.own or not self.values:
            return [parameter]
        return [self.copied(parameter, number) for number in range(len(self.values))]

    def copied(self, parameter: Parameter, number: int) -> Parameter:
        """A parameter as that of one level."""
        word, shown = self._levels[number]
        copy = rename(parameter, f"{parameter.name}_{word}")
        # The order in a unit such as kN s^alpha/m is that of the level, where it is its own.
        if parameter.unit.time in self.own:
            unit = replace(parameter.unit, time=f"{parameter.unit.time}_{word}")
            copy = replace(copy, unit=unit)
        return replace(copy, symbol=f"{parameter.symbol}({shown})")

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        return tuple(copy for each in self.node.parameters for copy in self._copies(each))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The shared ones and, in the place of an own one, that of each level."""
        return self._parameters

    @property
    def needs(self) -> frozenset[str]:
        """What the inner node needs, and the condition."""
        return self.node.needs | {self.column}

    @property
    def absent_at(self) -> float | None:
        """As the inner node says."""
        return self.node.absent_at

    @property
    def released(self) -> Node:
        """The inner node with all its parameters free, and shared."""
        return self.node.released

    @property
    def held(self) -> dict[str, float]:
        """As the inner node says."""
        return self.node.held

    @property
    def origins(self) -> tuple[str, ...]:
        """For each parameter the name of the one that it is a level's own of."""
        pairs = zip(self.node.parameters, self.node.origins, strict=True)
        return tuple(origin for each, origin in pairs for _ in self._copies(each))

    @cached_property
    def sources(self) -> NDArray[np.intp]:
        """Where the inner node has what each parameter (q,) is a level's own of, or the same."""
        counts = [len(self._copies(each)) for each in self.node.parameters]
        return np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """Where the inner node's parameters (p,) of each level stand in theta, (levels, p)."""
        ends = np.cumsum([0] + [len(self._copies(each)) for each in self.node.parameters])
        many = np.diff(ends) > 1
        rows = [ends[:-1] + np.where(many, i, 0) for i in range(max(len(self.values), 1))]
        return np.array(rows, dtype=np.intp)

    def level(self, at: Points) -> NDArray[np.intp]:
        """Number of the level that each point (n,) belongs to."""
        values = np.array(self.values or (0.0,))
        return np.searchsorted(0.5 * (values[1:] + values[:-1]), at.need(self.column))

    def rows(self, at: Points) -> list[NDArray[np.intp]]:
        """Numbers of the points of each level, in their order."""
        return rows_of_levels(self.level(at), len(self.places))

    def at_levels(self, kept: NDArray[np.intp]) -> Own:
        """The node with some of its levels, by their numbers."""
        return replace(self, values=tuple(self.values[i] for i in kept.tolist()))

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K of each point by the parameters of its level."""
        count, parts = at.need(self.column).shape[-1], []
        for rows, places in zip(self.rows(at), self.places, strict=True):
            parts.append(
                (rows, places, self.node.respond(theta[..., places], at.some(rows), depth))
            )
        lead = max((part.value.shape[:-1] for _, _, part in parts), key=len)
        value = np.empty((*lead, count), dtype=np.complex128)
        for rows, _, part in parts:
            value[..., rows] = part.value
        if depth == VALUE:
            return Response(value)
        by_theta = np.zeros((*lead, theta.shape[-1], count), dtype=np.complex128)
        for rows, places, part in parts:
            by_theta[..., places[:, None], rows] = part.by_theta
        if depth == GRADIENT:
            return Response(value, by_theta)
        slope = np.empty_like(value)
        for rows, _, part in parts:
            slope[..., rows] = part.by_log_omega
        return Response(value, by_theta, slope)


def owned(node: Node, own: Collection[str], column: str) -> Node:
    """The node with parameters of which each level of a condition has its own.

    Itself where none is its own.

    Raises
    ------
    ModelError
        If an order is to be each level's own, but not the constant whose unit it is in.
    """
    if isinstance(node, Own) and not node.values:
        # One after the other they are one kind of levels: all that have a column have it alike.
        own = {*own, *node.own}
        node = node.node
    mine = tuple(each.name for each in node.parameters if each.name in own)
    if not mine:
        return node
    for each in node.parameters:
        if each.unit.time in mine and each.name not in mine:
            raise ModelError(
                f"{each.name} has the order {each.unit.time} in its unit: where each level has an"
                f" {each.unit.time} of its own it has a {each.name} of its own, too"
            )
    return Own(node, mine, column)


def own_of(node: Node) -> dict[str, str]:
    """Parameters that are each level's own, by name, and the condition."""
    if not isinstance(node, Own):
        return {}
    return dict.fromkeys(node.own, node.column)
