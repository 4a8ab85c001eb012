"""An element that is written as its formula, such as ``c*(i*omega)^alpha``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import inf
from typing import Any, cast

import numpy as np

from springpot.errors import ModelError

from ..numerics import ALIKE, NEGLIGIBLE
from .factors import activation_energy, bounded_shift
from .grammar import OWN, free_names, names_in, parsed, spread, units_of
from .nodes import VALUE, Response
from .nonlinear import Compliant
from .parameters import PURE, Dimension, Parameter, order
from .points import HALF_PI, LARGEST_SHIFT, ROOM, Complex, Points, Real
from .terms import LOG_OMEGA, Called, Dual, Joined, Name, Number, Power, Term, inverse, settled

EXPONENT = Parameter("n", "n", PURE, 0.0, 4.0, "linear", 1.0)
"""A free power: whoever expects a negative one writes its sign, as in X^(-n)."""
OF_WARMTH = 20.0
"""Largest power of T/T0, which in all that is measured stays near one."""
KELVINS = Parameter("T", "T", Dimension(label="K"), 0.0, 1e4, typical=100.0)
LEAST, MOST = 1e-18, 1e18
"""Sizes, beside those of the data, at which a law must be gone to be one that may be missing."""
FACTORS = ("log-complex", "shift")


@dataclass(frozen=True)
class TypedLaw:
    """A formula as elements are evaluated: value, slopes, slope by ln omega.

    Parameters
    ----------
    term : Term
        The formula.
    plane : str
        What it gives: stiffness, compliance, a factor (``log-complex``) or one of the frequency
        (``shift``). As a part of a network it is a stiffness, a factor or the logarithm of one.
    free : tuple of str
        Names of its parameters.
    """

    term: Term
    plane: str
    free: tuple[str, ...]

    def dual(self, at: Points, values: Iterable[Any]) -> Dual:
        """The formula itself."""
        return self._of(self.term, self._known(at), values)

    def _of(self, term: Term, known: Mapping[str, Dual], values: Iterable[Any]) -> Dual:
        own = {
            name: Dual(value, {name: 1.0}) for name, value in zip(self.free, values, strict=True)
        }
        # Where it has no number, as X^(-n) of an amplitude of zero, the caller finds none.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return term.at({**known, **own})

    def _known(self, at: Points) -> dict[str, Dual]:
        known = {name: _variable(name, at, self.plane) for name in self._variables}
        known[LOG_OMEGA] = Dual(at.log_omega, {LOG_OMEGA: 1.0})
        return known

    @cached_property
    def _variables(self) -> list[str]:
        return [name for name in names_in(self.term) if name not in self.free]

    def _settled(self, at: Points) -> tuple[Term, Mapping[str, Dual]]:
        """What the network adds at these points, and their columns; of a fit they stay the same."""
        points, term, known = self.__dict__.get("_last", (None, None, None))
        if points is not at:
            known = self._known(at)
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                term = settled(self._joined, known, self.free)
            self.__dict__["_last"] = (at, term, known)
        return term, known

    def joined(self, at: Points, values: Iterable[Any], by: str | None = None) -> Dual:
        """What the network adds, with no slope, or one alone: that by ln Y under `OWN`."""
        known = {name: Dual(value, {}) for name, value in zip(self.free, values, strict=True)}
        for name, (value, slopes) in self._known(at).items():
            known[name] = Dual(value, {key: slopes[key] for key in slopes if key == by})
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return self._joined.at(known)

    @cached_property
    def _joined(self) -> Term:
        """What the network adds: of a compliance the stiffness."""
        if self.plane == "compliance":
            return inverse(self.term)
        return self.term

    def __call__(self, at: Points, *values: Any) -> Any:
        """What a network takes."""
        value, slopes = self._of(*self._settled(at), values)
        by_theta = [slopes.get(name, 0.0) for name in self.free]
        by_log_omega = slopes.get(LOG_OMEGA, 0.0)
        if self.plane == "shift":
            return _logarithm(value, by_theta, by_log_omega)
        return value, by_theta, by_log_omega


def _logarithm(value: Any, by_theta: list[Any], by_log_omega: Any) -> Any:
    """Of a factor of the frequency, bounded as those of the temperature are."""
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.log(value)
        slopes = tuple(slope / value for slope in by_theta)
        by_log_omega = by_log_omega / value
    log, slopes, flat = bounded_shift(log, slopes)
    return log, slopes, np.where(np.abs(np.real(log)) < LARGEST_SHIFT, by_log_omega, flat)


def _column(name: str, plane: str) -> str:
    """The column that a name stands for: of Y the network gives what the part in series takes."""
    if name == OWN and plane != "compliance":
        return name
    return {"X": "amplitude", "T": "temperature", OWN: "amplitude"}.get(name, name)


def _variable(name: str, at: Points, plane: str) -> Dual:
    if name in ("omega", "s", "f"):
        factor = {"omega": 1.0, "s": 1j, "f": 0.5 / np.pi}[name]
        value = factor * np.exp(at.log_omega)
        return Dual(value, {LOG_OMEGA: value})
    if name == "T0":
        return Dual(at.reference_temperature, {})
    column = at.need(_column(name, plane))
    return Dual(column, {OWN: column} if name == OWN and plane == "compliance" else {})


@dataclass(frozen=True)
class Written(Compliant):
    """An element by its text; see `written`.

    Parameters
    ----------
    text : str
        The formula.
    plane : str
        What it gives.
    bound : bool
        Whether the columns of the data are known.
    gone_at : float or None
        Where its first parameter alone makes it vanish.
    """

    text: str = ""
    plane: str = "stiffness"
    bound: bool = False
    gone_at: float | None = None

    @property
    def is_balanced(self) -> bool:
        """Whether it asks for the amplitude of its own, not for that of the whole."""
        return self.plane == "compliance" and OWN in names_in(parsed(self.text))

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The law; slopes are worked out only where they are asked for."""
        if depth != VALUE:
            return super().respond(theta, at, depth)
        assert isinstance(self.law, TypedLaw)
        value, _ = self.law.joined(at, self._columns(theta))
        if self.plane == "shift":
            value, *_ = _logarithm(value, [], 0.0)
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape, np.shape(value))
        return Response(spread(value, shape))

    def growing(self, theta: Real, at: Points) -> tuple[Complex, Complex]:
        """K and its derivative by the logarithm of its own amplitude."""
        assert isinstance(self.law, TypedLaw)
        whole = self.law.joined(at, self._columns(theta), OWN)
        return whole.value, whole.slopes.get(OWN, 0.0) * np.ones(1)

    @property
    def absent_at(self) -> float | None:
        """Zero or infinity; None where its first parameter alone never makes it vanish."""
        return self.gone_at

    def bound_to(self, at: Points) -> Written:
        """The same where names of the data's columns are these, and sizes those of the data."""
        if self.bound:
            return self
        return written(self.text, self.plane, at)

    def sized_by(self, name: str, gone_at: float) -> Written:
        """The same with that parameter first, which alone makes it vanish."""
        free = sorted(self.free, key=lambda parameter: parameter.name != name)
        assert isinstance(self.law, TypedLaw)
        law = replace(self.law, free=tuple(parameter.name for parameter in free))
        return replace(self, free=tuple(free), law=law, gone_at=gone_at)


def written(text: str, plane: str = "stiffness", at: Points | None = None) -> Written:
    """An element of a formula.

    Parameters
    ----------
    text : str
        The formula; see `springpot.rheology.grammar.parsed`.
    plane : str
        What it gives.
    at : Points, optional
        The data's: their further columns are variables too.

    Raises
    ------
    ModelError
        If it is no formula, its units do not fit, or it has no parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points
    >>> from springpot.rheology.written import written
    >>> written("-m*omega^2").respond(np.array([0.5]), Points.at([2.0])).value
    array([-2.+0.j])
    """
    text = " ".join(text.split())
    term = parsed(text)
    columns: dict[str, object] = {} if at is None else dict(at.columns)
    names = names_in(term)
    columns = {name: column for name, column in columns.items() if name in names}
    if plane == "compliance" and OWN in names:
        if "X" in names:
            raise ModelError(f"'{text:.80}' has both X, of the whole, and Y, of the part in series")
        columns[OWN] = None
    free = free_names(term, columns)
    if not free:
        raise ModelError(f"'{text:.80}' has no parameter, so that nothing could be found of it")
    if plane == "shift" and not term.real:
        raise ModelError(f"'{text:.80}': a factor of the frequency is real, so it has no i")
    units = units_of(term, plane, text, columns, at is not None)
    parameters = tuple(_parameter(name, units[name], term) for name in free)
    if at is not None:
        parameters = tuple(_sized(parameter, at) for parameter in parameters)
    asked = tuple(_column(name, plane) for name in names if name in (*columns, "X", "T"))
    element = Written(
        parameters,
        TypedLaw(term, plane, tuple(free)),
        asked,
        text,
        text=text,
        plane=plane,
        bound=at is not None,
    )
    size = size_of(element)
    if size is None:
        return element
    return _signed(element.sized_by(*size))


def declared(text: str, plane: str, free: Sequence[Parameter], kind: str = "") -> Written:
    """An element of a formula whose parameters are known, so that nothing is worked out.

    Parameters
    ----------
    text : str
        The formula.
    plane : str
        What it gives.
    free : sequence of Parameter
        Its parameters, the size first.
    kind : str
        Name in drawings.

    Raises
    ------
    ModelError
        If it is no formula, or has other parameters.
    """
    text = " ".join(text.split())
    term = parsed(text)
    names, own = names_in(term), [OWN] if plane == "compliance" else []
    called = tuple(parameter.name for parameter in free)
    if set(called) != set(free_names(term, own)):
        raise ModelError(f"'{text:.80}' has other parameters than {', '.join(called)}")
    asked = tuple(_column(name, plane) for name in names if name in (*own, "X", "T"))
    law = TypedLaw(term, plane, called)
    return Written(tuple(free), law, asked, kind or text, text=text, plane=plane, bound=True)


def _parameter(name: str, unit: Dimension, term: Term) -> Parameter:
    """Bounds by where it stands and what it is."""
    # What a mere number is raised to is no power of anything that is measured.
    powers = [
        part
        for part in term.walk()
        if isinstance(part, Power) and not isinstance(part.base, Number)
    ]
    of_s = [part.exponent for part in powers if _of_s(part.base)]
    if any(_is(exponent, name) for exponent in of_s):
        return order(name, name)
    like = Parameter(name, name, unit)
    raised = [p.base for p in powers if any(_is(part, name) for part in p.exponent.walk())]
    if raised and unit == PURE:
        warm = all(set(names_in(base)) == {"T", "T0"} for base in raised)
        like = replace(EXPONENT, upper=OF_WARMTH) if warm else EXPONENT
    elif unit.label == "kJ/mol":
        like = activation_energy()
    elif unit.label == "K":
        like = KELVINS
    return replace(like, name=name, symbol=name)


def _of_s(base: Term) -> bool:
    """Whether it is s, or s in units of its own, as in (s tau)^alpha."""
    if isinstance(base, Joined) and base.sign == "*":
        return any(_of_s(part) for part in base.parts)
    return _is(base, "s")


def _is(term: Term, name: str) -> bool:
    return isinstance(term, Name) and term.name == name


def _signed(element: Written) -> Written:
    """What an instrument does may go either way: a delay, a gain, an error of the clock."""
    first = element.free[0]
    if element.plane not in FACTORS or first.unit.label:
        return element
    # What slips at a force, or lets go beyond a play, does so in both directions.
    parts = parsed(element.text).walk()
    if any(isinstance(p, Called) and p.function == "slider" for p in parts):
        return element
    # A power by which a law is there at all, such as (T/T0)^n, keeps its size.
    if first.scale == "linear":
        return replace(element, free=(replace(first, lower=-first.upper), *element.free[1:]))
    # Of a size that is gone at infinity, as a resonance far above, the other sign says nothing new.
    if element.gone_at != 0.0:
        return element
    either = replace(first, lower=-inf, scale="linear", typical=0.1 * first.typical)
    if first.unit == PURE:
        either = replace(either, lower=-0.99)
    return replace(element, free=(either, *element.free[1:]))


def _sized(parameter: Parameter, at: Points) -> Parameter:
    """The typical size, where units are beyond stiffness, time and amplitude."""
    size = 1.0
    for base, power in parameter.unit.beyond:
        exponent = sum(share * (EXPONENT.typical if name else 1.0) for name, share in power)
        size *= _middle(base, at) ** exponent
    return replace(parameter, typical=parameter.typical * size)


def _middle(base: str, at: Points) -> float:
    """What one of a unit comes to in the data."""
    if base == "K":
        return ROOM
    values = at.columns.get(base)
    if base == "amplitude":
        values = at.amplitude
    if base == "time":
        values = np.exp(-np.real(at.log_omega))
    if values is None:
        return 1.0
    sizes = np.abs(values[np.isfinite(values) & (values != 0.0)])
    return float(np.median(sizes)) if len(sizes) else 1.0


def examples(element: Written) -> tuple[Points, list[float]]:
    """Points and parameters, all of the order of one, at which a formula is looked at."""
    rows = np.linspace(0.6, 1.7, 12)
    names = names_in(parsed(element.text))
    columns = {name: rows[::-1] for name in names if name in element.conditions}
    at = Points(np.log(rows), rows[::-1] ** 0.5, 260.0 + 40.0 * rows, ROOM, columns)
    values = []
    for i, parameter in enumerate(element.free):
        value = parameter.typical if parameter.unit.label else 1.0 + 0.1 * i
        values.append(0.5 if parameter.is_order else value)
    # Of NumPy's own kind, whose division by zero is no error but a number that is not finite.
    return at, list(np.array(values))


def size_of(element: Written) -> tuple[str, float] | None:
    """The parameter that alone decides whether a law is there, and where it is gone.

    Returns
    -------
    tuple of (str, float) or None
        Its name, and 0 or infinity. None where no parameter does.
    """
    at, usual = examples(element)
    law = element.law
    assert isinstance(law, TypedLaw)
    least = ALIKE if law.plane in FACTORS else 0.0
    with np.errstate(all="ignore"):
        whole = np.max(np.abs(_there(law, at, usual)))
        if not whole > least:
            return None
        for place, parameter in enumerate(element.free):
            for factor, end in ((LEAST, 0.0), (MOST, inf)):
                # An order has both its ends, and is no size; at infinity none that has one is.
                if parameter.is_order or (end and np.isfinite(parameter.upper)):
                    continue
                # Whatever the others are.
                tried = [list(usual), [value * 1.3 for value in usual]]
                for values in tried:
                    values[place] = factor * usual[place]
                left = [np.abs(_there(law, at, values)) for values in tried]
                if np.all(np.array(left) < NEGLIGIBLE * whole):
                    return parameter.name, end
    return None


def _there(law: TypedLaw, at: Points, values: list[float]) -> Any:
    """What a formula adds in its plane: nothing where it is gone."""
    value = law.dual(at, values).value
    if law.plane in FACTORS:
        return value - 1.0
    return np.asarray(value)


AROUND = 256
"""Points of a circle on which a mean is taken."""
NEARLY = 0.97
"""Radius of a circle beside its distance from the imaginary axis."""
OFF = 1e-3
"""By how much a mean may miss the value at the centre, beside the largest value on the circle."""
SLOW, FAST, STEEPEST = 30.0, 300.0, 30.0
"""Rates between which the logarithm of a law grows by no more than that: 13 powers of ten."""


def causal(element: Written) -> bool:
    """Whether a law is causal.

    Examples
    --------
    >>> from springpot.rheology.written import causal
    >>> from springpot.rheology.written import written
    >>> causal(written("-m*omega^2")), causal(written("i*h"))
    (True, False)
    """
    with np.errstate(all="ignore"):
        real = np.geomspace(0.03, 30.0, 25).astype(complex)
        values = _values(element, real)
        # Of what is no number anywhere nothing is said against.
        if np.max(np.abs(values.imag)) > OFF * np.max(np.abs(values)):
            return False
        ends = np.log(np.abs(_values(element, np.array([SLOW, FAST], dtype=complex))))
        if not ends[1] - ends[0] < STEEPEST:
            return False
        turn = np.exp(2j * np.pi * np.arange(AROUND) / AROUND)
        for x, slope in product(np.geomspace(0.03, 30.0, 7), (0.0, 1.0, 4.0, 16.0)):
            centre = x * (1.0 + 1j * slope)
            circle = _values(element, centre + NEARLY * x * turn)
            off = np.abs(np.mean(circle) - _values(element, np.array([centre]))[0])
            if not off <= OFF * np.max(np.abs(circle)):
                return False
    return True


def passive(element: Written) -> bool:
    """Whether a law of stiffness or compliance gives out no energy, at any of some sizes.

    Examples
    --------
    >>> from springpot.rheology.written import passive
    >>> from springpot.rheology.written import written
    >>> passive(written("c*i*omega")), passive(written("-c*i*omega"))
    (True, False)
    """
    at, usual = examples(element)
    assert isinstance(element.law, TypedLaw)
    sign = -1.0 if element.plane == "compliance" else 1.0
    at = replace(at, log_omega=np.linspace(-3.0, 3.0, len(at.log_omega)))
    with np.errstate(all="ignore"):
        for share in product((0.5, 1.5), repeat=min(len(usual), 4)):
            values = [value * by for value, by in zip(usual, (*share, 1.0, 1.0), strict=False)]
            values += usual[len(values) :]
            value = np.asarray(element.law.dual(at, values).value, dtype=complex)
            if np.any(sign * value.imag < -ALIKE * np.abs(value)):
                return False
    return True


def _values(element: Written, s: Complex) -> Complex:
    """The law at complex rates s (n,), at one set of conditions."""
    at, usual = examples(element)
    assert isinstance(element.law, TypedLaw)
    one = at.mapped(lambda column: np.full(len(s), column[0]))
    there = replace(one, log_omega=cast("Real", np.log(s) - HALF_PI))
    return np.broadcast_to(np.asarray(element.law.dual(there, usual).value, complex), s.shape)


def told(element: Written) -> str:
    """What kind of law it is, in a few words.

    Examples
    --------
    >>> from springpot.rheology.written import told
    >>> from springpot.rheology.written import written
    >>> told(written("i*h"))
    "not causal: no physical law, an instrument's fault"
    """
    # The first harmonic of what knows an amplitude is no linear answer: friction follows no clock.
    linear = "amplitude" not in element.needs
    if linear and not causal(element):
        return "not causal: no physical law, an instrument's fault"
    # What multiplies a signal or moves a clock has no energy of its own.
    if element.plane in FACTORS:
        return "causal"
    if not passive(element):
        return "not passive: it gives out energy"
    if not linear:
        return "passive"
    return "causal and passive"
