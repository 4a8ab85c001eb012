"""A model: a named network and the effects that have joined it.

With the rule by which an effect that a model has already would be the same thing once more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import chain, compress
from typing import NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError

from ..numerics import ALIKE
from .effect import Effect, Layer, Test, find_effect
from .elements import KnownMass
from .levels import Levels, Own, own_of, owned
from .nodes import FULL, GRADIENT, VALUE, Node, Response, Scaled, parallel
from .parameters import HasParameters, Parameter, SearchForm
from .points import HALF_PI, KELVIN, ROOM, Complex, Points, Real
from .tied import (
    Bounds,
    Fixed,
    Follower,
    Held,
    Tied,
    bases_in,
    followers,
    hold,
    part_of,
    started,
    tied,
    ties_in,
    untied,
)

_GRID = np.meshgrid(np.log(np.geomspace(0.1, 10.0, 5)), [0.5, 2.0], [280.0, 300.0], indexing="ij")
_POINTS = Points(_GRID[0].ravel(), _GRID[1].ravel(), _GRID[2].ravel(), ROOM)


class _Sample(Node):
    """A material without parameters: K = 1 + s^0.4."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return ()

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        power = np.exp(0.4 * (at.log_omega + HALF_PI))
        nothing = np.zeros((0, len(power)), dtype=np.complex128)
        return Response(1.0 + power, nothing, 0.4 * power)


def same_twice(effect: Effect) -> bool:
    """Whether two effects of this kind in one model act as one of them with another size.

    Two masses are one larger mass; two relaxation modes, or two filters of different corner
    frequencies, are not one. Effects with a factor for each level and those of a test are; of the
    others only those with a single parameter are judged.
    """
    if effect.by_levels or effect.of_test:
        return True
    if len(effect.element.parameters) != 1:
        return False
    network: Node = _Sample()
    for prefix in ("first", "second"):
        network = effect.composition(network, effect.element.with_prefix(prefix))
    # Of two different sizes, as two equal ones would have the same slope whatever the effect.
    sizes = np.array([_inside(effect.element.parameters[0], share) for share in (0.3, 0.6)])
    with np.errstate(all="ignore"):
        slopes = network.respond(sizes, _POINTS, GRADIENT).by_theta
    first, second = np.concatenate([slopes.real, slopes.imag], axis=-1)
    length = np.linalg.norm(first) * np.linalg.norm(second)
    if not (np.isfinite(length) and length > 0):
        return False
    # Two of one kind are the same where both move K in one direction.
    left = second - first * (first @ second) / (first @ first)
    return bool(np.linalg.norm(left) < ALIKE * np.linalg.norm(second))


def _inside(parameter: Parameter, share: float) -> float:
    """A value within the bounds."""
    low, high = parameter.lower, parameter.upper
    if np.isfinite(low) and np.isfinite(high):
        return low + share * (high - low)
    # From the end that there is, away from the other.
    if high == np.inf:
        return max(low, 0.0) + share
    return min(high, 0.0) - share


T = TypeVar("T")
M = TypeVar("M", bound="NamedNetwork")


class Placed(NamedTuple):
    """An effect of a model, the prefix of its parameters' names and where they stand in theta."""

    effect: Effect
    prefix: str
    own: list[int]


@lru_cache(maxsize=256)
def _with_some(model: M, which: tuple[bool, ...]) -> tuple[M, list[int]]:
    """A model with some of its placed effects, and where its parameters stand in the whole theta.

    One for all fits of a test: what it works out of itself is kept with it.
    """
    if all(which):
        return model, list(range(len(model.parameters)))
    mine = list(compress(model.placed, which))
    own = [range(len(model.material.parameters)), *(each.own for each in mine)]
    return replace(model, effects=tuple(each.effect for each in mine)), list(chain(*own))


@dataclass(frozen=True, eq=False)
class NamedNetwork(HasParameters):
    """A network with a name, possibly grown by effects; see `Model`.

    Its parameters are those of `Model`.
    """

    base: str
    material: Node
    summary: str = ""
    citation: str = ""
    aliases: tuple[str, ...] = ()
    search: SearchForm | None = None
    effects: tuple[Effect, ...] = field(default=())
    drawing: str = ""

    @property
    def name(self) -> str:
        """The model expression, such as ``fractional-maxwell + inertia``."""
        return " + ".join([self.base, *(effect.expression for effect in self.effects)])

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"<Model {self.name}: {', '.join(self.names)}>"

    @cached_property
    def network(self) -> Node:
        """Material and effects composed from the material outwards."""
        return self.resized(1.0)

    def resized(self, factor: float, mass: float = 0.0) -> Node:
        """The network with `factor` times as much specimen (twice the area, say) in the same rig.

        Parameters
        ----------
        factor : float
            Above zero.
        mass : float
            A known mass that moves with the specimen, in units of stiffness times s^2.
        """
        # Of the usual specimen nothing is multiplied: it counts as resized from the start.
        network, resized = self.material, factor == 1.0 and mass == 0.0
        for effect, prefix, _ in self.placed:
            # The specimen ends where the first effect of the rig stands: only what lies within is
            # resized.
            if not resized and effect.layer > Layer.SPECIMEN:
                network, resized = _loaded(network, factor, mass), True
            network = effect.composition(network, effect.element.with_prefix(prefix))
        # Without a rig the whole network is the specimen.
        if not resized:
            network = _loaded(network, factor, mass)
        return network

    def named_effects(self) -> list[tuple[Effect, str]]:
        """The effects, each with the prefix of its parameters' names.

        A second one of its kind has `#2`.
        """
        # Names of parameters must be unique: a second relaxation mode has a number behind its name.
        seen: Counter[str] = Counter()
        named = []
        for effect in self.effects:
            seen[effect.name] += 1
            prefix, count = effect.name, seen[effect.name]
            if count > 1:
                prefix = f"{prefix}#{count}"
            named.append((effect, prefix))
        return named

    @cached_property
    def placed(self) -> tuple[Placed, ...]:
        """The effects from the material outwards, and where their parameters stand in theta."""
        first, placed = len(self.material.parameters), []
        for effect, prefix in sorted(self.named_effects(), key=lambda pair: pair[0].position):
            last = first + len(effect.element.parameters)
            placed.append(Placed(effect, prefix, list(range(first, last))))
            first = last
        return tuple(placed)

    def had_by(self, test: Test) -> tuple[Self, list[int]]:
        """The model that a test has, and where its parameters stand in theta.

        Effects that do not apply to the test are left out: of another rig, or of another kind of
        test. Of levels with parameters of their own it has those of one, where it lies at one.
        """
        if self.own and (level := self.level_of(test)) is not None:
            one, inner = self.of_any_level.had_by(test)
            return one, self.places[level][inner].tolist()
        return _with_some(self, tuple(each.effect.applies_to(test) for each in self.placed))

    def level_of(self, test: Test) -> int | None:
        """Number of the level whose own parameters a test has; None of one at several levels."""
        own = {name: test.conditions[name] for name in self.own.values()}
        kelvin = own.pop("temperature", None)
        size = next(map(len, test.conditions.values()))
        at = Points(np.zeros(size), None, None if kelvin is None else kelvin + KELVIN, columns=own)
        found = np.unique(self.levels(at))
        return int(found[0]) if len(found) == 1 else None

    @property
    def of_tests(self) -> tuple[Effect, ...]:
        """What the tests did, in the order of theta."""
        return tuple(each.effect for each in self.placed if each.effect.of_test)

    @property
    def of_specimen(self) -> Self:
        """The model without what the tests did; its parameters are the first of theta."""
        effects = tuple(effect for effect in self.effects if not effect.of_test)
        if len(effects) == len(self.effects):
            return self
        return replace(self, effects=effects)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters in the order of theta."""
        return self.network.parameters

    @property
    def needs(self) -> frozenset[str]:
        """Condition columns without which the model cannot be evaluated."""
        return self.network.needs

    def theta(self, **values: float) -> Real:
        """Parameter vector from keyword values; dots in names are written as double underscores.

        Raises
        ------
        ModelError
            If a name is unknown or missing.
        """
        # No Python name has a dot, and no parameter two underscores.
        given = {name.replace("__", "."): value for name, value in values.items()}
        return self.vector(given)

    def holding(
        self, values: Mapping[str, float], bounds: Mapping[str, Bounds] | None = None
    ) -> Self:
        """The model with some parameters held at a value and others within narrower bounds.

        What is held is no parameter of the new model: theta, degrees of freedom and uncertainty are
        of the rest.

        Parameters
        ----------
        values : mapping of str to float
            By name, in the unit of theta: ``{"alpha": 0.5}``.
        bounds : mapping of str to (float, float), optional
            Lower and upper end, by name.

        Raises
        ------
        ModelError
            If a name is unknown or stands in both, a value cannot be, or nothing is left to be
            fitted.

        Examples
        --------
        >>> from springpot.rheology import Model, series, spring, springpot
        >>> model = Model("maxwell", series(spring(), springpot())).holding({"alpha": 0.5})
        >>> model.names, model.held
        (('k', 'c'), {'alpha': 0.5})
        """
        bounds = bounds or {}
        if not (values or bounds):
            return self
        for name in (*values, *bounds):
            if name not in self.names:
                raise ModelError(
                    f"{self.name} has no free parameter '{name}': it has {', '.join(self.names)}"
                )
        if both := sorted(set(values) & set(bounds)):
            raise ModelError(f"{', '.join(both)}: a parameter is held or has bounds, not both")
        if set(values) == set(self.names):
            raise ModelError(f"{self.name}: all parameters are held, nothing is left to be fitted")
        effects = []
        for effect, prefix in self.named_effects():
            own_values, own_bounds = _own(values, prefix), _own(bounds, prefix)
            if own_values or own_bounds:
                # Its parameters are those of whatever levels the data have.
                if isinstance(effect.element, Levels):
                    raise ModelError(
                        f"{effect.name} has a factor for each level of the data:"
                        " none of them can be held"
                    )
                effect = replace(effect, element=hold(effect.element, own_values, own_bounds))
            effects.append(effect)
        # The published search form knows no model of which a parameter is missing: it is left out.
        material = hold(self.material, values, bounds)
        return replace(self, material=material, effects=tuple(effects), search=None)

    @property
    def held(self) -> dict[str, float]:
        """Parameters that are held, by name, in the unit of theta."""
        values = dict(self.material.held)
        for effect, prefix in self.named_effects():
            values |= {f"{prefix}.{name}": value for name, value in effect.element.held.items()}
        return values

    def tying(self, ties: Sequence[str], factors: Mapping[str, float] | None = None) -> Self:
        """The model with some parameters that follow from others.

        Parameters
        ----------
        ties : sequence of str
            Such as ``k2 = 2*k1`` or ``tau1 < tau2``; each within the material or within one effect.
        factors : mapping of str to float, optional
            From the unit of theta to the one that the numbers of the ties are in, by name.

        Raises
        ------
        ModelError
            If one is no tie, names what is no free parameter or is of several parts, or if ties go
            round in a circle.

        Examples
        --------
        >>> from springpot.rheology import Model, dashpot, parallel, spring
        >>> model = Model("kelvin", parallel(spring(), dashpot())).tying(["c = 0.1*k"])
        >>> model.names, model.stiffness([2.0], [1.0]).round(6)
        (('k',), array([2.+0.2j]))
        """
        known = factors or {}
        own: dict[str, list[str]] = {}
        prefixes = [prefix for _, prefix in self.named_effects()]
        for text in ties:
            own.setdefault(part_of(text, prefixes), []).append(text)
        material, effects = self.material, []
        if "" in own:
            material = tied(material, own[""], known)
        for effect, prefix in self.named_effects():
            if prefix in own:
                element = tied(effect.element, own[prefix], _own(known, prefix), prefix)
                effect = replace(effect, element=element)
            effects.append(effect)
        if not own:
            return self
        return replace(self, material=material, effects=tuple(effects), search=None)

    @property
    def ties(self) -> tuple[str, ...]:
        """How parameters are tied, as it was typed."""
        ties = list(ties_in(self.material))
        for effect in self.effects:
            ties += ties_in(effect.element)
        return tuple(ties)

    @property
    def bases(self) -> dict[str, list[str]]:
        """What each tied parameter hangs on: those it follows from, or its share of an order."""
        found = bases_in(self.material)
        for effect, prefix in self.named_effects():
            for name, on in bases_in(effect.element).items():
                found[f"{prefix}.{name}"] = [f"{prefix}.{each}" for each in on]
        return found

    def untied(self) -> Self:
        """The model whose parameters are not tied; held and each level's own they stay."""
        effects = tuple(replace(each, element=untied(each.element)) for each in self.effects)
        return replace(self, material=untied(self.material), effects=effects)

    def followers(self, theta: Real) -> list[Follower]:
        """The tied parameters at `theta` (p,)."""
        found = []
        rows = list(range(len(self.material.parameters)))
        parts: list[tuple[Node, str, list[int]]] = [(self.material, "", rows)]
        parts += [(each.effect.element, f"{each.prefix}.", each.own) for each in self.placed]
        for node, prefix, rows in parts:
            for each in followers(node, theta[rows]):
                parameter = each.parameter
                if prefix:
                    parameter = parameter.renamed(f"{prefix}{parameter.name}")
                at, origin = np.array(rows)[each.at], f"{prefix}{each.origin}"
                found.append(each._replace(origin=origin, parameter=parameter, at=at))
        return found

    def started(self, full: Real) -> Real:
        """Parameters (..., p) near those (..., q) of the `released` model."""
        nodes = [self.material, *(each.effect.element for each in self.placed)]
        ends = np.cumsum([0, *(len(node.released.parameters) for node in nodes)])
        parts = [
            started(node, full[..., first:last])
            for node, first, last in zip(nodes, ends, ends[1:], strict=False)
        ]
        return np.concatenate(parts, axis=-1)

    def owning(self, names: Collection[str], column: str) -> Self:
        """The model with parameters of which each level of a condition has its own.

        Parameters
        ----------
        names : collection of str
            Of parameters: ``["k", "inertia.m"]``. All others are shared by all levels.
        column : str
            The condition: ``"temperature"``, or a column that numbers specimens.

        Raises
        ------
        ModelError
            If a name is unknown, or a constant would share its unit with several orders.

        Examples
        --------
        >>> from springpot.rheology import Model, Points, dashpot, parallel, spring
        >>> model = Model("kelvin", parallel(spring(), dashpot())).owning(["k"], "batch")
        >>> at = Points(np.zeros(2), columns={"batch": np.array([1.0, 2.0])})
        >>> model.bound_to(at).names
        ('k_1', 'k_2', 'c')
        """
        for name in names:
            if name not in self.names:
                raise ModelError(
                    f"{self.name} has no free parameter '{name}': it has {', '.join(self.names)}"
                )
        if others := set(self.own.values()) - {column}:
            raise ModelError(
                f"{', '.join(self.own)}: each {', '.join(others)} has its own already,"
                f" and none can be each {column}'s"
            )
        effects = [
            replace(
                effect, element=owned(effect.element, _own(dict.fromkeys(names), prefix), column)
            )
            for effect, prefix in self.named_effects()
        ]
        material = owned(self.material, names, column)
        return replace(self, material=material, effects=tuple(effects), search=None)

    @property
    def own(self) -> dict[str, str]:
        """Parameters of which each level of a condition has its own, and the condition."""
        of = own_of(self.material)
        for effect, prefix in self.named_effects():
            of |= {f"{prefix}.{name}": by for name, by in own_of(effect.element).items()}
        return of

    @property
    def level_values(self) -> dict[str, list[float]]:
        """The levels with parameters of their own, by their condition; temperatures in degC."""
        nodes = [self.material, *(effect.element for effect in self.effects)]
        own = [node for node in nodes if isinstance(node, Own)]
        return {node.column: list(Levels(node.column, values=node.values).shown) for node in own}

    def levels(self, at: Points) -> NDArray[np.intp]:
        """Number of the level (n,) whose own parameters each point has; 0 where all share them."""
        nodes = [self.material, *(effect.element for effect in self.effects)]
        own = next((node for node in nodes if isinstance(node, Own)), None)
        if own is None:
            return np.zeros(at.log_omega.shape[-1], dtype=np.intp)
        return own.level(at)

    @property
    def places(self) -> NDArray[np.intp]:
        """Where the parameters (q,) of each level stand in theta, (levels, q)."""
        first, places = 0, list[NDArray[np.intp]]()
        nodes = [self.material, *(each.effect.element for each in self.placed)]
        levels = max((len(node.places) for node in nodes if isinstance(node, Own)), default=1)
        for node in nodes:
            mine = np.arange(len(node.parameters))[None]
            if isinstance(node, Own):
                mine = node.places
            places.append(np.broadcast_to(first + mine, (levels, mine.shape[1])))
            first += len(node.parameters)
        return np.concatenate(places, axis=1)

    def at_all_levels(self, theta: Real) -> Real:
        """Parameters (..., p) of which all levels have those (..., q) of one."""
        places = self.places
        whole = np.empty((*theta.shape[:-1], int(places.max()) + 1))
        whole[..., places] = theta[..., None, :]
        return whole

    @cached_property
    def of_any_level(self) -> Self:
        """The model that each level has for itself, which has one set of parameters."""
        return self._mapped(lambda node: node.node if isinstance(node, Own) else node)

    def at_levels(self, kept: NDArray[np.intp]) -> Self:
        """The model with some of the levels that have parameters of their own, by their numbers."""
        if len(kept) == len(self.places):
            return self
        return self._mapped(lambda node: node.at_levels(kept) if isinstance(node, Own) else node)

    def _mapped(self, change: Callable[[Node], Node]) -> Self:
        """The model with each of its nodes changed."""
        effects = tuple(replace(each, element=change(each.element)) for each in self.effects)
        return replace(self, material=change(self.material), effects=effects)

    @property
    def constrained(self) -> bool:
        """Whether parameters are held, tied, kept within narrower bounds, or each level's own."""
        nodes = [self.material, *(effect.element for effect in self.effects)]
        return any(isinstance(node, Held | Tied | Own) for node in nodes)

    def released(self) -> Self:
        """The same model with all its parameters free and shared, within the bounds of physics."""
        effects = tuple(replace(effect, element=effect.element.released) for effect in self.effects)
        return replace(self, material=self.material.released, effects=effects)

    @property
    def origins(self) -> tuple[str, ...]:
        """For each parameter its name in the `released` model."""
        names = list(self.material.origins)
        for effect, prefix, _ in self.placed:
            names += [f"{prefix}.{name}" for name in effect.element.origins]
        return tuple(names)

    def fixed_at(self, theta: Real) -> Self:
        """The model as it is at `theta` (p,), without parameters.

        Whatever is added to it brings the only ones.

        Thousands of settings of one more effect are then evaluated without as many evaluations of
        the model itself.
        """
        # The material's come first in theta: effects join behind it.
        own = len(self.material.parameters)
        effects = [
            replace(effect, element=Fixed(effect.element, theta[rows]))
            for effect, _, rows in self.placed
        ]
        material = Fixed(self.material, theta[:own])
        return replace(self, material=material, effects=tuple(effects), search=None)

    def third_harmonic(self, theta: Real, at: Points) -> Complex | None:
        """Third harmonic of the force over the first, by the describing functions of the effects.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            Parameters.
        at : Points
            The n points, with their amplitudes.

        Returns
        -------
        ndarray, shape (n,), or None
            Zero where all is linear; None where an effect makes a harmonic that no formula here
            predicts, because it has none or does not act in parallel.
        """
        centre, radius = self.third_harmonic_range(theta, at)
        if np.any(radius):
            return None
        return centre

    def third_harmonic_range(self, theta: Real, at: Points) -> tuple[Complex, Real]:
        """Where the third harmonic of the force over the first must lie.

        As a circle around what is predicted.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            Parameters.
        at : Points
            The n points, with their amplitudes.

        Returns
        -------
        centre : ndarray of complex, shape (n,)
            The sum of what the effects make by their formulas.
        radius : ndarray, shape (n,)
            The sum of the bounds of those without one; infinite where an effect has neither.
        """
        centre = np.zeros(at.log_omega.shape[-1], dtype=np.complex128)
        radius = np.zeros(centre.shape)
        for effect, _, own in self.placed:
            known, unsure = effect.third_harmonic_range(theta[own], at)
            centre, radius = centre + known, radius + unsure
        first = self.stiffness(theta, at)
        with np.errstate(divide="ignore", invalid="ignore"):
            # A model that has no force has no share of it either: not finite, as where nothing is
            # known.
            return np.asarray(centre / first, dtype=np.complex128), radius / np.abs(first)

    def stiffness(self, theta: Real, at: Points | Real | float) -> Complex:
        """Complex stiffness.

        Parameters
        ----------
        theta : ndarray, shape (..., p)
            Parameters.
        at : Points or array of omega in rad/s
            The n points.

        Returns
        -------
        ndarray, shape (..., n)
            K = K' + i K'' in the unit of the parameters.
        """
        return self.network.respond(np.asarray(theta, dtype=float), _points(at)).value

    def jacobian(self, theta: Real, at: Points | Real | float) -> Complex:
        """Exact derivative dK/dtheta, shape (..., n, p)."""
        # Networks answer parameter by parameter; users expect a row for each point.
        response = self.network.respond(np.asarray(theta, dtype=float), _points(at), GRADIENT)
        return np.swapaxes(response.by_theta, -1, -2)

    def slope(self, theta: Real, at: Points | Real | float) -> Complex:
        """Exact derivative dK / d ln omega, shape (..., n)."""
        return self.network.respond(np.asarray(theta, dtype=float), _points(at), FULL).by_log_omega

    def bound_to(self, at: Points) -> Self:
        """The model with the levels and columns of these points, where it has such parts.

        Else the model itself.

        Raises
        ------
        ModelError
            If a condition has one level only.
        """
        effects = tuple(effect.bound_to(at) for effect in self.effects)
        material = self.material.bound_to(at)
        pairs = zip((material, *effects), (self.material, *self.effects), strict=True)
        if all(new is old for new, old in pairs):
            return self
        for effect in effects:
            if effect.by_levels and not effect.element.parameters:
                column = ", ".join(sorted(effect.needs))
                raise ModelError(
                    f"{effect.name} needs two levels of {column} or more; these data have one"
                )
        return replace(self, material=material, effects=effects)

    def __add__(self, effect: Effect | str) -> Self:
        """The model with one more effect, given as an object or by name.

        Raises
        ------
        ModelError
            If the name is unknown, or is one that `taking` refuses.
        """
        if isinstance(effect, str):
            return self.taking(find_effect(effect))
        if not isinstance(effect, Effect):
            raise ModelError(f"{self.name} + {effect!r:.40}: an effect is an Effect or its name")
        return replace(self, effects=(*self.effects, effect))

    def taking(self, effect: Effect) -> Self:
        """The model with one more effect that a user asks for.

        Raises
        ------
        ModelError
            If it has the effect already, and a second one would only share the size of the first:
            no data can tell two masses from one.
        """
        if effect.name in {own.name for own in self.effects} and same_twice(effect):
            one = (
                "a second one would be the same as one of another size; leave out one"
                f" '{effect.name}'"
            )
            raise ModelError(f"{self.name} has the effect '{effect.name}' already: {one}")
        return self + effect

    def __sub__(self, effect: Effect | str) -> Self:
        """The model without the last effect of that name or alias.

        Raises
        ------
        ModelError
            If the model has no such effect.
        """
        name = effect
        if not isinstance(effect, str):
            name = effect.name
        # The last one, as of two relaxation modes the second was added to the first.
        for i in reversed(range(len(self.effects))):
            if name in (self.effects[i].name, *self.effects[i].aliases):
                return replace(self, effects=self.effects[:i] + self.effects[i + 1 :])
        raise ModelError(f"{self.name} has no effect '{name}'")


def _own(given: Mapping[str, T], prefix: str) -> dict[str, T]:
    """What is given for the parameters of one effect, by their own names."""
    return {
        name.rpartition(".")[2]: value
        for name, value in given.items()
        if name.rpartition(".")[0] == prefix
    }


def _loaded(specimen: Node, factor: float, mass: float) -> Node:
    scaled = Scaled(specimen, factor)
    if not mass:
        return scaled
    return parallel(scaled, KnownMass(mass))


def _points(at: Points | Real | float) -> Points:
    if isinstance(at, Points):
        return at
    return Points.at(at)
