"""The grammar of formulas: text to a tree, by Python's parser and a list of what is allowed.

Nothing of the text is ever run: what is not on the list is refused, in one line that names the
sign. Units of its parameters follow from those of what it stands among: addends have one unit,
powers and what functions take have none, and the whole has that of its plane. These are linear
equations for the powers of the units of each parameter, solved one by one.
"""

from __future__ import annotations

import ast
import re
import warnings
from cmath import isfinite
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NoReturn, TypeAlias, TypeVar

import numpy as np

from springpot.errors import ModelError

from ..numerics import ALIKE
from .nodes import GRADIENT, VALUE, Node, Response
from .parameters import Dimension, Exponent, Parameter
from .points import GAS_CONSTANT, Complex, Points, Real
from .terms import CALLED, JOINED, OF_REAL, Called, Joined, Name, Number, Power, Term

VARIABLES = ("omega", "f", "s", "X", "T", "T0", "Tr")
"""Frequency in rad/s and Hz, s = i omega, amplitude, temperature and the one of reference in K."""
OWN = "Y"
"""Of a compliance a variable too: the amplitude that the part in series takes itself."""
CONSTANTS = {"i": 1j, "pi": np.pi, "R": GAS_CONSTANT}
"""R in kJ/(mol K), in which activation energies are told in kJ/mol."""
LONGEST, MOST, LARGEST_POWER = 1000, 120, 20.0
"""Signs and parts of a formula, and the largest number as a power: more is a slip, or no law."""
_ALLOWED = re.compile(r"[A-Za-z0-9_.+\-*/^(), ]")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*")
_NUMBER = re.compile(r"[0-9.]+(?:[eE][+-]?[0-9]+)?(?![A-Za-z0-9_])")
_SIGNS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
}
_KNOWN = ", ".join((*VARIABLES, *CONSTANTS, *CALLED, "max", "min"))
N = TypeVar("N", bound=ast.expr)


# A law is read when it is found, bound to its data, held against others: a few hundred texts.
@lru_cache(maxsize=1024)
def parsed(text: str) -> Term:
    """The tree of a formula.

    Parameters
    ----------
    text : str
        Such as ``k*(1 + (X/Xc)^n)``.

    Raises
    ------
    ModelError
        If it is none, or something in it is not allowed; the line tells the sign.

    Examples
    --------
    >>> from springpot.rheology.grammar import parsed
    >>> [part.name for part in parsed("c*(i*omega)^alpha").walk() if hasattr(part, "name")]
    ['c', 's', 'alpha']
    """
    if len(text) > LONGEST:
        raise ModelError(f"a formula of {len(text)} signs is too long: at most {LONGEST}")
    for place, sign in enumerate(text, 1):
        if not _ALLOWED.fullmatch(sign):
            _refuse(text, place, f"{sign!a} has no meaning in a formula")
    # Python writes a power as **; `_place` counts the signs as the user typed them.
    python = text.replace("^", "**").strip()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(python, mode="eval")
    except SyntaxError as error:
        _refuse(text, _place(text, (error.offset or 1) - 1), f"this is no formula ({error.msg})")
    except (ValueError, RecursionError, MemoryError):
        _refuse(text, 1, "this is no formula that can be read")
    if sum(1 for _ in ast.walk(tree)) > 3 * MOST:
        raise ModelError(f"a formula of more than {MOST} parts is no law: '{text:.40}...'")
    return _Reading(text).read(tree.body)


def _place(text: str, offset: int) -> int:
    """The sign of the user's text that stands at an offset of Python's."""
    stripped = len(text) - len(text.lstrip())
    powers = text[stripped:].replace("^", "**")[:offset].count("**")
    return stripped + offset - min(powers, text.count("^")) + 1


def _refuse(text: str, place: int, why: str) -> NoReturn:
    shown = text if len(text) <= 80 else f"{text[:77]}..."
    raise ModelError(f"'{shown}', sign {place}: {why}")


class _Reading:
    """Goes through Python's tree; whatever is not on the list ends it."""

    def __init__(self, text: str) -> None:
        self.text = text

    def read(self, node: ast.expr) -> Term:
        readers: dict[type[ast.expr], Callable[[ast.expr, int], Term]] = {
            ast.Constant: self._number,
            ast.Name: self._name,
            ast.UnaryOp: self._signed,
            ast.BinOp: self._joined,
            ast.Call: self._called,
        }
        place = _place(self.text, node.col_offset)
        if type(node) not in readers:
            what = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(node).__name__).lower()
            _refuse(self.text, place, f"a formula has no {what}")
        return self._folded(readers[type(node)](node, place))

    def _number(self, node: ast.expr, place: int) -> Term:
        assert isinstance(node, ast.Constant)
        value = node.value
        # Nor are Python's other ways of writing one: 0x10, 1_000, 1j.
        if not isinstance(value, int | float) or not _NUMBER.match(self.text, place - 1):
            _refuse(self.text, place, f"{value!r:.20} is no number as a formula has it: 1.5e-3")
        try:
            return Number(place, complex(float(value)))
        except OverflowError:
            _refuse(self.text, place, "this number is too large")

    def _name(self, node: ast.expr, place: int) -> Term:
        assert isinstance(node, ast.Name)
        if node.id in CONSTANTS:
            return Number(place, complex(CONSTANTS[node.id]), node.id)
        if node.id in CALLED or node.id in OF_REAL:
            _refuse(self.text, place, f"{node.id} is a function: write {node.id}(...)")
        if not _NAME.fullmatch(node.id) or len(node.id) > 30:
            _refuse(self.text, place, f"'{node.id:.30}' is no name of a parameter")
        # The temperature of reference has two usual names.
        return Name(place, {"Tr": "T0"}.get(node.id, node.id))

    def _signed(self, node: ast.expr, place: int) -> Term:
        assert isinstance(node, ast.UnaryOp)
        if isinstance(node.op, ast.UAdd):
            return self.read(node.operand)
        if not isinstance(node.op, ast.USub):
            _refuse(self.text, place, "only + and - stand before a part")
        return Joined(place, "*", Number(place, -1.0 + 0j), self.read(node.operand))

    def _joined(self, node: ast.expr, place: int) -> Term:
        assert isinstance(node, ast.BinOp)
        left, right = self.read(node.left), self.read(node.right)
        if isinstance(node.op, ast.Pow):
            return self._power(left, right, place)
        if type(node.op) not in _SIGNS:
            _refuse(self.text, place, "parts are joined by + - * / and ^ only")
        sign = _SIGNS[type(node.op)]
        if sign == "/" and isinstance(right, Number) and right.value == 0.0:
            _refuse(self.text, right.place, "nothing is divided by zero")
        pair = (left, right)
        if sign == "*" and {_word(part) for part in pair} == {"i", "omega"}:
            return Name(place, "s")
        # i*omega*tau stands there as (i*omega)*tau, but c*i*omega as (c*i)*omega.
        match left:
            case Joined(sign="*", right=Name() | Number() as last) if sign == "*":
                if {_word(last), _word(right)} == {"i", "omega"}:
                    return Joined(place, "*", left.left, Name(last.place, "s"))
        return Joined(place, sign, left, right)

    def _power(self, base: Term, exponent: Term, place: int) -> Term:
        if not exponent.real:
            _refuse(self.text, exponent.place, "a power is a real number")
        if isinstance(exponent, Number) and abs(exponent.value) > LARGEST_POWER:
            _refuse(self.text, exponent.place, f"a power beyond {LARGEST_POWER:g} is no law")
        return Power(place, base, exponent)

    def _called(self, node: ast.expr, place: int) -> Term:
        assert isinstance(node, ast.Call)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in CALLED and name not in OF_REAL:
            shown = f"'{name}' is no function" if name else "only a function is called"
            _refuse(self.text, place, f"{shown}: known are {_KNOWN}; a product needs its *")
        count = 2 if name in JOINED else 1
        if len(node.args) != count or node.keywords:
            _refuse(self.text, place, f"{name} takes {count} part{'s' * (count > 1)}")
        parts = [self.read(part) for part in node.args]
        if name in OF_REAL and not all(part.real for part in parts):
            _refuse(self.text, place, f"{name} takes what is real")
        if count == 2:
            return Joined(place, name, *parts)
        return Called(place, name, parts[0])

    def _folded(self, term: Term) -> Term:
        """A part of numbers alone is one number."""
        # R is a number with a unit, which a number alone would lose.
        pure = all(isinstance(part, Number) and part.name != "R" for part in term.parts)
        if not term.parts or not pure:
            return term
        try:
            with np.errstate(all="ignore"):
                value = complex(term.at({}).value)
        except (ZeroDivisionError, OverflowError):
            value = complex("nan")
        if not isfinite(value):
            _refuse(self.text, term.place, "this is no finite number")
        return Number(term.place, value)


def _word(part: Term) -> str:
    return getattr(part, "name", "")


def names_in(term: Term) -> list[str]:
    """Names of a formula in the order of the text, each once."""
    names = [part.name for part in term.walk() if isinstance(part, Name)]
    return list(dict.fromkeys(names))


def free_names(term: Term, columns: Collection[str] = ()) -> list[str]:
    """The names that are neither variables nor columns: the parameters."""
    return [name for name in names_in(term) if name not in VARIABLES and name not in columns]


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
    under_force : callable or None
        The same of an element in the measurement chain where a force is imposed: it turns the
        displacement (n, c) that the recorded force would have into the recorded one.
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
    under_force: Callable[..., tuple[Any, Sequence[Any]]] | None = None
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
        whole = spread(value, shape)
        if depth == VALUE:
            return Response(whole)
        # Filled in place: laws give slopes of any shape that broadcasts.
        by_theta = np.empty((*shape[:-1], len(self.free), shape[-1]), dtype=complex)
        for i, slope in enumerate(slopes):
            by_theta[..., i, :] = slope
        if depth == GRADIENT:
            return Response(whole, by_theta)
        return Response(whole, by_theta, spread(by_log_omega, shape))

    def third_harmonic(self, theta: Real, at: Points) -> Complex | None:
        """Third harmonic of force over displacement amplitude; None where no law is known."""
        if self.third is None:
            return None
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape)
        return spread(self.third(at, *self._columns(theta)), shape)

    def third_harmonic_at_most(self, theta: Real, at: Points) -> Real | None:
        """The most that the third harmonic may be, over the displacement amplitude.

        None where that is not known.
        """
        if self.third_at_most is None:
            return None
        shape = np.broadcast_shapes((*theta.shape[:-1], 1), at.log_omega.shape)
        return np.broadcast_to(self.third_at_most(at, *self._columns(theta)), shape)


def spread(value: Any, shape: tuple[int, ...]) -> Complex:
    """A value of any shape that broadcasts, as complex numbers of this one."""
    whole = np.asarray(value, dtype=complex)
    # Mostly it has that shape; a view takes longer than the law itself.
    if whole.shape == shape:
        return whole
    return np.broadcast_to(whole, shape)


Unit: TypeAlias = dict[tuple[str, str], float]
"""Powers of units: ``("time", "")`` to a number, ``("time", "alpha")`` to a multiple of alpha.

``("?", "k")`` is the unit of the parameter k, yet to be found.
"""
PURE: Unit = {}
OF_VARIABLE: dict[str, Unit] = {
    "omega": {("time", ""): -1.0},
    "s": {("time", ""): -1.0},
    "f": {("time", ""): -1.0},
    "X": {("amplitude", ""): 1.0},
    "T": {("K", ""): 1.0},
    "T0": {("K", ""): 1.0},
}
OF_PLANE: dict[str, Unit] = {
    "stiffness": {("stiffness", ""): 1.0},
    "compliance": {("stiffness", ""): -1.0},
    "log-complex": PURE,
    "shift": PURE,
}
GAS: Unit = {("kJ/mol", ""): 1.0, ("K", ""): -1.0}
_WORDS = {"stiffness": "a stiffness", "time": "a time", "amplitude": "an amplitude"}


def units_of(
    term: Term, plane: str, text: str, columns: Mapping[str, object], whole: bool = True
) -> dict[str, Dimension]:
    """The unit of each parameter of a formula.

    Parameters
    ----------
    term : Term
        The formula.
    plane : str
        What it gives: a ``stiffness``, a ``compliance``, or a factor (``log-complex``, ``shift``).
    text : str
        As it was typed, for messages.
    columns : mapping of str
        Names that are columns of the data; each has a unit of its own.
    whole : bool
        Whether these are all: else what seems one parameter too many may be a column.

    Raises
    ------
    ModelError
        If units do not fit each other, or two parameters count only together.

    Examples
    --------
    >>> from springpot import Units
    >>> from springpot.rheology.grammar import units_of
    >>> from springpot.rheology.grammar import parsed
    >>> text = "-m*omega^2"
    >>> Units("kN/m", "mm").of(units_of(parsed(text), "stiffness", text, {})["m"])
    (1000.0, 'kg')
    """
    equations = _Equations(text, columns)
    found = equations.unit(term)
    equations.equal(found, OF_PLANE[plane], term, f"the whole is {_shown(OF_PLANE[plane])}")
    names = free_names(term, columns)
    units = {name: equations.resolved({("?", name): 1.0}) for name in names}
    for name, unit in units.items():
        # As units may be scaled there at will, so may the numbers: the law stays the same.
        others = [other for base, other in unit if base == "?"]
        if others and whole:
            together = ", ".join(dict.fromkeys([name, *others]))
            raise ModelError(f"'{text:.80}': {together} count only together: leave out one of them")
    return {name: _dimension(unit) for name, unit in units.items()}


class _Equations:
    """What is known of the units so far."""

    def __init__(self, text: str, columns: Mapping[str, object]) -> None:
        self.text = text
        self.columns = columns
        self.found: dict[str, Unit] = {}

    def resolved(self, unit: Unit) -> Unit:
        """A unit with those of the parameters that are known already put in."""
        whole: Unit = {}
        for key, power in unit.items():
            base, name = key
            if base == "?" and name in self.found:
                whole = _sum(whole, self.resolved(self.found[name]), power)
            else:
                whole = _sum(whole, {key: power})
        return whole

    def equal(self, a: Unit, b: Unit, term: Term, why: str) -> None:
        """Let two units be one; what is open is found by it."""
        off = self.resolved(_sum(a, b, -1.0))
        for (base, name), power in off.items():
            if base == "?":
                rest = {key: value for key, value in off.items() if key != (base, name)}
                self.found[name] = _sum({}, rest, -1.0 / power)
                return
        if off:
            here = _shown(self.resolved(a))
            raise ModelError(
                f"'{self.text:.80}', sign {term.place}: units do not fit: {why}, here is {here}"
            )

    def unit(self, term: Term) -> Unit:
        """The unit of a part, and on the way all that follows from it."""
        if isinstance(term, Number):
            return GAS if term.name == "R" else PURE
        if isinstance(term, Name):
            own: Unit = {("?", term.name): 1.0}
            if term.name in self.columns:
                own = {("amplitude" if term.name == OWN else term.name, ""): 1.0}
            return OF_VARIABLE.get(term.name, own)
        if isinstance(term, Called):
            return self._called(term)
        if isinstance(term, Power):
            return self._power(term)
        assert isinstance(term, Joined)
        left, right = self.unit(term.left), self.unit(term.right)
        if term.sign in "*/":
            return _sum(left, right, 1.0 if term.sign == "*" else -1.0)
        # Nothing has any unit: max(0, X - Xc).
        nothing = [isinstance(part, Number) and part.value == 0 for part in term.parts]
        if not any(nothing):
            word = f"beside {_shown(self.resolved(left))}"
            self.equal(right, left, term.right, f"{word} stands the same")
        return right if nothing[0] else left

    def _called(self, term: Called) -> Unit:
        inner = self.unit(term.inner)
        if term.function == "abs":
            return inner
        if term.function == "sqrt":
            return _sum({}, inner, 0.5)
        self.equal(inner, PURE, term.inner, f"{term.function} takes a pure number")
        return PURE

    def _power(self, term: Power) -> Unit:
        self.equal(self.unit(term.exponent), PURE, term.exponent, "a power is a pure number")
        base, exponent = self.resolved(self.unit(term.base)), _linear(term.exponent)
        if exponent is not None and set(exponent) <= {""}:
            return _sum({}, base, exponent.get("", 0.0))
        plain = all(kind != "?" and not symbol for kind, symbol in base)
        # (X/Xc)^n is a pure number to the power n: what is open below a free power makes it so.
        if exponent is None or not plain:
            self.equal(base, PURE, term.base, "below this power stands a pure number")
            return PURE
        return {
            (kind, symbol): power * share
            for (kind, _), power in base.items()
            for symbol, share in exponent.items()
        }


def _linear(term: Term) -> dict[str, float] | None:
    """A power as multiples of parameters, of one under ``""``; None where it is no such sum."""
    if isinstance(term, Number):
        return {"": term.value.real}
    if isinstance(term, Name):
        return {term.name: 1.0}
    if not isinstance(term, Joined):
        return None
    left, right = _linear(term.left), _linear(term.right)
    if left is None or right is None:
        return None
    if term.sign in "+-":
        sign = 1.0 if term.sign == "+" else -1.0
        pairs = {**left, **right}
        sums = {name: left.get(name, 0.0) + sign * right.get(name, 0.0) for name in pairs}
        return {name: share for name, share in sums.items() if share}
    if term.sign == "*" and set(left) == {""}:
        return {name: share * left[""] for name, share in right.items()}
    if term.sign in "*/" and set(right) == {""} and right[""]:
        factor = right[""] if term.sign == "*" else 1.0 / right[""]
        return {name: share * factor for name, share in left.items()}
    return None


def _sum(a: Unit, b: Unit, times: float = 1.0) -> Unit:
    whole = dict(a)
    for key, power in b.items():
        whole[key] = whole.get(key, 0.0) + times * power
    return {key: power for key, power in whole.items() if abs(power) > ALIKE}


def _plain(power: float) -> float:
    """A whole number where it is one: it is printed."""
    rounded = round(power, 9)
    return int(rounded) if rounded == int(rounded) else rounded


def _dimension(unit: Unit) -> Dimension:
    """Powers of stiffness, time and amplitude, and what is beyond them."""
    powers: dict[str, Exponent] = {}
    for (base, symbol), power in unit.items():
        if base == "?":
            return Dimension()
        powers[base] = (*powers.get(base, ()), (symbol, _plain(power)))
    if list(powers) in (["K"], ["kJ/mol"]) and next(iter(powers.values())) == (("", 1),):
        return Dimension(label=next(iter(powers)))
    plain = {base: power[0][1] for base, power in powers.items() if power[0][0] == ""}
    whole = {base: number for base, number in plain.items() if len(powers[base]) == 1}
    time: float | str = whole.get("time", 0)
    # What is beside a fractional order in one unit has a name of its own for long: N s^alpha/m.
    if len(powers.get("time", ())) == 1 and powers["time"][0][1] == 1 and powers["time"][0][0]:
        time = powers.pop("time")[0][0]
    usual = ("stiffness", "time", "amplitude")
    beyond = tuple(
        (base, power)
        for base, power in sorted(powers.items())
        if not (base in usual and base in whole)
    )
    stiffness, amplitude = whole.get("stiffness", 0), whole.get("amplitude", 0)
    return Dimension(stiffness, time, amplitude, beyond=beyond)


def _shown(unit: Unit) -> str:
    """A unit in words."""
    words = []
    for (base, symbol), power in unit.items():
        word = f"the unit of {symbol}" if base == "?" else _WORDS.get(base, base)
        exponent = f"{_plain(power):g}" + (f"*{symbol}" if symbol and base != "?" else "")
        words.append(word if exponent == "1" else f"{word}^{exponent}")
    return " times ".join(words) or "a pure number"
