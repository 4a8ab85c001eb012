"""Parameters of which each level of a condition, or each specimen, has a value of its own."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError

from .levels import Levels, level_word, levels_of
from .nodes import GRADIENT, VALUE, Node, Response, rename
from .parameters import Parameter
from .points import Points, Real


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
        means = np.bincount(number, column) / np.bincount(number)
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
        column = at.need(self.column)
        apart = np.abs(column - np.array(self.values or (0.0,))[:, None])
        return np.asarray(np.argmin(apart, axis=0), dtype=np.intp)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K of each point by the parameters of its level."""
        number, parts = self.level(at), []
        for i, places in enumerate(self.places):
            rows = np.flatnonzero(number == i)
            parts.append(
                (rows, places, self.node.respond(theta[..., places], at.some(rows), depth))
            )
        lead = max((part.value.shape[:-1] for _, _, part in parts), key=len)
        value = np.empty((*lead, len(number)), dtype=np.complex128)
        for rows, _, part in parts:
            value[..., rows] = part.value
        if depth == VALUE:
            return Response(value)
        by_theta = np.zeros((*lead, theta.shape[-1], len(number)), dtype=np.complex128)
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
