"""An element written as one function: what every effect beyond the linear basics is made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .nodes import GRADIENT, VALUE, Node, Response
from .parameters import Parameter
from .points import Complex, Points, Real

Law: TypeAlias = Callable[..., tuple[Any, Sequence[Any], Any]]


@dataclass(frozen=True)
class Formula(Node):
    """An element given by a law of its parameters and the points.

    Parameters
    ----------
    free : tuple of Parameter
        Its parameters. The first is the *size*: by itself it decides whether the element is there.
    law : callable
        ``law(at, *parameters)`` gives the value, its derivative by each parameter and its
        derivative by ln omega. Parameters arrive with shape (..., 1); whatever broadcasts with the
        (..., n) points may be returned. A law that also accepts complex parameters can be tested by
        Cauchy's integral.
    conditions : tuple of str
        Columns that the law asks of the points, such as ``"amplitude"``.
    kind : str
        Name of the element in drawings.
    third : callable or None
        ``third(at, *parameters)`` gives the third harmonic of the force over the displacement
        amplitude; see `Effect.third_harmonic`.
    in_time : callable or None
        The same law in time, for an element that is not linear or belongs to the signals; linear
        ones need none. Beside the material, ``in_time(t, x, velocity, *parameters)`` gives the
        force and its derivative by each parameter, all (n,). In the measurement chain, ``in_time(t,
        columns, *parameters)`` turns signals (n, c) into what is recorded of them, and gives the
        derivatives of the first one.
    step : callable or None
        For an element that remembers: ``step(force, way, *parameters)`` gives the force after a
        straight way, from that before it. Others need none, for `in_time` tells their force at each
        sample alone.
    flows : bool
        Whether it goes on by itself while nothing moves: then neither the motion of a moment nor a
        way tells its force, but the whole course alone.
    third_at_most : callable or None
        ``third_at_most(at, *parameters)`` gives the most that the third harmonic may be where
        `third` is not known.
    """

    free: tuple[Parameter, ...]
    law: Law
    conditions: tuple[str, ...] = ()
    kind: str = "element"
    third: Callable[..., Any] | None = None
    in_time: Callable[..., tuple[Any, Sequence[Any]]] | None = None
    third_at_most: Callable[..., Any] | None = None
    step: Callable[..., float] | None = None
    flows: bool = False

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The free parameters."""
        return self.free

    @property
    def needs(self) -> frozenset[str]:
        """The columns that the law asks for."""
        return frozenset(self.conditions)

    def _columns(self, theta: Real) -> tuple[Real, ...]:
        return tuple(theta[..., i : i + 1] for i in range(len(self.free)))

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The law, in the shapes that compositions expect."""
        value, slopes, by_log_omega = self.law(at, *self._columns(theta))
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape, np.shape(value))
        whole = _spread(value, shape)
        if depth == VALUE:
            return Response(whole)
        # Filled in place: laws give slopes of any shape that broadcasts.
        by_theta = np.empty((*shape[:-1], len(self.free), shape[-1]), dtype=complex)
        for i, slope in enumerate(slopes):
            by_theta[..., i, :] = slope
        if depth == GRADIENT:
            return Response(whole, by_theta)
        return Response(whole, by_theta, _spread(by_log_omega, shape))

    def third_harmonic(self, theta: Real, at: Points) -> Complex | None:
        """Third harmonic of force over displacement amplitude; None where no law is known."""
        if self.third is None:
            return None
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape)
        return _spread(self.third(at, *self._columns(theta)), shape)

    def third_harmonic_at_most(self, theta: Real, at: Points) -> Real | None:
        """The most that the third harmonic may be, over the displacement amplitude.

        None where that is not known.
        """
        if self.third_at_most is None:
            return None
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape)
        return np.broadcast_to(self.third_at_most(at, *self._columns(theta)), shape)


def _spread(value: Any, shape: tuple[int, ...]) -> Complex:
    whole = np.asarray(value, dtype=complex)
    # Mostly it has that shape; a view takes longer than the law itself.
    if whole.shape == shape:
        return whole
    return np.broadcast_to(whole, shape)
