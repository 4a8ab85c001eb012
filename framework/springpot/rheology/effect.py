"""A physical effect: an element and the composition by which it joins a model."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from math import inf
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from springpot.errors import ModelError

from .levels import Levels
from .nodes import (
    VALUE,
    Composing,
    Composition,
    Node,
    Parallel,
    Response,
    chain,
    parallel,
    series,
    shift,
)
from .parameters import Parameter
from .points import Complex, Points, Real
from .tied import Fixed, Held

V = TypeVar("V")
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


@dataclass(frozen=True)
class InstrumentConstant:
    """What an instrument's file may say of an effect.

    The constant with which its software corrects for it.

    Parameters
    ----------
    fact : str
        Key under which readers keep it in the provenance.
    parameter : str
        The parameter of the effect that it would be.
    says : str
        What it means; ``{stated}`` is the constant with its unit.
    """

    fact: str
    parameter: str
    says: str


class Layer(IntEnum):
    """How far from the material an effect acts.

    Effects join a network from the material outwards whatever the order in which they are typed:
    temperature shifts the material but never the rig, the rig adds its compliance and mass around
    the specimen, and the measurement chain sees all of it.
    """

    MATERIAL = 0
    TEMPERATURE = 1
    SPECIMEN = 2
    DEVICE = 3
    MOUNTING = 4
    MOVING_PARTS = 5
    SIGNAL = 6
    TEST = 7


class Test(Protocol):
    """What an effect asks of a test, a sweep or one in time."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def control(self) -> str:
        """What was imposed, of `CONTROLS`."""

    @property
    def conditions(self) -> Mapping[str, Real]:
        """What was set beside the load, a number (n,) for each measured one."""


PLANES = {"parallel": parallel, "series": series, "chain": chain, "shift": shift}
"""Where a formula is put: it is a stiffness, a compliance, a factor of K, one of the frequency."""
OF_PLANE = {
    "parallel": (Layer.MATERIAL, "K + {0}"),
    "series": (Layer.MATERIAL, "1 / (1 / K + {0})"),
    "chain": (Layer.SIGNAL, "K * ({0})"),
    "shift": (Layer.TEMPERATURE, "K(omega * ({0}))"),
}
"""The layer of a formula of which nothing else is said, and what is measured with it."""
OF_WHOLE = "X is the amplitude of the whole, not the share that this part takes"
OF_BALANCE = "1 / (1 / K + J), J = {0}, Y = X * |K * J / (1 + K * J)|"
OF_OWN = "first harmonics are balanced; higher ones of the force do not move the model"

IN_TIME = ("displacement", "force")
CONTROLS = ("frequency", *IN_TIME)


def _any(test: Test) -> bool:
    return True


@dataclass(frozen=True)
class AppliesTo:
    """To which tests of a specimen an effect applies.

    Parameters
    ----------
    controls : tuple of str
        What was imposed in them: ``frequency`` in a sweep, ``displacement`` or ``force`` in time.
    suits : callable
        Whether a test that it is given can show the effect at all.
    alone : callable
        Whether a test can show it with no other beside it; asked of the only test that there is.
    one : bool
        Whether it tells one of several tests from the others, so that it must be said of which:
        ``NAME:TEST``.
    test : str
        The only test that has it, as it stands in a model expression; empty where all can.

    Examples
    --------
    >>> import springpot
    >>> drift = springpot.plugins().effect("force-drift")
    >>> drift.applies_to(springpot.TimeTest.of_relaxation([1.0, 4.0], [2.0, 1.0], "kPa"))
    True
    >>> drift.applies_to(springpot.read("artificial-hidden"))
    False
    """

    controls: tuple[str, ...] = CONTROLS
    suits: Callable[[Any], bool] = _any
    alone: Callable[[Any], bool] = _any
    one: bool = False
    test: str = ""

    def __call__(self, test: Test) -> bool:
        """Whether a test can have it, and show it."""
        if self.test and self.test != in_expression(test.name):
            return False
        return test.control in self.controls and bool(self.suits(test))

    def __str__(self) -> str:
        """In words, as lists show it."""
        if self.test:
            return f"the test {self.test}"
        words = {CONTROLS: "all tests", ("frequency",): "sweeps", IN_TIME: "tests in time"}
        told = words.get(self.controls, f"tests under a {' or '.join(self.controls)}")
        if self.one:
            return f"one of several {told}"
        return told


ALL, SWEEPS = AppliesTo(), AppliesTo(("frequency",))


def in_expression(name: str) -> str:
    """The name of a test as it stands in a model expression, without blanks and signs.

    Examples
    --------
    >>> in_expression("creep 25 C + glue.csv")
    'creep-25-C-glue.csv'
    """
    return re.sub(r"[^\w.]+", "-", name).strip("-")


@dataclass(frozen=True)
class Effect:
    """A physical effect that may be missing from a model.

    Parameters
    ----------
    name : str
        What users type, such as ``"inertia"``.
    composition : Composing
        `parallel`, `series`, `chain` or `shift`; of what a test in time did `on_loading`,
        `on_clock` or `on_response`.
    element : Node
        What is put there, at a stage of a test its `StageLaw`; its parameters become
        ``name.parameter`` in the grown model.
    summary : str
        One sentence of physics.
    layer : Layer
        Where between material and signal it acts; at a stage of a test it is always ``TEST``.
    citation : str
        Source of the equation (DOI where there is one).
    aliases : tuple of str
        Other names for the same thing.
    approximate : str
        Empty where the composition is exact; otherwise what is approximated (a slider in series).
    absent_at : float, optional
        Value of the element's first parameter, its size, at which the effect vanishes whatever the
        others are; by default infinity in series and zero elsewhere.
    prior : float
        How common the effect is beside the others before any data are seen: 1 for what every
        laboratory meets, less, but not 0, for rarer physics.
    apparatus : bool
        Whether it is a fault of the apparatus and nothing of the specimen; what is of the layer
        ``SIGNAL`` always is. Of a test in time it needs more evidence than what specimens do.
    narrow : bool
        Whether its shape can imitate any narrow feature of a sweep. Such an effect is tried only
        where simple common ones do not explain the data, and some of its probability is left to
        what the library does not know.
    equation : str
        What is measured in place of K(omega) if the effect alone joins it, in terms of K, s = i
        omega, the amplitude X, the temperatures T and Tr (reference), R in the unit of Ea, and the
        element's parameters.
    constant : InstrumentConstant, optional
        What the file of an instrument may say of it.
    largest_of_modulus : float, optional
        Largest size, in the unit in which it is printed, that physics allows where a modulus was
        measured; of a stiffness the size of the specimen would decide.
    only_varied : bool
        Whether the conditions that it needs must have been varied: at one value of them it would be
        a factor that goes with the frequency alone, as many a fault of a measuring chain does.
    applies_to : AppliesTo
        The tests that can have it: by default all, and at a stage all in time.
    signature : str
        How it shows in a record: one sentence.
    expression : str
        How it stands in a model expression; by default its name.

    Examples
    --------
    >>> from springpot.rheology import Effect, Model, mass, parallel, spring
    >>> inertia = Effect("inertia", parallel, mass(), "a mass that moves along")
    >>> (Model("spring", spring()) + inertia).names
    ('k', 'inertia.m')
    """

    name: str
    composition: Composing
    element: Node
    summary: str
    layer: Layer = Layer.MATERIAL
    citation: str = ""
    aliases: tuple[str, ...] = ()
    approximate: str = ""
    absent_at: float | None = None
    prior: float = 1.0
    apparatus: bool = False
    narrow: bool = False
    equation: str = ""
    constant: InstrumentConstant | None = None
    largest_of_modulus: float = inf
    only_varied: bool = False
    applies_to: AppliesTo = ALL
    signature: str = ""
    expression: str = ""

    @classmethod
    def from_formula(
        cls,
        name: str,
        formula: str,
        summary: str = "",
        parameters: Sequence[Parameter] = (),
        kind: str = "",
        **more: Any,
    ) -> Effect:
        """An effect by its formula: units, bounds and the size that is found follow from it.

        Parameters
        ----------
        name : str
            What users type.
        formula : str
            ``PLANE: FORMULA``: what stands ``parallel`` is a stiffness, ``series`` a compliance,
            ``chain`` a factor of K and ``shift`` one of the frequency.
        summary : str
            One sentence of physics; by default what kind of law it is.
        parameters : sequence of Parameter
            Those of the formula, the size first, where their units, bounds and symbols are known;
            then nothing is worked out, and it applies to all tests unless it is said otherwise.
        kind : str
            Name of the element in drawings; by default the formula.
        **more
            Whatever else an effect has: layer, citation, aliases, prior.

        Raises
        ------
        ModelError
            If it is no formula, its units do not fit, or no parameter of it alone makes it vanish.

        Examples
        --------
        >>> from springpot.rheology import Effect
        >>> Effect.from_formula("drag", "parallel: c*i*omega").equation
        'K + c*i*omega'
        """
        # Only where one is written: whoever names effects needs no grammar.
        from .nonlinear import balanced_series
        from .written import declared, told, written

        plane, colon, text = (part.strip() for part in formula.partition(":"))
        if not colon or plane not in PLANES:
            raise ModelError(
                f"'{formula:.80}': write PLANE: FORMULA, PLANE being one of {', '.join(PLANES)}"
            )
        own = PLANES[plane].kind.plane
        element = declared(text, own, parameters, kind) if parameters else written(text, own)
        layer, equation = OF_PLANE[plane]
        if element.absent_at is None and not parameters:
            names = ", ".join(each.name for each in element.free)
            raise ModelError(
                f"'{element.text:.80}' never vanishes: none of {names} does it alone, at zero or"
                " infinity, so that it could not be missing"
            )
        nonlinear = "amplitude" in element.needs
        joins, nearly = PLANES[plane], OF_WHOLE
        if element.is_balanced:
            joins, nearly, equation = balanced_series, OF_OWN, OF_BALANCE
        usual: dict[str, Any] = {
            "summary": summary or f"{element.text}, a law of your own: {told(element)}",
            "layer": layer,
            "equation": equation.format(element.text),
            # Nothing here follows from a first harmonic in time, nor of what a signal went through.
            "applies_to": SWEEPS if (nonlinear or plane == "chain") and not parameters else ALL,
            "approximate": nearly if nonlinear and plane == "series" else "",
        }
        return cls(name, joins, element, **(usual | more))

    def __post_init__(self) -> None:
        if not self.expression:
            object.__setattr__(self, "expression", self.name)
        law = self.element
        # Values that are held, or all of them fixed, stand around it.
        while isinstance(law, Held | Fixed):
            law = law.node
        if self.of_test is not isinstance(law, StageLaw):
            raise ModelError(
                f"effect '{self.name}': on_loading, on_clock and on_response take a StageLaw,"
                " other compositions an element"
            )
        if not self.of_test:
            return
        # Outside of all else, and in no sweep.
        controls = tuple(each for each in self.applies_to.controls if each in IN_TIME)
        object.__setattr__(self, "layer", Layer.TEST)
        object.__setattr__(self, "applies_to", replace(self.applies_to, controls=controls))

    @property
    def of_test(self) -> bool:
        """Whether it is what a test in time did, which no network shows."""
        return issubclass(self.composition.kind, Stage)

    @property
    def of_apparatus(self) -> bool:
        """Whether it is a fault of the apparatus and nothing of the specimen."""
        return self.apparatus or self.layer is Layer.SIGNAL

    @property
    def in_time(self) -> bool:
        """Whether tests in time can have it."""
        return self.applies_to.controls != SWEEPS.controls

    def at(self, tests: AppliesTo) -> Effect:
        """The same effect of these tests alone."""
        return replace(self, applies_to=tests)

    def of_one(self, test: str) -> Effect:
        """The same effect of one test alone, called ``NAME:TEST``."""
        test = in_expression(test)
        tests = replace(self.applies_to, test=test)
        name = f"{self.name}:{test}"
        return replace(self, name=name, expression=name, applies_to=tests, aliases=())

    @property
    def vanishes_at(self) -> float:
        """Value of the first parameter (0 or infinity) at which the grown model is the old one."""
        known = self.element.absent_at if self.absent_at is None else self.absent_at
        if known is not None:
            return known
        # In series it is what yields nothing, such as a spring without limit, that is not there.
        if self.plane == "compliance":
            return inf
        return 0.0

    @property
    def needs(self) -> frozenset[str]:
        """Condition columns without which the effect cannot be seen."""
        return self.element.needs

    @property
    def by_levels(self) -> bool:
        """Whether it has a parameter for each level of a condition, which only data can give."""
        return isinstance(self.element, Levels)

    def own_of(self, values: Mapping[str, V]) -> dict[str, V]:
        """Those of the values of a model's parameters that are its own, by their short names.

        Of an effect that was added twice those of the second.
        """
        owned = ((*name.rpartition("."), value) for name, value in values.items())
        return {
            short: value for owner, _, short, value in owned if owner.partition("#")[0] == self.name
        }

    def of_column(self, column: str) -> Effect:
        """Of one by levels that of another column; ``NAME:COLUMN`` is then its name."""
        assert isinstance(self.element, Levels)
        if column == self.element.column:
            return self
        # An alias means the effect of the usual column: this one is another.
        return replace(
            self,
            name=f"{self.name}:{column}",
            expression=f"{self.name}:{column}",
            element=replace(self.element, column=column),
            aliases=(),
        )

    def bound_to(self, at: Points) -> Effect:
        """The effect with the levels and columns of these points; itself where it has none."""
        bound = self.element.bound_to(at)
        if bound is self.element:
            return self
        return replace(self, element=bound)

    @property
    def plane(self) -> str:
        """The plane in which the effect adds, such as ``stiffness``, or its stage of a test."""
        return self.composition.kind.plane

    @property
    def position(self) -> tuple[int, int, str]:
        """Where the effect joins.

        By layer, in a layer parallel before series before shift before chain.

        The name settles the rest, so that a model never depends on the order in which it is typed.
        """
        return int(self.layer), self.composition.kind.order, self.name

    def third_harmonic(self, theta: Real, at: Points) -> Complex | None:
        """Third harmonic of the force that the effect adds, over the displacement amplitude.

        With x = X cos(omega t), the force contains the real part of F_3 exp(3 i omega t); divided
        by X it has the unit of a stiffness, and |F_3 / X| / |K| is what I3/I1 of the measured force
        shows.

        Parameters
        ----------
        theta : ndarray, shape (..., p)
            The element's own parameters.
        at : Points
            The n points.

        Returns
        -------
        ndarray, shape (..., n), or None
            Zero for a linear element; None where the effect makes a harmonic that no formula here
            predicts.
        """
        # Elements of plugins need not know harmonics.
        predict = getattr(self.element, "third_harmonic", None)
        harmonic: Complex | None = None
        if predict is not None:
            harmonic = predict(theta, at)
        # What knows no amplitude is linear, and makes none.
        if harmonic is None and "amplitude" not in self.needs:
            return np.zeros((*theta.shape[:-1], at.log_omega.shape[-1]), dtype=complex)
        return harmonic

    def third_harmonic_range(self, theta: Real, at: Points) -> tuple[Complex, Real]:
        """Where the third harmonic that the effect adds to the force must lie.

        As a circle around what is predicted.

        Parameters
        ----------
        theta : ndarray, shape (p,)
            The element's own parameters.
        at : Points
            The n points.

        Returns
        -------
        centre : ndarray of complex, shape (n,)
            As `third_harmonic`; zero where only a bound is known.
        radius : ndarray, shape (n,)
            How far off it may be: zero for a formula, infinite where nothing is known. A formula
            holds beside the model only, where the displacement is a sinusoid; elsewhere only "none"
            and a bound do.
        """
        shape = at.log_omega.shape[-1:]
        centre = self.third_harmonic(theta, at)
        # Inside another part the harmonic passes on changed: by how much no formula here says.
        beside = self.composition.kind is Parallel or "amplitude" not in self.needs
        if centre is not None and (beside or not np.any(centre)):
            return centre, np.zeros(shape)
        bound = getattr(self.element, "third_harmonic_at_most", lambda *_: None)(theta, at)
        if bound is None:
            bound = np.full(shape, inf)
        return np.zeros(shape, dtype=complex), bound


def _unset(name: str) -> Effect:
    raise ModelError(f"effect '{name}' cannot be looked up by name before 'import springpot'")


_finder: Callable[[str], Effect] = _unset


def use_finder(finder: Callable[[str], Effect]) -> None:
    """Let `finder` resolve effect names from now on."""
    global _finder
    _finder = finder


def find_effect(name: str) -> Effect:
    """The effect called `name`.

    Raises
    ------
    ModelError
        If no plugin offers it.
    """
    return _finder(name)
