"""What a test in time did: to its loading, by the clock of its material, to its response.

A test in time goes three ways: what was imposed reaches the specimen, the specimen answers by its
own clock, and something records the answer. An effect of the test acts at one of these *stages*, by
one vectorised law with its derivatives. In K(omega) a stage changes nothing: a sweep has no ramp.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .nodes import VALUE, Composing, Composition, Node, Response
from .parameters import Parameter
from .points import Points, Real

Tries: TypeAlias = Sequence[tuple[float, ...]]


class Answered(NamedTuple):
    """What a record shows of a response.

    Attributes
    ----------
    value : ndarray, shape (n,)
        What was recorded.
    by_parameters : sequence of ndarray, shape (n,)
        Its derivative by each parameter of the effect.
    by_response : ndarray, shape (n,) or (n, n)
        Its derivative by the response itself: at the same instant, or at all of them.
    """

    value: Real
    by_parameters: Sequence[Real]
    by_response: Real


@dataclass(frozen=True)
class StageLaw(Node):
    """The element of an effect of a test in time.

    Parameters
    ----------
    function : callable
        Of the loading, ``function(loading, *parameters)`` gives the `Loading` that reached the
        specimen and its derivative by each parameter, as loadings too. Of the clock,
        ``function(time, *parameters)`` gives the time (n,) by the material's clock at the times
        (n,) since the load first moved, and its derivatives. Of the response, ``function(record,
        response, *parameters)`` gives what is recorded of a response (n,), as `Answered`.
    own : tuple of Parameter
        The first is its *size*: by itself it decides whether the effect is there.
    tries : callable, optional
        Values of the parameters from which a search in a test begins; by default those that the
        units suggest.
    """

    function: Callable[..., Any]
    own: tuple[Parameter, ...]
    tries: Callable[[Any], Tries] | None = None

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters in the order in which the law takes them."""
        return self.own


def acting(element: Node, values: Real, *on: Any) -> tuple[Any, ...]:
    """What a law gives at `values` (q,), with the derivatives by those that are free alone.

    Parameters
    ----------
    element : Node
        A `StageLaw`, or one some of whose parameters are held.
    values : ndarray, shape (q,)
        The parameters that are free.
    *on
        The loading, the time, or the record and the response.
    """
    law, whole = element, values
    # Values that are held, or all of them fixed, stand around it.
    while not isinstance(law, StageLaw):
        whole, law = law.within(whole)
    value, slopes, *rest = law.function(*on, *whole)
    free = {parameter.name for parameter in element.parameters}
    pairs = zip(law.parameters, slopes, strict=True)
    return value, [slope for parameter, slope in pairs if parameter.name in free], *rest


class Stage(Composition):
    """A network and the law of a test around it; its parameters come last."""

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The network's own response: no law of a test changes K."""
        inner = self.children[0].respond(theta[..., self.cuts[0]], at, depth)
        if depth == VALUE:
            return inner
        count = len(self.children[1].parameters)
        by_theta = inner.by_theta
        nothing = np.zeros((*by_theta.shape[:-2], count, by_theta.shape[-1]), by_theta.dtype)
        return inner._replace(by_theta=np.concatenate([by_theta, nothing], axis=-2))


class OfLoading(Stage):
    """What was imposed is not what reached the specimen."""

    plane, order = "loading", 10


class OfClock(Stage):
    """The material goes by a clock of its own."""

    plane, order = "clock", 11


class OfResponse(Stage):
    """The record is not the response."""

    plane, order = "response", 12


on_loading = Composing(OfLoading)
"""A law between what was imposed and what reached the specimen."""
on_clock = Composing(OfClock)
"""A law of the clock by which the specimen answers."""
on_response = Composing(OfResponse)
"""A law between the response and its record."""
