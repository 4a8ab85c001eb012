"""Parameters that follow from others, ``k2 = 2*k1``, or keep an order, ``tau1 < tau2``.

What is tied leaves theta, as what is held does. Of an order the share of the smaller one in the
larger one takes its place: no search can leave it, and no two modes can change places.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from graphlib import CycleError, TopologicalSorter
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError

from .grammar import CONSTANTS, names_in, parsed
from .levels import Own
from .nodes import Mapped, Node, Response
from .parameters import PURE, Parameter
from .points import Complex, Points, Real
from .terms import Dual, Joined, Name, Term

Bounds = tuple[float, float]


@dataclass(frozen=True)
class Inserted:
    """The map from the parameters that are left to all of them.

    Parameters
    ----------
    values : tuple of (float or None)
        For each parameter of the inner node the value it is held at, or None where it is free.
    """

    values: tuple[float | None, ...]

    @property
    def free(self) -> NDArray[np.intp]:
        """Positions of the free parameters."""
        return np.array([i for i, value in enumerate(self.values) if value is None], dtype=np.intp)

    def __call__(self, theta: Real) -> Real:
        """All parameters (..., p) of the free ones (..., q)."""
        # Of theta's own kind: a complex step of a derivative must pass through.
        full: Real = np.empty((*theta.shape[:-1], len(self.values)), dtype=theta.dtype)
        # Those that are free are no numbers here, until theta takes their places.
        full[...] = np.array(self.values, dtype=float)
        full[..., self.free] = theta
        return full

    def jacobian(self, theta: Real) -> Real:
        """Its derivative (..., p, q): ones where a free parameter stands."""
        slopes: Real = np.eye(len(self.values))[:, self.free]
        return np.broadcast_to(slopes, (*theta.shape[:-1], *slopes.shape))


@dataclass(frozen=True)
class Lessened(Mapped):
    """A node with fewer free parameters than the one within it."""

    @property
    def released(self) -> Node:
        """The inner node with all its parameters free."""
        return self.node.released

    @property
    def held(self) -> dict[str, float]:
        """As the inner node says."""
        return self.node.held

    @property
    def absent_at(self) -> float | None:
        """As the inner node says."""
        return self.node.absent_at

    def third_harmonic(self, theta: Real, at: Points) -> Complex | None:
        """That of the inner node, where it knows one."""
        predict = getattr(self.node, "third_harmonic", None)
        if predict is None:
            return None
        harmonic: Complex | None = predict(self.forward(theta), at)
        return harmonic


@dataclass(frozen=True)
class Held(Lessened):
    """A node some of whose parameters are held or bounded; see `hold`."""

    forward: Inserted

    @property
    def held(self) -> dict[str, float]:
        """Parameters that are held, by name."""
        return {**self.node.held, **self.here}

    @property
    def here(self) -> dict[str, float]:
        """Those that are held by this node, and by none within it."""
        pairs = zip(self.node.parameters, self.forward.values, strict=True)
        return {parameter.name: value for parameter, value in pairs if value is not None}

    def bound_to(self, at: Points) -> Node:
        """The inner node bound, and held as before."""
        bound = self.node.bound_to(at)
        if bound is self.node:
            return self
        bounds = {each.name: (each.lower, each.upper) for each in self.parameters}
        return hold(bound, self.here, bounds)


@dataclass(frozen=True, eq=False)
class Fixed(Node):
    """A node at given parameters.

    It has none of its own, and is evaluated once for all settings beside it.

    Parameters
    ----------
    node : Node
        What is fixed.
    theta : ndarray, shape (p,)
        Its parameters.
    """

    node: Node
    theta: Real

    @property
    def parameters(self) -> tuple[()]:
        """None are left."""
        return ()

    @property
    def needs(self) -> frozenset[str]:
        """What the inner node needs."""
        return self.node.needs

    def within(self, theta: Real) -> tuple[Real, Node]:
        """The inner node and its parameters."""
        return self.theta, self.node

    def respond(self, theta: Real, at: Points, depth: int = 0) -> Response:
        """The inner node's response, without leading axes where the points have none."""
        # Once for all thetas beside it: that is why it is fixed.
        response = self.node.respond(self.theta, at, depth)
        empty = np.zeros(
            (*response.value.shape[:-1], 0, response.value.shape[-1]), dtype=np.complex128
        )
        return response._replace(by_theta=empty)


def hold(node: Node, values: Mapping[str, float], bounds: Mapping[str, Bounds]) -> Node:
    """The node with parameters held at `values` and others within `bounds`.

    Itself where neither names its own.

    Parameters
    ----------
    node : Node
        Its parameters.
    values, bounds : mapping of str
        By name, in the unit of theta.

    Raises
    ------
    ModelError
        If a value or bound is none that the parameter can take.
    """
    # Most nodes of a model are not named: they stay what they are, without a wrapping that costs
    # time.
    names = {parameter.name for parameter in node.parameters}
    if not names & (set(values) | set(bounds)):
        return node
    # What is held already stays held, in one wrapping for all.
    inner, known = node, dict[str, float]()
    if isinstance(node, Held):
        inner, known = node.node, node.here
    known |= {name: allowed(p, values[name]) for p in node.parameters if (name := p.name) in values}
    free = [_bounded(p, bounds.get(p.name), known) for p in node.parameters if p.name not in known]
    inserted = Inserted(tuple(known.get(parameter.name) for parameter in inner.parameters))
    return Held(inner, tuple(free), inserted, inserted.jacobian)


def allowed(parameter: Parameter, value: float) -> float:
    """A value that a parameter can take.

    Raises
    ------
    ModelError
        If it is none.
    """
    if not (isfinite(value) and parameter.lower <= value <= parameter.upper):
        ends = f"{parameter.lower:g}", f"{parameter.upper:g}"
        room = f"[{ends[0]}, {ends[1]}{']' if isfinite(parameter.upper) else ')'}"
        raise ModelError(f"{parameter.name} cannot be {value:g}: it lies in {room}")
    return float(value)


def _bounded(parameter: Parameter, bounds: Bounds | None, known: Mapping[str, float]) -> Parameter:
    """The parameter in its narrower bounds; an order that is held becomes a number in the unit."""
    # A unit such as kN s^alpha/m is told with the number from here on: there is no alpha left to be
    # looked up.
    time = parameter.unit.time
    if isinstance(time, str) and time in known:
        parameter = replace(parameter, unit=replace(parameter.unit, time=known[time]))
    if bounds is None:
        return parameter
    # Bounds of a user never reach beyond those of physics.
    low, high = max(bounds[0], parameter.lower), min(bounds[1], parameter.upper)
    if not low < high:
        ends = f"{parameter.lower:g}", f"{parameter.upper:g}"
        room = f"[{ends[0]}, {ends[1]}{']' if isfinite(parameter.upper) else ')'}"
        raise ModelError(
            f"{parameter.name} has no room between {bounds[0]:g} and {bounds[1]:g}:"
            f" it lies in {room}"
        )
    return replace(parameter, lower=low, upper=high)


EXAMPLE = "write it as 'k2 = 2*k1' or 'tau1 < tau2'"


@dataclass(frozen=True)
class Tie:
    """A parameter by others.

    Parameters
    ----------
    name : str
        The parameter.
    base : Term
        What it is, or is smaller or larger than.
    text : str
        As it was typed.
    sign : {"=", "<", ">"}
        Which of these.
    share : str
        Of an order, the name of the smaller one over the larger one.
    """

    name: str
    base: Term
    text: str
    sign: str = "="
    share: str = ""

    @property
    def term(self) -> Term:
        """What it is."""
        if self.sign == "=":
            return self.base
        joined = {"<": "*", ">": "/"}[self.sign]
        return Joined(self.base.place, joined, self.base, Name(self.base.place, self.share))

    @property
    def names(self) -> list[str]:
        """The parameters that it follows from."""
        return names_in(self.base)


class Follower(NamedTuple):
    """A tied parameter at some values of the others.

    Attributes
    ----------
    origin : str
        Its name in the model without levels.
    parameter : Parameter
        Itself.
    value : float
        In the unit of theta.
    at : ndarray of int, shape (q,)
        Where in theta the parameters stand among which it follows: of levels those of one.
    slopes : ndarray, shape (q,)
        Derivative by these.
    text : str
        How it is tied.
    follow : callable
        Its value at other values (q,) of these.
    """

    origin: str
    parameter: Parameter
    value: float
    at: NDArray[np.intp]
    slopes: Real
    text: str
    follow: Callable[[Real], float]


def ties_of(
    text: str, names: Collection[str], taken: Collection[str] = (), prefix: str = ""
) -> Iterator[Tie]:
    """The ties of a text, of which an order of several parameters gives several.

    Parameters
    ----------
    text : str
        Such as ``k2 = 2*k1``, ``tau1 < tau2`` or ``tau1 < tau2 < tau3``.
    names : collection of str
        The parameters that there are.
    taken : collection of str
        Those that are tied already.
    prefix : str
        Of the effect that they are of.

    Raises
    ------
    ModelError
        If it is none, or names what is no parameter.

    Examples
    --------
    >>> from springpot.rheology.tied import ties_of
    >>> [(tie.name, tie.sign, tie.names) for tie in ties_of("a < b < c", ["a", "b", "c"])]
    [('a', '<', ['b']), ('b', '<', ['c'])]
    """
    sides = [side.strip() for side in re.split(r"[=<>]", text)]
    signs = re.findall(r"[=<>]", text)
    if len(set(signs)) != 1 or not all(sides) or (signs[0] == "=" and len(signs) > 1):
        raise ModelError(f"'{text:.80}' is no tie: {EXAMPLE}")
    mine = set(taken)
    for first, sign, second in zip(sides, signs, sides[1:], strict=False):
        shown = f"{first} {sign} {second}"
        left, right = (
            side.replace(f"{prefix}.", "") if prefix else side for side in (first, second)
        )
        # An order can be read from either side: of a parameter that is tied already, from the
        # other.
        free = [side for side in (left, right) if side in names and side not in mine]
        if sign != "=" and left not in free and free:
            left, right, sign = right, left, {"<": ">", ">": "<"}[sign]
        yield _tie(shown, left, sign, right, names)
        mine.add(left)


def _tie(text: str, name: str, sign: str, base: str, names: Collection[str]) -> Tie:
    term = parsed(base)
    for each in (name, *names_in(term)):
        if each not in names:
            known = ", ".join(names) or "none"
            raise ModelError(f"'{text:.80}': no free parameter '{each:.40}' (there are: {known})")
    if not names_in(term):
        raise ModelError(f"'{text:.80}' names one parameter: hold it by fix, or bound it by bounds")
    if not term.real:
        raise ModelError(f"'{text:.80}': a parameter is real, so what it follows from has no i")
    if sign == "=":
        return Tie(name, term, text)
    bare = base.replace(" ", "")
    shown = bare if bare.isidentifier() else f"({bare})"
    pair = (name, shown) if sign == "<" else (shown, name)
    return Tie(name, term, text, sign, "/".join(pair))


@dataclass(frozen=True)
class Following:
    """The map from the parameters that are left to all of them.

    Parameters
    ----------
    inner : tuple of Parameter
        All of them.
    free : tuple of str
        Names of those that are left, shares of orders among them.
    ties : tuple of Tie
        Each after those that it follows from.
    factors : tuple of float
        From the unit of theta to the printed one in which ties are typed, of `inner`.
    """

    inner: tuple[Parameter, ...]
    free: tuple[str, ...]
    ties: tuple[Tie, ...]
    factors: tuple[float, ...]

    def duals(self, theta: Real) -> dict[str, Dual]:
        """Each parameter as it is printed, with its slopes by the free ones."""
        factor = dict(zip((each.name for each in self.inner), self.factors, strict=True))
        known = {
            name: Dual(theta[..., i] * factor.get(name, 1.0), {name: factor.get(name, 1.0)})
            for i, name in enumerate(self.free)
        }
        # Where a tie has no number the search finds none, and takes the step back.
        with np.errstate(all="ignore"):
            for tie in self.ties:
                known[tie.name] = tie.term.at(known)
        return known

    def __call__(self, theta: Real) -> Real:
        """All parameters (..., p) of the free ones (..., q), what is tied within its bounds."""
        known = self.duals(theta)
        # Of theta's own kind: a complex step of a derivative must pass through.
        full: Real = np.empty((*theta.shape[:-1], len(self.inner)), dtype=theta.dtype)
        for i, (each, factor) in enumerate(zip(self.inner, self.factors, strict=True)):
            value = known[each.name].value / factor
            # The free ones are kept by the search, which has to know their slopes at the bounds.
            if each.name not in self.free:
                value = np.where(np.real(value) < each.lower, each.lower, value)
                value = np.where(np.real(value) > each.upper, each.upper, value)
            full[..., i] = value
        return full

    def jacobian(self, theta: Real) -> Real:
        """Its derivative (..., p, q); none where a bound holds what is tied."""
        known = self.duals(theta)
        slopes: Real = np.zeros((*theta.shape[:-1], len(self.inner), len(self.free)))
        for i, (each, factor) in enumerate(zip(self.inner, self.factors, strict=True)):
            value = known[each.name].value / factor
            inside = (np.real(value) >= each.lower) & (np.real(value) <= each.upper)
            inside |= each.name in self.free
            for name, slope in known[each.name].slopes.items():
                slopes[..., i, self.free.index(name)] = np.where(inside, slope / factor, 0.0)
        return slopes

    def started(self, full: Real) -> Real:
        """Free parameters (..., q) near all parameters (..., p) that do not keep to the ties."""
        printed = {
            each.name: Dual(full[..., i] * factor, {})
            for i, (each, factor) in enumerate(zip(self.inner, self.factors, strict=True))
        }
        found, places = np.empty((*full.shape[:-1], len(self.free))), {}
        for tie in self.ties:
            if tie.share:
                value, base = printed[tie.name].value, tie.base.at(printed).value
                with np.errstate(all="ignore"):
                    places[tie.share] = value / base if tie.sign == "<" else base / value
        names = [each.name for each in self.inner]
        for i, name in enumerate(self.free):
            if name in places:
                found[..., i] = np.clip(np.nan_to_num(places[name], nan=0.5), 0.0, 1.0)
            else:
                found[..., i] = full[..., names.index(name)]
        return found

    def narrowed(self, parameter: Parameter) -> Parameter:
        """A free parameter within bounds in which what is a straight line of it keeps its own."""
        lower, upper = parameter.lower, parameter.upper
        first, second = (self.duals(np.full(len(self.free), value)) for value in (1.0, 2.0))
        for each, factor in zip(self.inner, self.factors, strict=True):
            slopes = [known[each.name].slopes for known in (first, second)]
            if slopes[0] != slopes[1] or set(slopes[0]) != {parameter.name}:
                continue
            slope = slopes[0][parameter.name] / factor
            shift = first[each.name].value / factor - slope
            with np.errstate(divide="ignore", invalid="ignore"):
                ends = (np.array([each.lower, each.upper]) - shift) / np.float64(slope)
            if slope:
                lower, upper = max(lower, float(ends.min())), min(upper, float(ends.max()))
        if not lower < upper:
            raise ModelError(f"'{self.ties[0].text}' leaves {parameter.name} no room in its bounds")
        return replace(parameter, lower=lower, upper=upper)


@dataclass(frozen=True)
class Tied(Lessened):
    """A node some of whose parameters follow from others; see `tied`."""

    forward: Following

    def bound_to(self, at: Points) -> Node:
        """The inner node bound, and tied as before."""
        bound = self.node.bound_to(at)
        if bound is self.node:
            return self
        return _tied(bound, self.forward.ties, self.forward.factors)


def tied(node: Node, texts: Sequence[str], factors: Mapping[str, float], prefix: str = "") -> Node:
    """The node with parameters that follow from others.

    Parameters
    ----------
    node : Node
        Its parameters.
    texts : sequence of str
        As `ties_of` reads them.
    factors : mapping of str to float
        From the unit of theta to the one in which values are typed, by name.
    prefix : str
        Of the effect that the node is of, as it stands before the names in the texts.

    Raises
    ------
    ModelError
        If a text is no tie, or ties go round in a circle or leave nothing free.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, dashpot, parallel, spring
    >>> from springpot.rheology.tied import tied
    >>> node = tied(parallel(spring(), dashpot()), ["c = 2*k"], {})
    >>> node.respond(np.array([3.0]), Points.at([1.0])).value
    array([3.+6.j])
    """
    names = [each.name for each in node.parameters]
    ties: list[Tie] = []
    for text in texts:
        for tie in ties_of(text, names, [each.name for each in ties], prefix):
            if any(tie.name == other.name for other in ties):
                raise ModelError(f"'{text:.80}': {tie.name} is tied already")
            ties.append(tie)
    by_name = {tie.name: tie for tie in ties}
    graph = {tie.name: [name for name in tie.names if name in by_name] for tie in ties}
    try:
        order = list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        raise ModelError(f"{circle}: ties go round in a circle, which leaves none free") from None
    return _tied(
        node, [by_name[name] for name in order], [factors.get(name, 1.0) for name in names]
    )


def _tied(node: Node, ties: Sequence[Tie], factors: Sequence[float]) -> Tied:
    mine = {tie.name: tie for tie in ties}
    free = []
    for each in node.parameters:
        tie = mine.get(each.name)
        if tie is None:
            free.append(_with_order(each, mine))
        elif tie.share:
            free.append(_share(tie, node.parameters))
    names = tuple(each.name for each in free)
    following = Following(node.parameters, names, tuple(ties), tuple(factors))
    outer = tuple(following.narrowed(each) for each in free)
    return Tied(node, outer, following, following.jacobian)


def _share(tie: Tie, parameters: Sequence[Parameter]) -> Parameter:
    """The smaller one of an order over the larger one."""
    known = {each.name: each for each in parameters}
    for name in (tie.name, *tie.names):
        if known[name].lower < 0.0:
            raise ModelError(f"'{tie.text}': {name} may be negative, and an order is of sizes")
    if isinstance(tie.base, Name) and known[tie.base.name].unit != known[tie.name].unit:
        raise ModelError(f"'{tie.text}' compares what has different units")
    return Parameter(tie.share, tie.share, PURE, 0.0, 1.0, "log", 0.3)


def _with_order(parameter: Parameter, ties: Mapping[str, Tie]) -> Parameter:
    """A constant in whose unit an order stands that is another one."""
    tie = ties.get(str(parameter.unit.time))
    if tie is None or tie.sign != "=" or not isinstance(tie.base, Name):
        return parameter
    return replace(parameter, unit=replace(parameter.unit, time=tie.base.name))


def part_of(text: str, prefixes: Sequence[str]) -> str:
    """The prefix of the effect that a tie is of; nothing where it is of the model itself.

    Raises
    ------
    ModelError
        If it names parameters of several parts.
    """
    found = []
    for prefix in prefixes:
        marked = re.sub(rf"(?<![\w.#-]){re.escape(prefix)}\.", "@", text)
        if marked != text:
            found.append(prefix)
            plain = set(re.findall(r"(?<![\w@.])[A-Za-z]\w*(?![\w(])", marked)) - set(CONSTANTS)
    if not found:
        return ""
    if len(found) > 1 or plain:
        raise ModelError(
            f"'{text:.80}' ties parameters of several parts of a model, and a tie is within one:"
            " type the model as one formula"
        )
    return found[0]


def ties_in(node: Node) -> tuple[str, ...]:
    """The ties of a node as they were typed."""
    if isinstance(node, Own | Held):
        return ties_in(node.node)
    if isinstance(node, Tied):
        return tuple(dict.fromkeys(tie.text for tie in node.forward.ties))
    return ()


def bases_in(node: Node) -> dict[str, list[str]]:
    """What each tied parameter hangs on: the parameters it follows from, or its share of an order.

    Examples
    --------
    >>> from springpot.rheology import dashpot, parallel, spring
    >>> from springpot.rheology.tied import bases_in, tied
    >>> bases_in(tied(parallel(spring(), dashpot()), ["c = 2*k"], {}))
    {'c': ['k']}
    """
    if isinstance(node, Own | Held):
        return bases_in(node.node)
    if isinstance(node, Tied):
        return {each.name: [each.share] if each.share else each.names for each in node.forward.ties}
    return {}


def untied(node: Node) -> Node:
    """The node without ties, its levels and held parameters as before."""
    if isinstance(node, Own):
        return replace(node, node=untied(node.node))
    if isinstance(node, Tied):
        return node.node
    return node


def started(node: Node, full: Real) -> Real:
    """Parameters (..., q) of a node near those (..., p) of the released one."""
    if isinstance(node, Held):
        return np.asarray(started(node.node, full)[..., node.forward.free])
    if isinstance(node, Tied):
        return node.forward.started(started(node.node, full))
    if isinstance(node, Own):
        inner = started(node.node, full)
        return np.asarray(inner[..., node.sources])
    return full


def followers(node: Node, theta: Real) -> list[Follower]:
    """The tied parameters of a node at its parameters (p,)."""
    if isinstance(node, Tied):
        return _followers(node, theta)
    if not isinstance(node, Own | Held):
        return []
    if isinstance(node, Held):
        return [_outside(node, each, theta) for each in followers(node.node, node.forward(theta))]
    found: dict[str, Follower] = {}
    for number, places in enumerate(node.places):
        for each in followers(node.node, theta[places]):
            on = each.at[np.flatnonzero(each.slopes)]
            parameter = each.parameter
            if any(node.node.parameters[i].name in node.own for i in on):
                parameter = node.copied(parameter, number)
            moved = each._replace(parameter=parameter, at=places[each.at])
            found.setdefault(parameter.name, moved)
    return list(found.values())


def _outside(node: Held, inner: Follower, theta: Real) -> Follower:
    """A tied parameter by the parameters (q,) that a node leaves free."""
    slopes = inner.slopes @ node.jacobian(theta)[inner.at]

    def follow(values: Real) -> float:
        return inner.follow(node.forward(values)[inner.at])

    return inner._replace(at=np.arange(len(theta)), slopes=slopes, follow=follow)


def _followers(node: Tied, theta: Real) -> list[Follower]:
    values, slopes = node.forward(theta), node.forward.jacobian(theta)
    text = {tie.name: tie.text for tie in node.forward.ties}
    at = np.arange(len(theta))

    def followed(i: int) -> Callable[[Real], float]:
        return lambda values: float(node.forward(values)[i])

    return [
        Follower(each.name, each, float(values[i]), at, slopes[i], text[each.name], followed(i))
        for i, each in enumerate(node.forward.inner)
        if each.name in text
    ]
